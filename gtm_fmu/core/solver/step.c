#include "solver/step.h"

#include <math.h>
#include <string.h>

#include "solver/linear_algebra.h"
#include "solver/linear_program.h"

const double gtm_violation_price = 1000;
static const double tight = 1e-9;

double gtm_value(const gtm_search *s, const double *y)
{
    double value = 0;
    for (int i = 0; i < s->problem->unknowns; i++) value += s->objective[i] * y[i] / s->problem->aircraft->scale[i];
    return value;
}

static void add_row(gtm_linear_model *l, int unknown, double side, double sign, const double *direction,
                    double violation, double room)
{
    const int m = l->dimension - 1;
    double *row = l->A + l->rows * l->dimension;
    for (int j = 0; j < m; j++) row[j] = sign * direction[j];
    row[m] = -violation;
    l->b[l->rows] = room;
    l->unknown[l->rows] = unknown;
    l->side[l->rows++] = side;
}

void gtm_linear_model_at(const gtm_search *s, const double *y, const gtm_tangent *at_y, const gtm_cell *c,
                         double radius, gtm_linear_model *l)
{
    const double *scale = s->problem->aircraft->scale;
    const int n = s->problem->unknowns, m = at_y->count;
    l->dimension = m + 1;
    l->rows = 0;
    l->radius = radius;
    l->violation = gtm_violation(s->problem, y, s->lower, s->upper);
    memset(l->price, 0, sizeof l->price);
    l->price[m] = gtm_violation_price;
    for (int i = 0; i < n; i++) {
        const double *direction = at_y->direction[i];
        for (int j = 0; j < m; j++) l->price[j] += s->objective[i] * direction[j];
        if (!s->is_free[i]) continue;
        const double bound[2] = {(s->upper[i] - y[i]) / scale[i], (y[i] - s->lower[i]) / scale[i]};
        const double border[2] = {(c->upper[i] - y[i]) / scale[i], (y[i] - c->lower[i]) / scale[i]};
        for (int k = 0; k < 2; k++) { /* the trust region and the cell hold for every unknown */
            const double sign = k ? -1 : 1, reach = fmax(border[k], 0);
            if (bound[k] < radius) add_row(l, i, sign, sign, direction, 1, bound[k]);
            add_row(l, i, reach < radius ? sign : 0, sign, direction, 0, fmin(radius, reach));
        }
    }
}

int gtm_linear_step(const gtm_linear_model *l, double *x)
{
    const int m = l->dimension - 1;
    double low[GTM_MOST_X], high[GTM_MOST_X];
    for (int j = 0; j < m; j++) {
        low[j] = -l->radius;
        high[j] = l->radius;
    }
    low[m] = 0;
    high[m] = l->violation;
    return gtm_linear_program(l->dimension, l->rows, l->A, l->b, l->price, low, high, x);
}

static double room_left(const gtm_linear_model *l, int row, const double *x)
{
    double room = l->b[row];
    for (int j = 0; j < l->dimension; j++) room -= l->A[row * l->dimension + j] * x[j];
    return room;
}

int gtm_is_cut_short(const gtm_linear_model *l, const double *x)
{
    for (int i = 0; i < l->rows; i++)
        if (l->side[i] == 0 && room_left(l, i, x) < tight * l->radius) return 1;
    return 0;
}

/* Rows that hold x, made independent: the affine space x = point + basis q on all of them. */
typedef struct {
    int rows, row[GTM_MOST_X];
    int freedom;
    double point[GTM_MOST_X], basis[GTM_MOST_X][GTM_MOST_X];
} face;

static void face_at(const gtm_linear_model *l, const double *x, face *f)
{
    const int d = l->dimension;
    double R[GTM_MOST_X][GTM_MOST_X + 1] = {{0}};
    int pivot[GTM_MOST_X], is_pivot[GTM_MOST_X] = {0};
    f->rows = 0;
    for (int i = -1; i < l->rows && f->rows < d; i++) {
        double *next = R[f->rows];
        if (i < 0) { /* no violation */
            if (x[d - 1] > tight) continue;
            memset(next, 0, sizeof R[0]);
            next[d - 1] = 1;
        } else {
            if (l->side[i] == 0 || room_left(l, i, x) > tight) continue;
            memcpy(next, l->A + i * d, (size_t)d * sizeof *next);
            next[d] = l->b[i];
        }
        for (int k = 0; k < f->rows; k++) {
            const double factor = next[pivot[k]];
            for (int j = 0; j <= d; j++) next[j] -= factor * R[k][j];
        }
        int e = -1;
        double largest = 1e-7;
        for (int j = 0; j < d; j++)
            if (!is_pivot[j] && fabs(next[j]) > largest) {
                largest = fabs(next[j]);
                e = j;
            }
        if (e < 0) continue;
        const double inverse = 1 / next[e];
        for (int j = 0; j <= d; j++) next[j] *= inverse;
        for (int k = 0; k < f->rows; k++) {
            const double factor = R[k][e];
            for (int j = 0; j <= d; j++) R[k][j] -= factor * next[j];
        }
        is_pivot[e] = 1;
        pivot[f->rows] = e;
        f->row[f->rows++] = i;
    }
    f->freedom = 0;
    memset(f->point, 0, sizeof f->point);
    memset(f->basis, 0, sizeof f->basis);
    for (int k = 0; k < f->rows; k++) f->point[pivot[k]] = R[k][d];
    for (int j = 0; j < d; j++) {
        if (is_pivot[j]) continue;
        f->basis[f->freedom][j] = 1;
        for (int k = 0; k < f->rows; k++) f->basis[f->freedom][pivot[k]] = -R[k][j];
        f->freedom++;
    }
}

