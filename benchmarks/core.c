/* Nanoseconds of one call from C, over 1000 rows of random states near a trim, again and again. */
#define _POSIX_C_SOURCE 199309L
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "gtm_core.h"

enum { ROWS = 1000, ROUNDS = 200 };
static double x[ROWS][GTM_NX], u[ROWS][GTM_NU], dx[ROWS][GTM_NX], jacobian[ROWS][GTM_NX * GTM_NXU];

static double seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return now.tv_sec + 1e-9 * now.tv_nsec;
}

static double uniform(double low, double high)
{
    return low + (high - low) * rand() / RAND_MAX;
}

int main(void)
{
    for (int i = 0; i < ROWS; i++) {
        const double state[GTM_NX] = {uniform(120, 250),   uniform(-25, 25),   uniform(0, 35),
                                      uniform(-0.3, 0.3),  uniform(-0.2, 0.2), uniform(-0.3, 0.3),
                                      0.66,                -1.3,               uniform(0, 30000),
                                      uniform(-0.5, 0.5),  uniform(-0.2, 0.2), uniform(-3, 3)};
        const double control[GTM_NU] = {uniform(-10, 10), uniform(-15, 15), uniform(-25, 25), uniform(0, 100)};
        for (int k = 0; k < GTM_NX; k++) x[i][k] = state[k];
        for (int k = 0; k < GTM_NU; k++) u[i][k] = control[k];
    }
    double least_xdot = 1, least_jacobian = 1;
    for (int round = 0; round < ROUNDS; round++) {
        double start = seconds();
        gtm_derivatives_batch(ROWS, x[0], u[0], dx[0]);
        double taken = (seconds() - start) / ROWS;
        if (taken < least_xdot) least_xdot = taken;
        start = seconds();
        gtm_jacobian_batch(ROWS, x[0], u[0], dx[0], jacobian[0]);
        taken = (seconds() - start) / ROWS;
        if (taken < least_jacobian) least_jacobian = taken;
    }
    printf("%.1f %.1f\n", 1e9 * least_xdot, 1e9 * least_jacobian);
    return 0;
}
