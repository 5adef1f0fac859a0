#include "gtm_simulation.h"

#include <math.h>
#include <string.h>

#include "generated/actuators.h"
#include "gtm/configured_table.h"

typedef const double *arguments[];
typedef double *results[];

enum { FLAPS = 3, INBOARD, OUTBOARD };      /* servos after those of the control surfaces */
enum { NX = GTM_SIMULATION_NX, FUEL = GTM_NX, CONTROL_SURFACES = 3, THROTTLE = 3 };

static const gtm_range throttle_range = {0, 100}, gear_range = {0, 1};

static double within(double value, gtm_range range)
{
    return fmin(fmax(value, range.lowest), range.highest);
}

/* ---- The failure ---- */

/* Times are sums of steps, which round. */
static int has_failed(const gtm_simulation_settings *p, double time)
{
    return time >= p->failure_time - 1e-9;
}

static double rate_limit(const gtm_simulation_settings *p, int servo, double time)
{
    return servo < CONTROL_SURFACES && has_failed(p, time) ? p->rate_limit[servo] : gtm_fastest_servo;
}

/* What is left of a control: the travel of its servo, inside what the failure leaves. */
static gtm_range authority(const gtm_simulation_settings *p, const gtm_actuators *m, int control)
{
    const gtm_range whole = control == THROTTLE ? throttle_range : gtm_servo_range[control];
    if (!has_failed(p, m->time)) return whole;
    if (control < CONTROL_SURFACES && p->rate_limit[control] == 0)
        return (gtm_range){m->surface[control], m->surface[control]};
    return (gtm_range){within(p->limits[control][0], whole), within(p->limits[control][1], whole)};
}

/* ---- Commands and their delays ---- */

static gtm_commands commands_of(const gtm_simulation_inputs *u, const gtm_simulation_settings *p, double time)
{
    gtm_commands c = {time, {0}, 0, within(u->gear, gear_range)};
    double control[GTM_NU];
    for (int i = 0; i < GTM_NU; i++) {
        const gtm_range left = {p->limits[i][0], p->limits[i][1]};
        control[i] = has_failed(p, time) ? within(u->control[i], left) : u->control[i];
    }
    memcpy(c.servo, control, CONTROL_SURFACES * sizeof *control);
    c.servo[FLAPS] = u->flaps;
    c.servo[INBOARD] = c.servo[OUTBOARD] = u->spoilers;
    c.throttle = within(control[THROTTLE], throttle_range);
    return c;
}

/* Before the first step: commands have always been as now. */
static void settle(gtm_actuators *m, const gtm_simulation_inputs *u, const gtm_simulation_settings *p)
{
    const gtm_commands c = commands_of(u, p, 0);
    for (int i = 0; i < GTM_SERVOS; i++)
        m->surface[i] = m->start[i] = p->has_servos ? within(c.servo[i], gtm_servo_range[i]) : c.servo[i];
    cas_settled_lag((arguments){&c.throttle}, (results){m->lag}, 0, 0, 0);
    m->throttle = c.throttle;
    m->gear = c.gear;
    m->is_begun = 1;
}

/* The k-th of the commands that are remembered, of any k from 0 on. */
static gtm_commands *commands_at(gtm_commands ring[GTM_RING], const gtm_actuators *m, int k)
{
    return ring + ((int)m->oldest + k) % GTM_RING;
}

/* The first of the commands that arrive, after a delay, later than a time; as many as there are when none does. */
static int first_after(gtm_commands ring[GTM_RING], const gtm_actuators *m, double delay, double time)
{
    int first = 0, end = (int)m->records;
    while (first < end) {
        const int middle = (first + end) / 2;
        if (commands_at(ring, m, middle)->time + delay > time) end = middle;
        else first = middle + 1;
    }
    return first;
}

/* The latest commands that have arrived, after a delay, at a time; or the oldest. */
static int arrived(gtm_commands ring[GTM_RING], const gtm_actuators *m, double delay, double time)
{
    const int next = first_after(ring, m, delay, time);
    return next > 0 ? next - 1 : 0;
}

