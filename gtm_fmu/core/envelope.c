/* V_min and V_max of a flight condition under limits: local optima are many, so each end is sought from many starts,
   first spread over the whole range, then about the best point found (another bank or deflection may do better). */
#include <math.h>
#include <string.h>

#include "solver.h"

enum { SPEEDS = 6, DESCENT_SPEEDS = 9, BANKS = 3, DEFLECTIONS = 3, NEAR_BANKS = 5, NEAR_DEFLECTIONS = 10 };
static const double slowest = 97, fastest = 320; /* ft/s, of the starts: stall at sea level, and level flight */
static const double steep = -0.095;              /* rad: below, idle thrust is too much at moderate speeds */
static const double fastest_descent = 590;
static const double nearer = 3;                  /* ft/s inside the best end */

/* Cold trims at every combination of speeds, banks and deflections. */
static long starts_at(const gtm_problem *p, int speeds, const double *speed, int banks, const double *bank,
                      int deflections, const double *deflection, double *starts)
{
    double held[3 * DESCENT_SPEEDS * NEAR_BANKS * NEAR_DEFLECTIONS];
    long n = 0;
    for (int i = 0; i < speeds; i++)
        for (int j = 0; j < banks; j++)
            for (int k = 0; k < deflections; k++, n++) {
                held[3 * n] = speed[i];
                held[3 * n + 1] = bank[j];
                held[3 * n + 2] = deflection[k];
            }
    return gtm_find_starts(p, n, held, starts);
}

/* Evenly spread values; one if both ends agree. */
static int spread(double lower, double upper, int count, double *values)
{
    if (lower == upper) count = 1;
    for (int i = 0; i < count; i++) values[i] = count > 1 ? lower + (upper - lower) * i / (count - 1) : lower;
    return count;
}

/* With a throttle for each engine: every start also with more thrust on the left, and on the right. */
static long with_thrust_apart(const gtm_problem *p, long n, double *starts)
{
    static const double apart = 30; /* %, to either side */
    if (p->unknowns < GTM_FULL_NT) return n;
    for (int side = 0; side < 2; side++) {
        double *copy = starts + (side + 1) * n * GTM_FULL_NT;
        memcpy(copy, starts, sizeof *starts * (size_t)n * GTM_FULL_NT);
        for (long i = 0; i < n; i++, copy += GTM_FULL_NT) {
            copy[THROTTLE] += side ? -apart : apart;
            copy[THROTTLE_RIGHT] += side ? apart : -apart;
        }
    }
    return 3 * n;
}

static int better(int status, double value, double violation, int than_status, double than_value,
                  double than_violation)
{
    if (status != than_status) return status < than_status;
    return status == GTM_TRIMMED ? value < than_value : violation < than_violation;
}

int gtm_find_end(const gtm_problem *p, const double *lower, const double *upper, const double *objective, double *y,
                 double *violation)
{
    double starts[DESCENT_SPEEDS * NEAR_BANKS * NEAR_DEFLECTIONS * GTM_FULL_NT];
    double speed[DESCENT_SPEEDS], bank[NEAR_BANKS], deflection[NEAR_DEFLECTIONS];
    const double margin = 0.1 * (upper[PHI] - lower[PHI]);
    const double stall = slowest * sqrt(gtm_condition_at(0, 0).density / p->at.density);
    const int descends = p->at.gamma < steep;
    const double top = fmin(upper[V], descends ? fastest_descent : fastest);
    const int speeds = spread(fmax(lower[V], stall), top, descends ? DESCENT_SPEEDS : SPEEDS, speed);
    int banks = spread(lower[PHI] + margin, upper[PHI] - margin, BANKS, bank);
    int deflections = spread(lower[RUDDER], upper[RUDDER], DEFLECTIONS, deflection);
    long n = starts_at(p, speeds, speed, banks, bank, deflections, deflection, starts);
    int status = gtm_find_extreme(p, lower, upper, objective, n, starts, y, violation);
    if (status == GTM_NO_TRIM) return status;

    banks = spread(lower[PHI] + 0.5 * margin, upper[PHI] - 0.5 * margin, NEAR_BANKS, bank);
    deflections = spread(lower[RUDDER], upper[RUDDER], 5, deflection);
    if (lower[RUDDER] < upper[RUDDER]) {
        static const double about[] = {-3, -1, 1, 3};
        for (int k = 0; k < 4; k++)
            deflection[deflections++] = fmin(fmax(y[RUDDER] + about[k], lower[RUDDER]), upper[RUDDER]);
        if (lower[RUDDER] < 0 && upper[RUDDER] > 0) deflection[deflections++] = 0;
    }
    speed[0] = objective[V] > 0 ? y[V] + nearer : objective[V] < 0 ? y[V] - nearer : y[V];
    n = starts_at(p, 1, speed, banks, bank, deflections, deflection, starts);
    n = with_thrust_apart(p, n, starts);
    double other[GTM_FULL_NT] = {0}, other_violation, value = 0, other_value = 0;
    const int other_status = gtm_find_extreme(p, lower, upper, objective, n, starts, other, &other_violation);
    for (int i = 0; i < p->unknowns; i++) value += objective[i] * y[i], other_value += objective[i] * other[i];
    if (better(other_status, other_value, other_violation, status, value, *violation)) {
        memcpy(y, other, sizeof *y * (size_t)p->unknowns);
        *violation = other_violation;
        status = other_status;
    }
    return status;
}
