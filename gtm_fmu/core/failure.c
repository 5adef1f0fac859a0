#include "gtm_failure.h"

#include <math.h>
#include <string.h>

#include "generated/unknowns.h"
#include "gtm/configured_table.h"

/* What a value that came through other units may be off by, relative to its range. */
static const double rounding = 1e-9;

/* A value that is a rounding outside a range, inside; any other as it is. */
static double settled(double value, gtm_range range)
{
    const double slack = rounding * (range.highest - range.lowest);
    const double inside = fmin(fmax(value, range.lowest), range.highest);
    return fabs(value - inside) <= slack ? inside : value;
}

/* ---- The airframe ---- */

static int is_undamaged(const gtm_failure *f)
{
    return f->damage_case == 0 && f->engine_running[0] && f->engine_running[1] && f->stabilizer == 0 &&
           f->flaps == 0 && f->spoilers == 0 && f->gear == 0 && f->fuel_used == 0;
}

static int configure(const gtm_failure *f, gtm_configuration *c)
{
    const double damage_case = floor(f->damage_case + 0.5);
    if (!(fabs(damage_case - f->damage_case) <= rounding && fabs(damage_case) < GTM_DAMAGE_CASES)) return GTM_BAD_DAMAGE;
    gtm_study_configuration(c);
    c->damage_case = (int)damage_case;
    for (int side = 0; side < 2; side++) c->engine_running[side] = f->engine_running[side] != 0;
    c->stabilizer = settled(f->stabilizer, gtm_stabilizer_deg_range);
    c->gear = settled(f->gear, gtm_gear_range);
    c->fuel_used = settled(f->fuel_used, gtm_fuel_used_lb_range);
    for (int k = 0; k < GTM_FLAPS; k++) c->flap[k] = settled(f->flaps, gtm_flap_deg_range);
    for (int k = 0; k < GTM_SPOILERS; k++) c->spoiler[k] = settled(f->spoilers, gtm_spoiler_deg_range);
    return gtm_configure(c) ? GTM_BAD_AIRFRAME : GTM_LEFT;
}

/* ---- Limits ---- */

/* The first pair whose lower end is above its upper one, from the failure's beginning on. */
static int reversed(const gtm_failure *f)
{
    const double *pairs[] = {f->limits[0], f->limits[1], f->limits[2], f->limits[3],
                             f->engine_limits[0], f->engine_limits[1], f->alpha, f->bank};
    for (int k = 0; k < (int)(sizeof pairs / sizeof *pairs); k++)
        if (!(pairs[k][0] <= pairs[k][1])) return GTM_REVERSED + k;
    return GTM_LEFT;
}

static void narrow(gtm_remainder *left, int unknown, const double range[2])
{
    left->lower[unknown] = fmax(left->lower[unknown], range[0]);
    left->upper[unknown] = fmin(left->upper[unknown], range[1]);
}

/* Of the throttles: one of its own for each engine, or one for those that run. */
static int take_throttles(const gtm_failure *f, gtm_remainder *left)
{
    const int runs[2] = {f->engine_running[0] != 0, f->engine_running[1] != 0};
    const int is_apart = f->has_two_throttles && runs[0] && runs[1];
    left->throttles = is_apart ? GTM_TWO_THROTTLES : GTM_ONE_THROTTLE;
    for (int side = 0; side < 2; side++) {
        left->lower[THROTTLE + side] = f->limits[THROTTLE - ELEVATOR][0];
        left->upper[THROTTLE + side] = f->limits[THROTTLE - ELEVATOR][1];
    }
    for (int side = 0; side < 2; side++)
        if (runs[side]) narrow(left, is_apart ? THROTTLE + side : THROTTLE, f->engine_limits[side]);
    for (int side = 0; side < 2; side++)
        if (left->lower[THROTTLE + side] > left->upper[THROTTLE + side]) return GTM_NO_THROTTLE;
    return GTM_LEFT;
}

int gtm_take_failure(const gtm_failure *f, const double lower[GTM_NT], const double upper[GTM_NT], gtm_remainder *left)
{
    int fault = reversed(f);
    if (fault) return fault;
    memcpy(left->lower, lower, GTM_NT * sizeof *lower);
    memcpy(left->upper, upper, GTM_NT * sizeof *upper);
    for (int end = 0; end < 2; end++) {
        double *bound = end ? left->upper : left->lower;
        bound[ALPHA] = f->alpha[end];
        bound[PHI] = f->bank[end];
        for (int k = ELEVATOR; k <= RUDDER; k++) bound[k] = f->limits[k - ELEVATOR][end];
    }
    fault = take_throttles(f, left);
    if (fault) return fault;
    left->is_study = left->throttles == GTM_ONE_THROTTLE && is_undamaged(f);
    return left->is_study ? GTM_LEFT : configure(f, &left->configuration);
}

/* ---- Envelopes ---- */

static const gtm_configuration *airframe(const gtm_remainder *left)
{
    return left->is_study ? 0 : &left->configuration;
}

