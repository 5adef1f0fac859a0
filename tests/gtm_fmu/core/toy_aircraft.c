/* An aircraft in closed form, handed to the solver as the GTM-T2 is, and the solver's parts on plain arrays.

   Steady manoeuvres: throttle = 10 + (V - 100)^2 / 50, beta = 0.002 rudder (1 + V / 300), alpha = 900 / V^2,
   V psi_dot = 32 tan phi, aileron = -rudder / 2 (-rudder beyond 10 deg: a kink), elevator = 3 - 20 alpha.
   With `toy_set_drag` sideslip makes drag: throttle grows by drag (rudder - without)^2. */
#include <math.h>
#include <string.h>

#include "solver/cell.h"
#include "solver/cold_start.h"
#include "solver/descent.h"
#include "solver/ends.h"
#include "solver/grid.h"
#include "solver/manifold.h"
#include "solver/step.h"
#include "solver/trim.h"

static const double scale[GTM_MOST_UNKNOWNS] = {30, 0.05, 0.05, 0.1, 0.17, 4, 4, 6, 20, 20};
static const double longest[GTM_MOST_UNKNOWNS] = {60, 0.1, 0.1, 0.2, 0.25, 10, 10, 10, 60, 60};
static const double least[GTM_MOST_UNKNOWNS] = {20, -0.5, -0.7, -3, -1.4, -60, -60, -60, -60, -60};
static const double most[GTM_MOST_UNKNOWNS] = {600, 0.5, 0.7, 3, 1.4, 60, 60, 60, 400, 400};
static const double kink = 10; /* deg of rudder */
static double drag = 0, without = 0;

static void residual(const gtm_problem *p, const double *y, double F[GTM_NF])
{
    (void)p;
    const double beyond = y[RUDDER] > kink ? y[RUDDER] - kink : 0;
    F[0] = y[THROTTLE] - 10 - (y[V] - 100) * (y[V] - 100) / 50
           - drag * (y[RUDDER] - without) * (y[RUDDER] - without);
    F[1] = 100 * (y[BETA] - 0.002 * y[RUDDER] * (1 + y[V] / 300));
    F[2] = (y[ALPHA] * y[V] * y[V] - 900) / 30;
    F[3] = y[V] * y[PSI_DOT] - 32 * tan(y[PHI]);
    F[4] = y[AILERON] + 0.5 * y[RUDDER] + 0.5 * beyond;
    F[5] = y[ELEVATOR] - 3 + 20 * y[ALPHA];
}

static void jacobian(const gtm_problem *p, const double *y, double F[GTM_NF], double *J)
{
    const int n = p->unknowns;
    residual(p, y, F);
    memset(J, 0, sizeof *J * GTM_NF * (size_t)n);
    J[0 * n + THROTTLE] = 1;
    J[0 * n + V] = -(y[V] - 100) / 25;
    J[0 * n + RUDDER] = -2 * drag * (y[RUDDER] - without);
    J[1 * n + BETA] = 100;
    J[1 * n + RUDDER] = -0.2 * (1 + y[V] / 300);
    J[1 * n + V] = -0.2 * y[RUDDER] / 300;
    J[2 * n + ALPHA] = y[V] * y[V] / 30;
    J[2 * n + V] = 2 * y[ALPHA] * y[V] / 30;
    J[3 * n + V] = y[PSI_DOT];
    J[3 * n + PSI_DOT] = y[V];
    J[3 * n + PHI] = -32 / (cos(y[PHI]) * cos(y[PHI]));
    J[4 * n + AILERON] = 1;
    J[4 * n + RUDDER] = y[RUDDER] >= kink ? 1 : 0.5;
    J[5 * n + ELEVATOR] = 1;
    J[5 * n + ALPHA] = 20;
}

static void cut(const gtm_problem *p, int unknown, gtm_interval *i)
{
    (void)p;
    if (unknown != RUDDER) return;
    gtm_cut(i, -kink);
    gtm_cut(i, kink);
}

static gtm_speeds speeds(const gtm_problem *p)
{
    (void)p;
    return (gtm_speeds){60, 250, 0};
}

static const gtm_aircraft toy = {
    .scale = scale, .longest_step = longest, .least = least, .most = most,
    .kinked = {ALPHA, BETA, PSI_DOT, ELEVATOR, AILERON, RUDDER},
    .point_mass = {.wing_area = 6, .gravity = 32, .lift = 0.2, .lift_slope = 4.8, .least_lift = 0.1, .most_lift = 1.1,
                   .side_force_slope = 0.5, .alpha = 0.07, .least_alpha = 0, .most_alpha = 0.2, .slowest = 60,
                   .fastest = 300},
    .guess = {{0.2, 50}, {0.2, 100}, {0.1, 50}, {0.5, 50}, {0, 50}},
    .spacing = {.glide_sideslip = 0.1, .inside = 1, .beyond = 2, .beside = {-3, -2, -1, 1, 2, 3}, .thrust_apart = 30,
                .rudder_piece = 10},
    .speeds = speeds, .cut = cut, .residual = residual, .jacobian = jacobian,
};

