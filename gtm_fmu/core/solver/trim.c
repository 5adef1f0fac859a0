#include "solver/trim.h"

#include <math.h>
#include <string.h>

#include "solver/cold_start.h"
#include "solver/descent.h"
#include "solver/rudder_curve.h"

enum { SCANNED = 48 };

/* The values that the bounds hold, or the nearest to zero, and the side of a bank that is sought. */
static void take_given(const double *lower, const double *upper, int count, const int *given, double *y)
{
    y[PHI] = upper[PHI] <= 0 && lower[PHI] < 0 ? -1 : 0;
    for (int k = 0; k < count; k++) y[given[k]] = fmin(fmax(0, lower[given[k]]), upper[given[k]]);
}

/* Cold trims from which the least sideslip is sought: glides to either side, deflections over the rudder's range. */
enum { MOST_STARTS = 7 };
static long starts_over_sideslip(const gtm_problem *p, const double *lower, const double *upper, const int given[2],
                                 double *starts)
{
    const int rudder_held[3] = {given[0], given[1], RUDDER};
    /* In a glide without net thrust the throttle moves nothing, and only sideslip makes drag. */
    const int throttle_held[3] = {given[0], given[1], THROTTLE};
    const size_t row = sizeof *starts * (size_t)p->unknowns;
    long n = 0;
    for (int side = -1; side <= 1; side += 2) {
        double *start = starts + n * p->unknowns;
        memset(start, 0, row);
        take_given(lower, upper, 2, given, start);
        start[THROTTLE] = lower[THROTTLE];
        start[BETA] = side * p->aircraft->spacing.glide_sideslip;
        if (lower[RUDDER] < upper[RUDDER] && !gtm_cold_newton(p, start, throttle_held)) n++;
    }
    for (int k = 0; k < MOST_STARTS - 2; k++) {
        double *start = starts + n * p->unknowns;
        memset(start, 0, row);
        take_given(lower, upper, 2, given, start);
        start[RUDDER] = lower[RUDDER] + 0.25 * k * (upper[RUDDER] - lower[RUDDER]);
        if (!gtm_cold_newton(p, start, rudder_held)) n++;
        if (lower[RUDDER] == upper[RUDDER]) break;
    }
    return n;
}

/* A point of the manifold: enum gtm_trim_status and its excess over the bounds. */
typedef struct {
    int status;
    double y[GTM_MOST_UNKNOWNS], violation;
} point;

/* Inside the bounds the one with less sideslip, outside the one that exceeds them less. */
static int is_better(const point *a, const point *b)
{
    if (a->status != b->status) return a->status < b->status;
    if (a->status == GTM_TRIMMED) return fabs(a->y[BETA]) < fabs(b->y[BETA]);
    return a->violation < b->violation;
}

/* Least |beta| under the bounds when neither the rudder nor beta = 0 settles it: the best of both signs. */
static point least_sideslip(const gtm_problem *p, const double *lower, const double *upper, const int given[2])
{
    const size_t row = sizeof *lower * (size_t)p->unknowns;
    double starts[MOST_STARTS * GTM_MOST_UNKNOWNS];
    const long n = starts_over_sideslip(p, lower, upper, given, starts);
    point best = {GTM_NO_TRIM, {0}, INFINITY};
    for (int side = 0; side < 2; side++) {
        double one_sided[GTM_MOST_UNKNOWNS], other[GTM_MOST_UNKNOWNS], objective[GTM_MOST_UNKNOWNS] = {0};
        point found = best;
        memcpy(one_sided, lower, row);
        memcpy(other, upper, row);
        if (side) {
            other[BETA] = fmin(other[BETA], 0);
            objective[BETA] = -1;
        } else {
            one_sided[BETA] = fmax(one_sided[BETA], 0);
            objective[BETA] = 1;
        }
        found.status = gtm_find_extreme(p, one_sided, other, objective, n, starts, found.y, &found.violation);
        if (found.status != GTM_NO_TRIM && is_better(&found, &best)) best = found;
    }
    return best;
}

