/* Small systems of linear equations. */
#ifndef GTM_LINEAR_ALGEBRA_H
#define GTM_LINEAR_ALGEBRA_H

/* Solve the square system A x = b (row-major, both overwritten) by elimination; 0, or 1 when singular. */
int gtm_solve(int n, double *A, double *b);

/* Solve the positive definite H x = b (n rows of `width` numbers, both overwritten) by Cholesky; 1 when it is not. */
int gtm_solve_definite(int n, int width, double *H, double *b);

#endif
