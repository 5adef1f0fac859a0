/* Steps in the tangent space of the manifold: x holds the null-space unknowns and, last, the largest violation left. */
#ifndef GTM_STEP_H
#define GTM_STEP_H

#include "solver/manifold.h"

enum { GTM_MOST_X = GTM_MOST_NULL + 1, GTM_MOST_ROWS = 4 * GTM_MOST_UNKNOWNS };

/* What is sought: the least of objective.(y / scale) under bounds; violations are charged at a high price. */
typedef struct {
    const gtm_problem *problem;
    const double *lower, *upper, *objective;
    int is_free[GTM_MOST_UNKNOWNS];
} gtm_search;

extern const double gtm_violation_price;

double gtm_value(const gtm_search *s, const double *y);

/* Linear model about a point: least price.x, A x <= b, -radius <= x <= radius, 0 <= violation <= violation now. */
typedef struct {
    int dimension, rows;
    double A[GTM_MOST_ROWS * GTM_MOST_X], b[GTM_MOST_ROWS], price[GTM_MOST_X], violation, radius;
    int unknown[GTM_MOST_ROWS];             /* that the row bounds, on this side: */
    double side[GTM_MOST_ROWS];             /* 1 above, -1 below; 0 where only the trust region does */
} gtm_linear_model;

void gtm_linear_model_at(const gtm_search *s, const double *y, const gtm_tangent *at_y, const gtm_cell *c,
                         double radius, gtm_linear_model *out);

/* Best x of the linear model; 1 when there is none. */
int gtm_linear_step(const gtm_linear_model *l, double *x);

/* Whether the trust region keeps x from going on. */
int gtm_is_cut_short(const gtm_linear_model *l, const double *x);

/* The step along the bounds that x reaches to the least of the quadratic model, as far as the other rows let it; the
   drop of the merit that it promises, negative when the model has no least. */
double gtm_quadratic_step(const gtm_search *s, const gtm_linear_model *l, const gtm_curvature *at_y, double *x);

#endif
