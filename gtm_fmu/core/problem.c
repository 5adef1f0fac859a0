/* Steady manoeuvres at the public edge: a flight condition of the study's airframe or of any other, and its solvers. */
#include <math.h>
#include <string.h>

#include "full_table.h"
#include "generated/airframe.h"
#include "solver.h"

typedef const double *arguments[];
typedef double *results[];

/* Mark the controls that no surface and no running engine follows. */
static void mark_dead(gtm_problem *p)
{
    enum { FIRST_COMMAND = GTM_NK - 3 }; /* columns of K */
    const gtm_configuration *c = p->configuration;
    unsigned char *dead = p->is_dead + ELEVATOR;
    memset(dead, 1, 3);
    for (int k = 0; k < c->segments; k++)
        if (c->segment[k].gain != 0) dead[0] = 0;
    for (int k = 0; k < c->panels; k++)
        if (c->panel[k].gain != 0) dead[gtm_drives[c->panel[k].panel->surface].command - FIRST_COMMAND] = 0;
    const int left = c->engine_running[0] != 0, right = c->engine_running[1] != 0;
    p->is_dead[THROTTLE] = p->unknowns == GTM_NT ? !left && !right : !left;
    p->is_dead[THROTTLE_RIGHT] = !right;
}

gtm_problem gtm_problem_at(const gtm_configuration *c, int unknowns, double altitude, double gamma)
{
    gtm_problem p = {gtm_condition_at(altitude, gamma), c, unknowns, {0}, gtm_usual_alpha};
    if (c) mark_dead(&p);
    return p;
}

/* All ten unknowns of a configuration. */
static const double *with_both_throttles(const gtm_problem *p, const double *y, double both[GTM_FULL_NT])
{
    if (p->unknowns == GTM_FULL_NT) return y;
    memcpy(both, y, GTM_NT * sizeof *y);
    both[THROTTLE_RIGHT] = y[THROTTLE];
    return both;
}

void gtm_problem_residual(const gtm_problem *p, const double *y, double F[GTM_NF])
{
    double K[GTM_NK], C[GTM_NC], both[GTM_FULL_NT];
    if (p->configuration) {
        gtm_full_trim_residual(p->configuration, with_both_throttles(p, y, both), &p->at, F);
        return;
    }
    cas_trim_lookup((arguments){y, &p->at.gamma}, (results){K}, 0, 0, 0);
    gtm_coefficients(K, C);
    cas_trim_residual((arguments){y, &p->at.gamma, C}, (results){F}, 0, 0, 0);
}

void gtm_problem_jacobian(const gtm_problem *p, const double *y, double F[GTM_NF], double *J)
{
    double K[GTM_NK], C[GTM_NC], T[GTM_NC * GTM_NK], both[GTM_FULL_NT], J_both[GTM_NF * GTM_FULL_NT];
    if (!p->configuration) {
        cas_trim_lookup((arguments){y, &p->at.gamma}, (results){K}, 0, 0, 0);
        gtm_coefficients_and_slopes(K, C, T);
        cas_trim_jacobian((arguments){y, &p->at.gamma, C, T}, (results){F, J}, 0, 0, 0);
    } else if (p->unknowns == GTM_FULL_NT) {
        gtm_full_trim_jacobian(p->configuration, y, &p->at, F, J);
    } else {
        gtm_full_trim_jacobian(p->configuration, with_both_throttles(p, y, both), &p->at, F, J_both);
        for (int i = 0; i < GTM_NF; i++) {
            memcpy(J + i * GTM_NT, J_both + i * GTM_FULL_NT, GTM_NT * sizeof *J);
            J[i * GTM_NT + THROTTLE] += J_both[i * GTM_FULL_NT + THROTTLE_RIGHT];
        }
    }
}

/* Bounds that hold a dead control as near to zero as they let it. */
typedef struct {
    double lower[GTM_FULL_NT], upper[GTM_FULL_NT];
} bounds;

/* The bounds of a problem, with room above that of alpha. */
static bounds set_bounds(gtm_problem *p, const double *lower, const double *upper)
{
    bounds b;
    p->highest_alpha = fmax(gtm_usual_alpha, upper[ALPHA] + 0.1);
    for (int i = 0; i < p->unknowns; i++) {
        b.lower[i] = p->is_dead[i] ? fmin(fmax(0, lower[i]), upper[i]) : lower[i];
        b.upper[i] = p->is_dead[i] ? b.lower[i] : upper[i];
    }
    return b;
}