/* Note the commands from a time on, and forget those that have arrived everywhere. */
static int remember(gtm_commands ring[GTM_RING], gtm_actuators *m, const gtm_simulation_inputs *u,
                    const gtm_simulation_settings *p, double time)
{
    const gtm_commands c = commands_of(u, p, time);
    const int records = (int)m->records;
    if (records && !memcmp(c.servo, commands_at(ring, m, records - 1)->servo, sizeof c - sizeof c.time)) return 0;
    const int forgotten = arrived(ring, m, p->command_delay + p->surface_delay, time);
    if (records - forgotten == GTM_RECORDS) return GTM_TOO_MANY_COMMANDS;
    m->oldest = ((int)m->oldest + forgotten) % GTM_RING;
    m->records = records - forgotten + 1;
    *commands_at(ring, m, records - forgotten) = c;
    return 0;
}

/* ---- A part of a step, in which no command arrives ---- */

typedef struct {
    gtm_configuration airframe;
    const gtm_simulation_settings *p;
    const gtm_actuators *m;
    double command[GTM_SERVOS], rate[GTM_SERVOS], throttle;
} part;

static int configure(gtm_configuration *c, const gtm_simulation_inputs *u, const gtm_simulation_settings *p,
                     double gear, double time)
{
    const int failed = has_failed(p, time);
    gtm_study_configuration(c);
    memset(c->surface_gain, 0, sizeof c->surface_gain);
    if (failed && p->damage_case != floor(p->damage_case)) return GTM_BAD_SETTING;
    if (failed && !(fabs(p->damage_case) < GTM_DAMAGE_CASES)) return GTM_BAD_SETTING;
    c->damage_case = failed ? (int)p->damage_case : 0;
    for (int i = 0; i < 2; i++) c->engine_running[i] = !failed || p->engine_running[i] != 0;
    c->stabilizer = p->stabilizer;
    c->gear = gear;
    memcpy(c->wind, u->wind, sizeof c->wind);
    memcpy(c->gust, u->gust, sizeof c->gust);
    c->has_shear = p->has_shear != 0;
    c->runway_altitude = p->runway_altitude;
    c->has_stall_asymmetry = p->has_stall_asymmetry != 0;
    return 0;
}

/* Complete the airframe with surfaces and fuel. */
static int set_surfaces(gtm_configuration *c, const gtm_simulation_settings *p, const double surface[GTM_SERVOS],
                        double fuel_used)
{
    cas_surfaces((arguments){surface, &p->has_dead_band}, (results){c->surface_offset, c->spoiler, c->flap}, 0, 0, 0);
    c->fuel_used = fuel_used;
    return gtm_configure(c) ? GTM_BAD_SETTING : 0;
}

static void fuel_flow(const gtm_configuration *c, double throttle, double flow[2])
{
    const double running[2] = {c->engine_running[0], c->engine_running[1]};
    cas_fuel_flow((arguments){&throttle, running}, (results){flow}, 0, 0, 0);
}

/* Controls of an airframe whose surfaces are set: the throttles. */
#define ONLY_THROTTLE(throttle) {0, 0, 0, throttle, throttle}

static int derivatives(const gtm_configuration *c, const gtm_simulation_settings *p, const double x[NX],
                       double throttle, double dx[NX])
{
    const double u[GTM_TWO_THROTTLE_NU] = ONLY_THROTTLE(throttle);
    const int fault = gtm_configured_state_fault(c, x);
    if (fault) return fault;
    double flow[2];
    fuel_flow(c, throttle, flow);
    gtm_configured_derivatives(c, x, u, dx);
    dx[FUEL] = p->has_fuel_burn ? (flow[0] + flow[1]) / 60 : 0;
    return 0;
}

