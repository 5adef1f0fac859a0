#include "failure.h"

#include <math.h>
#include <string.h>

#include "generated/unknowns.h"
#include "gtm/configured_table.h"
#include "gtm_sections.h"
#include "gtm_t2.h"
#include "solver/ends.h"

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

/* Bounds of an unknown, and which numbers of a question they are. */
static void take(gtm_remainder *left, int unknown, const double range[2], int from)
{
    left->lower[unknown] = range[0];
    left->upper[unknown] = range[1];
    for (int end = 0; end < 2; end++) left->from[unknown][end] = from < 0 ? -1 : from + end;
}

static void narrow(gtm_remainder *left, int unknown, const double range[2], int from)
{
    if (range[0] > left->lower[unknown]) {
        left->lower[unknown] = range[0];
        left->from[unknown][0] = from;
    }
    if (range[1] < left->upper[unknown]) {
        left->upper[unknown] = range[1];
        left->from[unknown][1] = from + 1;
    }
}

static int place_of(const gtm_failure *f, const double *number)
{
    return GTM_ASKED + (int)(number - (const double *)f);
}

/* Of the throttles: one of its own for each engine, or one for those that run. */
static int take_throttles(const gtm_failure *f, gtm_remainder *left)
{
    const int runs[2] = {f->engine_running[0] != 0, f->engine_running[1] != 0};
    const int is_apart = f->has_two_throttles && runs[0] && runs[1];
    const double *both = f->limits[THROTTLE - ELEVATOR];
    left->throttles = is_apart ? GTM_TWO_THROTTLES : GTM_ONE_THROTTLE;
    for (int side = 0; side < 2; side++) take(left, THROTTLE + side, both, place_of(f, both));
    for (int side = 0; side < 2; side++) {
        const double *own = f->engine_limits[side];
        if (runs[side]) narrow(left, is_apart ? THROTTLE + side : THROTTLE, own, place_of(f, own));
    }
    for (int side = 0; side < 2; side++)
        if (left->lower[THROTTLE + side] > left->upper[THROTTLE + side]) return GTM_NO_THROTTLE;
    return GTM_LEFT;
}

int gtm_take_failure(const gtm_failure *f, const double lower[GTM_NT], const double upper[GTM_NT], gtm_remainder *left)
{
    int fault = reversed(f);
    if (fault) return fault;
    for (int i = 0; i < GTM_NT; i++) take(left, i, (const double[]){lower[i], upper[i]}, -1);
    take(left, ALPHA, f->alpha, place_of(f, f->alpha));
    take(left, PHI, f->bank, place_of(f, f->bank));
    for (int k = ELEVATOR; k <= RUDDER; k++) take(left, k, f->limits[k - ELEVATOR], place_of(f, f->limits[k - ELEVATOR]));
    fault = take_throttles(f, left);
    if (fault) return fault;
    left->is_study = left->throttles == GTM_ONE_THROTTLE && is_undamaged(f);
    return left->is_study ? GTM_LEFT : configure(f, &left->configuration);
}

const gtm_configuration *gtm_airframe_left(const gtm_remainder *left)
{
    return left->is_study ? 0 : &left->configuration;
}

/* ---- Envelopes ---- */

int gtm_take_case(const gtm_failure_case *at, const gtm_failure *f, const double lower[GTM_NT],
                  const double upper[GTM_NT], gtm_remainder *left)
{
    enum { RUDDER_LIMITS = 2 };
    if (!(at->rudder[0] <= at->rudder[1])) return GTM_RUDDER_REVERSED;
    const int fault = gtm_take_failure(f, lower, upper, left);
    if (fault) return fault;
    narrow(left, RUDDER, at->rudder, RUDDER_LIMITS);
    return left->lower[RUDDER] > left->upper[RUDDER] ? GTM_NO_RUDDER : GTM_LEFT;
}

typedef char known_ends_fit[sizeof((gtm_known_ends *)0)->y == sizeof *((gtm_envelope_memory *)0)->y ? 1 : -1];

