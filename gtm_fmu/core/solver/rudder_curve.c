#include "solver/rudder_curve.h"

#include <math.h>
#include <string.h>

#include "solver/cold_start.h"
#include "solver/linear_algebra.h"
#include "solver/newton.h"

static const double step = 5;               /* deg between the points of the curve that are solved first */
enum { MOST_REFINED = 40, SMALLER = 4 };
static const double near = 1.5;             /* scaled units of violation, more than it changes over half a step */
static const double enough = 1e-9;          /* scaled units of violation: so much less is not sought */
static const double narrow = 0.1;           /* deg: between so near trims the violation is convex */

typedef struct {
    const gtm_problem *problem;
    const double *lower, *upper;
    int rudder_held[3];
    int status, is_sure;                    /* of the best trim so far; whether none better can have been passed */
    double *y, violation;
} curve;

static size_t row_of(const curve *c)
{
    return sizeof *c->y * (size_t)c->problem->unknowns;
}

/* Inside the bounds less sideslip is better, outside less excess. */
static void keep_better(curve *c, const double *trial)
{
    const double violation = gtm_violation(c->problem, trial, c->lower, c->upper);
    const int status = violation <= gtm_rounding ? GTM_TRIMMED : GTM_OUTSIDE;
    if (status > c->status) return;
    if (status == c->status) {
        if (status == GTM_TRIMMED ? fabs(trial[BETA]) >= fabs(c->y[BETA]) : violation >= c->violation) return;
    }
    c->status = status;
    c->violation = violation;
    memcpy(c->y, trial, row_of(c));
}

/* The trim at another deflection, from y; the trim before gives the direction. */
static int solve_at(const curve *c, double rudder, const double *before, double *y)
{
    const double share = before && before[RUDDER] != y[RUDDER] ? (rudder - y[RUDDER]) / (y[RUDDER] - before[RUDDER]) : 0;
    for (int i = 0; i < c->problem->unknowns && share > 0; i++) y[i] += share * (y[i] - before[i]);
    y[RUDDER] = rudder;
    if (gtm_newton(c->problem, y, c->rudder_held)) return 1;
    return y[THROTTLE] <= c->problem->aircraft->least[THROTTLE]; /* without net thrust the throttle is anywhere */
}

/* The trims between two neighbouring ones at which an unknown crosses a bound. */
static void try_crossings(curve *c, const double *before, const double *after)
{
    const gtm_problem *p = c->problem;
    double trial[GTM_MOST_UNKNOWNS];
    for (int i = V; i < p->unknowns; i++) {
        const int is_given = i == c->rudder_held[0] || i == c->rudder_held[1];
        if (is_given || i == RUDDER || p->is_dead[i] || before[i] == after[i]) continue;
        const int bound_held[3] = {c->rudder_held[0], c->rudder_held[1], i};
        const double bound[2] = {c->lower[i], c->upper[i]};
        for (int side = 0; side < (bound[0] < bound[1] ? 2 : 1); side++) {
            const double share = (bound[side] - before[i]) / (after[i] - before[i]);
            if (!(share >= 0 && share <= 1)) continue;
            for (int j = 0; j < p->unknowns; j++) trial[j] = before[j] + share * (after[j] - before[j]);
            trial[i] = bound[side];
            if (!gtm_newton(p, trial, bound_held)) keep_better(c, trial);
        }
    }
}

/* Violation at a trim and its slope per deg of rudder; 1 where there is none. */
static int slope_of_violation(const curve *c, const double *y, double *violation, double *slope)
{
    const gtm_problem *p = c->problem;
    double F[GTM_NF], J[GTM_NF * GTM_MOST_UNKNOWNS], A[GTM_NF * GTM_NF], along[GTM_NF + 1];
    int moving[GTM_NF + 1], count = 0;
    for (int i = 0; i < p->unknowns && count < GTM_NF; i++)
        if (i != c->rudder_held[0] && i != c->rudder_held[1] && i != RUDDER && !p->is_dead[i]) moving[count++] = i;
    moving[GTM_NF] = RUDDER;
    p->aircraft->jacobian(p, y, F, J);
    for (int i = 0; i < GTM_NF; i++) {
        for (int k = 0; k < GTM_NF; k++) A[i * GTM_NF + k] = J[i * p->unknowns + moving[k]];
        along[i] = -J[i * p->unknowns + RUDDER];
    }
    if (gtm_solve(GTM_NF, A, along)) return 1;
    along[GTM_NF] = 1;
    *violation = -INFINITY;
    for (int k = 0; k <= GTM_NF; k++) {
        const int i = moving[k], is_above = y[i] - c->upper[i] > c->lower[i] - y[i];
        const double excess = (is_above ? y[i] - c->upper[i] : c->lower[i] - y[i]) / p->aircraft->scale[i];
        if (excess <= *violation) continue;
        *violation = excess;
        *slope = (is_above ? along[k] : -along[k]) / p->aircraft->scale[i];
    }
    return 0;
}

/* Close in on the least violation between two trims where it falls and rises: the next deflection is where the
   tangents of both meet, or near the end that this is beyond. */
