/* How an end of an envelope moves with its bounds and with the flight condition.

   At the end y the linear program in the tangent space has the objective's multipliers as its dual: the change of its
   optimum is the derivative of the end. It has two sides: where a bound is just met, on a breakpoint of the tables or at
   a corner where more bounds meet than needed, a quantity that grows moves the end otherwise than one that shrinks. */
#ifndef GTM_END_SLOPES_H
#define GTM_END_SLOPES_H

#include "solver/problem.h"

/* Derivative of the objective's least value where a quantity shrinks and where it grows; NaN where no manoeuvre is left
   inside the bounds to first order. */
typedef struct {
    double below, above;
} gtm_sides;

typedef struct {
    gtm_sides lower[GTM_MOST_UNKNOWNS], upper[GTM_MOST_UNKNOWNS]; /* each bound by itself */
    gtm_sides held[GTM_MOST_UNKNOWNS];                            /* both together, where they are equal */
} gtm_bound_slopes;

/* Of the bounds about an end y, found by gtm_find_end under the same bounds. */
void gtm_slopes_of_bounds(const gtm_problem *p, const double *lower, const double *upper, const double *objective,
                          const double *y, gtm_bound_slopes *out);

/* Of something else; dF are the derivatives of the accelerations at y with respect to it, below and above where it is
   (NaN: it can not go there). */
gtm_sides gtm_slopes_of_condition(const gtm_problem *p, const double *lower, const double *upper,
                                  const double *objective, const double *y, double dF[2][GTM_NF]);

#endif