void gtm_join_throttles(const gtm_problem *p, const double *lower, const double *upper, double *y)
{
    if (!gtm_has_free_throttles(p)) return;
    if (fabs(y[BETA]) > gtm_rounding || y[THROTTLE] == y[THROTTLE_RIGHT]) return;
    double held_lower[GTM_MOST_UNKNOWNS], held_upper[GTM_MOST_UNKNOWNS], objective[GTM_MOST_UNKNOWNS] = {0};
    double joined[GTM_MOST_UNKNOWNS], excess;
    memcpy(held_lower, lower, sizeof held_lower);
    memcpy(held_upper, upper, sizeof held_upper);
    held_lower[BETA] = held_upper[BETA] = 0;
    objective[THROTTLE] = y[THROTTLE] > y[THROTTLE_RIGHT] ? 1 : -1;
    objective[THROTTLE_RIGHT] = -objective[THROTTLE];
    if (gtm_find_extreme(p, held_lower, held_upper, objective, 1, y, joined, &excess) == GTM_TRIMMED)
        memcpy(y, joined, sizeof joined);
}

/* Whether a control but the rudder has hardly any range: then only single deflections of the rudder give a trim. */
static int is_narrow(const gtm_problem *p, const double *lower, const double *upper)
{
    for (int i = ELEVATOR; i < p->unknowns; i++)
        if (i != RUDDER && !p->is_dead[i] && upper[i] - lower[i] < p->aircraft->scale[i]) return 1;
    return 0;
}

/* What a scan of the rudder seeks, and the best trim so far. */
typedef struct {
    const gtm_problem *problem;
    const double *lower, *upper;
    const int *given;
    int status;
    double *y;
} scan;

/* Keep a trim inside the bounds that has less sideslip than the best so far. */
static void keep_better(scan *s, const double *trial)
{
    if (gtm_violation(s->problem, trial, s->lower, s->upper) > gtm_rounding) return;
    if (s->status == GTM_TRIMMED && fabs(trial[BETA]) >= fabs(s->y[BETA])) return;
    memcpy(s->y, trial, sizeof *trial * (size_t)s->problem->unknowns);
    s->status = GTM_TRIMMED;
}

/* The trims between two neighbouring ones at which an unknown crosses a bound. */
static void try_crossings(scan *s, const double *before, const double *after)
{
    const gtm_problem *p = s->problem;
    double trial[GTM_MOST_UNKNOWNS];
    for (int i = V; i < p->unknowns; i++) {
        if (i == s->given[0] || i == s->given[1] || i == RUDDER || p->is_dead[i]) continue;
        const int bound_held[3] = {s->given[0], s->given[1], i};
        const double bound[2] = {s->lower[i], s->upper[i]};
        const int bounds = bound[0] < bound[1] ? 2 : 1;
        for (int side = 0; side < bounds; side++) {
            const double share = (bound[side] - before[i]) / (after[i] - before[i]);
            if (!(share >= 0 && share <= 1)) continue;
            for (int j = 0; j < p->unknowns; j++) trial[j] = before[j] + share * (after[j] - before[j]);
            trial[i] = bound[side];
            if (!gtm_newton(p, trial, bound_held)) keep_better(s, trial);
        }
    }
}

int gtm_scan_rudder(const gtm_problem *p, const double *lower, const double *upper, const int given[2],
                    const double *start, double *y)
{
    const int rudder_held[3] = {given[0], given[1], RUDDER};
    const size_t row = sizeof *y * (size_t)p->unknowns;
    double before[GTM_MOST_UNKNOWNS], at[GTM_MOST_UNKNOWNS];
    scan s = {p, lower, upper, given, GTM_NO_TRIM, y};
    if (!is_narrow(p, lower, upper)) return GTM_NO_TRIM;
    for (int k = 0, had_trim = 0; k <= SCANNED; k++) {
        memcpy(at, had_trim ? before : start, row);
        for (int g = 0; g < 2; g++) at[given[g]] = lower[given[g]];
        at[RUDDER] = lower[RUDDER] + (upper[RUDDER] - lower[RUDDER]) * k / SCANNED;
        int has_trim = had_trim && !gtm_newton(p, at, rudder_held);
        if (!has_trim) has_trim = !gtm_cold_newton(p, at, rudder_held);
        if (has_trim) keep_better(&s, at);
        if (has_trim && had_trim) try_crossings(&s, before, at);
        had_trim = has_trim;
        memcpy(before, at, row);
    }
    return s.status;
}