static void refine(curve *c, const double *falling, const double *rising)
{
    double low = falling[RUDDER], high = rising[RUDDER], v_low, s_low, v_high, s_high;
    double y[GTM_MOST_UNKNOWNS], before[GTM_MOST_UNKNOWNS], after[GTM_MOST_UNKNOWNS];
    if (slope_of_violation(c, falling, &v_low, &s_low) || slope_of_violation(c, rising, &v_high, &s_high)) return;
    if (!(s_low < 0 && s_high > 0)) return;
    memcpy(y, falling, row_of(c));
    memcpy(before, falling, row_of(c));
    memcpy(after, rising, row_of(c));
    for (int k = 0; k < MOST_REFINED && c->status != GTM_TRIMMED; k++) {
        double violation, slope;
        const double width = high - low, least = 0.02 * width;
        double meet = (v_low - v_high + s_high * high - s_low * low) / (s_high - s_low);
        if (width < narrow && c->violation - (v_low + s_low * (meet - low)) < enough) return;
        meet = fmin(fmax(meet, low + least), high - least);
        if (solve_at(c, meet, 0, y) || slope_of_violation(c, y, &violation, &slope)) return;
        keep_better(c, y);
        try_crossings(c, before, y);
        try_crossings(c, y, after);
        if (slope < 0) low = meet, v_low = violation, s_low = slope;
        else high = meet, v_high = violation, s_high = slope;
        memcpy(slope < 0 ? before : after, y, row_of(c));
    }
}

/* Whether a trim inside the bounds lies on one of them. */
static int is_at_bound(const curve *c, const double *y)
{
    for (int i = ALPHA; i < c->problem->unknowns; i++) {
        const double slack = gtm_rounding * c->problem->aircraft->scale[i];
        const int is_given = i == c->rudder_held[0] || i == c->rudder_held[1];
        if (!is_given && (y[i] <= c->lower[i] + slack || y[i] >= c->upper[i] - slack)) return 1;
    }
    return 0;
}

/* Close in on where the trims inside the bounds begin, between one outside of them and the best. */
static void find_edge(curve *c, const double *outside)
{
    double before[GTM_MOST_UNKNOWNS], y[GTM_MOST_UNKNOWNS];
    memcpy(before, outside, row_of(c));
    for (int k = 0; k < MOST_REFINED && !is_at_bound(c, c->y); k++) {
        memcpy(y, c->y, row_of(c));
        if (solve_at(c, 0.5 * (before[RUDDER] + y[RUDDER]), 0, y)) return;
        const int is_outside = gtm_violation(c->problem, y, c->lower, c->upper) > gtm_rounding;
        keep_better(c, y);
        if (is_outside) memcpy(before, y, row_of(c));
        memcpy(y, c->y, row_of(c));
        try_crossings(c, before, y);
    }
}

static void refine_between(curve *c, const double *a, const double *b)
{
    if (a[RUDDER] < b[RUDDER]) refine(c, a, b);
    else refine(c, b, a);
}

/* What lies between two neighbouring trims, the second with it; the first is outside the bounds. Few trims inside
   between two outside are looked for where these are near the bounds. */
static void search_between(curve *c, const double *at, const double *next)
{
    const double excess = gtm_violation(c->problem, at, c->lower, c->upper);
    keep_better(c, next);
    try_crossings(c, at, next);
    if (c->status == GTM_TRIMMED) {
        find_edge(c, at);
    } else if (fmin(excess, gtm_violation(c->problem, next, c->lower, c->upper)) < near) {
        refine_between(c, at, next);
        if (c->status == GTM_TRIMMED) c->is_sure = 0; /* there may be others beside them */
    }
}

/* Where all trims are outside: look about the one that is nearest to the bounds, with smaller steps. */
static void look_about(curve *c)
{
    double points[2 * SMALLER + 1][GTM_MOST_UNKNOWNS];
    int first = SMALLER, last = SMALLER, nearest = SMALLER;
    memcpy(points[SMALLER], c->y, row_of(c));
    for (int direction = -1; direction <= 1; direction += 2)
        for (int k = 1, at = SMALLER; k <= SMALLER; k++, at += direction) {
            double *next = points[at + direction];
            const double rudder = points[SMALLER][RUDDER] + direction * k * step / SMALLER;
            memcpy(next, points[at], row_of(c));
            if (solve_at(c, fmin(fmax(rudder, c->lower[RUDDER]), c->upper[RUDDER]), 0, next)) break;
            if (next[RUDDER] == points[at][RUDDER]) break;
            const double before = c->violation;
            keep_better(c, next);
            if (c->violation < before) nearest = at + direction;
            if (direction < 0) first = at + direction;
            else last = at + direction;
        }
    if (nearest > first) refine_between(c, points[nearest - 1], points[nearest]);
    if (nearest < last) refine_between(c, points[nearest], points[nearest + 1]);
}

/* From a trim towards another deflection, to the first trims inside the bounds, as long as there is less than this
   sideslip; where the curve breaks before, the deflection that it reached. */
