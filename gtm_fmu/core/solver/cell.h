/* Cells between the breakpoints of the aircraft's tables. */
#ifndef GTM_CELL_H
#define GTM_CELL_H

#include "solver/problem.h"

/* Where slopes hold: the interval of each unknown between breakpoints, and no limits for those without. */
typedef struct {
    double lower[GTM_MOST_UNKNOWNS], upper[GTM_MOST_UNKNOWNS];
} gtm_cell;

extern const double gtm_border; /* of a scale unit: this near to a breakpoint is on it */

/* The cell without breakpoints, and that of y: on a breakpoint it lies below if y is at its upper bound, else above. */
gtm_cell gtm_open_cell(void);
gtm_cell gtm_cell_at(const gtm_problem *p, const double *y, const double *upper);

/* The cell on the given side of the breakpoint that an unknown lies on. */
gtm_cell gtm_cell_beyond(const gtm_problem *p, const gtm_cell *c, int unknown, double value, int above);

/* Follow y to its cell; an unknown on the border of its old interval stays there. */
void gtm_update_cell(const gtm_problem *p, gtm_cell *c, const double *y);

/* Which unknowns of y lie on a breakpoint. */
void gtm_find_breakpoints(const gtm_problem *p, const double *y, unsigned char *is_on);

#endif
