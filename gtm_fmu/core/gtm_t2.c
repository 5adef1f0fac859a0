#include "gtm_t2.h"

#include <math.h>
#include <string.h>

#include "generated/airframe.h"
#include "generated/constants.h"
#include "gtm/configured_motion.h"
#include "gtm/configured_table.h"
#include "gtm_manoeuvres.h"

typedef const double *arguments[];
typedef double *results[];

/* ---- Constants of the airframe; unknowns in their order: V alpha beta psi_dot phi, surfaces, throttles ---- */

#define DEGREE 0.017453292519943295

const double gtm_scale[GTM_MOST_UNKNOWNS] = {30, 0.05, 0.05, 0.1, 0.17, 4, 4, 6, 20, 20};
static const double longest_step[GTM_MOST_UNKNOWNS] = {30, 0.1, 0.12, 0.2, 0.25, 10, 8, 8, 40, 40};
static const double least[GTM_MOST_UNKNOWNS] = {20, -0.5, -0.7, -3, -1.4, -60, -60, -60, -60, -60};
static const double most[GTM_MOST_UNKNOWNS] = {600, 0.34, 0.7, 3, 1.4, 60, 60, 60, 400, 400};
static const double room_above_alpha = 0.1; /* rad, for Newton beyond the bound of alpha */

static const double stall = 97;             /* ft/s, at sea level */
static const double fastest_level = 320;    /* ft/s */
static const double fastest_descent = 590;  /* ft/s */
static const double steep = -0.095;         /* rad: below, idle thrust is too much at moderate speeds */

static gtm_speeds speeds(const gtm_problem *p);
static void cut(const gtm_problem *p, int unknown, gtm_interval *i);
static void residual(const gtm_problem *p, const double *y, double F[GTM_NF]);
static void jacobian(const gtm_problem *p, const double *y, double F[GTM_NF], double *J);

static const gtm_aircraft gtm_t2 = {
    .scale = gtm_scale,
    .longest_step = longest_step,
    .least = least,
    .most = most,
    .kinked = {ALPHA, BETA, PSI_DOT, ELEVATOR, AILERON, RUDDER},
    .point_mass = {.wing_area = GTM_WING_AREA, .gravity = GTM_GRAVITY,
                   .lift = 0.2, .lift_slope = 4.8, .least_lift = 0.1, .most_lift = 1.1,
                   .side_force_slope = 0.56,
                   .alpha = 4 * DEGREE, .least_alpha = -0.08, .most_alpha = 0.2,
                   .slowest = 80, .fastest = 400,
                   .elevator = 3, .elevator_per_alpha = -0.5, .aileron_per_rudder = -0.6},
    .guess = {{0.7, 50}, {0.7, 100}, {0.4, 100}, {1, 100}, {0, 100}},
    .spacing = {.glide_sideslip = 0.2, .inside = 1, .beyond = 2, .beside = {-3, -1.5, -0.5, 0.5, 1.5, 3},
                .thrust_apart = 30, .rudder_piece = 10},
    .speeds = speeds,
    .cut = cut,
    .residual = residual,
    .jacobian = jacobian,
};

/* ---- Flight conditions ---- */

/* Mark the controls that no surface and no running engine follows. */
static void mark_dead(const gtm_configuration *c, gtm_problem *p)
{
    unsigned char *dead = p->is_dead;
    dead[ELEVATOR] = dead[AILERON] = dead[RUDDER] = 1;
    for (int k = 0; k < c->segments; k++)
        if (c->segment[k].gain != 0) dead[ELEVATOR] = 0;
    for (int k = 0; k < c->panels; k++) {
        const struct gtm_active_panel *panel = &c->panel[k];
        if (panel->gain == 0) continue; /* spoilers have no command at all */
        dead[ELEVATOR + gtm_drives[panel->panel->surface].command - K_ELEVATOR] = 0;
    }
    const int left = c->engine_running[0] != 0, right = c->engine_running[1] != 0;
    const int drives_both = p->throttles == GTM_ONE_THROTTLE;
    dead[THROTTLE] = drives_both ? !left && !right : !left;
    dead[THROTTLE_RIGHT] = !right;
}

