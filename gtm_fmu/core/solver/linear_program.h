/* Linear programs in a few variables. */
#ifndef GTM_LINEAR_PROGRAM_H
#define GTM_LINEAR_PROGRAM_H

/* min c.x subject to A x <= b (rows of width d) and lower <= x <= upper, d <= 5; 0 when x was found (Seidel). */
int gtm_linear_program(int d, int rows, const double *A, const double *b, const double *c, const double *lower,
                       const double *upper, double *x);

#endif
