#include "solver/descent.h"

#include <math.h>
#include <string.h>

#include "solver/step.h"

static const double tolerated = 1e-7; /* violation that the rounding of a descent leaves */
enum { MOST_STEPS = 100 };

/* When to stop: the promise and the radius, in scaled units, and the largest |F| of a point on the manifold; and the
   first and the largest radius of a step. Every start is followed roughly, the best to the end. */
typedef struct {
    double promise, radius, residual, first_radius, largest_radius;
} precision;

static const precision rough = {3e-5, 1e-3, 1e-7, 0.5, 4}, fine = {1e-9, 1e-8, 1e-11, 0.5, 4};

/* Where a descent is, with the Jacobian there. */
typedef struct {
    double y[GTM_MOST_UNKNOWNS], J[GTM_NF * GTM_MOST_UNKNOWNS], merit, violation;
} place;

static void price(const gtm_search *s, place *at)
{
    at->violation = gtm_violation(s->problem, at->y, s->lower, s->upper);
    at->merit = gtm_value(s, at->y) + gtm_violation_price * at->violation;
}

/* Bring y to F = 0 with the unknowns of equal bounds held there. Where they are more than three, or too far away, only
   those stay held that y already meets, and the search brings the others to their bounds. */
static int take_hold(gtm_search *s, double enough, place *at)
{
    double held[GTM_MOST_UNKNOWNS];
    const int n = s->problem->unknowns;
    int count = 0;
    for (int i = 0; i < n; i++) {
        s->is_free[i] = s->lower[i] != s->upper[i];
        held[i] = s->is_free[i] ? at->y[i] : s->lower[i];
        count += s->is_free[i];
    }
    if (count >= GTM_NF && !gtm_project(held, s->problem, s->is_free, enough, at->J)) {
        memcpy(at->y, held, sizeof held);
        return 0;
    }
    count = n;
    for (int i = 0; i < n; i++) {
        const int is_met = s->lower[i] == s->upper[i] && at->y[i] == s->lower[i];
        s->is_free[i] = !is_met || count == GTM_NF;
        if (!s->is_free[i]) count--;
    }
    return gtm_project(at->y, s->problem, s->is_free, enough, at->J);
}

/* A step in the tangent space and the drop of the merit that it promises. */
typedef struct {
    gtm_tangent tangent;
    gtm_linear_model model;
    double x[GTM_MOST_X], promised;
} proposal;

static void propose(const gtm_search *s, const place *at, const gtm_cell *c, double radius, proposal *out)
{
    out->promised = -1;
    if (gtm_tangent_at(at->y, s->problem, s->is_free, c, at->J, &out->tangent)) return;
    gtm_linear_model_at(s, at->y, &out->tangent, c, radius, &out->model);
    if (gtm_linear_step(&out->model, out->x)) return;
    out->promised = 0;
    for (int j = 0; j < out->model.dimension; j++) out->promised -= out->model.price[j] * out->x[j];
    out->promised += gtm_violation_price * out->model.violation;
}

/* Where no gain is left in the cell: the same from the cell beyond a breakpoint that y lies on. */
static void propose_beyond(const gtm_search *s, const place *at, gtm_cell *here, double radius, double enough,
                           proposal *out)
{
    for (int j = 0; out->promised < enough && j < GTM_KINKED; j++) {
        const int i = s->problem->aircraft->kinked[j];
        const double slack = gtm_border * s->problem->aircraft->scale[i];
        const int at_upper = fabs(at->y[i] - here->upper[i]) <= slack;
        if (!s->is_free[i] || !(at_upper || fabs(at->y[i] - here->lower[i]) <= slack)) continue;
        const gtm_cell beyond = gtm_cell_beyond(s->problem, here, i, at->y[i], at_upper);
        propose(s, at, &beyond, radius, out);
        if (out->promised >= enough) *here = beyond;
    }
}

