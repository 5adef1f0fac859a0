/* Look-up of the aerodynamic coefficients: piecewise multilinear, extrapolated with the slope of the end intervals
   (SPEC 1). At a breakpoint the slope is the one of the interval above it. */
#ifndef GTM_TABLE_H
#define GTM_TABLE_H

#include "generated/order.h"
#include "gtm/axis.h"

/* Component innermost and padded: 8 for six-component tables, 4 for (CX, CZ, Cm) and (CY, Cl, Cn). Zero until
   gtm_unfold_tables, which runs when the library is loaded, has filled them in. */
extern double gtm_basic_table[], gtm_aileron_table[], gtm_rudder_table[], gtm_omega_table[],
    gtm_elevator_table[], gtm_p_table[], gtm_q_table[], gtm_r_table[];

/* ft^2, lbf, ft/s^2: what a first guess of a trim needs of the airframe. */
extern const double gtm_wing_area, gtm_weight, gtm_gravity;

void gtm_unfold_tables(void);

/* Total coefficients C[6] (CX CY CZ Cl Cm Cn) at arguments K[9] (names.LOOKUPS). */
void gtm_coefficients(const double K[GTM_NK], double C[GTM_NC]);

/* The same, and the slopes T[i*9 + j] = dC_i / dK_j. */
void gtm_coefficients_and_slopes(const double K[GTM_NK], double C[GTM_NC], double T[GTM_NC * GTM_NK]);

#endif
