#include "solver/manifold.h"

#include <math.h>
#include <string.h>

#include "solver/linear_algebra.h"

/* Row scale of the residual: g and 1 rad/s^2 weigh alike in pivoting. */
static const double row_scale[GTM_NF] = {0.03, 0.03, 0.03, 1, 1, 1};

void gtm_move_inside(const double *y, const gtm_problem *p, const gtm_cell *c, double slack, double *within)
{
    for (int i = 0; i < p->unknowns; i++) {
        const double room = slack * p->aircraft->scale[i];
        within[i] = fmin(fmax(y[i], c->lower[i] + room), c->upper[i] - room);
    }
}

/* Scaled slopes of the accelerations, columns in the given order. */
static void order_slopes(const gtm_problem *p, const double *J, int count, const int *column,
                         double slope[GTM_NF][GTM_MOST_UNKNOWNS])
{
    for (int i = 0; i < GTM_NF; i++)
        for (int k = 0; k < count; k++)
            slope[i][k] = J[i * p->unknowns + column[k]] * p->aircraft->scale[column[k]] * row_scale[i];
}

/* Gauss-Jordan elimination of A with complete pivoting: the six columns that follow come first, then the others, with
   their share of each. `column` is put in this order, too; 1 when A is singular. */
static int reduce(int columns, double A[GTM_NF][GTM_MOST_UNKNOWNS], int *column)
{
    for (int s = 0; s < GTM_NF; s++) {
        int row = s, col = s;
        for (int i = s; i < GTM_NF; i++)
            for (int k = s; k < columns; k++)
                if (fabs(A[i][k]) > fabs(A[row][col])) {
                    row = i;
                    col = k;
                }
        if (!(fabs(A[row][col]) > 1e-10)) return 1;
        for (int k = 0; k < columns; k++) {
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
        for (int k = s; k < columns; k++) A[s][k] *= inverse;
        for (int i = 0; i < GTM_NF; i++) {
            if (i == s) continue;
            const double factor = A[i][s];
            for (int k = s; k < columns; k++) A[i][k] -= factor * A[s][k];
        }
    }
    return 0;
}

int gtm_tangent_at(const double *y, const gtm_problem *p, const int *is_free, const gtm_cell *c, const double *J,
                   gtm_tangent *out)
{
    double F[GTM_NF], J_within[GTM_NF * GTM_MOST_UNKNOWNS], A[GTM_NF][GTM_MOST_UNKNOWNS];
    double within[GTM_MOST_UNKNOWNS] = {0};
    const int n = p->unknowns;
    int *column = out->column, free_count = 0;
    gtm_move_inside(y, p, c, gtm_border, within);
    if (!J || memcmp(within, y, sizeof *y * (size_t)n)) {
        p->aircraft->jacobian(p, within, F, J_within);
        J = J_within;
    }
    for (int i = 0; i < n; i++)
        if (is_free[i]) column[free_count++] = i;
    order_slopes(p, J, free_count, column, A);
    if (reduce(free_count, A, column)) return 1;
    order_slopes(p, J, free_count, column, out->slope);
    memset(out->direction, 0, sizeof out->direction);
    out->count = free_count - GTM_NF;
    for (int s = 0; s < GTM_NF; s++)
        for (int j = 0; j < out->count; j++) out->direction[column[s]][j] = -A[s][GTM_NF + j];
    for (int j = 0; j < out->count; j++) out->direction[column[GTM_NF + j]][j] = 1;
    return 0;
}

int gtm_follow(const gtm_tangent *at_y, const double dF[GTM_NF], double *step)
{
    double A[GTM_NF * GTM_NF], by[GTM_NF];
    for (int i = 0; i < GTM_NF; i++) {
        memcpy(A + i * GTM_NF, at_y->slope[i], GTM_NF * sizeof *A);
        by[i] = -dF[i] * row_scale[i];
    }
    if (gtm_solve(GTM_NF, A, by)) return 1;
    for (int s = 0; s < GTM_NF; s++) step[at_y->column[s]] = by[s];
    return 0;
}

/* F(y(z)) = 0 differentiated twice: the six that follow have J_B y'' = -(dJ/dz_j) dy/dz_k, by differences of J. */
int gtm_curvature_at(const double *y, const gtm_problem *p, const gtm_cell *c, const gtm_tangent *at_y,
                     gtm_curvature *out)
{
    static const double reach = 1e-5; /* of a scale unit */
    const int m = at_y->count, free_count = GTM_NF + m;
    double F[GTM_NF], J[GTM_NF * GTM_MOST_UNKNOWNS], base[GTM_MOST_UNKNOWNS] = {0}, there[GTM_MOST_UNKNOWNS];
    double slope[GTM_NF][GTM_MOST_UNKNOWNS], moved[GTM_NF][GTM_MOST_UNKNOWNS];
    memset(out, 0, sizeof *out);
    gtm_move_inside(y, p, c, 2 * reach, base);
    if (memcmp(base, y, sizeof *y * (size_t)p->unknowns)) {
        p->aircraft->jacobian(p, base, F, J);
        order_slopes(p, J, free_count, at_y->column, slope);
    } else {
        memcpy(slope, at_y->slope, sizeof slope);
    }
    for (int j = 0; j < m; j++) {
        double longest = 0;
        for (int i = 0; i < p->unknowns; i++) longest = fmax(longest, fabs(at_y->direction[i][j]));
        const double step = reach / longest;
        for (int i = 0; i < p->unknowns; i++) there[i] = base[i] + step * at_y->direction[i][j] * p->aircraft->scale[i];
        p->aircraft->jacobian(p, there, F, J);
        order_slopes(p, J, free_count, at_y->column, moved);
        for (int k = 0; k <= j; k++) {
            double A[GTM_NF * GTM_NF], second[GTM_NF];
            for (int i = 0; i < GTM_NF; i++) {
                second[i] = 0;
                for (int s = 0; s < free_count; s++)
                    second[i] -= (moved[i][s] - slope[i][s]) / step * at_y->direction[at_y->column[s]][k];
                memcpy(A + i * GTM_NF, at_y->slope[i], GTM_NF * sizeof *A);
            }
            if (gtm_solve(GTM_NF, A, second)) return 1;
            for (int s = 0; s < GTM_NF; s++)
                out->of[at_y->column[s]][j][k] = out->of[at_y->column[s]][k][j] = second[s];
        }
    }
    return 0;
}

int gtm_project(double *y, const gtm_problem *p, const int *movable, double enough, double *J)
{
    const int n = p->unknowns;
    double before = INFINITY;
    for (int iteration = 0; iteration < 10; iteration++) {
        double F[GTM_NF], S[GTM_NF][GTM_MOST_UNKNOWNS], A[GTM_NF * GTM_NF];
        p->aircraft->jacobian(p, y, F, J);
        const double norm = gtm_residual_norm(F);
        if (!isfinite(norm)) return 1;
        if (norm < enough) return 0;
        if (iteration > 3 && norm > 0.5 * before) return norm < 1e-9 ? 0 : 1;
        before = norm;
        for (int i = 0; i < GTM_NF; i++) {
            for (int k = 0; k < n; k++) S[i][k] = movable[k] ? J[i * n + k] * p->aircraft->scale[k] * row_scale[i] : 0;
            F[i] *= row_scale[i];
        }
        for (int i = 0; i < GTM_NF; i++)
            for (int j = 0; j <= i; j++) {
                double sum = 0;
                for (int k = 0; k < n; k++) sum += S[i][k] * S[j][k];
                A[i * GTM_NF + j] = A[j * GTM_NF + i] = sum;
            }
        if (gtm_solve(GTM_NF, A, F)) return 1;
        for (int k = 0; k < n; k++) {
            double step = 0;
            for (int i = 0; i < GTM_NF; i++) step += S[i][k] * F[i];
            if (!(fabs(step) < 10)) return 1;
            y[k] -= step * p->aircraft->scale[k];
        }
        if (!(y[V] > 1)) return 1;
    }
    return before < 1e-9 ? 0 : 1;
}

int gtm_project_along_bounds(double *y, const gtm_problem *p, const double *lower, const double *upper,
                             const gtm_cell *c, const int *is_free, double enough, double *J)
{
    int movable[GTM_MOST_UNKNOWNS], count = 0;
    double frozen[GTM_MOST_UNKNOWNS];
    memcpy(frozen, y, sizeof frozen);
    for (int i = 0; i < p->unknowns; i++) {
        const double slack = gtm_border * p->aircraft->scale[i];
        movable[i] = is_free[i] && fabs(y[i] - lower[i]) > slack && fabs(y[i] - upper[i]) > slack &&
                     fabs(y[i] - c->lower[i]) > slack && fabs(y[i] - c->upper[i]) > slack;
        count += movable[i];
    }
    if (count >= GTM_NF && !gtm_project(frozen, p, movable, enough, J)) {
        memcpy(y, frozen, sizeof frozen);
        return 0;
    }
    return gtm_project(y, p, is_free, enough, J);
}
