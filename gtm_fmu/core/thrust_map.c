/* V_min and V_max by the thrust map. Between two deflections the thrust at a given speed is linear, and so are the ends
   of the range of speeds. So over such a cell V_min and V_max lie on its sides, or where an end of the range needs just
   the thrust available. Over a range of deflections they are the extremes of finitely many values, and a wider range
   never has a smaller envelope. */
#include "thrust_map.h"

#include <math.h>
#include <string.h>

#include "gtm/condition.h"
#include "gtm/lagrange.h"

enum { BISECTIONS = 60 };
static const double jump = 2; /* kn EAS within the tolerance: the end lies on another branch */

/* The map at one altitude and path: least thrust over speed with one deflection. Outside the range of speeds it goes on
   with the slope of its first or last eighth where that lowers it. */
typedef struct {
    double slowest, fastest, speed[GTM_MAP_SPEEDS], thrust[GTM_MAP_SPEEDS], slope_below, slope_above;
} curve;

/* The deflections of the map at one altitude and path. */
typedef struct {
    double least, greatest, node[GTM_MAP_DEFLECTIONS];
} deflections;

/* The map between deflections number j and j + 1. A deflection in it is given by w, its share of the way. */
typedef struct {
    const gtm_thrust_map *map;
    double density, gamma;
    long j;
    curve a, b;
} cell;

typedef struct {
    long j;
    double w;
} place;

/* Ends in EAS, the deflections that reach them, spare thrust. */
typedef struct {
    double v_min, v_max, spare;
    place at_v_min, at_v_max;
} ends;

/* An end of the reach at an altitude and path. Where it is the same everywhere it is found without rounding. */
static double reach_end(const gtm_thrust_map *map, double density, double gamma, int is_greatest)
{
    const double *reach = map->reach + is_greatest;
    double found = reach[0];
    for (long k = 0; k < map->densities; k++)
        for (long l = 0; l < map->paths; l++)
            found += gtm_lagrange(map->densities, map->density, k, density) *
                     gtm_lagrange(map->paths, map->gamma, l, gamma) * (reach[2 * (k * map->paths + l)] - reach[0]);
    return found;
}

static void take_deflections(const gtm_thrust_map *map, double density, double gamma, deflections *d)
{
    const long last = map->deflections - 1;
    const double least = reach_end(map, density, gamma, 0), greatest = reach_end(map, density, gamma, 1);
    const double stretch = (greatest - least) / (map->deflection[last] - map->deflection[0]);
    d->least = least;
    d->greatest = greatest;
    for (long j = 0; j < last; j++) d->node[j] = least + stretch * (map->deflection[j] - map->deflection[0]);
    d->node[last] = greatest;
}

static long cell_of(const gtm_thrust_map *map, const deflections *d, double deflection)
{
    long j = 0;
    while (j < map->deflections - 2 && deflection >= d->node[j + 1]) j++;
    return j;
}

/* A row of the table at an altitude and path, the first `count` numbers of deflection j. */
static void interpolate(const gtm_thrust_map *map, double density, double gamma, long j, long count, double *row)
{
    for (long i = 0; i < count; i++) row[i] = 0;
    for (long k = 0; k < map->densities; k++)
        for (long l = 0; l < map->paths; l++) {
            const double weight = gtm_lagrange(map->densities, map->density, k, density) *
                                  gtm_lagrange(map->paths, map->gamma, l, gamma);
            const float *node = map->table + ((k * map->paths + l) * map->deflections + j) * (2 + map->speeds);
            for (long i = 0; i < count; i++) row[i] += weight * node[i];
        }
}

static void take_curve(const gtm_thrust_map *map, double density, double gamma, long j, curve *c)
{
    const long n = map->speeds, near = (n + 6) / 8;
    double row[2 + GTM_MAP_SPEEDS];
    interpolate(map, density, gamma, j, 2 + n, row);
    *c = (curve){.slowest = row[0], .fastest = row[1]};
    memcpy(c->thrust, row + 2, (size_t)n * sizeof *row);
    for (long i = 0; i < n; i++) {
        const double root = (double)i / (double)(n - 1);
        c->speed[i] = c->slowest + (c->fastest - c->slowest) * root * root;
    }
    if (!(c->slowest < c->fastest)) return; /* a single speed, or far outside the map */
    c->slope_below = fmax(0, (c->thrust[near] - c->thrust[0]) / (c->speed[near] - c->slowest));
    c->slope_above = fmin(0, (c->thrust[n - 1] - c->thrust[n - 1 - near]) / (c->fastest - c->speed[n - 1 - near]));
}

