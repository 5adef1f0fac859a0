/* Newton's method for a trim with some unknowns held. */
#ifndef GTM_NEWTON_H
#define GTM_NEWTON_H

#include "solver/problem.h"

/* Mark what Newton keeps: the dead controls and the unknowns of `held`, the last of these freed where that is too many.
   Whether six unknowns are left, two throttles counted as one. */
int gtm_keeps(const gtm_problem *p, const int held[3], int *is_kept);

/* Newton with what it keeps; two throttles that are free move together. 0 when F = 0 was reached. */
int gtm_newton(const gtm_problem *p, double *y, const int held[3]);

#endif