gtm_flight gtm_flight_at(const gtm_configuration *c, enum gtm_throttles throttles, double altitude, double gamma)
{
    gtm_flight flight = {.at = gtm_condition_at(altitude, gamma), .configuration = c};
    gtm_problem *p = &flight.problem;
    p->aircraft = &gtm_t2;
    p->throttles = throttles;
    p->unknowns = GTM_NT - GTM_ONE_THROTTLE + (int)throttles;
    p->highest_alpha = most[ALPHA];
    p->density = flight.at.density;
    p->weight = c ? c->mass * GTM_GRAVITY : GTM_WEIGHT;
    if (c) mark_dead(c, p);
    return flight;
}

gtm_bounds gtm_bounds_of(gtm_flight *flight, const double *lower, const double *upper)
{
    gtm_problem *p = &flight->problem;
    gtm_bounds b;
    p->highest_alpha = fmax(most[ALPHA], upper[ALPHA] + room_above_alpha);
    for (int i = 0; i < p->unknowns; i++) {
        b.lower[i] = p->is_dead[i] ? fmin(fmax(0, lower[i]), upper[i]) : lower[i];
        b.upper[i] = p->is_dead[i] ? b.lower[i] : upper[i];
    }
    return b;
}

/* The flight condition of a problem: the struct that it begins. */
static const gtm_flight *flight_of(const gtm_problem *p)
{
    return (const gtm_flight *)(const void *)p;
}

static gtm_speeds speeds(const gtm_problem *p)
{
    const gtm_flight *flight = flight_of(p);
    const double slowest = stall * sqrt(gtm_condition_at(0, 0).density / flight->at.density);
    const int is_steep = flight->at.gamma < steep;
    return (gtm_speeds){slowest, is_steep ? fastest_descent : fastest_level, is_steep};
}

/* ---- Accelerations ---- */

const double *gtm_with_both_throttles(enum gtm_throttles throttles, const double *y, double both[GTM_MOST_UNKNOWNS])
{
    if (throttles == GTM_TWO_THROTTLES) return y;
    memcpy(both, y, GTM_NT * sizeof *y);
    both[THROTTLE_RIGHT] = y[THROTTLE];
    return both;
}

static void residual(const gtm_problem *p, const double *y, double F[GTM_NF])
{
    const gtm_flight *flight = flight_of(p);
    double K[GTM_NK], C[GTM_NC], both[GTM_MOST_UNKNOWNS];
    if (flight->configuration) {
        const double *all = gtm_with_both_throttles(p->throttles, y, both);
        gtm_configured_trim_residual(flight->configuration, all, &flight->at, F);
        return;
    }
    cas_trim_lookup((arguments){y, &flight->at.gamma}, (results){K}, 0, 0, 0);
    gtm_coefficients(K, C);
    cas_trim_residual((arguments){y, &flight->at.gamma, C}, (results){F}, 0, 0, 0);
}

/* One throttle moves both engines. */
static void jacobian_of_one_throttle(const gtm_flight *flight, const double *y, double F[GTM_NF], double *J)
{
    double both[GTM_MOST_UNKNOWNS], J_both[GTM_NF * GTM_MOST_UNKNOWNS];
    const double *all = gtm_with_both_throttles(GTM_ONE_THROTTLE, y, both);
    gtm_configured_trim_jacobian(flight->configuration, all, &flight->at, F, J_both);
    for (int i = 0; i < GTM_NF; i++) {
        const double *row = J_both + i * GTM_MOST_UNKNOWNS;
        memcpy(J + i * GTM_NT, row, GTM_NT * sizeof *J);
        J[i * GTM_NT + THROTTLE] += row[THROTTLE_RIGHT];
    }
}

static void jacobian(const gtm_problem *p, const double *y, double F[GTM_NF], double *J)
{
    const gtm_flight *flight = flight_of(p);
    double K[GTM_NK], C[GTM_NC], T[GTM_NC * GTM_NK];
    if (!flight->configuration) {
        cas_trim_lookup((arguments){y, &flight->at.gamma}, (results){K}, 0, 0, 0);
        gtm_coefficients_and_slopes(K, C, T);
        cas_trim_jacobian((arguments){y, &flight->at.gamma, C, T}, (results){F, J}, 0, 0, 0);
    } else if (p->throttles == GTM_TWO_THROTTLES) {
        gtm_configured_trim_jacobian(flight->configuration, y, &flight->at, F, J);
    } else {
        jacobian_of_one_throttle(flight, y, F, J);
    }
}

