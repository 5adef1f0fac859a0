/* Least of a linear objective on the trim manifold under bounds: trust-region sequential linear programming.

   At a point of the manifold six unknowns follow from the others (null space of the Jacobian); a linear program in the
   remaining two to four, plus one variable for the largest violation of the bounds, gives the step; Newton brings its
   end back to the manifold. The violation is charged at a high price, which also is the search for a feasible point.

   The tables are piecewise linear, and an optimum may lie on a breakpoint, where the slopes of one side mislead. Once a
   step disappoints, steps end at the border of the cell between breakpoints; a point on a border, with no gain left in
   its cell, looks into the cell beyond. */
#include <math.h>
#include <string.h>

#include "solver.h"

static const double violation_price = 1000, inside = 1e-7;
static const double first_radius = 0.5, largest_radius = 4;
enum { MOST_STEPS = 100, MOST_FREE = GTM_FULL_NT, MOST_NULL = MOST_FREE - GTM_NF };

/* Row scale of the residual: g and 1 rad/s^2 weigh alike in pivoting. */
static const double row_scale[GTM_NF] = {0.03, 0.03, 0.03, 1, 1, 1};

typedef struct {
    int count;                                /* dimension of the null space */
    double direction[GTM_FULL_NT][MOST_NULL]; /* scaled step for one unit of each null-space unknown */
} tangent;

/* Tangent space at y with the slopes of cell c: eliminate six free unknowns with complete pivoting. */
static int tangent_at(const double *y, const gtm_problem *p, const int *is_free, const gtm_cell *c, tangent *out)
{
    double F[GTM_NF], J[GTM_NF * GTM_FULL_NT], A[GTM_NF][GTM_FULL_NT], within[GTM_FULL_NT] = {0};
    const int n = p->unknowns;
    int column[GTM_FULL_NT], free_count = 0;
    for (int i = 0; i < n; i++) {
        const double slack = gtm_border * gtm_scale[i];
        within[i] = fmin(fmax(y[i], c->lower[i] + slack), c->upper[i] - slack);
    }
    gtm_problem_jacobian(p, within, F, J);
    for (int i = 0; i < n; i++)
        if (is_free[i]) column[free_count++] = i;
    for (int i = 0; i < GTM_NF; i++) {
        for (int k = 0; k < free_count; k++) A[i][k] = J[i * n + column[k]] * gtm_scale[column[k]] * row_scale[i];
    }
    for (int s = 0; s < GTM_NF; s++) {
        int row = s, col = s;
        for (int i = s; i < GTM_NF; i++)
            for (int k = s; k < free_count; k++)
                if (fabs(A[i][k]) > fabs(A[row][col])) row = i, col = k;
        if (!(fabs(A[row][col]) > 1e-10)) return 1;
        for (int k = 0; k < free_count; k++) {
            const double kept = A[s][k];
            A[s][k] = A[row][k];
            A[row][k] = kept;
        }
        for (int i = 0; i < GTM_NF; i++) {
            const double kept = A[i][s];
            A[i][s] = A[i][col];
            A[i][col] = kept;
        }
        const int kept = column[s];
        column[s] = column[col];
        column[col] = kept;
        const double inverse = 1 / A[s][s];
        for (int k = s; k < free_count; k++) A[s][k] *= inverse;
        for (int i = 0; i < GTM_NF; i++) {
            if (i == s) continue;
            const double factor = A[i][s];
            for (int k = s; k < free_count; k++) A[i][k] -= factor * A[s][k];
        }
    }
    memset(out, 0, sizeof *out);
    out->count = free_count - GTM_NF;
    for (int s = 0; s < GTM_NF; s++)
        for (int j = 0; j < out->count; j++) out->direction[column[s]][j] = -A[s][GTM_NF + j];
    for (int j = 0; j < out->count; j++) out->direction[column[GTM_NF + j]][j] = 1;
    return 0;
}

