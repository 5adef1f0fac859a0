/* The trim with the least sideslip under bounds that hold two or three of V, psi_dot, phi, alpha and beta. */
#ifndef GTM_TRIM_H
#define GTM_TRIM_H

#include "solver/problem.h"

/* enum gtm_trim_status. Without a trim, `violation` and `residual` (largest acceleration) say how far away y is. Of
   trims with two throttles and no sideslip, the one with the least difference between them is taken. */
int gtm_find_trim(const gtm_problem *p, const double *lower, const double *upper, double *y, double *residual,
                  double *violation);

/* Least |beta| under bounds that hold the two `given` unknowns and leave another control than the rudder hardly any
   range: all deflections of the rudder are gone through, and every bound that is met between two of them. GTM_TRIMMED,
   or not. */
int gtm_scan_rudder(const gtm_problem *p, const double *lower, const double *upper, const int given[2],
                    const double *start, double *y);

/* Where y has no sideslip, two throttles are not settled yet: bring them together as far as the bounds allow. */
void gtm_join_throttles(const gtm_problem *p, const double *lower, const double *upper, double *y);

#endif
