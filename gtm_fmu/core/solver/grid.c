#include "solver/grid.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "solver/descent.h"
#include "solver/linear_algebra.h"
#include "solver/newton.h"
#include "solver/trim.h"

enum { MOST_FAILURES = 2, GIVEN_UP = 255, MOST_NEIGHBOURS = 5 };

static const int rudder_held[3] = {V, PSI_DOT, RUDDER}, beta_held[3] = {V, PSI_DOT, BETA};

/* The bounds of one cell of the grid, which hold V and psi_dot. */
typedef struct {
    double lower[GTM_MOST_UNKNOWNS], upper[GTM_MOST_UNKNOWNS];
} cell_bounds;

static cell_bounds bounds_at(const gtm_problem *p, const double *lower, const double *upper, double speed, double rate)
{
    const size_t row = sizeof *lower * (size_t)p->unknowns;
    cell_bounds b;
    memcpy(b.lower, lower, row);
    memcpy(b.upper, upper, row);
    b.lower[V] = b.upper[V] = speed;
    b.lower[PSI_DOT] = b.upper[PSI_DOT] = rate;
    return b;
}

/* Newton to a trim inside the bounds. */
static int finds_inside(const gtm_problem *p, double *y, const int held[3], const cell_bounds *b)
{
    return !gtm_newton(p, y, held) && gtm_violation(p, y, b->lower, b->upper) <= gtm_rounding;
}

/* Whether |beta| grows when the rudder leaves its bound: then the trim y, held there, has the least sideslip. */
static int is_least_sideslip(const gtm_problem *p, const double *y, const double *lower)
{
    double F[GTM_NF], J[GTM_NF * GTM_MOST_UNKNOWNS], A[GTM_NF * GTM_NF], slope[GTM_NF];
    p->aircraft->jacobian(p, y, F, J);
    for (int row = 0; row < GTM_NF; row++) {
        static const int moving[GTM_NF] = {BETA, ALPHA, PHI, ELEVATOR, AILERON, THROTTLE};
        for (int k = 0; k < GTM_NF; k++) A[row * GTM_NF + k] = J[row * p->unknowns + moving[k]];
        slope[row] = -J[row * p->unknowns + RUDDER];
    }
    if (gtm_solve(GTM_NF, A, slope)) return 0;
    const double inward = y[RUDDER] == lower[RUDDER] ? 1 : -1;
    return slope[0] * inward * y[BETA] > 0;
}

/* Descents from two starts towards less sideslip of the first one's sign, then from beyond zero back to it. */
static int descend_to_least_sideslip(const gtm_problem *p, cell_bounds b, const double *starts, double *y)
{
    static const int given[2] = {V, PSI_DOT};
    const double sign = starts[BETA] < 0 ? -1 : 1;
    double objective[GTM_MOST_UNKNOWNS] = {0}, beyond[GTM_MOST_UNKNOWNS], excess;
    objective[BETA] = sign;
    if (gtm_find_extreme(p, b.lower, b.upper, objective, 2, starts, y, &excess) != GTM_TRIMMED)
        return gtm_scan_rudder(p, b.lower, b.upper, given, starts, y) != GTM_TRIMMED;
    if (sign * y[BETA] < 0) {
        memcpy(beyond, y, sizeof *y * (size_t)p->unknowns);
        objective[BETA] = -sign;
        if (sign > 0) b.upper[BETA] = 0;
        else b.lower[BETA] = 0;
        if (gtm_find_extreme(p, b.lower, b.upper, objective, 1, beyond, y, &excess) != GTM_TRIMMED) return 1;
    }
    gtm_join_throttles(p, b.lower, b.upper, y);
    return 0;
}

/* The least |beta| trim at the V and psi_dot of y, from the neighbouring trim y; 0 when it lies inside the bounds. */
static int trim_near(const gtm_problem *p, const double *lower, const double *upper, double *y)
{
    const size_t row = sizeof *y * (size_t)p->unknowns;
    const cell_bounds b = bounds_at(p, lower, upper, y[V], y[PSI_DOT]);
    double starts[2 * GTM_MOST_UNKNOWNS], *second = starts + p->unknowns;
    memcpy(starts, y, row);
    if (gtm_rudder_settles(p, lower, upper)) {
        y[RUDDER] = lower[RUDDER];
        return !finds_inside(p, y, rudder_held, &b);
    }

    y[BETA] = 0;
    const int is_straight = !gtm_newton(p, y, beta_held);
    if (is_straight && gtm_violation(p, y, b.lower, b.upper) <= gtm_rounding) return 0;
    memcpy(second, is_straight ? y : starts, row);

    /* Where that asks for more rudder than there is, all that there is may give the least sideslip. */
    const int is_short = y[RUDDER] < lower[RUDDER] || y[RUDDER] > upper[RUDDER];
    if (p->throttles == GTM_ONE_THROTTLE && is_straight && is_short) {
        memcpy(y, starts, row);
        y[RUDDER] = second[RUDDER] < lower[RUDDER] ? lower[RUDDER] : upper[RUDDER];
        if (finds_inside(p, y, rudder_held, &b) && is_least_sideslip(p, y, lower)) return 0;
    }
    return descend_to_least_sideslip(p, b, starts, y);
}