/* Minimum-norm Newton back to F = 0 in the unknowns of `movable` (at least six). */
static int project(double *y, const gtm_problem *p, const int *movable)
{
    const int n = p->unknowns;
    double before = INFINITY;
    for (int iteration = 0; iteration < 10; iteration++) {
        double F[GTM_NF], J[GTM_NF * GTM_FULL_NT], A[GTM_NF * GTM_NF];
        gtm_problem_jacobian(p, y, F, J);
        const double norm = gtm_residual_norm(F);
        if (!isfinite(norm)) return 1;
        if (norm < 1e-11) return 0;
        if (iteration > 3 && norm > 0.5 * before) return norm < 1e-9 ? 0 : 1;
        before = norm;
        for (int i = 0; i < GTM_NF; i++)
            for (int k = 0; k < n; k++) J[i * n + k] *= movable[k] ? gtm_scale[k] * row_scale[i] : 0;
        for (int i = 0; i < GTM_NF; i++) {
            F[i] *= row_scale[i];
            for (int j = 0; j < GTM_NF; j++) {
                double sum = 0;
                for (int k = 0; k < n; k++) sum += J[i * n + k] * J[j * n + k];
                A[i * GTM_NF + j] = sum;
            }
        }
        if (gtm_solve(GTM_NF, A, F)) return 1;
        for (int k = 0; k < n; k++) {
            double step = 0;
            for (int i = 0; i < GTM_NF; i++) step += J[i * n + k] * F[i];
            if (!(fabs(step) < 10)) return 1;
            y[k] -= step * gtm_scale[k];
        }
        if (!(y[V] > 1)) return 1;
    }
    return before < 1e-9 ? 0 : 1;
}

/* Project with the unknowns that reached a bound or the cell's border frozen there; with all of them if that leaves too
   few or fails. */
static int project_along_bounds(double *y, const gtm_problem *p, const double *lower, const double *upper,
                                const gtm_cell *c, const int *is_free)
{
    int movable[GTM_FULL_NT], count = 0;
    double frozen[GTM_FULL_NT];
    memcpy(frozen, y, sizeof frozen);
    for (int i = 0; i < p->unknowns; i++) {
        const double slack = 1e-9 * gtm_scale[i];
        movable[i] = is_free[i] && fabs(y[i] - lower[i]) > slack && fabs(y[i] - upper[i]) > slack &&
                     fabs(y[i] - c->lower[i]) > slack && fabs(y[i] - c->upper[i]) > slack;
        count += movable[i];
    }
    if (count >= GTM_NF && !project(frozen, p, movable)) {
        memcpy(y, frozen, sizeof frozen);
        return 0;
    }
    return project(y, p, is_free);
}

/* Linear program in the tangent space: step of y/scale and the violation it leaves. */
static int linear_step(const double *y, const gtm_problem *p, const double *lower, const double *upper, const double *objective,
                       const int *is_free, const tangent *at_y, const gtm_cell *c_y, double radius, double *step,
                       double *left_over)
{
    const int n = p->unknowns, m = at_y->count, d = m + 1;
    double A[4 * MOST_FREE * (MOST_NULL + 1)], b[4 * MOST_FREE], c[MOST_NULL + 1] = {0};
    double low[MOST_NULL + 1], high[MOST_NULL + 1], x[MOST_NULL + 1], violation = 0;
    int rows = 0;
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < m; j++) c[j] += objective[i] * at_y->direction[i][j];
        if (!is_free[i]) continue;
        const double room[2] = {(upper[i] - y[i]) / gtm_scale[i], (y[i] - lower[i]) / gtm_scale[i]};
        for (int side = 0; side < 2; side++) {
            const double sign = side ? -1 : 1;
            for (int j = 0; j < m; j++) A[rows * d + j] = sign * at_y->direction[i][j];
            A[rows * d + m] = -1;
            b[rows++] = room[side];
            if (-room[side] > violation) violation = -room[side];
        }
    }
    for (int i = 0, k = 0; i < n; i++) { /* the trust region and the cell hold for every unknown */
        if (!is_free[i]) continue;
        const double reach[2] = {(c_y->upper[i] - y[i]) / gtm_scale[i], (y[i] - c_y->lower[i]) / gtm_scale[i]};
        for (int side = 0; side < 2; side++, k++, rows++) {
            memcpy(A + rows * d, A + k * d, m * sizeof *A);
            A[rows * d + m] = 0;
            b[rows] = fmin(radius, fmax(reach[side], 0));
        }
    }
    for (int j = 0; j < m; j++) low[j] = -radius, high[j] = radius;
    c[m] = violation_price;
    low[m] = 0;
    high[m] = violation;
    if (gtm_linear_program(d, rows, A, b, c, low, high, x)) return 1;
    for (int i = 0; i < n; i++) {
        step[i] = 0;
        for (int j = 0; j < m; j++) step[i] += at_y->direction[i][j] * x[j];
    }
    *left_over = x[m];
    return 0;
}

