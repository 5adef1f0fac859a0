#include "gtm_sections.h"

#include <math.h>
#include <string.h>

#include "generated/constants.h"
#include "gtm_t2.h"
#include "solver/descent.h"
#include "solver/trim.h"

enum { MOST_CLOSING = 60, MOST_LOOKS = 12, MOST_POINTS = 256 };
static const double tolerance = 1e-5;       /* of the scale, of an end */
static const double step = 0.3, coarser = 2; /* of the scale, between the first points; where they are not settled */
static const double near = 0.3;             /* of the scales of the limits: so near a limit may be passed unseen */
static const double room = 1.2;             /* of the scale, around the paths where trims are expected */
static const double leaning = 0.35, steepest = 1.45; /* rad of bank that a sideslip may stand for; most bank */
static const double slowest_of = 0.8;       /* of the stalling speed */
static const double golden = 0.3819660112501051;

/* A section and the flight condition that it varies. */
typedef struct {
    const gtm_configuration *configuration;
    enum gtm_throttles throttles;
    enum gtm_section_kind kind;
    double altitude, gamma, scale;
    const double *lower, *upper;
    int is_settled;                         /* trims are unique, so that their margins are continuous */
} section;

/* A trim along it. `excess`: over the bounds where it is outside, infinite where there is none; where it is inside and
   settled less than zero, by its least margin. All in scale units. */
typedef struct {
    double at, excess, y[GTM_MOST_UNKNOWNS];
    int is_inside;
} point;

static double least_margin(const gtm_problem *p, const gtm_bounds *b, const double *y)
{
    double least = INFINITY;
    for (int i = 0; i < p->unknowns; i++)
        if (b->lower[i] < b->upper[i])
            least = fmin(least, fmin(y[i] - b->lower[i], b->upper[i] - y[i]) / p->aircraft->scale[i]);
    return least;
}

static point point_at(const section *s, double at)
{
    point found = {at, INFINITY, {0}, 0};
    const double gamma = s->kind == GTM_CLIMBS ? at : s->gamma;
    gtm_flight flight = gtm_flight_at(s->configuration, s->throttles, s->altitude, gamma);
    gtm_bounds b = gtm_bounds_of(&flight, s->lower, s->upper);
    if (s->kind == GTM_TURN_RATES) b.lower[PSI_DOT] = b.upper[PSI_DOT] = at;
    if (s->kind == GTM_SPEEDS) b.lower[V] = b.upper[V] = at;
    double residual, violation;
    const int status = gtm_find_trim(&flight.problem, b.lower, b.upper, found.y, &residual, &violation);
    found.is_inside = status == GTM_TRIMMED;
    if (status == GTM_OUTSIDE) found.excess = violation;
    if (found.is_inside) found.excess = s->is_settled ? -least_margin(&flight.problem, &b, found.y) : 0;
    return found;
}

/* Where a straight line through the excess of two points is zero; not finite where they do not tell. */
static double crossing(const point *a, const point *b)
{
    if (!isfinite(a->excess) || !isfinite(b->excess) || a->excess == b->excess) return NAN;
    return a->at - a->excess * (b->at - a->at) / (b->excess - a->excess);
}

/* The farthest point inside that a descent reaches from one inside, not beyond one outside. */
static point descend(const section *s, const point *inside, const point *outside)
{
    const int i = s->kind == GTM_SPEEDS ? V : PSI_DOT;
    gtm_flight flight = gtm_flight_at(s->configuration, s->throttles, s->altitude, s->gamma);
    gtm_bounds b = gtm_bounds_of(&flight, s->lower, s->upper);
    double objective[GTM_MOST_UNKNOWNS] = {0}, excess;
    point found = *inside;
    b.lower[i] = fmin(inside->at, outside->at);
    b.upper[i] = fmax(inside->at, outside->at);
    objective[i] = outside->at > inside->at ? -1 : 1;
    if (gtm_find_extreme(&flight.problem, b.lower, b.upper, objective, 1, inside->y, found.y, &excess)) return *inside;
    found.at = found.y[i];
    return found;
}

