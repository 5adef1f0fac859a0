/* Least of a linear objective on the trim manifold under bounds: trust-region sequential programming.

   At a point of the manifold six unknowns follow from the others (null space of the Jacobian); a linear program in the
   remaining two to four, plus one variable for the largest violation of the bounds, gives the step; Newton brings its
   end back to the manifold. The violation is charged at a high price, which also is the search for a feasible point.

   The tables are piecewise linear, and an optimum may lie on a breakpoint, where the slopes of one side mislead. Once a
   step disappoints, steps end at the border of the cell between breakpoints; a point on a border, with no gain left in
   its cell, looks into the cell beyond. Inside a cell the manifold is smooth: where the trust region alone limits a
   step, the linear program only tells which bounds matter, and a Newton step along these, with the manifold's
   curvature, goes to the least between them (sequential linear programming with equality steps, Byrd et al. 2004). */
#ifndef GTM_DESCENT_H
#define GTM_DESCENT_H

#include "solver/problem.h"

/* The point of least objective.y inside the bounds, the best of descents from n starts (rows of y); `best` is left
   alone where no start leads to the manifold. */
int gtm_find_extreme(const gtm_problem *p, const double *lower, const double *upper, const double *objective, long n,
                     const double *starts, double *best, double *violation);

/* The optimum next to y, by steps of about `stride` scale units, which is left in y. */
int gtm_move_extreme(const gtm_problem *p, const double *lower, const double *upper, const double *objective, double stride,
                     double *y, double *violation);

#endif
