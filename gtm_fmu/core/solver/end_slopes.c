#include "solver/end_slopes.h"

#include <math.h>
#include <string.h>

#include "solver/linear_program.h"
#include "solver/manifold.h"

static const double touching = 1e-6;    /* of a scale unit: an unknown this near to a bound is held by it */
static const double farthest = 1e3;     /* scaled units, for a change of size 1 */
enum { MOST_HELD = 3 * GTM_MOST_UNKNOWNS };

/* Change of the problem for one unit of a quantity: of the accelerations, and of the bounds. */
typedef struct {
    double dF[GTM_NF], lower[GTM_MOST_UNKNOWNS], upper[GTM_MOST_UNKNOWNS];
} change;

typedef struct {
    const gtm_problem *p;
    const double *lower, *upper, *objective, *y;
    int is_free[GTM_MOST_UNKNOWNS], at_lower[GTM_MOST_UNKNOWNS], at_upper[GTM_MOST_UNKNOWNS];
    int kinks, kink[GTM_KINKED]; /* unknowns on a breakpoint */
} end;

static end end_at(const gtm_problem *p, const double *lower, const double *upper, const double *objective,
                  const double *y)
{
    end e = {.p = p, .lower = lower, .upper = upper, .objective = objective, .y = y};
    unsigned char is_on[GTM_MOST_UNKNOWNS];
    gtm_find_breakpoints(p, y, is_on);
    for (int i = 0; i < p->unknowns; i++) {
        const double slack = touching * p->aircraft->scale[i];
        e.is_free[i] = lower[i] < upper[i];
        e.at_lower[i] = y[i] <= lower[i] + slack;
        e.at_upper[i] = y[i] >= upper[i] - slack;
    }
    for (int k = 0; k < GTM_KINKED; k++)
        if (is_on[p->aircraft->kinked[k]]) e.kink[e.kinks++] = p->aircraft->kinked[k];
    return e;
}

/* Rows row.x <= room of the tangent space, `rows` of them, and what holds the end at first order. */
typedef struct {
    int m, rows;
    double A[MOST_HELD * GTM_MOST_NULL], b[MOST_HELD];
} held_rows;

static void hold(held_rows *h, double sign, const double *direction, double room)
{
    for (int j = 0; j < h->m; j++) h->A[h->rows * h->m + j] = sign * direction[j];
    h->b[h->rows++] = room;
}

/* The part of the price that the rows carry. At an optimum it is all of it; where the optimum is one of curvature, the
   search leaves a remainder. */
static void carried(const held_rows *h, double *price)
{
    double base[GTM_MOST_NULL][GTM_MOST_NULL], kept[GTM_MOST_NULL] = {0};
    int n = 0;
    for (int k = 0; k < h->rows && n < h->m; k++) {
        double *next = base[n], before = 0, left = 0;
        for (int j = 0; j < h->m; j++) {
            next[j] = h->A[k * h->m + j];
            before += next[j] * next[j];
        }
        for (int pass = 0; pass < 2; pass++)
            for (int i = 0; i < n; i++) {
                double dot = 0;
                for (int j = 0; j < h->m; j++) dot += next[j] * base[i][j];
                for (int j = 0; j < h->m; j++) next[j] -= dot * base[i][j];
            }
        for (int j = 0; j < h->m; j++) left += next[j] * next[j];
        if (!(left > 1e-12 * before)) continue;
        double along = 0;
        for (int j = 0; j < h->m; j++) {
            next[j] /= sqrt(left);
            along += next[j] * price[j];
        }
        for (int j = 0; j < h->m; j++) kept[j] += along * next[j];
        n++;
    }
    memcpy(price, kept, sizeof *price * (size_t)h->m);
}