/* The last point inside, between one inside and one outside: by secants, moved by less than the tolerance towards the
   side that the last one was not on, so that both sides close in; and halfway where these are slow. */
static point close_in(const section *s, point inside, point outside)
{
    const double least = 0.4 * tolerance * s->scale;
    if (!s->is_settled && s->kind != GTM_CLIMBS) { /* a descent is quick, but may end too early */
        const point reached = descend(s, &inside, &outside);
        const point beyond = point_at(s, reached.at + copysign(2 * least, outside.at - inside.at));
        if (!beyond.is_inside) return reached;
        inside = beyond;
    }
    point farther = outside;
    double width = outside.at - inside.at, before = INFINITY;
    for (int k = 0, was_inside = 0; k < MOST_CLOSING && fabs(width) > tolerance * s->scale; k++) {
        double guess = inside.excess < 0 ? crossing(&inside, &outside) : crossing(&farther, &outside);
        guess += copysign(least, was_inside ? width : -width);
        const double share = (guess - inside.at) / width;
        if (!(share > 0 && share < 1) || fabs(width) > 0.5 * before) guess = inside.at + 0.5 * width;
        if (k % 2) before = fabs(width);
        const point found = point_at(s, guess);
        was_inside = found.is_inside;
        if (was_inside) {
            inside = found;
        } else {
            farther = outside;
            outside = found;
        }
        width = outside.at - inside.at;
    }
    return inside;
}

/* ---- The first points of a section ---- */

typedef struct {
    int count;
    point at[MOST_POINTS];
} points;

static void append(points *all, const point *p)
{
    if (all->count < MOST_POINTS) all->at[all->count++] = *p;
}

/* Speeds, turn rates up to the bounds of bank (a sideslip may stand for some of it), or the paths between all thrust and
   none at the drag of level flight. */
static void expected_range(const section *s, double *low, double *high)
{
    const gtm_flight flight = gtm_flight_at(s->configuration, s->throttles, s->altitude, 0);
    if (s->kind == GTM_SPEEDS) {
        gtm_flight at_gamma = flight;
        at_gamma.at.gamma = s->gamma;
        const gtm_speeds speeds = flight.problem.aircraft->speeds(&at_gamma.problem);
        *low = slowest_of * speeds.slowest;
        *high = speeds.fastest;
    } else if (s->kind == GTM_TURN_RATES) {
        const double a = fmax(s->lower[PHI] - leaning, -steepest), b = fmin(s->upper[PHI] + leaning, steepest);
        *low = GTM_GRAVITY * tan(a) / s->lower[V];
        *high = GTM_GRAVITY * tan(b) / s->lower[V];
    } else {
        const point level = point_at(s, 0);
        if (!isfinite(level.excess) && !level.is_inside) return;
        const double drag = gtm_thrust(&flight, s->lower[V], level.y);
        double most[GTM_MOST_UNKNOWNS] = {0};
        for (int i = THROTTLE; i < flight.problem.unknowns; i++) most[i] = s->upper[i];
        const double thrust = gtm_thrust(&flight, s->lower[V], most), weight = flight.problem.weight;
        *low = asin(fmax(-drag / weight, -0.9)) - room * s->scale;
        *high = asin(fmin((thrust - drag) / weight, 0.9)) + room * s->scale;
    }
}

/* Between three neighbours, of which the middle one is nearest to the bounds from its side: a point on the other side,
   if there is one, by golden sections. */
static int other_side(const section *s, const point *a, const point *b, const point *c, point *found)
{
    double low = a->at, high = c->at;
    point middle = *b;
    for (int k = 0; k < MOST_LOOKS; k++) {
        const int is_left = middle.at - low > high - middle.at;
        const double at = is_left ? middle.at - golden * (middle.at - low) : middle.at + golden * (high - middle.at);
        *found = point_at(s, at);
        if (found->is_inside != b->is_inside) return 1;
        if (found->is_inside ? found->excess > middle.excess : found->excess < middle.excess) {
            if (is_left) high = middle.at;
            else low = middle.at;
            middle = *found;
        } else if (is_left) {
            low = at;
        } else {
            high = at;
        }
    }
    return 0;
}