/* The least value of an unknown (sign 1) or its greatest (-1); whether there is one. */
static int find_end(const gtm_remainder *left, double altitude, double gamma, int unknown, double sign, double *value)
{
    double objective[GTM_TWO_THROTTLE_NT] = {0}, best[GTM_TWO_THROTTLE_NT] = {0}, violation;
    objective[unknown] = sign;
    const int status = gtm_envelope_end(airframe(left), left->throttles, altitude, gamma, left->lower, left->upper,
                                        objective, best, &violation);
    *value = best[unknown];
    return status == GTM_TRIMMED;
}

int gtm_failure_envelope(const gtm_failure_case *at, const gtm_failure *f, const double lower[GTM_NT],
                         const double upper[GTM_NT], double speed[2], int *is_feasible)
{
    gtm_remainder left;
    if (!(at->rudder[0] <= at->rudder[1])) return GTM_RUDDER_REVERSED;
    const int fault = gtm_take_failure(f, lower, upper, &left);
    if (fault) return fault;
    narrow(&left, RUDDER, at->rudder);
    if (left.lower[RUDDER] > left.upper[RUDDER]) return GTM_NO_RUDDER;
    *is_feasible = find_end(&left, at->altitude, at->gamma, V, 1, speed) &&
                   find_end(&left, at->altitude, at->gamma, V, -1, speed + 1);
    if (!*is_feasible) speed[0] = speed[1] = 0;
    return GTM_LEFT;
}

/* ---- Manoeuvres ---- */

/* Bounds as a failure leaves them, at the speed of a manoeuvre. */
static int take_speed(const gtm_failure_manoeuvre *at, const gtm_failure *f, const double lower[GTM_NT],
                      const double upper[GTM_NT], gtm_remainder *left)
{
    const int fault = gtm_take_failure(f, lower, upper, left);
    left->lower[V] = left->upper[V] = at->tas;
    return fault;
}

static const int limited[GTM_LIMITED] = {ALPHA, BETA, PHI, ELEVATOR, AILERON, RUDDER, THROTTLE, THROTTLE_RIGHT};

/* The binding limit by its number: 1 none, then lower and upper of each that is limited, at last those of one throttle
   for both engines. */
static double binding_of(const gtm_remainder *left, const gtm_answer *found)
{
    int place = 0;
    while (place < GTM_LIMITED && limited[place] != found->binding) place++;
    if (found->binding < 0 || place == GTM_LIMITED) return 1;
    if (found->binding == THROTTLE && left->throttles == GTM_ONE_THROTTLE) place = GTM_LIMITED;
    return 2 + 2 * place + found->side;
}

int gtm_failure_query(const gtm_failure_manoeuvre *at, const gtm_failure *f, const double lower[GTM_NT],
                      const double upper[GTM_NT], gtm_failure_answer *answer)
{
    gtm_remainder left;
    gtm_answer found;
    const int fault = take_speed(at, f, lower, upper, &left);
    if (fault) return fault;
    left.lower[PSI_DOT] = left.upper[PSI_DOT] = at->turn_rate;
    gtm_query(airframe(&left), left.throttles, 1, &at->altitude, &at->gamma, left.lower, left.upper, &found);
    const double *y = found.y;
    *answer = (gtm_failure_answer){.is_feasible = found.status == GTM_TRIMMED, .is_stable = found.stable,
                                   .is_controllable = found.controllable, .is_found = found.status != GTM_NO_TRIM,
                                   .binding = binding_of(&left, &found)};
    if (!answer->is_found) return GTM_LEFT;
    for (int k = 0; k < GTM_LIMITED; k++) {
        const int is_shared = limited[k] == THROTTLE_RIGHT && left.throttles == GTM_ONE_THROTTLE;
        memcpy(answer->margin[k], found.margin[is_shared ? THROTTLE : limited[k]], sizeof *answer->margin);
    }
    memcpy(answer->thrust_margin, found.thrust_margin, sizeof found.thrust_margin);
    answer->alpha = y[ALPHA];
    answer->beta = y[BETA];
    answer->bank = y[PHI];
    memcpy(answer->surface, y + ELEVATOR, sizeof answer->surface);
    memcpy(answer->throttle, y + THROTTLE, sizeof answer->throttle);
    answer->thrust = found.thrust;
    return GTM_LEFT;
}

int gtm_failure_turn_rates(const gtm_failure_manoeuvre *at, const gtm_failure *f, const double lower[GTM_NT],
                           const double upper[GTM_NT], double rate[2])
{
    gtm_remainder left;
    const int fault = take_speed(at, f, lower, upper, &left);
    if (fault) return fault;
    if (!find_end(&left, at->altitude, at->gamma, PSI_DOT, 1, rate) ||
        !find_end(&left, at->altitude, at->gamma, PSI_DOT, -1, rate + 1)) {
        rate[0] = upper[PSI_DOT];
        rate[1] = lower[PSI_DOT];
    }
    return GTM_LEFT;
}