/* How far the numbers of a question may move before the ends are sought anew, for a better end may arise that was none
   before (benchmarks/follow.py: how often, and by how much). Damage and switches may not move. */
static const gtm_failure_case case_reach = {.altitude = 120, .gamma = 0.002, .rudder = {0.3, 0.3}};
static const gtm_failure failure_reach = {
    .limits = {{0.2, 0.2}, {0.3, 0.3}, {0.3, 0.3}, {1, 1}},
    .engine_limits = {{1, 1}, {1, 1}},
    .alpha = {0.002, 0.002}, .bank = {0.01, 0.01},
    .stabilizer = 0.05, .flaps = 0.3, .spoilers = 0.3, .gear = 0.03, .fuel_used = 0.1,
};

static int is_within(const void *one, const void *other, const void *reach, size_t size)
{
    const double *a = one, *b = other, *far = reach;
    for (size_t k = 0; k < size / sizeof(double); k++)
        if (!(fabs(a[k] - b[k]) <= far[k])) return 0;
    return 1;
}

static int is_near(const gtm_envelope_memory *m, const gtm_failure_case *at, const gtm_failure *f)
{
    return m->inside[0] > 0 && m->inside[1] > 0 && is_within(&m->at, at, &case_reach, sizeof *at) &&
           is_within(&m->failure, f, &failure_reach, sizeof *f);
}

static void recall(const gtm_envelope_memory *m, gtm_known_ends known[2])
{
    for (int k = 0; k < 2; k++) {
        known[k].inside = (int)fmin(fmax(m->inside[k], 0), GTM_MOST_KNOWN);
        known[k].outside = (int)fmin(fmax(m->outside[k], 0), GTM_MOST_OUTSIDE);
        memcpy(known[k].y, m->y[k], sizeof m->y[k]);
    }
}

/* Whether V_min and V_max are near those that were sought. Where they move fast, others come up. */
static int are_speeds_near(const gtm_envelope_memory *m, const double end[2][GTM_TWO_THROTTLE_NT])
{
    static const double reach = 0.6; /* ft/s */
    return fabs(end[0][V] - m->speed[0]) <= reach && fabs(end[1][V] - m->speed[1]) <= reach;
}

static void retain(const gtm_known_ends known[2], gtm_envelope_memory *m)
{
    for (int k = 0; k < 2; k++) {
        m->inside[k] = known[k].inside;
        m->outside[k] = known[k].outside;
        memcpy(m->y[k], known[k].y, sizeof m->y[k]);
    }
}

/* V_min and V_max, followed from known ends or sought; 0 when both are found. */
static int find_ends(const gtm_problem *p, const gtm_bounds *b, int is_followed, gtm_known_ends known[2],
                     double end[2][GTM_TWO_THROTTLE_NT])
{
    for (int k = 0; k < 2; k++) {
        double objective[GTM_TWO_THROTTLE_NT] = {0}, violation;
        objective[V] = k ? -1 : 1;
        const int status =
            is_followed ? gtm_follow_end(p, b->lower, b->upper, objective, known + k, end[k], &violation)
                        : gtm_find_end(p, b->lower, b->upper, objective, end[k], &violation, known + k);
        if (status != GTM_TRIMMED) return 1;
    }
    return 0;
}

long gtm_envelope_memory_size(void)
{
    return sizeof(gtm_envelope_memory) / sizeof(double);
}

int gtm_failure_envelope(const gtm_failure_case *at, const gtm_failure *f, const double lower[GTM_NT],
                         const double upper[GTM_NT], gtm_envelope_memory *memory, double end[2][GTM_TWO_THROTTLE_NT])
{
    gtm_remainder left;
    const int fault = gtm_take_case(at, f, lower, upper, &left);
    if (fault) return fault;
    gtm_flight flight = gtm_flight_at(gtm_airframe_left(&left), left.throttles, at->altitude, at->gamma);
    const gtm_bounds b = gtm_bounds_of(&flight, left.lower, left.upper);
    gtm_known_ends known[2] = {{0}};
    int is_missing = 1;
    memset(end, 0, 2 * sizeof *end);
    if (memory && is_near(memory, at, f)) {
        recall(memory, known);
        is_missing = find_ends(&flight.problem, &b, 1, known, end) || !are_speeds_near(memory, end);
    }
    if (is_missing) {
        is_missing = find_ends(&flight.problem, &b, 0, known, end);
        if (memory) *memory = (gtm_envelope_memory){.at = *at, .failure = *f, .speed = {end[0][V], end[1][V]}};
    }
    if (is_missing) memset(end, 0, 2 * sizeof *end);
    else if (memory) retain(known, memory);
    return GTM_LEFT;
}