/* Go the proposed way and back to the manifold; the share of the promise that it kept, -1 without a way back. */
static double try_step(const gtm_search *s, const gtm_cell *c, const proposal *way, double enough, const place *from,
                       place *to, double *longest)
{
    *longest = 0;
    for (int i = 0; i < s->problem->unknowns; i++) {
        double step = 0;
        for (int j = 0; j < way->tangent.count; j++) step += way->tangent.direction[i][j] * way->x[j];
        to->y[i] = from->y[i] + step * s->problem->aircraft->scale[i];
        *longest = fmax(*longest, fabs(step));
    }
    if (gtm_project_along_bounds(to->y, s->problem, s->lower, s->upper, c, s->is_free, enough, to->J)) return -1;
    price(s, to);
    return (from->merit - to->merit) / way->promised;
}

/* The same along the bounds that the step reaches, with the manifold's curvature; -1 when nothing is promised there. */
static double try_along_bounds(const gtm_search *s, const gtm_cell *c, const proposal *way, double enough,
                               const place *from, place *to, double *longest)
{
    gtm_curvature curvature;
    proposal along = *way;
    if (gtm_curvature_at(from->y, s->problem, c, &way->tangent, &curvature)) return -1;
    along.promised = gtm_quadratic_step(s, &way->model, &curvature, along.x);
    if (!(along.promised > 0)) return -1;
    return try_step(s, c, &along, enough, from, to, longest);
}

/* Shares of a promise: a step is taken, the tangent space of one cell will not do, the trust region is too small. */
static const double least_gain = 0.05, poor_gain = 0.25, good_gain = 0.7;

static double next_radius(double radius, double gained, double longest, double largest)
{
    if (gained < poor_gain) return 0.3 * fmin(radius, longest);
    if (gained > good_gain && longest > 0.9 * radius) return fmin(2 * radius, largest);
    return radius;
}

/* One start; y ends at a local optimum; its violation is returned (infinite: no trim). */
static double descend(gtm_search *s, precision enough, double *y)
{
    const size_t row = sizeof *y * (size_t)s->problem->unknowns;
    const gtm_cell open = gtm_open_cell();
    gtm_cell here = open;
    int in_cells = 0;
    place places[2], *at = places, *trial = places + 1;
    proposal way;
    memcpy(at->y, y, row);
    if (take_hold(s, enough.residual, at)) return INFINITY;
    price(s, at);
    double radius = enough.first_radius;
    for (int k = 0; k < MOST_STEPS && radius > enough.radius; k++) {
        double gained = -1, longest = 0;
        const gtm_cell *c = in_cells ? &here : &open;
        propose(s, at, c, radius, &way);
        if (in_cells) propose_beyond(s, at, &here, radius, enough.promise, &way);
        if (way.promised < enough.promise) break;
        if (in_cells && gtm_is_cut_short(&way.model, way.x))
            gained = try_along_bounds(s, c, &way, enough.residual, at, trial, &longest);
        if (gained <= least_gain) gained = try_step(s, c, &way, enough.residual, at, trial, &longest);
        if (gained > least_gain) {
            place *const left = at;
            at = trial;
            trial = left;
            if (in_cells) gtm_update_cell(s->problem, &here, at->y);
        }
        if (gained < poor_gain && !in_cells) {
            in_cells = 1;
            here = gtm_cell_at(s->problem, at->y, s->upper);
        } else {
            radius = next_radius(radius, gained, longest, enough.largest_radius);
        }
    }
    memcpy(y, at->y, row);
    return at->violation;
}

/* A local optimum. */
typedef struct {
    double y[GTM_MOST_UNKNOWNS], value, violation;
} optimum;

static int is_better(const optimum *a, const optimum *b)
{
    const int a_inside = a->violation <= tolerated, b_inside = b->violation <= tolerated;
    if (a_inside != b_inside) return a_inside;
    return a_inside ? a->value < b->value : a->violation < b->violation;
}

static int same_place(const gtm_problem *p, const optimum *a, const optimum *b)
{
    for (int i = 0; i < p->unknowns; i++)
        if (fabs(a->y[i] - b->y[i]) > 1e-3 * p->aircraft->scale[i]) return 0;
    return 1;
}

