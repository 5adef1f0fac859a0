/* Steady manoeuvres as points of a manifold: F(y) = 0, six accelerations of nine unknowns (names.TRIM_UNKNOWNS), or of
   ten where each engine has its throttle (names.FULL_TRIM_UNKNOWNS). */
#ifndef GTM_SOLVER_H
#define GTM_SOLVER_H

#include "gtm_configuration.h"
#include "gtm_core.h"

enum { GTM_NF = 6 };

/* Places of the unknowns; with a throttle for each engine, THROTTLE is the left one. */
enum { V, ALPHA, BETA, PSI_DOT, PHI, ELEVATOR, AILERON, RUDDER, THROTTLE, THROTTLE_RIGHT };

/* What a trim takes as given: flight-path angle in rad, air density in slug/ft^3, pressure ratio. */
typedef struct {
    double gamma, density, pressure_ratio;
} gtm_condition;

/* A flight condition of an airframe. Its unknowns are GTM_NT, both engines following one throttle, or GTM_FULL_NT. */
typedef struct {
    gtm_condition at;
    const gtm_configuration *configuration; /* 0: the study's */
    int unknowns;
    unsigned char is_dead[GTM_FULL_NT]; /* controls that move nothing */
    double highest_alpha;               /* rad; Newton's iterates stay below it */
} gtm_problem;

extern const double gtm_usual_alpha; /* rad, beyond any trim inside the study's bounds */

gtm_condition gtm_condition_at(double altitude, double gamma);
gtm_problem gtm_problem_at(const gtm_configuration *c, int unknowns, double altitude, double gamma);

/* Accelerations of the problem's unknowns; the Jacobian has a column for each of them. */
void gtm_problem_residual(const gtm_problem *p, const double *y, double F[GTM_NF]);
void gtm_problem_jacobian(const gtm_problem *p, const double *y, double F[GTM_NF], double *J);

/* Largest |F|, ft/s^2 and rad/s^2 alike. */
double gtm_residual_norm(const double F[GTM_NF]);

/* Newton with the unknowns of `held` and the dead controls kept, the last of `held` freed where that is too many; two
   throttles that are free move together. 0 when F = 0 was reached. */
int gtm_newton(const gtm_problem *p, double *y, const int held[3]);

void gtm_full_trim_residual(const gtm_configuration *c, const double y[GTM_FULL_NT], const gtm_condition *at,
                            double F[GTM_NF]);
void gtm_full_trim_jacobian(const gtm_configuration *c, const double y[GTM_FULL_NT], const gtm_condition *at,
                            double F[GTM_NF], double J[GTM_NF * GTM_FULL_NT]);

/* Newton from several first guesses, with what it keeps taken from y. */
int gtm_cold_newton(const gtm_problem *p, double *y, const int held[3]);

/* Largest excess over the bounds, in scaled units. */
double gtm_violation(const gtm_problem *p, const double *y, const double *lower, const double *upper);

/* Where slopes hold: the interval of each unknown between breakpoints, and no limits for those without. */
typedef struct {
    double lower[GTM_FULL_NT], upper[GTM_FULL_NT];
} gtm_cell;

enum { GTM_KINKED = 6 };
extern const int gtm_kinked[GTM_KINKED]; /* the unknowns with breakpoints */
extern const double gtm_border;          /* of a scale unit: this near to a breakpoint is on it */

/* The cell without breakpoints, and that of y: on a breakpoint it lies below if y is at its upper bound, else above. */
gtm_cell gtm_open_cell(void);
gtm_cell gtm_cell_at(const gtm_problem *p, const double *y, const double *upper);

/* The cell on the given side of the breakpoint that an unknown lies on. */
gtm_cell gtm_cell_beyond(const gtm_problem *p, const gtm_cell *c, int unknown, double value, int above);

/* Follow y to its cell; an unknown on the border of its old interval stays there. */
void gtm_update_cell(const gtm_problem *p, gtm_cell *c, const double *y);

/* The functions of gtm_core.h and gtm_configuration.h on a problem. */
int gtm_find_trim(const gtm_problem *p, const double *lower, const double *upper, double *y, double *residual,
                  double *violation);
long gtm_find_starts(const gtm_problem *p, long n, const double *held, double *y);
int gtm_find_extreme(const gtm_problem *p, const double *lower, const double *upper, const double *objective, long n,
                     const double *starts, double *best, double *violation);
int gtm_find_end(const gtm_problem *p, const double *lower, const double *upper, const double *objective, double *best,
                 double *violation);
long gtm_find_grid(const gtm_problem *p, const double *lower, const double *upper, long speeds, const double *speed,
                   long rates, const double *rate, long n, const double *seeds, unsigned char *feasible, double *y);

/* Whether the rudder is held and no second throttle is left: a trim at given V and psi_dot is unique then. */
int gtm_rudder_settles(const gtm_problem *p, const double *lower, const double *upper);

/* Least |beta| under bounds that hold the two `given` unknowns and leave another control than the rudder hardly any range:
   all deflections of the rudder are gone through, and every bound that is met between two of them. GTM_TRIMMED, or not. */
int gtm_scan_rudder(const gtm_problem *p, const double *lower, const double *upper, const int given[2],
                    const double *start, double *y);

/* V and psi_dot. */
extern const int gtm_usual[2];

/* Where y has no sideslip, separate throttles are not settled yet: bring them together as far as the bounds allow. */
void gtm_join_throttles(const gtm_problem *p, const double *lower, const double *upper, double *y);

/* Solve the square system A x = b (n <= 6, row-major, both overwritten) by elimination; 0, or 1 when singular. */
int gtm_solve(int n, double *A, double *b);

/* min c.x subject to A x <= b (rows of width d) and lower <= x <= upper, d <= 5; 0 when x was found (Seidel). */
int gtm_linear_program(int d, int rows, const double *A, const double *b, const double *c, const double *lower,
                       const double *upper, double *x);

#endif
