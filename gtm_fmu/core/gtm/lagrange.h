/* Interpolation over few nodes. */
#ifndef GTM_LAGRANGE_H
#define GTM_LAGRANGE_H

/* Weight at x of the value at node i of n, in the polynomial through all of them. */
double gtm_lagrange(long n, const double *nodes, long i, double x);

#endif
