/* The manifold of trims about a point: its tangent space, its curvature, and the way back to it. */
#ifndef GTM_MANIFOLD_H
#define GTM_MANIFOLD_H

#include "solver/cell.h"

enum { GTM_MOST_NULL = GTM_MOST_UNKNOWNS - GTM_NF };

/* Six unknowns follow from the others, those of the null space; all of it in scaled unknowns y / scale. */
typedef struct {
    int count;                                      /* dimension of the null space */
    int column[GTM_MOST_UNKNOWNS];                      /* the free unknowns: six that follow, then the null space */
    double slope[GTM_NF][GTM_MOST_UNKNOWNS];            /* of the scaled accelerations, a column for each of `column` */
    double direction[GTM_MOST_UNKNOWNS][GTM_MOST_NULL]; /* step for one unit of each null-space unknown */
} gtm_tangent;

/* Second derivatives of every unknown with respect to those of the null space. */
typedef struct {
    double of[GTM_MOST_UNKNOWNS][GTM_MOST_NULL][GTM_MOST_NULL];
} gtm_curvature;

/* Tangent space at y with the slopes of cell c; 1 when it has none. `J`: the Jacobian at y if it is known, else 0. */
int gtm_tangent_at(const double *y, const gtm_problem *p, const int *is_free, const gtm_cell *c, const double *J,
                   gtm_tangent *out);

/* y, at least `slack` (in scale units) inside the cell. */
void gtm_move_inside(const double *y, const gtm_problem *p, const gtm_cell *c, double slack, double *within);

/* Scaled step of the six unknowns that follow when the accelerations change by dF and the others stay; 1 when singular.
   Only these six of `step` are set. */
int gtm_follow(const gtm_tangent *at_y, const double dF[GTM_NF], double *step);

/* Curvature inside cell c; 1 when it has none. */
int gtm_curvature_at(const double *y, const gtm_problem *p, const gtm_cell *c, const gtm_tangent *at_y,
                     gtm_curvature *out);

/* Minimum-norm Newton back to largest |F| < enough in the unknowns of `movable` (at least six); 0 when it got there,
   with the Jacobian there in J. */
int gtm_project(double *y, const gtm_problem *p, const int *movable, double enough, double *J);

/* The same with the unknowns that reached a bound or the cell's border frozen there; with all of them if that leaves
   too few or fails. */
int gtm_project_along_bounds(double *y, const gtm_problem *p, const double *lower, const double *upper,
                             const gtm_cell *c, const int *is_free, double enough, double *J);

#endif