double gtm_thrust(const gtm_flight *flight, double V_ft_s, const double *y)
{
    const gtm_configuration *c = flight->configuration;
    double both[GTM_MOST_UNKNOWNS], total = 0;
    const double *all = gtm_with_both_throttles(flight->problem.throttles, y, both);
    for (int side = 0; side < 2; side++) {
        double thrust;
        if (c && !c->engine_running[side]) continue;
        cas_trim_thrust((arguments){&V_ft_s, all + THROTTLE + side, &flight->at.gamma}, (results){&thrust}, 0, 0, 0);
        total += thrust;
    }
    return total;
}

/* ---- Breakpoints. Outside the study's configuration more tables have a say, and the union of their breakpoints bounds
   the cells: a border without a kink does no harm. ---- */

/* The end intervals of a table extrapolate, so its ends cut only where it is clipped. */
static void cut_at_axis(gtm_interval *i, const gtm_axis *axis, int is_clipped, double unit)
{
    for (int k = !is_clipped; k < axis->points - !is_clipped; k++) gtm_cut(i, axis->point[k] * unit);
}

/* Breakpoints in terms of the command: deflection = gain * command + offset. */
static void cut_at_surface(gtm_interval *i, const gtm_axis *axis, double gain, double offset)
{
    for (int k = 1; gain != 0 && k < axis->points - 1; k++) gtm_cut(i, (axis->point[k] - offset) / gain);
}

static void cut_by_study(gtm_interval *i, int unknown)
{
    switch (unknown) {
    case ALPHA: cut_at_axis(i, &gtm_alpha_axis, 0, DEGREE); break;
    case BETA: cut_at_axis(i, &gtm_beta_axis, 0, DEGREE); break;
    case PSI_DOT: gtm_cut(i, 0); break; /* all rates are zero together there, where every rate table has a breakpoint */
    case ELEVATOR: cut_at_axis(i, &gtm_elevator_axis, 0, 1); break;
    case AILERON: cut_at_axis(i, &gtm_aileron_axis, 0, 1); break;
    default: cut_at_axis(i, &gtm_rudder_axis, 0, 1);
    }
}

/* By the panels whose tables have this axis. */
static void cut_by_panels(gtm_interval *i, const gtm_configuration *c, const gtm_axis *axis)
{
    for (int k = 0; k < c->panels; k++)
        if (c->panel[k].panel->axis == axis) cut_at_surface(i, axis, c->panel[k].gain, c->panel[k].offset);
}

static void cut_by_configuration(gtm_interval *i, const gtm_configuration *c, int unknown)
{
    switch (unknown) {
    case ALPHA:
        cut_by_study(i, ALPHA);
        if (c->damage_case) {
            cut_at_axis(i, &gtm_damage_alpha_axis, 1, DEGREE);
            for (int k = 0; k < GTM_RATES; k++) {
                gtm_cut(i, gtm_rate_alpha[k].lowest * DEGREE);
                gtm_cut(i, gtm_rate_alpha[k].highest * DEGREE);
            }
        }
        if (c->has_stall_asymmetry) cut_at_axis(i, &gtm_stall_alpha_axis, 1, DEGREE);
        break;
    case BETA:
        cut_by_study(i, BETA);
        if (c->damage_case) cut_at_axis(i, &gtm_damage_beta_axis, 1, DEGREE);
        if (c->has_stall_asymmetry) cut_at_axis(i, &gtm_stall_beta_axis, 1, DEGREE);
        break;
    case PSI_DOT: cut_by_study(i, PSI_DOT); break;
    case ELEVATOR:
        for (int k = 0; k < c->segments; k++)
            cut_at_surface(i, &gtm_elevator_axis, c->segment[k].gain, c->segment[k].offset);
        break;
    case AILERON: cut_by_panels(i, c, &gtm_aileron_axis); break;
    default: cut_by_panels(i, c, &gtm_rudder_axis);
    }
}

static void cut(const gtm_problem *p, int unknown, gtm_interval *i)
{
    const gtm_configuration *c = flight_of(p)->configuration;
    if (c) cut_by_configuration(i, c, unknown);
    else cut_by_study(i, unknown);
}
