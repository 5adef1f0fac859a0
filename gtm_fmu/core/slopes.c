#include "gtm_slopes.h"

#include <math.h>
#include <string.h>

#include "gtm/configured_table.h"
#include "gtm_t2.h"
#include "solver/end_slopes.h"

/* A flight condition and an airframe, one value of which is moved. */
typedef struct {
    double altitude, gamma;
    enum gtm_throttles throttles;
    gtm_configuration airframe;
    int is_study; /* the airframe is the study's, which its own functions know */
} place;

typedef enum {
    ALTITUDE, PATH, STABILIZER, FLAPS, SPOILERS, FUEL, TOLERANCES,
    MASS = TOLERANCES, CG, COEFFICIENTS = CG + 3, QUANTITIES = COEFFICIENTS + GTM_NC
} quantity;

/* Of differences: their error is of the second order in these, and rounding is below it. */
static double step_of(quantity q)
{
    static const double part = 1e-4;
    switch (q) {
    case ALTITUDE: return 1;
    case PATH: return 1e-5;
    case STABILIZER: return part * (gtm_stabilizer_deg_range.highest - gtm_stabilizer_deg_range.lowest);
    case FLAPS: return part * (gtm_flap_deg_range.highest - gtm_flap_deg_range.lowest);
    case SPOILERS: return part * (gtm_spoiler_deg_range.highest - gtm_spoiler_deg_range.lowest);
    case FUEL: return part * (gtm_fuel_used_lb_range.highest - gtm_fuel_used_lb_range.lowest);
    default: return part;
    }
}

/* Move a quantity; 1 where it can not go. */
static int move(quantity q, double by, place *at)
{
    gtm_configuration *c = &at->airframe;
    if (q == ALTITUDE) at->altitude += by;
    if (q == PATH) at->gamma += by;
    if (q == STABILIZER) c->stabilizer += by;
    for (int k = 0; q == FLAPS && k < GTM_FLAPS; k++) c->flap[k] += by;
    for (int k = 0; q == SPOILERS && k < GTM_SPOILERS; k++) c->spoiler[k] += by;
    if (q == FUEL) c->fuel_used += by;
    if (q == MASS) c->mass_factor += by;
    if (q >= CG && q < COEFFICIENTS) c->cg_offset[q - CG] += by;
    if (q >= COEFFICIENTS) c->coefficient_factor[q - COEFFICIENTS] += by;
    return q >= STABILIZER && gtm_configure(c);
}

/* Accelerations at y with the quantity moved; 1 where it can not go. */
static int accelerations(const place *here, quantity q, double by, const double *y, double F[GTM_NF])
{
    place at = *here;
    if (move(q, by, &at)) return 1;
    const int is_study = here->is_study && q < STABILIZER;
    const gtm_flight flight = gtm_flight_at(is_study ? 0 : &at.airframe, at.throttles, at.altitude, at.gamma);
    flight.problem.aircraft->residual(&flight.problem, y, F);
    return 0;
}

/* Derivatives of the accelerations at y to both sides of a quantity; NaN where it can not go. */
static void rates_of(const place *here, quantity q, const double *y, double dF[2][GTM_NF])
{
    const double step = step_of(q);
    for (int side = 0; side < 2; side++) {
        const double h = side ? step : -step;
        double F[3][GTM_NF];
        int is_out = 0;
        for (int k = 0; k < 3; k++) is_out |= accelerations(here, q, k * h, y, F[k]);
        for (int i = 0; i < GTM_NF; i++) dF[side][i] = is_out ? NAN : (4 * F[1][i] - 3 * F[0][i] - F[2][i]) / (2 * h);
    }
}

static gtm_slope slope_of(gtm_sides s)
{
    return (gtm_slope){s.below, s.above};
}

static place place_of(const gtm_configuration *c, enum gtm_throttles throttles, double altitude, double gamma)
{
    place here = {.altitude = altitude, .gamma = gamma, .throttles = throttles, .is_study = !c};
    if (c)
        here.airframe = *c;
    else
        gtm_study_configuration(&here.airframe);
    return here;
}

static gtm_slope slope_over(const place *here, quantity q, const gtm_problem *p, const gtm_bounds *b,
                            const double *objective, const double *y)
{
    double dF[2][GTM_NF];
    rates_of(here, q, y, dF);
    return slope_of(gtm_slopes_of_condition(p, b->lower, b->upper, objective, y, dF));
}

void gtm_end_slopes(const gtm_configuration *c, enum gtm_throttles throttles, double altitude, double gamma,
                    const double *lower, const double *upper, const double *objective, const double *y,
                    gtm_slopes *slopes)
{
    gtm_flight flight = gtm_flight_at(c, throttles, altitude, gamma);
    const gtm_bounds b = gtm_bounds_of(&flight, lower, upper);
    const gtm_problem *p = &flight.problem;
    gtm_bound_slopes of_bounds;
    memset(slopes, 0, sizeof *slopes);
    gtm_slopes_of_bounds(p, b.lower, b.upper, objective, y, &of_bounds);
    for (int i = 0; i < p->unknowns; i++) {
        if (p->is_dead[i]) continue;
        slopes->lower[i] = slope_of(of_bounds.lower[i]);
        slopes->upper[i] = slope_of(of_bounds.upper[i]);
        slopes->held[i] = slope_of(of_bounds.held[i]);
    }
    gtm_slope *const of[TOLERANCES] = {&slopes->altitude, &slopes->gamma, &slopes->stabilizer, &slopes->flaps,
                                       &slopes->spoilers, &slopes->fuel_used};
    const place here = place_of(c, throttles, altitude, gamma);
    for (int q = 0; q < TOLERANCES; q++) *of[q] = slope_over(&here, (quantity)q, p, &b, objective, y);
}

void gtm_tolerance_slopes(const gtm_configuration *c, enum gtm_throttles throttles, double altitude, double gamma,
                          const double *lower, const double *upper, const double *objective, const double *y,
                          gtm_slope slopes[GTM_TOLERANCES])
{
    gtm_flight flight = gtm_flight_at(c, throttles, altitude, gamma);
    const gtm_bounds b = gtm_bounds_of(&flight, lower, upper);
    const place here = place_of(c, throttles, altitude, gamma);
    for (int q = TOLERANCES; q < QUANTITIES; q++)
        slopes[q - TOLERANCES] = slope_over(&here, (quantity)q, &flight.problem, &b, objective, y);
}