/* Surfaces and throttle after a time in the part. */
static void actuate(const part *at, double elapsed, double surface[GTM_SERVOS], double lag[2], double *throttle)
{
    if (at->p->has_servos)
        cas_servos((arguments){at->m->surface, at->command, &elapsed, at->rate}, (results){surface}, 0, 0, 0);
    else memcpy(surface, at->command, GTM_SERVOS * sizeof *surface);
    cas_throttle_lag((arguments){at->m->lag, &at->throttle, &elapsed}, (results){lag, throttle}, 0, 0, 0);
    if (!at->p->has_throttle_lag) *throttle = at->throttle;
}

static int stage(part *at, const double x[NX], double elapsed, double dx[NX])
{
    double surface[GTM_SERVOS], lag[2], throttle;
    actuate(at, elapsed, surface, lag, &throttle);
    const int fault = set_surfaces(&at->airframe, at->p, surface, x[FUEL]);
    return fault ? fault : derivatives(&at->airframe, at->p, x, throttle, dx);
}

static int runge_kutta_4(part *at, double x[NX], double dt)
{
    double k1[NX], k2[NX], k3[NX], k4[NX], y[NX];
    int fault = stage(at, x, 0, k1);
    if (fault) return fault;
    for (int i = 0; i < NX; i++) y[i] = x[i] + 0.5 * dt * k1[i];
    fault = stage(at, y, 0.5 * dt, k2);
    if (fault) return fault;
    for (int i = 0; i < NX; i++) y[i] = x[i] + 0.5 * dt * k2[i];
    fault = stage(at, y, 0.5 * dt, k3);
    if (fault) return fault;
    for (int i = 0; i < NX; i++) y[i] = x[i] + dt * k3[i];
    fault = stage(at, y, dt, k4);
    if (fault) return fault;
    for (int i = 0; i < NX; i++) x[i] += dt / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
    return gtm_configured_state_fault(&at->airframe, x);
}

/* Move on by dt from a time at which the memory is. */
static int take_part(gtm_commands ring[GTM_RING], gtm_actuators *m, const gtm_simulation_inputs *u,
                     const gtm_simulation_settings *p, double x[NX], double dt)
{
    const double middle = m->time + 0.5 * dt;
    const int is_delayed = middle >= p->surface_delay; /* before, SPEC 10.1 lets the positions pass undelayed */
    if (is_delayed && !m->is_delayed) memcpy(m->surface, m->start, sizeof m->surface);
    m->is_delayed = is_delayed;
    const gtm_commands *here = commands_at(ring, m, arrived(ring, m, p->command_delay, middle));
    const double whole_delay = p->command_delay + is_delayed * p->surface_delay;
    part at = {.p = p, .m = m, .throttle = here->throttle};
    m->gear = here->gear;
    memcpy(at.command, commands_at(ring, m, arrived(ring, m, whole_delay, middle))->servo, sizeof at.command);
    for (int i = 0; i < GTM_SERVOS; i++) at.rate[i] = rate_limit(p, i, middle);
    int fault = configure(&at.airframe, u, p, m->gear, middle);
    if (!fault) fault = runge_kutta_4(&at, x, dt);
    double surface[GTM_SERVOS], lag[2];
    actuate(&at, dt, surface, lag, &m->throttle);
    memcpy(m->surface, surface, sizeof surface);
    memcpy(m->lag, lag, sizeof lag);
    return fault;
}

/* ---- Steps ---- */

static int is_whole(double value, int least, int greatest)
{
    return value >= least && value <= greatest && value == floor(value);
}

static int argument_fault(const gtm_simulation_settings *p, const gtm_actuators *m)
{
    if (m->is_begun && !(is_whole(m->records, 1, GTM_RECORDS) && is_whole(m->oldest, 0, GTM_RING - 1)))
        return GTM_BAD_MEMORY;
    for (int i = 0; i < GTM_NU; i++)
        if (!(p->limits[i][0] <= p->limits[i][1])) return GTM_BAD_LIMITS;
    const double delay[2] = {p->command_delay, p->surface_delay};
    for (int i = 0; i < 2; i++)
        if (!(delay[i] >= 0 && delay[i] <= 1)) return GTM_BAD_SETTING;
    for (int i = 0; i < CONTROL_SURFACES; i++)
        if (!(p->rate_limit[i] >= 0)) return GTM_BAD_SETTING;
    return 0;
}