static double thrust_at(const gtm_thrust_map *map, const curve *c, double v)
{
    const long steps = map->speeds - 1;
    if (v <= c->slowest) return c->thrust[0] + c->slope_below * (v - c->slowest);
    if (v >= c->fastest) return c->thrust[steps] + c->slope_above * (v - c->fastest);
    const long below = (long)((double)steps * sqrt((v - c->slowest) / (c->fastest - c->slowest)));
    const long i = below < steps ? below : steps - 1;
    const double start = c->speed[i];
    return c->thrust[i] + (c->thrust[i + 1] - c->thrust[i]) * (v - start) / (c->speed[i + 1] - start);
}

static double between(double w, double a, double b)
{
    return (1 - w) * a + w * b;
}

/* Excess over the thrust available at the slowest speed, or at the fastest. */
static double excess(const cell *c, double w, int is_fast, double available)
{
    const double v = is_fast ? between(w, c->a.fastest, c->b.fastest) : between(w, c->a.slowest, c->b.slowest);
    return between(w, thrust_at(c->map, &c->a, v), thrust_at(c->map, &c->b, v)) - available;
}

/* Widen the ends by those of a curve through n points, the speeds rising. */
static void widen(ends *e, long n, const double *v, const double *thrust, double available, place at)
{
    long first = 0, last = n - 1;
    double least = thrust[0];
    for (long i = 1; i < n; i++) least = fmin(least, thrust[i]);
    e->spare = fmax(e->spare, available - least);
    if (least > available) return;
    while (thrust[first] > available) first++;
    while (thrust[last] > available) last--;
    double v_min = v[first], v_max = v[last];
    if (first > 0) v_min -= (v_min - v[first - 1]) * (available - thrust[first]) / (thrust[first - 1] - thrust[first]);
    if (last < n - 1) v_max += (v[last + 1] - v_max) * (available - thrust[last]) / (thrust[last + 1] - thrust[last]);
    if (v_min < e->v_min) {
        e->v_min = v_min;
        e->at_v_min = at;
    }
    if (v_max > e->v_max) {
        e->v_max = v_max;
        e->at_v_max = at;
    }
}

static void widen_by(ends *e, const cell *c, double w, double available)
{
    const curve *a = w == 1 ? &c->b : &c->a;
    const curve *b = w == 0 ? &c->a : &c->b;
    const double slowest = between(w, a->slowest, b->slowest), fastest = between(w, a->fastest, b->fastest);
    const long speeds = c->map->speeds;
    const place at = {c->j, w};
    double v[2 * GTM_MAP_SPEEDS + 2], thrust[2 * GTM_MAP_SPEEDS + 2];
    long n = 0;
    if (a == b) {
        widen(e, speeds, a->speed, a->thrust, available, at);
        return;
    }
    v[n++] = slowest;
    for (long i = 0, k = 0; i < speeds || k < speeds;) {
        const double next_a = i < speeds ? a->speed[i] : INFINITY;
        const double next_b = k < speeds ? b->speed[k] : INFINITY;
        const double next = fmin(next_a, next_b);
        i += next_a <= next;
        k += next_b <= next;
        if (v[n - 1] < next && next < fastest) v[n++] = next;
    }
    if (v[n - 1] < fastest) v[n++] = fastest;
    for (long i = 0; i < n; i++) thrust[i] = between(w, thrust_at(c->map, a, v[i]), thrust_at(c->map, b, v[i]));
    widen(e, n, v, thrust, available, at);
}

/* Where between two places of a cell an end of the range of speeds needs just the thrust available: at most once. */
static void widen_by_root(ends *e, const cell *c, double from, double to, int is_fast, double available)
{
    const int starts_inside = excess(c, from, is_fast, available) <= 0;
    if (starts_inside == (excess(c, to, is_fast, available) <= 0)) return;
    double inside = starts_inside ? from : to, outside = starts_inside ? to : from;
    for (int k = 0; k < BISECTIONS; k++) {
        const double middle = 0.5 * (inside + outside);
        if (excess(c, middle, is_fast, available) <= 0)
            inside = middle;
        else
            outside = middle;
    }
    widen_by(e, c, inside, available);
}

/* The same where the excess is a parabola over the places: the roots to both sides of its vertex. */
static void widen_by_parabola(ends *e, const cell *c, double from, double to, int is_fast, double available)
{
    const double first = excess(c, from, is_fast, available);
    const double middle = excess(c, 0.5 * (from + to), is_fast, available);
    const double last = excess(c, to, is_fast, available);
    const double rise = 3 * first - 4 * middle + last, bend = 4 * (first - 2 * middle + last);
    const int has_vertex = fabs(rise) < fabs(bend) && (rise > 0) == (bend > 0) && rise != 0; /* inside; no bend: none */
    const double vertex = has_vertex ? from + rise / bend * (to - from) : to;
    widen_by_root(e, c, from, vertex, is_fast, available);
    if (vertex != to) widen_by_root(e, c, vertex, to, is_fast, available);
}