/* What a grid is filled with, and the cells whose neighbours are next, first in first out. */
typedef struct {
    const gtm_problem *problem;
    const double *lower, *upper, *speed, *rate;
    long speeds, rates;
    unsigned char *feasible, *failures;
    double *y;
    long *queue, tail;
} flood;

/* A cell with a trim waits for its neighbours. */
static void settle(flood *f, long cell, const double *trim)
{
    f->feasible[cell] = 1;
    memcpy(f->y + cell * f->problem->unknowns, trim, sizeof *trim * (size_t)f->problem->unknowns);
    f->queue[f->tail++] = cell;
}

/* Solve a cell from a neighbouring trim unless it is settled. */
static void try_cell(flood *f, long i, long j, const double *from)
{
    const long cell = i * f->rates + j;
    double trial[GTM_MOST_UNKNOWNS];
    if (f->feasible[cell] || f->failures[cell] >= MOST_FAILURES) return;
    memcpy(trial, from, sizeof *from * (size_t)f->problem->unknowns);
    trial[V] = f->speed[i];
    trial[PSI_DOT] = f->rate[j];
    if (trim_near(f->problem, f->lower, f->upper, trial)) f->failures[cell]++;
    else settle(f, cell, trial);
}

/* Solve from cold, once, the cells that failed although most of their neighbours have a trim. */
static void try_enclosed(flood *f)
{
    for (long i = 0; i < f->speeds; i++)
        for (long j = 0; j < f->rates; j++) {
            const long cell = i * f->rates + j;
            if (f->feasible[cell] || f->failures[cell] < MOST_FAILURES || f->failures[cell] == GIVEN_UP) continue;
            int neighbours = 0;
            for (long a = i > 0 ? i - 1 : 0; a <= i + 1 && a < f->speeds; a++)
                for (long b = j > 0 ? j - 1 : 0; b <= j + 1 && b < f->rates; b++)
                    neighbours += f->feasible[a * f->rates + b];
            if (neighbours < MOST_NEIGHBOURS) continue;
            const cell_bounds b = bounds_at(f->problem, f->lower, f->upper, f->speed[i], f->rate[j]);
            double y[GTM_MOST_UNKNOWNS], residual, violation;
            f->failures[cell] = GIVEN_UP;
            if (gtm_find_trim(f->problem, b.lower, b.upper, y, &residual, &violation) == GTM_TRIMMED)
                settle(f, cell, y);
        }
}

long gtm_find_grid(const gtm_problem *p, const double *lower, const double *upper, long speeds, const double *speed,
                   long rates, const double *rate, long n, const double *seeds, unsigned char *feasible, double *y)
{
    const long cells = speeds * rates;
    flood f = {p, lower, upper, speed, rate, speeds, rates, feasible, calloc((size_t)cells, 1), y,
               malloc(sizeof(long) * (size_t)cells), 0};
    memset(feasible, 0, (size_t)cells);
    if (!f.failures || !f.queue) {
        free(f.failures), free(f.queue);
        return -1;
    }
    for (long k = 0; k < n; k++) { /* the cells about a seed */
        const double *seed = seeds + k * p->unknowns;
        long i = 0, j = 0;
        while (i < speeds - 1 && speed[i + 1] <= seed[V]) i++;
        while (j < rates - 1 && rate[j + 1] <= seed[PSI_DOT]) j++;
        for (long a = i; a <= i + 1 && a < speeds; a++)
            for (long b = j; b <= j + 1 && b < rates; b++) {
                f.failures[a * rates + b] = 0;
                try_cell(&f, a, b, seed);
            }
    }
    for (long head = 0; head < f.tail; head++) {
        const long i = f.queue[head] / rates, j = f.queue[head] % rates;
        for (long a = i > 0 ? i - 1 : 0; a <= i + 1 && a < speeds; a++)
            for (long b = j > 0 ? j - 1 : 0; b <= j + 1 && b < rates; b++)
                try_cell(&f, a, b, y + f.queue[head] * p->unknowns);
        if (head + 1 == f.tail) try_enclosed(&f);
    }
    free(f.failures), free(f.queue);
    return f.tail;
}