/* Whether the middle one of three is nearest to the bounds, and near to them. */
static int is_suspect(const section *s, const point *a, const point *b, const point *c)
{
    if (a->is_inside != b->is_inside || c->is_inside != b->is_inside) return 0;
    if (b->is_inside) return s->is_settled && b->excess > -near && b->excess >= a->excess && b->excess >= c->excess;
    return b->excess < near && b->excess <= a->excess && b->excess <= c->excess;
}

/* Points over the expected range, and on as long as they are inside; between them those that show a gap, or an interval
   by itself. */
static void scan(const section *s, double least, double most, points *all)
{
    double low = least, high = most;
    points even = {0};
    expected_range(s, &low, &high);
    low = fmin(fmax(low, least), most);
    high = fmin(fmax(high, low), most);
    const double length = (s->is_settled ? 1 : coarser) * step * s->scale;
    const int count = low < high ? (int)fmin(ceil((high - low) / length), MOST_POINTS / 4) : 0;
    point first = point_at(s, low);
    append(&even, &first);
    while (first.is_inside && first.at > least && even.count < MOST_POINTS / 4) {
        first = point_at(s, fmax(first.at - length, least));
        append(&even, &first);
    }
    for (int k = 0; k < even.count / 2; k++) { /* they were found from the right */
        const point kept = even.at[k];
        even.at[k] = even.at[even.count - 1 - k];
        even.at[even.count - 1 - k] = kept;
    }
    for (int k = 1; k <= count; k++) {
        const point next = point_at(s, k == count ? high : low + (high - low) * k / count);
        append(&even, &next);
    }
    while (even.at[even.count - 1].is_inside && even.at[even.count - 1].at < most && even.count < MOST_POINTS / 2) {
        const point next = point_at(s, fmin(even.at[even.count - 1].at + length, most));
        append(&even, &next);
    }
    all->count = 0;
    for (int k = 0; k < even.count; k++) {
        point found;
        const point *b = even.at + k;
        const int is_between = k > 0 && k + 1 < even.count && is_suspect(s, b - 1, b, b + 1);
        const int has_other = is_between && other_side(s, b - 1, b, b + 1, &found);
        if (has_other && found.at < b->at) append(all, &found);
        append(all, b);
        if (has_other && found.at > b->at) append(all, &found);
    }
}

static void set_end(const section *s, gtm_intervals *found, int side, const point *p)
{
    const int k = found->count;
    found->end[k][side] = p->at;
    memcpy(found->y[k][side], p->y, sizeof p->y);
    if (s->throttles == GTM_ONE_THROTTLE) found->y[k][side][THROTTLE_RIGHT] = p->y[THROTTLE];
}

void gtm_section(const gtm_configuration *c, enum gtm_throttles throttles, enum gtm_section_kind kind,
                 double altitude, double gamma, const double *lower, const double *upper, double least, double most,
                 gtm_intervals *found)
{
    static const int varied[] = {PSI_DOT, V, ALPHA};
    gtm_flight flight = gtm_flight_at(c, throttles, altitude, gamma);
    const gtm_bounds b = gtm_bounds_of(&flight, lower, upper);
    const section s = {c, throttles, kind, altitude, gamma, gtm_scale[varied[kind]], b.lower, b.upper,
                       gtm_rudder_settles(&flight.problem, b.lower, b.upper)};
    points all;
    found->count = 0;
    scan(&s, least, most, &all);
    for (int k = 0; k < all.count && found->count < GTM_MOST_INTERVALS; k++) {
        const point *p = all.at + k;
        if (!p->is_inside) continue;
        const point start = k > 0 && !p[-1].is_inside ? close_in(&s, *p, p[-1]) : *p;
        while (k + 1 < all.count && all.at[k + 1].is_inside) k++;
        const point end = k + 1 < all.count ? close_in(&s, all.at[k], all.at[k + 1]) : all.at[k];
        set_end(&s, found, 0, &start);
        set_end(&s, found, 1, &end);
        found->count++;
    }
}

long gtm_intervals_size(void)
{
    return sizeof(gtm_intervals);
}
