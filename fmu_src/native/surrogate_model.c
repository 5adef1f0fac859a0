/* V_min and V_max of a flight condition with a failed rudder, learnt, and how far a speed is inside. */
#include <string.h>

#include "model.h"
#include "speeds.h"
#include "throttle.h"

/* The fault after FAULT_NOT_FINITE. */
enum { FAULT_REVERSED = 2 };

enum { CASE = speeds_inputs, LOWEST = 0, HIGHEST = 1 };

/* Inputs and outputs by their places in u and y. */
#define IN(name) ((name) - INPUTS)
#define OUT(name) ((name) - OUTPUTS)

static int is_reversed(const double u[]) { return u[IN(RUDDER_LOWER)] > u[IN(RUDDER_UPPER)]; }

int model_outputs(const double x[], const double u[], const double values[], double memory[], double y[])
{
    (void)x, (void)values, (void)memory;
    if (is_reversed(u)) return FAULT_REVERSED;
    const double *const asked = u + IN(ALTITUDE);
    double v[2], least_throttle;
    speeds_predict(asked, v);
    throttle_predict(asked, &least_throttle);
    y[OUT(V_MIN)] = v[LOWEST];
    y[OUT(V_MAX)] = v[HIGHEST];
    y[OUT(FEASIBLE)] = least_throttle <= model_full_throttle_pct[0] && v[LOWEST] <= v[HIGHEST];
    y[OUT(IN_DOMAIN)] = speeds_in_range(asked, ROUNDING);
    y[OUT(MARGIN_SLOW)] = u[IN(TAS)] - v[LOWEST];
    y[OUT(MARGIN_FAST)] = v[HIGHEST] - u[IN(TAS)];
    return 0;
}

int model_deferred_outputs(const double x[], const double u[], const double values[], double memory[], double y[])
{
    (void)x, (void)values, (void)memory;
    if (is_reversed(u)) return FAULT_REVERSED;
    speeds_std(u + IN(ALTITUDE), y);
    return 0;
}

/* Slopes of an output: a sign times those of `slopes`, and one with respect to the speed. */
static void put_row(double jacobian[], int output, double sign, const double slopes[], double of_tas)
{
    double *const row = jacobian + output * N_KNOWNS;
    for (int k = 0; k < CASE; k++) row[IN(ALTITUDE) + k] = sign * slopes[k];
    row[IN(TAS)] = of_tas;
}

int model_jacobian(const double x[], const double u[], const double values[], double memory[], double jacobian[])
{
    (void)x, (void)values, (void)memory;
    if (is_reversed(u)) return FAULT_REVERSED;
    double v[2], slopes[2 * CASE];
    speeds_gradient(u + IN(ALTITUDE), v, slopes);
    memset(jacobian, 0, N_UNKNOWNS * N_KNOWNS * sizeof *jacobian);
    put_row(jacobian, OUT(V_MIN), 1, slopes, 0);
    put_row(jacobian, OUT(V_MAX), 1, slopes + CASE, 0);
    put_row(jacobian, OUT(MARGIN_SLOW), -1, slopes, 1);
    put_row(jacobian, OUT(MARGIN_FAST), 1, slopes + CASE, -1);
    return 0;
}

int model_deferred_jacobian(const double x[], const double u[], const double values[], double memory[],
                            double jacobian[])
{
    (void)x, (void)values, (void)memory;
    if (is_reversed(u)) return FAULT_REVERSED;
    double std[2], of_std[2 * CASE];
    speeds_std_gradient(u + IN(ALTITUDE), std, of_std);
    put_row(jacobian, OUT(V_MIN_STD), 1, of_std, 0);
    put_row(jacobian, OUT(V_MAX_STD), 1, of_std + CASE, 0);
    return 0;
}