/* The same between any places of a cell. Along an end of the range of speeds the excess is a parabola between the
   tabulated speeds of the curve that reaches further; the other one goes on straight. */
static void widen_by_crossings(ends *e, const cell *c, double from, double to, int is_fast, double available)
{
    const double end_a = is_fast ? c->a.fastest : c->a.slowest, end_b = is_fast ? c->b.fastest : c->b.slowest;
    const int is_a_further = is_fast ? !(end_a < end_b) : end_a < end_b;
    const curve *further = is_a_further ? &c->a : &c->b;
    const long speeds = end_a == end_b ? 0 : c->map->speeds; /* an end that stays passes none of them */
    double reached = end_a < end_b ? from : to;
    const double last = end_a < end_b ? to : from;
    for (long i = 0; i < speeds && further->speed[i] < fmax(end_a, end_b); i++) {
        const double w = (further->speed[i] - end_a) / (end_b - end_a);
        if (from < w && w < to) {
            widen_by_parabola(e, c, reached, w, is_fast, available);
            reached = w;
        }
    }
    widen_by_parabola(e, c, reached, last, is_fast, available);
}

/* Thrusts for which the ends are found: that available, and the tolerance more and less. */
enum { EXACTLY, MORE, LESS, THRUSTS };

/* Ends over all deflections lower .. upper, cell by cell. */
static void find_ends(const gtm_thrust_map *map, double density, double gamma, const deflections *at, double lower,
                      double upper, const double available[THRUSTS], ends e[THRUSTS])
{
    const double *d = at->node;
    cell c = {.map = map, .j = cell_of(map, at, lower)};
    take_curve(map, density, gamma, c.j, &c.a);
    take_curve(map, density, gamma, c.j + 1, &c.b);
    double from = (lower - d[c.j]) / (d[c.j + 1] - d[c.j]);
    for (int k = 0; k < THRUSTS; k++) {
        e[k] = (ends){.v_min = INFINITY, .v_max = -INFINITY, .spare = -INFINITY};
        widen_by(&e[k], &c, from, available[k]);
    }
    for (double reached = lower; reached < upper; from = 0) {
        reached = fmin(d[c.j + 1], upper);
        const double to = (reached - d[c.j]) / (d[c.j + 1] - d[c.j]);
        for (int k = 0; k < THRUSTS; k++) {
            for (int is_fast = 0; is_fast < 2; is_fast++)
                widen_by_crossings(&e[k], &c, from, to, is_fast, available[k]);
            widen_by(&e[k], &c, to, available[k]);
        }
        if (reached < upper) {
            c.a = c.b;
            c.j++;
            take_curve(map, density, gamma, c.j + 1, &c.b);
        }
    }
}

/* Bend in kn of the slowest speed between two deflections, or of the fastest. */
static double deflection_bend(const gtm_thrust_map *map, double density, double gamma, place at, int is_fast)
{
    double most = 0;
    for (long j = at.j; j <= at.j + 1; j++)
        if (j > 0 && j < map->deflections - 1) {
            double range[3][2];
            for (long k = 0; k < 3; k++) interpolate(map, density, gamma, j - 1 + k, 2, range[k]);
            most = fmax(most, fabs(range[0][is_fast] - 2 * range[1][is_fast] + range[2][is_fast]));
        }
    return 4 * at.w * (1 - at.w) * most;
}

/* Whether a speed is the fastest that any thrust reaches. */
static int is_at_end(const gtm_thrust_map *map, double density, double gamma, place at, double v)
{
    double a[2], b[2];
    interpolate(map, density, gamma, at.j, 2, a);
    interpolate(map, density, gamma, at.j + 1, 2, b);
    return v >= between(at.w, a[1], b[1]);
}

