/* The trims at two given unknowns as a curve over the rudder: each deflection has one. */
#ifndef GTM_RUDDER_CURVE_H
#define GTM_RUDDER_CURVE_H

#include "solver/problem.h"

/* Along the curve over the rudder's range, from the trim `start` (inside the bounds of the rudder or not; 0 where
   there is none without sideslip): enum gtm_trim_status, and the trim inside the bounds with the least sideslip, or the one that exceeds them least.
   `is_sure` is 0 where a better one may have been passed: the curve breaks, or so few trims of it are inside that there
   may be others beside them. GTM_NO_TRIM: it begins nowhere, or there is a wider choice than a curve. */
int gtm_follow_rudder(const gtm_problem *p, const double *lower, const double *upper, const int given[2],
                      const double *start, double *y, double *violation, int *is_sure);

#endif