static double value_of(const gtm_problem *p, const double *objective, const double *y)
{
    double value = 0;
    for (int i = 0; i < p->unknowns; i++) value += objective[i] * y[i] / gtm_scale[i];
    return value;
}

/* What a linear program in cell c promises: the drop of the merit, and the step that leads there. */
static double promise(const double *y, const gtm_problem *p, const double *lower, const double *upper,
                      const double *objective, const int *is_free, const gtm_cell *c, double radius, double *step)
{
    tangent at_y;
    double left_over, end[GTM_FULL_NT];
    if (tangent_at(y, p, is_free, c, &at_y)) return -1;
    if (linear_step(y, p, lower, upper, objective, is_free, &at_y, c, radius, step, &left_over)) return -1;
    for (int i = 0; i < p->unknowns; i++) end[i] = y[i] + step[i] * gtm_scale[i];
    return value_of(p, objective, y) - value_of(p, objective, end) +
           violation_price * (gtm_violation(p, y, lower, upper) - left_over);
}

/* When to stop: the promise and the radius, in scaled units. Every start is followed roughly, the best to the end. */
typedef struct {
    double promise, radius;
} precision;

static const precision rough = {3e-5, 1e-3}, fine = {1e-9, 1e-8};

/* Bring y to F = 0 with the unknowns of equal bounds held there. Where they are more than three, or too far away, only
   those stay held that y already meets, and the search brings the others to their bounds. */
static int take_hold(double *y, const gtm_problem *p, const double *lower, const double *upper, int *is_free)
{
    double held[GTM_FULL_NT];
    int count = 0;
    for (int i = 0; i < p->unknowns; i++) {
        is_free[i] = lower[i] != upper[i];
        held[i] = is_free[i] ? y[i] : lower[i];
        count += is_free[i];
    }
    if (count >= GTM_NF && !project(held, p, is_free)) {
        memcpy(y, held, sizeof held);
        return 0;
    }
    count = p->unknowns;
    for (int i = 0; i < p->unknowns; i++) {
        is_free[i] = lower[i] != upper[i] || y[i] != lower[i] || count == GTM_NF;
        count -= !is_free[i];
    }
    return project(y, p, is_free);
}

