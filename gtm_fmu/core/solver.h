/* Steady manoeuvres as points of a manifold: F(y) = 0, six accelerations of nine unknowns (names.TRIM_UNKNOWNS). */
#ifndef GTM_SOLVER_H
#define GTM_SOLVER_H

#include "gtm_configuration.h"
#include "gtm_core.h"

enum { GTM_NF = 6 };

/* What a trim takes as given: flight-path angle in rad, air density in slug/ft^3, pressure ratio. */
typedef struct {
    double gamma, density, pressure_ratio;
} gtm_condition;

gtm_condition gtm_condition_at(double altitude, double gamma);

void gtm_trim_residual(const double y[GTM_NT], const gtm_condition *at, double F[GTM_NF]);
void gtm_trim_jacobian(const double y[GTM_NT], const gtm_condition *at, double F[GTM_NF], double J[GTM_NF * GTM_NT]);

/* The same for any configuration, the study's tables taken where they serve. */
void gtm_full_trim_residual(const gtm_configuration *c, const double y[GTM_FULL_NT], const gtm_condition *at,
                            double F[GTM_NF]);
void gtm_full_trim_jacobian(const gtm_configuration *c, const double y[GTM_FULL_NT], const gtm_condition *at,
                            double F[GTM_NF], double J[GTM_NF * GTM_FULL_NT]);

/* Largest |F|, ft/s^2 and rad/s^2 alike. */
double gtm_residual_norm(const double F[GTM_NF]);

/* Newton in the six unknowns that `held` leaves free (three are held); 0 when F = 0 was reached. */
int gtm_newton(double y[GTM_NT], const gtm_condition *at, const int held[3]);

/* Newton from several first guesses with V, the rudder (or beta) and phi (or psi_dot) of y held; 0 when it converged. */
int gtm_cold_newton(double y[GTM_NT], const gtm_condition *at, const int held[3]);

/* Largest excess over the bounds, in scaled units. */
double gtm_violation(const double y[GTM_NT], const double lower[GTM_NT], const double upper[GTM_NT]);

/* Solve the square system A x = b (n <= 6, row-major, both overwritten) by elimination; 0, or 1 when singular. */
int gtm_solve(int n, double *A, double *b);

/* min c.x subject to A x <= b (rows of width d) and lower <= x <= upper, d <= 4; 0 when x was found (Seidel). */
int gtm_linear_program(int d, int rows, const double *A, const double *b, const double *c, const double *lower,
                       const double *upper, double *x);

#endif
