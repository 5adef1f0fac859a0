/* All trims on a grid of speed and turn rate: a flood from known points, each cell solved from a neighbour's trim. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "solver.h"

enum { V = 0, BETA = 2, PSI_DOT = 3, RUDDER = 7, MOST_FAILURES = 3 };
static const double inside = 1e-9;

/* The least |beta| trim at the V and psi_dot of y, from the neighbouring trim y; 0 when it lies inside the bounds. */
static int trim_near(double altitude, double gamma, const gtm_condition *at, const double *lower, const double *upper,
                     double *y)
{
    static const int rudder_held[3] = {V, PSI_DOT, RUDDER}, beta_held[3] = {V, PSI_DOT, BETA};
    const int jammed = lower[RUDDER] == upper[RUDDER];
    double bounded_lower[GTM_NT], bounded_upper[GTM_NT], start[GTM_NT];
    memcpy(bounded_lower, lower, sizeof bounded_lower);
    memcpy(bounded_upper, upper, sizeof bounded_upper);
    memcpy(start, y, sizeof start);
    bounded_lower[V] = bounded_upper[V] = y[V];
    bounded_lower[PSI_DOT] = bounded_upper[PSI_DOT] = y[PSI_DOT];

    if (jammed)
        y[RUDDER] = lower[RUDDER];
    else
        y[BETA] = 0;
    if (!gtm_newton(y, at, jammed ? rudder_held : beta_held) &&
        gtm_violation(y, bounded_lower, bounded_upper) <= inside)
        return 0;
    if (jammed) return 1;

    /* Without beta = 0 the trims of one cell have sideslip of one sign; the neighbour's tells which to try first. */
    for (int side = 0; side < 2; side++) {
        const double sign = (start[BETA] < 0) == (side == 0) ? -1 : 1;
        double one_sided[GTM_NT], other[GTM_NT], objective[GTM_NT] = {0}, excess;
        memcpy(one_sided, bounded_lower, sizeof one_sided);
        memcpy(other, bounded_upper, sizeof other);
        if (sign > 0)
            one_sided[BETA] = fmax(one_sided[BETA], 0);
        else
            other[BETA] = fmin(other[BETA], 0);
        objective[BETA] = sign;
        if (gtm_extreme(altitude, gamma, one_sided, other, objective, 1, start, y, &excess) == GTM_TRIMMED) return 0;
    }
    return 1;
}

typedef struct {
    double altitude, gamma;
    gtm_condition at;
    const double *lower, *upper, *speed, *rate;
    long rates;
    unsigned char *feasible, *failures;
    double *y;
    long *queue, tail;
} flood;

/* Solve a cell from a neighbouring trim unless it is settled; a feasible one waits for its own neighbours. */
static void try_cell(flood *f, long i, long j, const double *from)
{
    const long cell = i * f->rates + j;
    double trial[GTM_NT];
    if (f->feasible[cell] || f->failures[cell] >= MOST_FAILURES) return;
    memcpy(trial, from, sizeof trial);
    trial[V] = f->speed[i];
    trial[PSI_DOT] = f->rate[j];
    if (trim_near(f->altitude, f->gamma, &f->at, f->lower, f->upper, trial)) {
        f->failures[cell]++;
        return;
    }
    f->feasible[cell] = 1;
    memcpy(f->y + cell * GTM_NT, trial, sizeof trial);
    f->queue[f->tail++] = cell;
}

long gtm_grid(double altitude, double gamma, const double lower[GTM_NT], const double upper[GTM_NT], long speeds,
              const double *speed, long rates, const double *rate, long n, const double *seeds,
              unsigned char *feasible, double *y)
{
    const long cells = speeds * rates;
    flood f = {altitude, gamma, gtm_condition_at(altitude, gamma), lower, upper, speed, rate, rates, feasible,
               calloc((size_t)cells, 1), y, malloc(sizeof(long) * (size_t)cells), 0};
    memset(feasible, 0, (size_t)cells);
    if (!f.failures || !f.queue) {
        free(f.failures), free(f.queue);
        return -1;
    }
    for (long k = 0; k < n; k++) { /* the cells about a seed */
        const double *seed = seeds + k * GTM_NT;
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
                try_cell(&f, a, b, y + f.queue[head] * GTM_NT);
    }
    free(f.failures), free(f.queue);
    return f.tail;
}
