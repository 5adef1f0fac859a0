#include "solver/grid.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "solver/descent.h"
#include "solver/linear_algebra.h"
#include "solver/newton.h"
#include "solver/trim.h"

enum { MOST_FAILURES = 2, GIVEN_UP = 255, MOST_NEIGHBOURS = 5 };

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
    return slope[0] * (y[RUDDER] == lower[RUDDER] ? 1 : -1) * y[BETA] > 0;
}

/* The least |beta| trim at the V and psi_dot of y, from the neighbouring trim y; 0 when it lies inside the bounds. */
static int trim_near(const gtm_problem *p, const double *lower, const double *upper, double *y)
{
    static const int held[2] = {V, PSI_DOT}, rudder_held[3] = {V, PSI_DOT, RUDDER}, beta_held[3] = {V, PSI_DOT, BETA};
    const size_t row = sizeof *y * (size_t)p->unknowns;
    double held_lower[GTM_MOST_UNKNOWNS], held_upper[GTM_MOST_UNKNOWNS], starts[2 * GTM_MOST_UNKNOWNS], *second = starts + p->unknowns;
    memcpy(held_lower, lower, row);
    memcpy(held_upper, upper, row);
    held_lower[V] = held_upper[V] = y[V];
    held_lower[PSI_DOT] = held_upper[PSI_DOT] = y[PSI_DOT];
    memcpy(starts, y, row);

    if (gtm_rudder_settles(p, lower, upper)) {
        y[RUDDER] = lower[RUDDER];
        return gtm_newton(p, y, rudder_held) || gtm_violation(p, y, held_lower, held_upper) > gtm_rounding;
    }
    y[BETA] = 0;
    const int without_slip = !gtm_newton(p, y, beta_held);
    if (without_slip && gtm_violation(p, y, held_lower, held_upper) <= gtm_rounding) return 0;
    memcpy(second, without_slip ? y : starts, row);
    if (p->throttles == GTM_ONE_THROTTLE && without_slip && (y[RUDDER] < lower[RUDDER] || y[RUDDER] > upper[RUDDER])) {
        memcpy(y, starts, row);
        y[RUDDER] = second[RUDDER] < lower[RUDDER] ? lower[RUDDER] : upper[RUDDER];
        if (!gtm_newton(p, y, rudder_held) && gtm_violation(p, y, held_lower, held_upper) <= gtm_rounding &&
            is_least_sideslip(p, y, lower))
            return 0;
    }
    /* Towards less sideslip of the neighbour's sign, then from beyond zero back to it. */
    double objective[GTM_MOST_UNKNOWNS] = {0}, excess;
    const double sign = objective[BETA] = starts[BETA] < 0 ? -1 : 1;
    if (gtm_find_extreme(p, held_lower, held_upper, objective, 2, starts, y, &excess) != GTM_TRIMMED)
        return gtm_scan_rudder(p, held_lower, held_upper, held, starts, y) != GTM_TRIMMED;
    if (sign * y[BETA] < 0) {
        memcpy(starts, y, row);
        objective[BETA] = -sign;
        (sign > 0 ? held_upper : held_lower)[BETA] = 0;
        if (gtm_find_extreme(p, held_lower, held_upper, objective, 1, starts, y, &excess) != GTM_TRIMMED) return 1;
    }
    gtm_join_throttles(p, held_lower, held_upper, y);
    return 0;
}

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
            double lower[GTM_MOST_UNKNOWNS], upper[GTM_MOST_UNKNOWNS], y[GTM_MOST_UNKNOWNS], residual, violation;
            memcpy(lower, f->lower, sizeof *lower * (size_t)f->problem->unknowns);
            memcpy(upper, f->upper, sizeof *upper * (size_t)f->problem->unknowns);
            lower[V] = upper[V] = f->speed[i];
            lower[PSI_DOT] = upper[PSI_DOT] = f->rate[j];
            f->failures[cell] = GIVEN_UP;
            if (gtm_find_trim(f->problem, lower, upper, y, &residual, &violation) == GTM_TRIMMED) settle(f, cell, y);
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
