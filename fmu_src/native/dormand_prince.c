#include "dormand_prince.h"

#include <math.h>
#include <string.h>

enum { STAGES = 7, MOST_STEPS = 100000 };

/* Row s gives the point at which stage s + 1 is taken; the last row is the solution of order 5. */
static const double A[STAGES - 1][STAGES - 1] = {
    {1.0 / 5},
    {3.0 / 40, 9.0 / 40},
    {44.0 / 45, -56.0 / 15, 32.0 / 9},
    {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
    {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
    {35.0 / 384, 0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84}};

/* Order 5 less order 4. */
static const double E[STAGES] = {71.0 / 57600,      0,          -71.0 / 16695, 71.0 / 1920,
                                 -17253.0 / 339200, 22.0 / 525, -1.0 / 40};

/* Stages 1 to 6 of a step h from x, whose derivatives k[0] are known; x_new is the solution of order 5. */
static int take_step(const double x[], const double u[], const double values[], const double memory[], double h,
                     double k[STAGES][ROOM(N_STATES)], double x_new[])
{
    int fault = 0;
    for (int s = 1; s < STAGES && !fault; s++) {
        for (int i = 0; i < N_STATES; i++) {
            double slope = 0;
            for (int j = 0; j < s; j++) slope += A[s - 1][j] * k[j][i];
            x_new[i] = x[i] + h * slope;
        }
        fault = model_derivatives(x_new, u, values, memory, k[s]);
    }
    return fault;
}

/* Error of a step in units of what is allowed. */
static double error_of(const double x[], const double x_new[], double h, double k[STAGES][ROOM(N_STATES)],
                       double tolerance, const double size[])
{
    double squares = 0;
    for (int i = 0; i < N_STATES; i++) {
        double slope = 0;
        for (int s = 0; s < STAGES; s++) slope += E[s] * k[s][i];
        const double relative = h * slope / (tolerance * (size[i] + fmax(fabs(x[i]), fabs(x_new[i]))));
        squares += relative * relative;
    }
    return sqrt(squares / ROOM(N_STATES));
}

int dormand_prince(double x[], const double u[], const double values[], const double memory[], double duration,
                   double tolerance, const double size[], int missed)
{
    double k[STAGES][ROOM(N_STATES)], x_new[ROOM(N_STATES)], time = 0, h = duration;
    int fault = model_derivatives(x, u, values, memory, k[0]);
    for (int n = 0; time < duration && !fault; n++) {
        if (n == MOST_STEPS || !(h > 1e-12 * duration)) return missed;
        if (h > (1 - 1e-12) * (duration - time)) h = duration - time;
        const int stage_fault = take_step(x, u, values, memory, h, k, x_new);
        const double error = stage_fault ? INFINITY : error_of(x, x_new, h, k, tolerance, size);
        if (error <= 1) {
            time = h == duration - time ? duration : time + h;
            memcpy(x, x_new, N_STATES * sizeof *x);
            memcpy(k[0], k[STAGES - 1], sizeof k[0]);
        } else if (stage_fault && h <= 1e-9 * duration)
            fault = stage_fault;
        h *= error > 0 ? fmin(5, fmax(0.2, 0.9 * pow(error, -0.2))) : 5;
    }
    return fault;
}
