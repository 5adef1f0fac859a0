#include "linear_model.h"

#include <math.h>
#include <string.h>

#include "generated/constants.h"
#include "gtm_t2.h"
#include "solver/cell.h"

static const int linear_state[GTM_NL] = {X_U, X_V, X_W, X_P, X_Q, X_R, X_PHI, X_THETA};
static const double state_scale[GTM_NL] = GTM_STATE_SCALE, input_scale[GTM_NU] = GTM_INPUT_SCALE;

/* How far to each side of a breakpoint slopes are taken, in typical sizes; the least jump that counts, of the largest
   slope; a rate that is zero but for rounding, of a typical one. */
static const double beside = 1e-8, least_jump = 1e-7, stands_still = 1e-9;

/* A trim and where its linear model is taken. */
typedef struct {
    const gtm_configuration *configuration;
    enum gtm_throttles throttles;
    double altitude, gamma;
    int inputs, input[GTM_TWO_THROTTLE_NU]; /* the controls that are, counted from the elevator */
} trim_place;

static void state_at(const trim_place *t, const double *y, double *x, double *u)
{
    if (t->configuration) gtm_configured_trim_states(t->configuration, t->throttles, t->altitude, t->gamma, 1, y, x, u);
    else gtm_trim_states(t->altitude, t->gamma, 1, y, x, u);
}

/* [A B] in typical units at a state. */
static void slopes_at(const trim_place *t, const double *x, const double *u, gtm_linear *l)
{
    double dx[GTM_NX], J[GTM_NX * GTM_TWO_THROTTLE_NXU];
    const int width = t->configuration ? GTM_TWO_THROTTLE_NXU : GTM_NXU;
    const int is_joined = t->configuration && t->throttles == GTM_ONE_THROTTLE;
    if (t->configuration) gtm_configured_jacobian(t->configuration, x, u, dx, J);
    else gtm_jacobian(x, u, dx, J);
    l->inputs = t->inputs;
    for (int i = 0; i < GTM_NL; i++) {
        const double *row = J + linear_state[i] * width;
        for (int k = 0; k < GTM_NL; k++) l->row[i][k] = row[linear_state[k]] * (state_scale[k] / state_scale[i]);
        for (int k = 0; k < t->inputs; k++) {
            const int control = t->input[k], kind = control < GTM_NU ? control : GTM_NU - 1;
            double slope = row[GTM_NX + control];
            if (is_joined && kind == GTM_NU - 1) slope += row[GTM_NX + control + 1];
            l->row[i][GTM_NL + k] = slope * (input_scale[kind] / state_scale[i]);
        }
    }
}

/* A breakpoint: the columns of [A B] that its variable moves, and how much more they are below it and above it. */
typedef struct {
    int first, count;
    double jump[2][GTM_NL][3];
} breakpoint;

static double largest_of(const gtm_linear *l)
{
    double largest = 0;
    for (int i = 0; i < GTM_NL; i++)
        for (int k = 0; k < GTM_NL + l->inputs; k++) largest = fmax(largest, fabs(l->row[i][k]));
    return largest;
}

/* The jumps from the slopes beside; whether they count. The side whose slopes the trim itself has gets none. */
static int take_jumps(const gtm_linear *here, const gtm_linear side[2], breakpoint *b)
{
    double size[2] = {0, 0};
    for (int s = 0; s < 2; s++)
        for (int i = 0; i < GTM_NL; i++)
            for (int k = 0; k < b->count; k++) {
                b->jump[s][i][k] = side[s].row[i][b->first + k] - here->row[i][b->first + k];
                size[s] = fmax(size[s], fabs(b->jump[s][i][k]));
            }
    const int own = size[1] <= size[0];
    memset(b->jump[own], 0, sizeof b->jump[own]);
    if (size[0] == size[1]) memset(b->jump, 0, sizeof b->jump);
    return fmax(size[0], size[1]) > least_jump * largest_of(here);
}

enum { MOST_BREAKPOINTS = GTM_KINKED + 2 };

/* The breakpoints that a trim lies on, those of each rate at zero. */
static int find_breakpoints(const trim_place *t, const gtm_problem *p, const double *y, const double *x,
                            const double *u, const gtm_linear *here, breakpoint *found)
{
    static const int flow[] = {ALPHA, BETA}, rate[] = {X_P, X_Q, X_R};
    const double *scale = p->aircraft->scale;
    unsigned char is_on[GTM_MOST_UNKNOWNS];
    double moved[GTM_MOST_UNKNOWNS], x_beside[GTM_NX], u_beside[GTM_TWO_THROTTLE_NU];
    gtm_linear side[2];
    int count = 0;
    gtm_find_breakpoints(p, y, is_on);
    memcpy(moved, y, sizeof *y * (size_t)p->unknowns);
    for (int k = 0; k < 2 + t->inputs; k++) {
        const int i = k < 2 ? flow[k] : ELEVATOR + t->input[k - 2];
        if (i >= THROTTLE || !is_on[i]) continue;
        for (int s = 0; s < 2; s++) {
            moved[i] = y[i] + (s ? beside : -beside) * scale[i];
            state_at(t, moved, x_beside, u_beside);
            slopes_at(t, x_beside, u_beside, side + s);
        }
        moved[i] = y[i];
        found[count].first = k < 2 ? 0 : GTM_NL + k - 2;
        found[count].count = k < 2 ? 3 : 1;
        count += take_jumps(here, side, found + count);
    }
    memcpy(x_beside, x, sizeof x_beside);
    for (int k = 0; k < 3; k++) {
        if (fabs(x[rate[k]]) > stands_still * scale[PSI_DOT]) continue;
        for (int s = 0; s < 2; s++) {
            x_beside[rate[k]] = (s ? beside : -beside) * scale[PSI_DOT];
            slopes_at(t, x_beside, u, side + s);
        }
        x_beside[rate[k]] = x[rate[k]];
        found[count].first = 3 + k;
        found[count].count = 1;
        count += take_jumps(here, side, found + count);
    }
    return count;
}

gtm_verdict gtm_judge_trim(const gtm_configuration *c, enum gtm_throttles throttles, double altitude, double gamma,
                           const double *lower, const double *upper, const double *y)
{
    const gtm_flight flight = gtm_flight_at(c, throttles, altitude, gamma);
    trim_place t = {c, throttles, altitude, gamma, 0, {0}};
    for (int i = ELEVATOR; i < flight.problem.unknowns; i++)
        if (lower[i] < upper[i] && !flight.problem.is_dead[i]) t.input[t.inputs++] = i - ELEVATOR;
    double x[GTM_NX], u[GTM_TWO_THROTTLE_NU];
    gtm_linear here;
    breakpoint found[MOST_BREAKPOINTS];
    state_at(&t, y, x, u);
    slopes_at(&t, x, u, &here);
    const int count = find_breakpoints(&t, &flight.problem, y, x, u, &here, found);
    gtm_verdict on_all = {1, 1};
    for (int sides = 0; sides < 1 << count; sides++) {
        gtm_linear there = here;
        for (int n = 0; n < count; n++)
            for (int i = 0; i < GTM_NL; i++)
                for (int k = 0; k < found[n].count; k++)
                    there.row[i][found[n].first + k] += found[n].jump[sides >> n & 1][i][k];
        const gtm_verdict on_these = gtm_judge(&there, GTM_PBH_THRESHOLD);
        on_all.is_stable &= on_these.is_stable;
        on_all.is_controllable &= on_these.is_controllable;
    }
    return on_all;
}