/* The unknowns besides the controls that the bounds hold, at most three; where they are fewer beta and psi_dot follow,
   which are sought at zero. */
static int conditions(const double *lower, const double *upper, int held[3])
{
    static const int order[] = {V, PSI_DOT, PHI, ALPHA, BETA}, sought[] = {BETA, PSI_DOT, V};
    int count = 0;
    for (int k = 0; k < 5 && count < 3; k++)
        if (lower[order[k]] == upper[order[k]]) held[count++] = order[k];
    for (int k = 0, n = count; n < 3 && k < 3; k++)
        if (lower[sought[k]] != upper[sought[k]]) held[n++] = sought[k];
    return count;
}

/* The trim that Newton finds with three unknowns held. */
static point trim_holding(const gtm_problem *p, const double *lower, const double *upper, const int held[3])
{
    point at = {GTM_NO_TRIM, {0}, INFINITY};
    for (int i = 0; i < p->unknowns; i++)
        if (p->is_dead[i]) at.y[i] = lower[i];
    take_given(lower, upper, 3, held, at.y);
    const int is_found = !gtm_cold_newton(p, at.y, held);
    at.violation = gtm_violation(p, at.y, lower, upper);
    if (is_found) at.status = at.violation <= gtm_rounding ? GTM_TRIMMED : GTM_OUTSIDE;
    return at;
}

/* Another sideslip than that of `near`, which is no trim inside the bounds. */
static point trim_at_other_sideslip(const gtm_problem *p, const double *lower, const double *upper, const int given[2],
                                    const point *near)
{
    point along = {GTM_NO_TRIM, {0}, INFINITY};
    int is_sure = 0;
    const double *start = near->status == GTM_NO_TRIM ? 0 : near->y;
    along.status = gtm_follow_rudder(p, lower, upper, given, start, along.y, &along.violation, &is_sure);
    if (is_sure) return along;
    point found = least_sideslip(p, lower, upper, given);
    if (is_better(&along, &found)) found = along;
    if (found.status == GTM_TRIMMED) return found;
    if (gtm_scan_rudder(p, lower, upper, given, near->y, found.y) == GTM_TRIMMED) {
        found.status = GTM_TRIMMED;
        found.violation = gtm_violation(p, found.y, lower, upper);
    }
    return found;
}

int gtm_find_trim(const gtm_problem *p, const double *lower, const double *upper, double *y, double *residual,
                  double *violation)
{
    int held[3];
    const int given = conditions(lower, upper, held);
    const int is_settled = given < 3 && gtm_rudder_settles(p, lower, upper);
    if (is_settled) held[2] = RUDDER;

    point at = trim_holding(p, lower, upper, held);
    /* With the rudder held the point of the manifold is unique, else another sideslip may lie inside the bounds. */
    if (at.status != GTM_TRIMMED && !is_settled) {
        point other = trim_at_other_sideslip(p, lower, upper, held, &at);
        if (other.status == GTM_TRIMMED) gtm_join_throttles(p, lower, upper, other.y);
        if (other.status != GTM_NO_TRIM) at = other;
    }
    double F[GTM_NF];
    p->aircraft->residual(p, at.y, F);
    *residual = gtm_residual_norm(F);
    *violation = at.violation;
    memcpy(y, at.y, sizeof *y * (size_t)p->unknowns);
    return at.status;
}