static const gtm_problem problem = {&toy, GTM_ONE_THROTTLE, GTM_NT, {0}, 0.5, 0.002, 60};

void toy_set_drag(double per_square_deg, double rudder_without)
{
    drag = per_square_deg;
    without = rudder_without;
}

void toy_jacobian(const double *y, double *F, double *J)
{
    jacobian(&problem, y, F, J);
}

/* ---- Cells ---- */

void toy_cell_at(const double *y, const double *upper, gtm_cell *c)
{
    *c = gtm_cell_at(&problem, y, upper);
}

void toy_cell_beyond(const gtm_cell *c, int unknown, double value, int above, gtm_cell *beyond)
{
    *beyond = gtm_cell_beyond(&problem, c, unknown, value, above);
}

void toy_update_cell(gtm_cell *c, const double *y)
{
    gtm_update_cell(&problem, c, y);
}

void toy_find_breakpoints(const double *y, unsigned char *is_on)
{
    gtm_find_breakpoints(&problem, y, is_on);
}

/* ---- Manifold ---- */

/* Dimension of the tangent space, its directions [10][4] and their second derivatives [10][4][4]; -1 without one. */
int toy_tangent(const double *y, const int *is_free, double *direction, double *second)
{
    const gtm_cell c = gtm_cell_at(&problem, y, most);
    gtm_tangent t;
    gtm_curvature bend;
    if (gtm_tangent_at(y, &problem, is_free, &c, 0, &t)) return -1;
    if (gtm_curvature_at(y, &problem, &c, &t, &bend)) return -1;
    memcpy(direction, t.direction, sizeof t.direction);
    memcpy(second, bend.of, sizeof bend.of);
    return t.count;
}

int toy_project(double *y, const int *movable, double enough)
{
    double J[GTM_NF * GTM_MOST_UNKNOWNS];
    return gtm_project(y, &problem, movable, enough, J);
}

int toy_project_along_bounds(double *y, const double *lower, const double *upper, const int *is_free)
{
    double J[GTM_NF * GTM_MOST_UNKNOWNS];
    const gtm_cell c = gtm_open_cell();
    return gtm_project_along_bounds(y, &problem, lower, upper, &c, is_free, 1e-11, J);
}

/* ---- Steps ---- */

/* The linear model about y, its best x, and the quadratic step from there with what it promises: A has `dimension`
   columns. Returns the number of rows, -1 without a step. */
int toy_steps(const double *y, const double *lower, const double *upper, const double *objective, double radius,
              int *dimension, double *A, double *b, double *price, double *violation, double *x, double *quadratic,
              double *promised, double *direction)
{
    gtm_search s = {&problem, lower, upper, objective, {0}};
    const gtm_cell c = gtm_cell_at(&problem, y, upper);
    gtm_tangent t;
    gtm_curvature bend;
    gtm_linear_model l;
    for (int i = 0; i < GTM_NT; i++) s.is_free[i] = lower[i] != upper[i];
    if (gtm_tangent_at(y, &problem, s.is_free, &c, 0, &t) || gtm_curvature_at(y, &problem, &c, &t, &bend)) return -1;
    gtm_linear_model_at(&s, y, &t, &c, radius, &l);
    if (gtm_linear_step(&l, x)) return -1;
    memcpy(quadratic, x, sizeof *x * GTM_MOST_X);
    *promised = gtm_quadratic_step(&s, &l, &bend, quadratic);
    *dimension = l.dimension;
    memcpy(A, l.A, sizeof *A * (size_t)(l.rows * l.dimension));
    memcpy(b, l.b, sizeof *b * (size_t)l.rows);
    memcpy(price, l.price, sizeof l.price);
    memcpy(direction, t.direction, sizeof t.direction);
    *violation = l.violation;
    return l.rows;
}

/* ---- Above: trims, ends, grid ---- */

int toy_trim(const double *lower, const double *upper, double *y, double *residual, double *violation)
{
    return gtm_find_trim(&problem, lower, upper, y, residual, violation);
}

int toy_end(const double *lower, const double *upper, const double *objective, double *best, double *violation)
{
    return gtm_find_end(&problem, lower, upper, objective, best, violation, 0);
}

int toy_pieces(double lower, double upper, int most, double *border)
{
    return gtm_pieces(&problem, lower, upper, most, border);
}

long toy_grid(const double *lower, const double *upper, long speeds, const double *speed, long rates, const double *rate,
              long seeds, const double *seed, unsigned char *feasible, double *y)
{
    return gtm_find_grid(&problem, lower, upper, speeds, speed, rates, rate, seeds, seed, feasible, y);
}