/* Keep the best of different places, best first. */
static void keep(const gtm_problem *p, optimum *kept, int *count, int most, const optimum *found)
{
    for (int k = 0; k < *count; k++)
        if (same_place(p, kept + k, found)) {
            if (!is_better(found, kept + k)) return;
            memmove(kept + k, kept + k + 1, sizeof *kept * (size_t)(--*count - k));
            break;
        }
    int rank = *count;
    while (rank > 0 && is_better(found, kept + rank - 1)) rank--;
    if (rank == most) return;
    if (*count < most) ++*count;
    memmove(kept + rank + 1, kept + rank, sizeof *kept * (size_t)(*count - 1 - rank));
    kept[rank] = *found;
}

/* Outside the bounds the objective still has its say against the price of the violation: bring the violation alone to
   its least, and should that lead inside, go on with the objective from there. */
static void exceed_least(gtm_search *s, optimum *o)
{
    static const double none[GTM_MOST_UNKNOWNS] = {0};
    gtm_search alone = *s;
    optimum nearest = *o;
    alone.objective = none;
    nearest.violation = descend(&alone, fine, nearest.y);
    if (nearest.violation <= tolerated) nearest.violation = descend(s, fine, nearest.y);
    nearest.value = gtm_value(s, nearest.y);
    if (is_better(&nearest, o)) *o = nearest;
}

/* The objective in scaled unknowns, the largest of its slopes 1. */
static void scale_objective(const gtm_problem *p, const double *objective, double *scaled)
{
    double largest = 0;
    for (int i = 0; i < p->unknowns; i++) largest = fmax(largest, fabs(objective[i]) * p->aircraft->scale[i]);
    for (int i = 0; i < p->unknowns; i++) scaled[i] = objective[i] * p->aircraft->scale[i] / largest;
}

int gtm_move_extreme(const gtm_problem *p, const double *lower, const double *upper, const double *objective, double stride,
                     double *y, double *violation)
{
    double scaled[GTM_MOST_UNKNOWNS];
    gtm_search s = {p, lower, upper, scaled, {0}};
    const precision enough = {fine.promise, fine.radius, fine.residual, stride, 2 * stride};
    scale_objective(p, objective, scaled);
    *violation = descend(&s, enough, y);
    if (!isfinite(*violation)) return GTM_NO_TRIM;
    return *violation <= tolerated ? GTM_TRIMMED : GTM_OUTSIDE;
}

int gtm_find_extreme(const gtm_problem *p, const double *lower, const double *upper, const double *objective, long n,
                     const double *starts, double *best, double *violation)
{
    enum { MOST_KEPT = 6 };
    double scaled[GTM_MOST_UNKNOWNS];
    gtm_search s = {p, lower, upper, scaled, {0}};
    optimum kept[MOST_KEPT], polished;
    const size_t row = (size_t)p->unknowns * sizeof *best;
    int count = 0, found = 0;
    scale_objective(p, objective, scaled);
    for (long k = 0; k < n; k++) {
        optimum o = {{0}, 0, 0};
        memcpy(o.y, starts + k * p->unknowns, row);
        o.violation = descend(&s, rough, o.y);
        o.value = gtm_value(&s, o.y);
        if (isfinite(o.violation)) keep(p, kept, &count, MOST_KEPT, &o);
    }
    for (int k = 0; k < count; k++) {
        optimum o = kept[k];
        o.violation = descend(&s, fine, o.y);
        o.value = gtm_value(&s, o.y);
        if (!isfinite(o.violation)) continue;
        if (!found || is_better(&o, &polished)) polished = o;
        found = 1;
    }
    *violation = INFINITY;
    if (!found) return GTM_NO_TRIM;
    if (polished.violation > tolerated) exceed_least(&s, &polished);
    *violation = polished.violation;
    memcpy(best, polished.y, row);
    return polished.violation <= tolerated ? GTM_TRIMMED : GTM_OUTSIDE;
}
