/* Least of a linear objective on the trim manifold under bounds: trust-region sequential linear programming.

   At a point of the manifold six unknowns follow from the others (null space of the Jacobian); a linear program in the
   remaining two or three, plus one variable for the largest violation of the bounds, gives the step; Newton brings its
   end back to the manifold. The violation is charged at a high price, which also is the search for a feasible point. */
#include <math.h>
#include <string.h>

#include "solver.h"

static const double violation_price = 1000, inside = 1e-7;
static const double first_radius = 0.5, least_radius = 1e-8, largest_radius = 4;
enum { MOST_STEPS = 80, MOST_FREE = 9, MOST_NULL = 3 };

/* Row scale of the residual: g and 1 rad/s^2 weigh alike in pivoting. */
static const double row_scale[GTM_NF] = {0.03, 0.03, 0.03, 1, 1, 1};

typedef struct {
    int count;                            /* dimension of the null space */
    double newton[GTM_NT];                /* scaled step to F = 0 with the null-space unknowns kept */
    double direction[GTM_NT][MOST_NULL];  /* scaled step for one unit of each null-space unknown */
} tangent;

/* Tangent space at y: eliminate six free unknowns with complete pivoting. */
static int tangent_at(const double *y, const gtm_condition *at, const int *is_free, tangent *out)
{
    double F[GTM_NF], J[GTM_NF * GTM_NT], A[GTM_NF][GTM_NT + 1];
    int column[GTM_NT], free_count = 0;
    gtm_trim_jacobian(y, at, F, J);
    for (int i = 0; i < GTM_NT; i++)
        if (is_free[i]) column[free_count++] = i;
    for (int i = 0; i < GTM_NF; i++) {
        for (int k = 0; k < free_count; k++) A[i][k] = J[i * GTM_NT + column[k]] * gtm_scale[column[k]] * row_scale[i];
        A[i][free_count] = -F[i] * row_scale[i];
    }
    for (int s = 0; s < GTM_NF; s++) {
        int row = s, col = s;
        for (int i = s; i < GTM_NF; i++)
            for (int k = s; k < free_count; k++)
                if (fabs(A[i][k]) > fabs(A[row][col])) row = i, col = k;
        if (!(fabs(A[row][col]) > 1e-10)) return 1;
        for (int k = 0; k <= free_count; k++) {
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
        for (int k = s; k <= free_count; k++) A[s][k] *= inverse;
        for (int i = 0; i < GTM_NF; i++) {
            if (i == s) continue;
            const double factor = A[i][s];
            for (int k = s; k <= free_count; k++) A[i][k] -= factor * A[s][k];
        }
    }
    memset(out, 0, sizeof *out);
    out->count = free_count - GTM_NF;
    for (int s = 0; s < GTM_NF; s++) {
        out->newton[column[s]] = A[s][free_count];
        for (int j = 0; j < out->count; j++) out->direction[column[s]][j] = -A[s][GTM_NF + j];
    }
    for (int j = 0; j < out->count; j++) out->direction[column[GTM_NF + j]][j] = 1;
    return 0;
}

/* Minimum-norm Newton back to F = 0 in the unknowns of `movable` (at least six). */
static int project(double *y, const gtm_condition *at, const int *movable)
{
    double before = INFINITY;
    for (int iteration = 0; iteration < 10; iteration++) {
        double F[GTM_NF], J[GTM_NF * GTM_NT], A[GTM_NF * GTM_NF];
        gtm_trim_jacobian(y, at, F, J);
        const double norm = gtm_residual_norm(F);
        if (!isfinite(norm)) return 1;
        if (norm < 1e-11) return 0;
        if (iteration > 3 && norm > 0.5 * before) return norm < 1e-9 ? 0 : 1;
        before = norm;
        for (int i = 0; i < GTM_NF; i++)
            for (int k = 0; k < GTM_NT; k++) J[i * GTM_NT + k] *= movable[k] ? gtm_scale[k] * row_scale[i] : 0;
        for (int i = 0; i < GTM_NF; i++) {
            F[i] *= row_scale[i];
            for (int j = 0; j < GTM_NF; j++) {
                double sum = 0;
                for (int k = 0; k < GTM_NT; k++) sum += J[i * GTM_NT + k] * J[j * GTM_NT + k];
                A[i * GTM_NF + j] = sum;
            }
        }
        if (gtm_solve(GTM_NF, A, F)) return 1;
        for (int k = 0; k < GTM_NT; k++) {
            double step = 0;
            for (int i = 0; i < GTM_NF; i++) step += J[i * GTM_NT + k] * F[i];
            if (!(fabs(step) < 10)) return 1;
            y[k] -= step * gtm_scale[k];
        }
        if (!(y[0] > 1)) return 1;
    }
    return before < 1e-9 ? 0 : 1;
}

/* Project with the unknowns that reached a bound frozen there; with all of them if that leaves too few or fails. */
static int project_along_bounds(double *y, const gtm_condition *at, const double *lower, const double *upper,
                                const int *is_free)
{
    int movable[GTM_NT], count = 0;
    double frozen[GTM_NT];
    memcpy(frozen, y, sizeof frozen);
    for (int i = 0; i < GTM_NT; i++) {
        const double slack = 1e-9 * gtm_scale[i];
        movable[i] = is_free[i] && fabs(y[i] - lower[i]) > slack && fabs(y[i] - upper[i]) > slack;
        count += movable[i];
    }
    if (count >= GTM_NF && !project(frozen, at, movable)) {
        memcpy(y, frozen, sizeof frozen);
        return 0;
    }
    return project(y, at, is_free);
}

/* Linear program in the tangent space: step of y/scale and the violation it leaves. */
static int linear_step(const double *y, const double *lower, const double *upper, const double *objective,
                       const int *is_free, const tangent *at_y, double radius, double *step, double *left_over)
{
    const int n = at_y->count, d = n + 1;
    double A[4 * MOST_FREE * (MOST_NULL + 1)], b[4 * MOST_FREE], c[MOST_NULL + 1] = {0};
    double low[MOST_NULL + 1], high[MOST_NULL + 1], x[MOST_NULL + 1], violation = 0;
    int rows = 0;
    for (int i = 0; i < GTM_NT; i++) {
        for (int j = 0; j < n; j++) c[j] += objective[i] * at_y->direction[i][j];
        if (!is_free[i]) continue;
        const double room[2] = {(upper[i] - y[i]) / gtm_scale[i] - at_y->newton[i],
                                (y[i] - lower[i]) / gtm_scale[i] + at_y->newton[i]};
        for (int side = 0; side < 2; side++) {
            const double sign = side ? -1 : 1;
            for (int j = 0; j < n; j++) A[rows * d + j] = sign * at_y->direction[i][j];
            A[rows * d + n] = -1;
            b[rows++] = room[side];
            if (-room[side] > violation) violation = -room[side];
        }
    }
    const int bound_rows = rows;
    for (int i = 0; i < bound_rows; i++, rows++) { /* the trust region holds for every unknown */
        memcpy(A + rows * d, A + i * d, n * sizeof *A);
        A[rows * d + n] = 0;
        b[rows] = radius;
    }
    for (int j = 0; j < n; j++) low[j] = -radius, high[j] = radius;
    c[n] = violation_price;
    low[n] = 0;
    high[n] = violation;
    if (gtm_linear_program(d, rows, A, b, c, low, high, x)) return 1;
    for (int i = 0; i < GTM_NT; i++) {
        step[i] = at_y->newton[i];
        for (int j = 0; j < n; j++) step[i] += at_y->direction[i][j] * x[j];
    }
    *left_over = x[n];
    return 0;
}

static double value_of(const double *objective, const double *y)
{
    double value = 0;
    for (int i = 0; i < GTM_NT; i++) value += objective[i] * y[i] / gtm_scale[i];
    return value;
}

/* One start; objective in scaled units. y ends at a local optimum; its violation is returned (infinite: no trim). */
static double descend(const gtm_condition *at, const double *lower, const double *upper, const double *objective,
                      double *y)
{
    int is_free[GTM_NT];
    for (int i = 0; i < GTM_NT; i++) {
        is_free[i] = lower[i] != upper[i];
        if (!is_free[i]) y[i] = lower[i];
    }
    if (project(y, at, is_free)) return INFINITY;
    double radius = first_radius, violation = gtm_violation(y, lower, upper);
    double merit = value_of(objective, y) + violation_price * violation;
    tangent at_y;
    int stale = 1;
    for (int k = 0; k < MOST_STEPS && radius > least_radius; k++) {
        double step[GTM_NT], left_over, trial[GTM_NT];
        if (stale && tangent_at(y, at, is_free, &at_y)) return violation;
        stale = 0;
        if (linear_step(y, lower, upper, objective, is_free, &at_y, radius, step, &left_over)) return violation;
        double promised = merit - violation_price * left_over, longest = 0;
        for (int i = 0; i < GTM_NT; i++) {
            trial[i] = y[i] + step[i] * gtm_scale[i];
            if (fabs(step[i]) > longest) longest = fabs(step[i]);
        }
        promised -= value_of(objective, trial);
        if (promised < 1e-10) break;
        double gained = -1, new_violation = 0, new_merit = 0;
        if (!project_along_bounds(trial, at, lower, upper, is_free)) {
            new_violation = gtm_violation(trial, lower, upper);
            new_merit = value_of(objective, trial) + violation_price * new_violation;
            gained = (merit - new_merit) / promised;
        }
        if (gained > 0.05) {
            memcpy(y, trial, sizeof trial);
            merit = new_merit;
            violation = new_violation;
            stale = 1;
        }
        if (gained < 0.25)
            radius = 0.3 * fmin(radius, longest);
        else if (gained > 0.7 && longest > 0.9 * radius)
            radius = fmin(2 * radius, largest_radius);
    }
    return violation;
}

int gtm_extreme(double altitude, double gamma, const double lower[GTM_NT], const double upper[GTM_NT],
                const double objective[GTM_NT], long n, const double *starts, double best[GTM_NT], double *violation)
{
    const gtm_condition at = gtm_condition_at(altitude, gamma);
    double scaled[GTM_NT], largest = 0, best_value = INFINITY;
    for (int i = 0; i < GTM_NT; i++) largest = fmax(largest, fabs(objective[i]) * gtm_scale[i]);
    for (int i = 0; i < GTM_NT; i++) scaled[i] = objective[i] * gtm_scale[i] / largest;
    *violation = INFINITY;
    for (long k = 0; k < n; k++) {
        double y[GTM_NT];
        memcpy(y, starts + k * GTM_NT, sizeof y);
        const double excess = descend(&at, lower, upper, scaled, y), value = value_of(scaled, y);
        const int feasible = excess <= inside, best_feasible = *violation <= inside;
        if (feasible ? !best_feasible || value < best_value : excess < *violation) {
            memcpy(best, y, sizeof y);
            best_value = value;
            *violation = excess;
        }
    }
    return *violation <= inside ? GTM_TRIMMED : isfinite(*violation) ? GTM_OUTSIDE : GTM_NO_TRIM;
}
