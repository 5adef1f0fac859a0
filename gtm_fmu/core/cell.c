/* Cells between the breakpoints of the tables. Outside the study's configuration more tables have a say, and the union of
   their breakpoints bounds the cells: a border without a kink does no harm. */
#include <math.h>
#include <string.h>

#include "full_table.h"
#include "solver.h"

const int gtm_kinked[GTM_KINKED] = {ALPHA, BETA, PSI_DOT, ELEVATOR, AILERON, RUDDER};
const double gtm_border = 1e-9;

static const double degree = 0.017453292519943295;

/* Interval of one unknown that holds `value`, or on a breakpoint the one on the given side of it. */
typedef struct {
    double value, slack, lower, upper;
    int above;
} interval;

static inline void cut(interval *i, double point)
{
    if (i->above ? point <= i->value + i->slack : point < i->value - i->slack) {
        if (point > i->lower) i->lower = point;
    } else if (point < i->upper) {
        i->upper = point;
    }
}

/* The end intervals of a table extrapolate, so its ends cut only where it is clipped. */
static inline void cut_at_axis(interval *i, const gtm_axis *axis, int is_clipped, double unit)
{
    for (int k = !is_clipped; k < axis->points - !is_clipped; k++) cut(i, axis->point[k] * unit);
}

/* Breakpoints in terms of the command: deflection = gain * command + offset. */
static void cut_at_surface(interval *i, const gtm_axis *axis, double gain, double offset)
{
    for (int k = 1; gain != 0 && k < axis->points - 1; k++) cut(i, (axis->point[k] - offset) / gain);
}

static void cut_by_study(interval *i, int unknown)
{
    switch (unknown) {
    case ALPHA: cut_at_axis(i, &gtm_alpha_axis, 0, degree); break;
    case BETA: cut_at_axis(i, &gtm_beta_axis, 0, degree); break;
    case PSI_DOT: cut(i, 0); break; /* all rates are zero together there, where every rate table has a breakpoint */
    case ELEVATOR: cut_at_axis(i, &gtm_elevator_axis, 0, 1); break;
    case AILERON: cut_at_axis(i, &gtm_aileron_axis, 0, 1); break;
    default: cut_at_axis(i, &gtm_rudder_axis, 0, 1);
    }
}

static void cut_by_configuration(interval *i, const gtm_configuration *c, int unknown)
{
    if (unknown <= PSI_DOT) cut_by_study(i, unknown);
    if (unknown == ALPHA && c->damage_case) {
        cut_at_axis(i, &gtm_damage_alpha_axis, 1, degree);
        for (int k = 0; k < GTM_RATES; k++) {
            cut(i, gtm_rate_alpha[k].lowest * degree);
            cut(i, gtm_rate_alpha[k].highest * degree);
        }
    }
    if (unknown == ALPHA && c->has_stall_asymmetry) cut_at_axis(i, &gtm_stall_alpha_axis, 1, degree);
    if (unknown == BETA && c->damage_case) cut_at_axis(i, &gtm_damage_beta_axis, 1, degree);
    if (unknown == BETA && c->has_stall_asymmetry) cut_at_axis(i, &gtm_stall_beta_axis, 1, degree);
    for (int k = 0; unknown == ELEVATOR && k < c->segments; k++)
        cut_at_surface(i, &gtm_elevator_axis, c->segment[k].gain, c->segment[k].offset);
    const gtm_axis *axis = unknown == AILERON ? &gtm_aileron_axis : unknown == RUDDER ? &gtm_rudder_axis : 0;
    for (int k = 0; axis && k < c->panels; k++)
        if (c->panel[k].panel->axis == axis) cut_at_surface(i, axis, c->panel[k].gain, c->panel[k].offset);
}

static void set_interval(const gtm_problem *p, gtm_cell *c, int unknown, double value, int above)
{
    interval i = {value, gtm_border * gtm_scale[unknown], -INFINITY, INFINITY, above};
    if (p->configuration)
        cut_by_configuration(&i, p->configuration, unknown);
    else
        cut_by_study(&i, unknown);
    c->lower[unknown] = i.lower;
    c->upper[unknown] = i.upper;
}

gtm_cell gtm_open_cell(void)
{
    gtm_cell c;
    for (int i = 0; i < GTM_FULL_NT; i++) c.lower[i] = -INFINITY, c.upper[i] = INFINITY;
    return c;
}

gtm_cell gtm_cell_at(const gtm_problem *p, const double *y, const double *upper)
{
    gtm_cell c = gtm_open_cell();
    for (int k = 0; k < GTM_KINKED; k++) {
        const int i = gtm_kinked[k];
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
        const int i = gtm_kinked[k];
        const double slack = gtm_border * gtm_scale[i];
        if (y[i] < c->lower[i] - slack || y[i] > c->upper[i] + slack) set_interval(p, c, i, y[i], y[i] > c->upper[i]);
    }
}

void gtm_full_breakpoints(const gtm_configuration *c, int unknowns, long n, const double *y, unsigned char *is_on)
{
    const gtm_problem p = {{0, 0, 0}, c, unknowns, {0}, 0};
    memset(is_on, 0, (size_t)n * (size_t)unknowns);
    for (long row = 0; row < n; row++, y += unknowns, is_on += unknowns)
        for (int k = 0; k < GTM_KINKED; k++) {
            const int i = gtm_kinked[k];
            gtm_cell above;
            set_interval(&p, &above, i, y[i], 1);
            is_on[i] = above.lower[i] >= y[i] - gtm_border * gtm_scale[i];
        }
}