/* The first of: the next command that arrives, the failure, the beginning of the surfaces' delay, and `end`; moments
   nearer than `least` to the present count as past. */
static double next_moment(gtm_commands ring[GTM_RING], const gtm_actuators *m, const gtm_simulation_settings *p,
                          double least, double end)
{
    const double moments[2] = {p->failure_time, p->surface_delay};
    const double delays[2] = {p->command_delay, p->command_delay + p->surface_delay};
    for (int i = 0; i < 2; i++) {
        if (moments[i] > m->time + least) end = fmin(end, moments[i]);
        const int next = first_after(ring, m, delays[i], m->time + least);
        if (next < m->records) end = fmin(end, commands_at(ring, m, next)->time + delays[i]);
    }
    return end;
}

int gtm_simulation_advance(double x[NX], const gtm_simulation_inputs *u, const gtm_simulation_settings *p,
                           gtm_simulation_memory *memory, double duration, double substep)
{
    if (!(substep > 0 && duration >= 0 && duration / substep <= GTM_SUBSTEPS * (1 + 1e-9))) return GTM_BAD_STEP;
    int fault = argument_fault(p, &memory->now);
    if (fault) return fault;
    const double least = 1e-9 * substep;
    double moved[NX];
    gtm_commands *const ring = memory->ring;
    gtm_actuators m = memory->now;
    memcpy(moved, x, sizeof moved);
    if (!m.is_begun) settle(&m, u, p);
    const double begin = m.time, end = begin + duration;
    fault = remember(ring, &m, u, p, begin);
    if (!fault && p->failure_time > begin && p->failure_time < end) fault = remember(ring, &m, u, p, p->failure_time);
    for (double wanted = substep; m.time < end - least && !fault;) {
        double moment = next_moment(ring, &m, p, least, fmin(end, begin + wanted));
        if (moment > end - least) moment = end;
        fault = take_part(ring, &m, u, p, moved, moment - m.time);
        if (moment >= begin + wanted - least) wanted += substep;
        m.time = moment;
    }
    if (fault) return fault;
    m.time = end;
    memcpy(x, moved, sizeof moved);
    memory->now = m;
    return 0;
}

int gtm_simulation_evaluate(const double x[NX], const gtm_simulation_inputs *u, const gtm_simulation_settings *p,
                            const gtm_simulation_memory *memory, double dx[NX], gtm_simulation_outputs *y)
{
    int fault = argument_fault(p, &memory->now);
    if (fault) return fault;
    gtm_actuators settled = {0};
    if (!memory->now.is_begun) settle(&settled, u, p);
    const gtm_actuators *m = memory->now.is_begun ? &memory->now : &settled;
    gtm_configuration airframe;
    fault = configure(&airframe, u, p, m->gear, m->time);
    if (!fault) fault = set_surfaces(&airframe, p, m->surface, x[FUEL]);
    if (!fault) fault = derivatives(&airframe, p, x, m->throttle, dx);
    if (fault) return fault;
    const double controls[GTM_TWO_THROTTLE_NU] = ONLY_THROTTLE(m->throttle);
    gtm_configured_outputs(&airframe, x, controls, y->flight);
    memcpy(y->surface, m->surface, sizeof y->surface);
    y->throttle = m->throttle;
    fuel_flow(&airframe, m->throttle, y->fuel_flow);
    for (int i = 0; i < GTM_NU; i++) {
        const gtm_range left = authority(p, m, i);
        y->authority[i][0] = left.lowest;
        y->authority[i][1] = left.highest;
    }
    return 0;
}

long gtm_simulation_memory_size(void)
{
    return sizeof(gtm_simulation_memory) / sizeof(double);
}