/* One start; objective in scaled units. y ends at a local optimum; its violation is returned (infinite: no trim). */
static double descend(const gtm_problem *p, const double *lower, const double *upper, const double *objective,
                      precision enough, double *y)
{
    int is_free[GTM_FULL_NT], in_cells = 0;
    if (take_hold(y, p, lower, upper, is_free)) return INFINITY;
    double radius = first_radius, violation = gtm_violation(p, y, lower, upper);
    double merit = value_of(p, objective, y) + violation_price * violation;
    const gtm_cell open = gtm_open_cell();
    gtm_cell here = open;
    for (int k = 0; k < MOST_STEPS && radius > enough.radius; k++) {
        double step[GTM_FULL_NT], trial[GTM_FULL_NT], longest = 0;
        double promised = promise(y, p, lower, upper, objective, is_free, in_cells ? &here : &open, radius, step);
        for (int j = 0; in_cells && promised < enough.promise && j < GTM_KINKED; j++) {
            const int i = gtm_kinked[j];
            const double slack = gtm_border * gtm_scale[i];
            const int at_upper = fabs(y[i] - here.upper[i]) <= slack;
            if (!is_free[i] || !(at_upper || fabs(y[i] - here.lower[i]) <= slack)) continue;
            const gtm_cell beyond = gtm_cell_beyond(p, &here, i, y[i], at_upper);
            promised = promise(y, p, lower, upper, objective, is_free, &beyond, radius, step);
            if (promised >= enough.promise) here = beyond;
        }
        if (promised < enough.promise) break;
        for (int i = 0; i < p->unknowns; i++) {
            trial[i] = y[i] + step[i] * gtm_scale[i];
            if (fabs(step[i]) > longest) longest = fabs(step[i]);
        }
        double gained = -1;
        if (!project_along_bounds(trial, p, lower, upper, in_cells ? &here : &open, is_free)) {
            const double new_violation = gtm_violation(p, trial, lower, upper);
            const double new_merit = value_of(p, objective, trial) + violation_price * new_violation;
            gained = (merit - new_merit) / promised;
            if (gained > 0.05) {
                memcpy(y, trial, sizeof trial);
                merit = new_merit;
                violation = new_violation;
                if (in_cells) gtm_update_cell(p, &here, y);
            }
        }
        if (gained < 0.25 && !in_cells) {
            in_cells = 1;
            here = gtm_cell_at(p, y, upper);
        } else if (gained < 0.25)
            radius = 0.3 * fmin(radius, longest);
        else if (gained > 0.7 && longest > 0.9 * radius)
            radius = fmin(2 * radius, largest_radius);
    }
    return violation;
}

/* A local optimum. */
typedef struct {
    double y[GTM_FULL_NT], value, violation;
} optimum;

static int is_better(const optimum *a, const optimum *b)
{
    const int a_inside = a->violation <= inside, b_inside = b->violation <= inside;
    if (a_inside != b_inside) return a_inside;
    return a_inside ? a->value < b->value : a->violation < b->violation;
}

static int same_place(const gtm_problem *p, const optimum *a, const optimum *b)
{
    for (int i = 0; i < p->unknowns; i++)
        if (fabs(a->y[i] - b->y[i]) > 1e-3 * gtm_scale[i]) return 0;
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
    int place = *count;
    while (place > 0 && is_better(found, kept + place - 1)) place--;
    if (place == most) return;
    if (*count < most) ++*count;
    memmove(kept + place + 1, kept + place, sizeof *kept * (size_t)(*count - 1 - place));
    kept[place] = *found;
}

int gtm_find_extreme(const gtm_problem *p, const double *lower, const double *upper, const double *objective, long n,
                     const double *starts, double *best, double *violation)
{
    enum { MOST_KEPT = 6 };
    double scaled[GTM_FULL_NT], largest = 0;
    optimum kept[MOST_KEPT], polished;
    const size_t row = (size_t)p->unknowns * sizeof *best;
    int count = 0, found = 0;
    for (int i = 0; i < p->unknowns; i++) largest = fmax(largest, fabs(objective[i]) * gtm_scale[i]);
    for (int i = 0; i < p->unknowns; i++) scaled[i] = objective[i] * gtm_scale[i] / largest;
    for (long k = 0; k < n; k++) {
        optimum o = {{0}, 0, 0};
        memcpy(o.y, starts + k * p->unknowns, row);
        o.violation = descend(p, lower, upper, scaled, rough, o.y);
        o.value = value_of(p, scaled, o.y);
        if (isfinite(o.violation)) keep(p, kept, &count, MOST_KEPT, &o);
    }
    for (int k = 0; k < count; k++) {
        optimum o = kept[k];
        o.violation = descend(p, lower, upper, scaled, fine, o.y);
        o.value = value_of(p, scaled, o.y);
        if (isfinite(o.violation) && (!found || is_better(&o, &polished))) polished = o, found = 1;
    }
    *violation = found ? polished.violation : INFINITY;
    if (!found) return GTM_NO_TRIM;
    memcpy(best, polished.y, row);
    return polished.violation <= inside ? GTM_TRIMMED : GTM_OUTSIDE;
}
