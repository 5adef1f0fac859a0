#include "gtm_query.h"

#include <math.h>
#include <string.h>

#include "gtm_t2.h"
#include "linear_model.h"
#include "solver/trim.h"

long gtm_answer_size(void)
{
    return sizeof(gtm_answer);
}

/* Margins to the bounds and the least of them; a held unknown that is met has none. */
static void measure(const gtm_flight *flight, const gtm_bounds *b, gtm_answer *a)
{
    const gtm_problem *p = &flight->problem;
    for (int i = 0; i < p->unknowns; i++) {
        const double scale = p->aircraft->scale[i];
        a->margin[i][GTM_LOWER] = a->y[i] - b->lower[i];
        a->margin[i][GTM_UPPER] = b->upper[i] - a->y[i];
        const int is_met = b->lower[i] == b->upper[i] && fabs(a->margin[i][GTM_LOWER]) <= gtm_rounding * scale;
        for (int side = GTM_LOWER; side <= GTM_UPPER && !is_met; side++) {
            if (a->binding >= 0 && a->margin[i][side] / scale >= a->least_margin) continue;
            a->binding = i;
            a->side = side;
            a->least_margin = a->margin[i][side] / scale;
        }
    }
    if (p->throttles == GTM_ONE_THROTTLE) a->y[THROTTLE_RIGHT] = a->y[THROTTLE];
    a->thrust = gtm_thrust(flight, a->y[V], a->y);
    a->thrust_margin[GTM_LOWER] = a->thrust - gtm_thrust(flight, a->y[V], b->lower);
    a->thrust_margin[GTM_UPPER] = gtm_thrust(flight, a->y[V], b->upper) - a->thrust;
}

static void answer_one(const gtm_configuration *c, enum gtm_throttles throttles, double altitude, double gamma,
                       const double *lower, const double *upper, gtm_answer *a)
{
    gtm_flight flight = gtm_flight_at(c, throttles, altitude, gamma);
    const gtm_bounds b = gtm_bounds_of(&flight, lower, upper);
    memset(a, 0, sizeof *a);
    a->binding = a->side = -1;
    a->status = gtm_find_trim(&flight.problem, b.lower, b.upper, a->y, &a->residual, &a->violation);
    if (a->status == GTM_NO_TRIM) return;
    measure(&flight, &b, a);
    if (a->status != GTM_TRIMMED) return;
    const gtm_verdict verdict = gtm_judge_trim(c, throttles, altitude, gamma, b.lower, b.upper, a->y);
    a->stable = verdict.is_stable;
    a->controllable = verdict.is_controllable;
}

void gtm_query(const gtm_configuration *c, enum gtm_throttles throttles, long n, const double *altitude,
               const double *gamma, const double *lower, const double *upper, gtm_answer *answer)
{
    const int unknowns = gtm_flight_at(c, throttles, 0, 0).problem.unknowns;
    for (long k = 0; k < n; k++)
        answer_one(c, throttles, altitude[k], gamma[k], lower + k * unknowns, upper + k * unknowns, answer + k);
}

void gtm_assess(const gtm_configuration *c, enum gtm_throttles throttles, double altitude, double gamma,
                const double *lower, const double *upper, long n, const double *y, unsigned char *stable,
                unsigned char *controllable)
{
    const int unknowns = gtm_flight_at(c, throttles, altitude, gamma).problem.unknowns;
    for (long k = 0; k < n; k++) {
        const gtm_verdict verdict = gtm_judge_trim(c, throttles, altitude, gamma, lower, upper, y + k * unknowns);
        stable[k] = verdict.is_stable != 0;
        controllable[k] = verdict.is_controllable != 0;
    }
}