static double follow(curve *c, const double *start, double end, double sideslip)
{
    double points[3][GTM_MOST_UNKNOWNS], *before = 0, *at = points[0], *next = points[1];
    const int is_up = end > start[RUDDER];
    memcpy(at, start, row_of(c));
    for (int k = 2; c->status != GTM_TRIMMED && at[RUDDER] != end && fabs(at[BETA]) < sideslip; k++) {
        const double beyond = step * (is_up ? floor(at[RUDDER] / step) + 1 : ceil(at[RUDDER] / step) - 1);
        memcpy(next, at, row_of(c));
        if (solve_at(c, is_up ? fmin(beyond, end) : fmax(beyond, end), before, next)) {
            /* What ends far outside the bounds has passed none inside. */
            if (gtm_violation(c->problem, at, c->lower, c->upper) < near) c->is_sure = 0;
            return at[RUDDER];
        }
        search_between(c, at, next);
        before = at;
        at = next;
        next = points[k % 3];
    }
    return end;
}

/* The same to the end of the range, and where the curve breaks back from there. */
static void follow_to_end(curve *c, const double *start, double end, double sideslip)
{
    double y[GTM_MOST_UNKNOWNS];
    const double reached = follow(c, start, end, sideslip);
    if (reached == end) return;
    memcpy(y, start, row_of(c));
    y[RUDDER] = end;
    if (gtm_cold_newton(c->problem, y, c->rudder_held)) return;
    keep_better(c, y);
    if (c->status != GTM_TRIMMED) follow(c, y, reached, INFINITY);
    if (c->status == GTM_TRIMMED) c->is_sure = 0; /* on this way the first trims inside have the most sideslip */
}

/* From a trim to both sides: the first trims inside the bounds to one side need not have the least sideslip. */
static void follow_both(curve *c, const double *start)
{
    double y[GTM_MOST_UNKNOWNS];
    curve other = *c;
    other.y = y;
    memcpy(y, c->y, row_of(c));
    follow_to_end(c, start, c->upper[RUDDER], INFINITY);
    follow_to_end(&other, start, c->lower[RUDDER], c->status == GTM_TRIMMED ? fabs(c->y[BETA]) : INFINITY);
    keep_better(c, y);
    c->is_sure &= other.is_sure;
}

/* Where less sideslip would need less thrust than the engines have at their lowest, the curve has a hole. Its trims
   begin to either side at that throttle, where they have the least sideslip, and go on from there. */
static void follow_from_glides(curve *c)
{
    const gtm_problem *p = c->problem;
    const int throttle_held[3] = {c->rudder_held[0], c->rudder_held[1], THROTTLE};
    for (int side = -1; side <= 1; side += 2) {
        double y[GTM_MOST_UNKNOWNS] = {0}, here[GTM_MOST_UNKNOWNS];
        curve one = *c;
        one.y = here;
        one.status = GTM_NO_TRIM;
        for (int k = 0; k < 2; k++) y[c->rudder_held[k]] = c->lower[c->rudder_held[k]];
        y[THROTTLE] = c->lower[THROTTLE];
        y[BETA] = side * p->aircraft->spacing.glide_sideslip;
        if (gtm_cold_newton(p, y, throttle_held) || side * y[BETA] < 0) {
            c->is_sure = 0;
            continue;
        }
        const double end = side > 0 ? c->upper[RUDDER] : c->lower[RUDDER];
        if (side * (y[RUDDER] - end) > 0) continue;
        const int is_short = y[RUDDER] < c->lower[RUDDER] || y[RUDDER] > c->upper[RUDDER];
        if (is_short && solve_at(&one, side > 0 ? c->lower[RUDDER] : c->upper[RUDDER], 0, y)) {
            c->is_sure = 0;
            continue;
        }
        keep_better(&one, y);
        if (one.status != GTM_TRIMMED) follow_to_end(&one, y, end, INFINITY);
        keep_better(c, here);
        c->is_sure &= one.is_sure;
    }
    if (c->status == GTM_NO_TRIM) c->is_sure = 0;
}

int gtm_follow_rudder(const gtm_problem *p, const double *lower, const double *upper, const int given[2],
                      const double *start, double *y, double *violation, int *is_sure)
{
    double at[GTM_MOST_UNKNOWNS];
    curve c = {p, lower, upper, {given[0], given[1], RUDDER}, GTM_NO_TRIM, 1, y, INFINITY};
    *is_sure = 0;
    if (p->throttles == GTM_TWO_THROTTLES) return GTM_NO_TRIM;
    for (int i = ELEVATOR; i < p->unknowns; i++)
        if (p->is_dead[i]) return GTM_NO_TRIM;
    if (start) memcpy(at, start, row_of(&c));
    if (start && !solve_at(&c, fmin(fmax(start[RUDDER], lower[RUDDER]), upper[RUDDER]), 0, at)) {
        keep_better(&c, at);
        if (c.status != GTM_TRIMMED) follow_both(&c, at);
    } else {
        follow_from_glides(&c);
    }
    if (c.status == GTM_OUTSIDE && c.is_sure) look_about(&c);
    *violation = c.violation;
    *is_sure = c.is_sure;
    return c.status;
}
