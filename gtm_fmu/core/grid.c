/* All trims on a grid of speed and turn rate: a flood from known points, each cell solved from a neighbour's trim. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "solver.h"

enum { V, ALPHA, BETA, PSI_DOT, PHI, ELEVATOR, AILERON, RUDDER, THROTTLE, MOST_FAILURES = 2 };
static const double inside = 1e-9;

/* Whether |beta| grows when the rudder leaves its bound: then the trim y, held there, has the least sideslip. */
static int is_least_sideslip(const double *y, const gtm_condition *at, const double *lower)
{
    double F[GTM_NF], J[GTM_NF * GTM_NT], A[GTM_NF * GTM_NF], slope[GTM_NF];
    gtm_trim_jacobian(y, at, F, J);
    for (int row = 0; row < GTM_NF; row++) {
        static const int moving[GTM_NF] = {BETA, ALPHA, PHI, ELEVATOR, AILERON, THROTTLE};
        for (int k = 0; k < GTM_NF; k++) A[row * GTM_NF + k] = J[row * GTM_NT + moving[k]];
        slope[row] = -J[row * GTM_NT + RUDDER];
    }
    if (gtm_solve(GTM_NF, A, slope)) return 0;
    return slope[0] * (y[RUDDER] == lower[RUDDER] ? 1 : -1) * y[BETA] > 0;
}

/* The least |beta| trim at the V and psi_dot of y, from the neighbouring trim y; 0 when it lies inside the bounds. */
static int trim_near(double altitude, double gamma, const gtm_condition *at, const double *lower, const double *upper,
                     double *y)
{
    static const int rudder_held[3] = {V, PSI_DOT, RUDDER}, beta_held[3] = {V, PSI_DOT, BETA};
    double held_lower[GTM_NT], held_upper[GTM_NT], starts[2][GTM_NT];
    memcpy(held_lower, lower, sizeof held_lower);
    memcpy(held_upper, upper, sizeof held_upper);
    held_lower[V] = held_upper[V] = y[V];
    held_lower[PSI_DOT] = held_upper[PSI_DOT] = y[PSI_DOT];
    memcpy(starts[0], y, sizeof starts[0]);

    if (lower[RUDDER] == upper[RUDDER]) {
        y[RUDDER] = lower[RUDDER];
        return gtm_newton(y, at, rudder_held) || gtm_violation(y, held_lower, held_upper) > inside;
    }
    y[BETA] = 0;
    const int without_slip = !gtm_newton(y, at, beta_held);
    if (without_slip && gtm_violation(y, held_lower, held_upper) <= inside) return 0;
    memcpy(starts[1], without_slip ? y : starts[0], sizeof starts[1]);
    if (without_slip && (y[RUDDER] < lower[RUDDER] || y[RUDDER] > upper[RUDDER])) {
        memcpy(y, starts[0], sizeof starts[0]);
        y[RUDDER] = starts[1][RUDDER] < lower[RUDDER] ? lower[RUDDER] : upper[RUDDER];
        if (!gtm_newton(y, at, rudder_held) && gtm_violation(y, held_lower, held_upper) <= inside &&
            is_least_sideslip(y, at, lower))
            return 0;
    }
    /* Towards less sideslip of the neighbour's sign, then from beyond zero back to it. */
    double objective[GTM_NT] = {0}, excess;
    const double sign = objective[BETA] = starts[0][BETA] < 0 ? -1 : 1;
    if (gtm_extreme(altitude, gamma, held_lower, held_upper, objective, 2, starts[0], y, &excess) != GTM_TRIMMED)
        return 1;
    if (sign * y[BETA] >= 0) return 0;
    memcpy(starts[0], y, sizeof starts[0]);
    objective[BETA] = -sign;
    (sign > 0 ? held_upper : held_lower)[BETA] = 0;
    return gtm_extreme(altitude, gamma, held_lower, held_upper, objective, 1, starts[0], y, &excess) != GTM_TRIMMED;
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
