/* Slopes of an envelope: derivatives of V_min and V_max with respect to all that they depend on. */
#ifndef GTM_SLOPES_H
#define GTM_SLOPES_H

#include "gtm_manoeuvres.h"

/* Derivative of an end where a quantity shrinks and where it grows. They differ at kinks. NaN: the quantity can not go
   there, or no manoeuvre is left. */
typedef struct {
    double below, above;
} gtm_slope;

/* Of the least objective.y, in units of the objective per unit of the quantity. */
typedef struct {
    gtm_slope lower[GTM_TWO_THROTTLE_NT], upper[GTM_TWO_THROTTLE_NT]; /* each bound by itself */
    gtm_slope held[GTM_TWO_THROTTLE_NT];                              /* equal bounds together */
    gtm_slope altitude, gamma;                                        /* per ft, per rad */
    gtm_slope stabilizer, flaps, spoilers, fuel_used;                 /* of a configuration; all panels alike */
} gtm_slopes;

/* Slopes of the end y that gtm_envelope_end found with the same arguments. */
GTM_API void gtm_end_slopes(const gtm_configuration *c, enum gtm_throttles throttles, double altitude, double gamma,
                            const double *lower, const double *upper, const double *objective, const double *y,
                            gtm_slopes *slopes);

/* The same of what is not known for sure of a configuration: the mass by a factor, the centre of gravity along each axis
   (per ft), each coefficient by a factor; in this order. */
enum { GTM_TOLERANCES = 1 + 3 + GTM_NC };
GTM_API void gtm_tolerance_slopes(const gtm_configuration *c, enum gtm_throttles throttles, double altitude,
                                  double gamma, const double *lower, const double *upper, const double *objective,
                                  const double *y, gtm_slope slopes[GTM_TOLERANCES]);

#endif