/* The least change of the objective inside one cell, for the change of the problem; not finite without one. */
static double least_in_cell(const end *e, const gtm_cell *c, const int *above, const change *d)
{
    const gtm_problem *p = e->p;
    const double *scale = p->aircraft->scale;
    double within[GTM_MOST_UNKNOWNS] = {0}, F[GTM_NF], J[GTM_NF * GTM_MOST_UNKNOWNS], rate[GTM_NF];
    double step[GTM_MOST_UNKNOWNS] = {0}, price[GTM_MOST_NULL] = {0}, value = 0;
    gtm_tangent t;
    gtm_move_inside(e->y, p, c, gtm_border, within);
    p->aircraft->jacobian(p, within, F, J);
    if (gtm_tangent_at(within, p, e->is_free, c, J, &t)) return NAN;
    memcpy(rate, d->dF, sizeof rate);
    for (int i = 0; i < p->unknowns; i++) {
        if (e->is_free[i]) continue;
        step[i] = d->lower[i] / scale[i];
        for (int k = 0; k < GTM_NF; k++) rate[k] += J[k * p->unknowns + i] * d->lower[i];
    }
    if (gtm_follow(&t, rate, step)) return NAN;
    held_rows h = {.m = t.count};
    for (int i = 0; i < p->unknowns; i++) {
        if (!e->is_free[i]) continue;
        if (e->at_upper[i]) hold(&h, 1, t.direction[i], d->upper[i] / scale[i] - step[i]);
        if (e->at_lower[i]) hold(&h, -1, t.direction[i], step[i] - d->lower[i] / scale[i]);
    }
    for (int k = 0; k < e->kinks; k++) {
        const int i = e->kink[k];
        const double sign = above[k] ? -1 : 1;
        if (e->is_free[i])
            hold(&h, sign, t.direction[i], -sign * step[i]);
        else if (sign * step[i] > 0)
            return NAN;
    }
    for (int i = 0; i < p->unknowns; i++) {
        value += e->objective[i] * scale[i] * step[i];
        for (int j = 0; j < t.count; j++) price[j] += e->objective[i] * scale[i] * t.direction[i][j];
    }
    carried(&h, price);
    if (t.count) {
        double low[GTM_MOST_NULL], high[GTM_MOST_NULL], x[GTM_MOST_NULL];
        for (int j = 0; j < t.count; j++) {
            low[j] = -farthest;
            high[j] = farthest;
        }
        if (gtm_linear_program(t.count, h.rows, h.A, h.b, price, low, high, x)) return NAN;
        for (int j = 0; j < t.count; j++) value += price[j] * x[j];
    }
    return value;
}

/* The change made one of size 1, in scaled units; its size. */
static double resize(const gtm_problem *p, change *d)
{
    double size = 0;
    for (int k = 0; k < GTM_NF; k++) size = fmax(size, fabs(d->dF[k]));
    for (int i = 0; i < p->unknowns; i++)
        size = fmax(size, fmax(fabs(d->lower[i]), fabs(d->upper[i])) / p->aircraft->scale[i]);
    if (!(size > 0)) return 0;
    for (int k = 0; k < GTM_NF; k++) d->dF[k] /= size;
    for (int i = 0; i < p->unknowns; i++) {
        d->lower[i] /= size;
        d->upper[i] /= size;
    }
    return size;
}

/* The least over all cells that meet at y. */
static double least_change(const end *e, change whole)
{
    change *const d = &whole;
    const double size = resize(e->p, d);
    double least = NAN;
    if (size == 0) return 0;
    for (unsigned cells = 0; cells < 1u << e->kinks; cells++) {
        gtm_cell c = gtm_cell_at(e->p, e->y, e->upper);
        int above[GTM_KINKED];
        for (int k = 0; k < e->kinks; k++) {
            above[k] = cells >> k & 1;
            c = gtm_cell_beyond(e->p, &c, e->kink[k], e->y[e->kink[k]], above[k]);
        }
        least = fmin(least, least_in_cell(e, &c, above, d)); /* fmin passes over NaN */
    }
    return size * least;
}

static gtm_sides both_sides(const end *e, const change *d)
{
    change reverse;
    for (int k = 0; k < GTM_NF; k++) reverse.dF[k] = -d->dF[k];
    for (int i = 0; i < GTM_MOST_UNKNOWNS; i++) {
        reverse.lower[i] = -d->lower[i];
        reverse.upper[i] = -d->upper[i];
    }
    return (gtm_sides){-least_change(e, reverse), least_change(e, *d)};
}

gtm_sides gtm_slopes_of_condition(const gtm_problem *p, const double *lower, const double *upper,
                                  const double *objective, const double *y, double dF[2][GTM_NF])
{
    const end e = end_at(p, lower, upper, objective, y);
    double slope[2];
    for (int side = 0; side < 2; side++) {
        const double sign = side ? 1 : -1;
        change d = {{0}, {0}, {0}};
        for (int k = 0; k < GTM_NF; k++) d.dF[k] = sign * dF[side][k];
        slope[side] = isfinite(dF[side][0]) ? sign * least_change(&e, d) : NAN;
    }
    return (gtm_sides){slope[0], slope[1]};
}

void gtm_slopes_of_bounds(const gtm_problem *p, const double *lower, const double *upper, const double *objective,
                          const double *y, gtm_bound_slopes *out)
{
    const end e = end_at(p, lower, upper, objective, y);
    memset(out, 0, sizeof *out);
    for (int i = 0; i < p->unknowns; i++) {
        if (!e.at_lower[i] && !e.at_upper[i]) continue;
        end apart = e; /* equal bounds that can part */
        apart.is_free[i] = 1;
        change d = {{0}, {0}, {0}};
        d.lower[i] = 1;
        if (e.at_lower[i]) out->lower[i] = both_sides(&apart, &d);
        d.lower[i] = 0;
        d.upper[i] = 1;
        if (e.at_upper[i]) out->upper[i] = both_sides(&apart, &d);
        d.lower[i] = 1;
        if (!e.is_free[i]) out->held[i] = both_sides(&e, &d);
    }
}