/* Bend in kn of the curve of least thrust between two speeds, at most `jump`. */
static double speed_bend(const gtm_thrust_map *map, double density, double gamma, place at, double v)
{
    curve c;
    take_curve(map, density, gamma, at.w < 0.5 ? at.j : at.j + 1, &c);
    if (!(c.slowest < c.fastest)) return jump;
    long i = 1;
    while (i < map->speeds - 3 && v > c.speed[i + 1]) i++;
    double slope[3];
    for (long k = 0; k < 3; k++)
        slope[k] = (c.thrust[i + k] - c.thrust[i + k - 1]) / (c.speed[i + k] - c.speed[i + k - 1]);
    const double most = fmax(fabs(slope[1] - slope[0]), fabs(slope[2] - slope[1])) * (c.speed[i + 1] - c.speed[i]);
    return most < jump * fabs(slope[1]) ? most / fabs(slope[1]) : jump;
}

static gtm_map_envelope envelope_of(const gtm_thrust_map *map, const double *given)
{
    const double gamma = given[1];
    const gtm_condition at = gtm_condition_at(given[0], 0);
    const double density = at.density / gtm_condition_at(0, 0).density, eas_per_tas = sqrt(density);
    const double full = map->full_thrust * at.pressure_ratio;
    const double available[THRUSTS] = {full, full + map->tolerance, full - map->tolerance};
    deflections d;
    take_deflections(map, density, gamma, &d);
    const double lower = fmax(given[2], d.least), upper = fmin(given[3], d.greatest);
    if (lower > upper || !(d.least < d.greatest)) /* the latter far outside the map */
        return (gtm_map_envelope){.spare_thrust = -INFINITY, .is_fold = lower - upper < map->reach_tolerance};
    ends found[THRUSTS];
    find_ends(map, density, gamma, &d, lower, upper, available, found);

    const ends e = found[EXACTLY], more = found[MORE], less = found[LESS];
    if (e.spare < 0) return (gtm_map_envelope){.spare_thrust = e.spare, .is_fold = -e.spare < map->tolerance};
    const double slow = 0.5 * (fmin(less.v_min, e.v_max) - more.v_min);
    const double fast = 0.5 * (more.v_max - fmax(less.v_max, e.v_min));
    const int ends_near = (d.least > map->deflection[0] && upper - d.least < map->reach_tolerance) ||
                          (d.greatest < map->deflection[map->deflections - 1] &&
                           d.greatest - lower < map->reach_tolerance);
    const int is_fold = less.spare < 0 || 2 * fmax(slow, fast) > jump || ends_near;
    const double share = is_fold ? 1 : 1 / map->tolerance_deviations;
    const double slow_bend = map->bend_share * deflection_bend(map, density, gamma, e.at_v_min, 0);
    const double fast_bend =
        map->bend_share * (is_at_end(map, density, gamma, e.at_v_max, e.v_max)
                               ? deflection_bend(map, density, gamma, e.at_v_max, 1)
                               : speed_bend(map, density, gamma, e.at_v_max, e.v_max));
    return (gtm_map_envelope){
        .v_min = e.v_min / eas_per_tas,
        .v_max = e.v_max / eas_per_tas,
        .v_min_std = hypot(map->least_deviation, hypot(share * slow, slow_bend)) / eas_per_tas,
        .v_max_std = hypot(map->least_deviation, hypot(share * fast, fast_bend)) / eas_per_tas,
        .spare_thrust = e.spare,
        .is_fold = is_fold,
    };
}

void gtm_map_envelopes(const gtm_thrust_map *map, long n, const double *cases, gtm_map_envelope *found)
{
    for (long i = 0; i < n; i++) found[i] = envelope_of(map, cases + 4 * i);
}

static long group_of(const gtm_thrust_map *map, const double *given, const gtm_map_envelope *found)
{
    if (!(found->spare_thrust >= map->tolerance)) return -1;
    return (given[3] > given[2]) + 2 * (found->is_fold > 0);
}

void gtm_map_groups(const gtm_thrust_map *map, long n, const double *cases, const gtm_map_envelope *found, long *group)
{
    for (long i = 0; i < n; i++) group[i] = group_of(map, cases + 4 * i, &found[i]);
}

void gtm_map_safe_ends(const gtm_thrust_map *map, const double *margins, long n, const double *cases,
                       const gtm_map_envelope *found, gtm_safe_ends *safe)
{
    for (long i = 0; i < n; i++) {
        const long group = group_of(map, cases + 4 * i, &found[i]);
        safe[i] = (gtm_safe_ends){INFINITY, -INFINITY};
        if (group < 0) continue;
        const double *margin = margins + GTM_MAP_ENDS * group;
        if (!isfinite(margin[0]) || !isfinite(margin[1])) continue;
        const double v_min = found[i].v_min + margin[0] * found[i].v_min_std;
        const double v_max = found[i].v_max - margin[1] * found[i].v_max_std;
        if (v_min <= v_max) safe[i] = (gtm_safe_ends){v_min, v_max};
    }
}