/* Hessian of the Lagrangian, with the least-squares multipliers of the face's rows; 1 when they are none. */
static int hessian(const gtm_search *s, const gtm_linear_model *l, const gtm_curvature *at_y, const face *f,
                   double H[GTM_MOST_X][GTM_MOST_X])
{
    const int d = l->dimension, rows = f->rows;
    double normal[GTM_MOST_X * GTM_MOST_X], multiplier[GTM_MOST_X], row[GTM_MOST_X][GTM_MOST_X] = {{0}};
    double weight[GTM_MOST_UNKNOWNS] = {0};
    for (int k = 0; k < rows; k++) {
        if (f->row[k] < 0)
            row[k][d - 1] = 1;
        else
            memcpy(row[k], l->A + f->row[k] * d, (size_t)d * sizeof **row);
    }
    for (int k = 0; k < rows; k++) {
        multiplier[k] = 0;
        for (int j = 0; j < d; j++) multiplier[k] -= row[k][j] * l->price[j];
        for (int i = 0; i < rows; i++) {
            double sum = 0;
            for (int j = 0; j < d; j++) sum += row[k][j] * row[i][j];
            normal[k * rows + i] = sum;
        }
    }
    if (gtm_solve(rows, normal, multiplier)) return 1;
    for (int i = 0; i < s->problem->unknowns; i++) weight[i] = s->objective[i];
    for (int k = 0; k < rows; k++)
        if (f->row[k] >= 0) weight[l->unknown[f->row[k]]] += multiplier[k] * l->side[f->row[k]];
    memset(H, 0, sizeof(double) * GTM_MOST_X * GTM_MOST_X);
    for (int i = 0; i < s->problem->unknowns; i++)
        for (int j = 0; weight[i] != 0 && j < d - 1; j++)
            for (int k = 0; k < d - 1; k++) H[j][k] += weight[i] * at_y->of[i][j][k];
    return 0;
}

double gtm_quadratic_step(const gtm_search *s, const gtm_linear_model *l, const gtm_curvature *at_y, double *x)
{
    const int d = l->dimension;
    double H[GTM_MOST_X][GTM_MOST_X], reduced[GTM_MOST_X][GTM_MOST_X], slope[GTM_MOST_X], q[GTM_MOST_X];
    double move[GTM_MOST_X], now[GTM_MOST_X] = {0};
    face f;
    face_at(l, x, &f);
    if (!f.freedom || hessian(s, l, at_y, &f, H)) return -1;
    for (int j = 0; j < d; j++) {
        slope[j] = l->price[j];
        for (int k = 0; k < d; k++) slope[j] += H[j][k] * f.point[k];
    }
    for (int a = 0; a < f.freedom; a++) {
        q[a] = 0;
        for (int j = 0; j < d; j++) q[a] -= f.basis[a][j] * slope[j];
        for (int b = 0; b < f.freedom; b++) {
            reduced[a][b] = 0;
            for (int j = 0; j < d; j++)
                for (int k = 0; k < d; k++) reduced[a][b] += f.basis[a][j] * H[j][k] * f.basis[b][k];
        }
    }
    if (gtm_solve_definite(f.freedom, GTM_MOST_X, reduced[0], q)) return -1;
    now[d - 1] = l->violation;
    for (int j = 0; j < d; j++) {
        move[j] = f.point[j] - now[j];
        for (int a = 0; a < f.freedom; a++) move[j] += f.basis[a][j] * q[a];
    }
    double share = 1;
    for (int i = 0; i < l->rows; i++) {
        const double room = room_left(l, i, now), rate = l->b[i] - room_left(l, i, move);
        if (rate > tight && room < share * rate) share = fmax(room, 0) / rate;
    }
    double promised = 0;
    for (int j = 0; j < d; j++) {
        promised -= l->price[j] * share * move[j];
        for (int k = 0; k < d - 1 && j < d - 1; k++) promised -= 0.5 * share * share * move[j] * H[j][k] * move[k];
        x[j] = now[j] + share * move[j];
    }
    return share > 1e-3 ? promised : -1;
}