int gtm_full_trim(const gtm_configuration *c, int unknowns, double altitude, double gamma, const double *lower,
                  const double *upper, double *y, double *residual, double *violation)
{
    gtm_problem p = gtm_problem_at(c, unknowns, altitude, gamma);
    const bounds b = set_bounds(&p, lower, upper);
    return gtm_find_trim(&p, b.lower, b.upper, y, residual, violation);
}

void gtm_full_trim_batch(const gtm_configuration *c, int unknowns, long n, const double *altitude, const double *gamma,
                         const double *lower, const double *upper, double *y, double *residual, double *violation,
                         int *status)
{
    for (long i = 0, row = 0; i < n; i++, row += unknowns)
        status[i] = gtm_full_trim(c, unknowns, altitude[i], gamma[i], lower + row, upper + row, y + row, residual + i,
                                  violation + i);
}

long gtm_full_cold_starts(const gtm_configuration *c, int unknowns, double altitude, double gamma, long n,
                          const double *held, double *y)
{
    const gtm_problem p = gtm_problem_at(c, unknowns, altitude, gamma);
    return gtm_find_starts(&p, n, held, y);
}

int gtm_full_extreme(const gtm_configuration *c, int unknowns, double altitude, double gamma, const double *lower,
                     const double *upper, const double *objective, long n, const double *starts, double *best,
                     double *violation)
{
    gtm_problem p = gtm_problem_at(c, unknowns, altitude, gamma);
    const bounds b = set_bounds(&p, lower, upper);
    return gtm_find_extreme(&p, b.lower, b.upper, objective, n, starts, best, violation);
}

int gtm_full_envelope_end(const gtm_configuration *c, int unknowns, double altitude, double gamma, const double *lower,
                          const double *upper, const double *objective, double *best, double *violation)
{
    gtm_problem p = gtm_problem_at(c, unknowns, altitude, gamma);
    const bounds b = set_bounds(&p, lower, upper);
    return gtm_find_end(&p, b.lower, b.upper, objective, best, violation);
}

long gtm_full_grid(const gtm_configuration *c, int unknowns, double altitude, double gamma, const double *lower,
                   const double *upper, long speeds, const double *speed, long rates, const double *rate, long n,
                   const double *seeds, unsigned char *feasible, double *y)
{
    gtm_problem p = gtm_problem_at(c, unknowns, altitude, gamma);
    const bounds b = set_bounds(&p, lower, upper);
    return gtm_find_grid(&p, b.lower, b.upper, speeds, speed, rates, rate, n, seeds, feasible, y);
}

int gtm_envelope_end(double altitude, double gamma, const double lower[GTM_NT], const double upper[GTM_NT],
                     const double objective[GTM_NT], double best[GTM_NT], double *violation)
{
    return gtm_full_envelope_end(0, GTM_NT, altitude, gamma, lower, upper, objective, best, violation);
}

void gtm_trim_states(double altitude, double gamma, long n, const double *y, double *x, double *u)
{
    for (long i = 0; i < n; i++, y += GTM_NT) {
        cas_trim_state((arguments){y, &gamma, &altitude}, (results){x + i * GTM_NX}, 0, 0, 0);
        memcpy(u + i * GTM_NU, y + ELEVATOR, GTM_NU * sizeof *u);
    }
}

void gtm_full_dead_controls(const gtm_configuration *c, unsigned char is_dead[GTM_FULL_NT])
{
    gtm_problem p = {{0, 0, 0}, c, GTM_FULL_NT, {0}, 0};
    mark_dead(&p);
    memcpy(is_dead, p.is_dead, sizeof p.is_dead);
}

void gtm_full_trim_states(const gtm_configuration *c, int unknowns, double altitude, double gamma, long n,
                          const double *y, double *x, double *u)
{
    const gtm_problem p = {gtm_condition_at(altitude, gamma), c, unknowns, {0}, 0};
    double both[GTM_FULL_NT];
    for (long i = 0; i < n; i++)
        gtm_full_trim_state(c, altitude, gamma, with_both_throttles(&p, y + i * unknowns, both), x + i * GTM_NX,
                            u + i * GTM_FULL_NU);
}