/* ---- Manoeuvres ---- */

enum { ASKED_SPEED = 2, ASKED_TURN_RATE = 3 };

int gtm_take_speed(const gtm_failure_manoeuvre *at, const gtm_failure *f, const double lower[GTM_NT],
                   const double upper[GTM_NT], gtm_remainder *left)
{
    const int fault = gtm_take_failure(f, lower, upper, left);
    left->lower[V] = left->upper[V] = at->tas;
    left->from[V][0] = left->from[V][1] = ASKED_SPEED;
    return fault;
}

int gtm_take_manoeuvre(const gtm_failure_manoeuvre *at, const gtm_failure *f, const double lower[GTM_NT],
                       const double upper[GTM_NT], gtm_remainder *left)
{
    const int fault = gtm_take_speed(at, f, lower, upper, left);
    left->lower[PSI_DOT] = left->upper[PSI_DOT] = at->turn_rate;
    left->from[PSI_DOT][0] = left->from[PSI_DOT][1] = ASKED_TURN_RATE;
    return fault;
}

const int gtm_limited[GTM_LIMITED] = {ALPHA, BETA, PHI, ELEVATOR, AILERON, RUDDER, THROTTLE, THROTTLE_RIGHT};

/* The binding limit by its number: 1 none, then lower and upper of each that is limited, at last those of one throttle
   for both engines. */
static double binding_of(const gtm_remainder *left, const gtm_answer *found)
{
    int place = 0;
    while (place < GTM_LIMITED && gtm_limited[place] != found->binding) place++;
    if (found->binding < 0 || place == GTM_LIMITED) return 1;
    if (found->binding == THROTTLE && left->throttles == GTM_ONE_THROTTLE) place = GTM_LIMITED;
    return 2 + 2 * place + found->side;
}

int gtm_failure_query(const gtm_failure_manoeuvre *at, const gtm_failure *f, const double lower[GTM_NT],
                      const double upper[GTM_NT], gtm_failure_answer *answer)
{
    gtm_remainder left;
    gtm_answer found;
    const int fault = gtm_take_manoeuvre(at, f, lower, upper, &left);
    if (fault) return fault;
    gtm_query(gtm_airframe_left(&left), left.throttles, 1, &at->altitude, &at->gamma, left.lower, left.upper, &found);
    const double *y = found.y;
    *answer = (gtm_failure_answer){.is_feasible = found.status == GTM_TRIMMED, .is_stable = found.stable,
                                   .is_controllable = found.controllable, .is_found = found.status != GTM_NO_TRIM,
                                   .binding = binding_of(&left, &found)};
    if (!answer->is_found) return GTM_LEFT;
    for (int k = 0; k < GTM_LIMITED; k++) {
        const int is_shared = gtm_limited[k] == THROTTLE_RIGHT && left.throttles == GTM_ONE_THROTTLE;
        memcpy(answer->margin[k], found.margin[is_shared ? THROTTLE : gtm_limited[k]], sizeof *answer->margin);
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
    gtm_intervals found;
    const int fault = gtm_take_speed(at, f, lower, upper, &left);
    if (fault) return fault;
    gtm_section(gtm_airframe_left(&left), left.throttles, GTM_TURN_RATES, at->altitude, at->gamma, left.lower, left.upper,
                lower[PSI_DOT], upper[PSI_DOT], &found);
    rate[0] = found.count ? found.end[0][0] : upper[PSI_DOT];
    rate[1] = found.count ? found.end[found.count - 1][1] : lower[PSI_DOT];
    return GTM_LEFT;
}
