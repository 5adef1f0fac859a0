#include "solver/cell.h"

#include <math.h>
#include <string.h>

const double gtm_border = 1e-9;

static void set_interval(const gtm_problem *p, gtm_cell *c, int unknown, double value, int above)
{
    gtm_interval i = {value, gtm_border * p->aircraft->scale[unknown], -INFINITY, INFINITY, above};
    p->aircraft->cut(p, unknown, &i);
    c->lower[unknown] = i.lower;
    c->upper[unknown] = i.upper;
}

gtm_cell gtm_open_cell(void)
{
    gtm_cell c;
    for (int i = 0; i < GTM_MOST_UNKNOWNS; i++) {
        c.lower[i] = -INFINITY;
        c.upper[i] = INFINITY;
    }
    return c;
}

gtm_cell gtm_cell_at(const gtm_problem *p, const double *y, const double *upper)
{
    gtm_cell c = gtm_open_cell();
    for (int k = 0; k < GTM_KINKED; k++) {
        const int i = p->aircraft->kinked[k];
        set_interval(p, &c, i, y[i], y[i] < upper[i]);
    }
    return c;
}

gtm_cell gtm_cell_beyond(const gtm_problem *p, const gtm_cell *c, int unknown, double value, int above)
{
    gtm_cell beyond = *c;
    set_interval(p, &beyond, unknown, value, above);
    return beyond;
}

void gtm_update_cell(const gtm_problem *p, gtm_cell *c, const double *y)
{
    for (int k = 0; k < GTM_KINKED; k++) {
        const int i = p->aircraft->kinked[k];
        const double slack = gtm_border * p->aircraft->scale[i];
        if (y[i] < c->lower[i] - slack || y[i] > c->upper[i] + slack) set_interval(p, c, i, y[i], y[i] > c->upper[i]);
    }
}

void gtm_find_breakpoints(const gtm_problem *p, const double *y, unsigned char *is_on)
{
    memset(is_on, 0, (size_t)p->unknowns);
    for (int k = 0; k < GTM_KINKED; k++) {
        const int i = p->aircraft->kinked[k];
        gtm_cell above;
        set_interval(p, &above, i, y[i], 1);
        is_on[i] = above.lower[i] >= y[i] - gtm_border * p->aircraft->scale[i];
    }
}
