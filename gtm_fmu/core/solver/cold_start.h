/* Trims without a near one to begin from: Newton from the guesses of a point mass. */
#ifndef GTM_COLD_START_H
#define GTM_COLD_START_H

#include "solver/newton.h"

/* Newton from several first guesses, with what it keeps taken from y. */
int gtm_cold_newton(const gtm_problem *p, double *y, const int held[3]);

/* Points of the manifold at n rows of (V, phi, rudder); those that were found are packed at the front of y. */
long gtm_find_starts(const gtm_problem *p, long n, const double *held, double *y);

#endif
