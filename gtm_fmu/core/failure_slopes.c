/* Slopes of answers under a failure. Those of the ends of an envelope are the multipliers of the optimum (gtm_slopes.h).
   Those of a trim follow by the theorem on implicit functions: F(y, numbers) = 0 with as many unknowns held as the manifold
   of trims has dimensions. */
#include <math.h>
#include <string.h>

#include "failure.h"
#include "generated/unknowns.h"
#include "gtm_sections.h"
#include "gtm_slopes.h"
#include "gtm_t2.h"
#include "solver/linear_algebra.h"

enum { MOST = GTM_MOST_UNKNOWNS, GAMMA = 1 };

/* Of a scale unit: this near to a bound an unknown is held by it. */
static const double near_bound = 1e-6;

/* A trim, and what holds it. A held unknown has the side of its bound, or NO_BOUND: it stays where it is; with both
   throttles together, the last condition is that they stay so. */
enum { NO_BOUND = 2 };
typedef struct {
    const gtm_failure *failure;
    const gtm_remainder *left;
    double altitude, gamma;
    gtm_flight flight;
    gtm_bounds bounds;
    double y[MOST];
    int held[GTM_MOST_UNKNOWNS], side[GTM_MOST_UNKNOWNS], count, needed, are_throttles_joined;
    double inverse[MOST][MOST];  /* change of each unknown: by each acceleration, then by each held unknown */
} place;

static place place_at(const gtm_failure *f, const gtm_remainder *left, double altitude, double gamma, const double *y)
{
    place p = {.failure = f, .left = left, .altitude = altitude, .gamma = gamma};
    p.flight = gtm_flight_at(gtm_airframe_left(left), left->throttles, altitude, gamma);
    p.bounds = gtm_bounds_of(&p.flight, left->lower, left->upper);
    memcpy(p.y, y, sizeof p.y);
    p.needed = p.flight.problem.unknowns - GTM_NF;
    return p;
}

/* ---- What holds a trim ---- */

static int is_held(const place *p, int unknown)
{
    for (int k = 0; k < p->count; k++)
        if (p->held[k] == unknown) return 1;
    return 0;
}

static void hold(place *p, int unknown, int side)
{
    if (p->count == p->needed || is_held(p, unknown)) return;
    p->held[p->count] = unknown;
    p->side[p->count++] = side;
}

static int is_near(const place *p, int unknown, double value)
{
    return fabs(p->y[unknown] - value) <= near_bound * gtm_scale[unknown];
}

/* Unknowns whose bounds are equal and met; of a control that moves nothing they are nobody's. */
static void hold_jams(place *p)
{
    static const int order[] = {V, PSI_DOT, RUDDER, ELEVATOR, AILERON, THROTTLE, THROTTLE_RIGHT, PHI, ALPHA, BETA};
    for (int k = 0; k < MOST; k++) {
        const int i = order[k];
        if (i >= p->flight.problem.unknowns || p->bounds.lower[i] != p->bounds.upper[i]) continue;
        if (is_near(p, i, p->bounds.lower[i])) hold(p, i, p->flight.problem.is_dead[i] ? NO_BOUND : 0);
    }
}

static void hold_at_bounds(place *p)
{
    for (int i = 0; i < p->flight.problem.unknowns; i++)
        for (int side = 0; side < 2; side++)
            if (is_near(p, i, side ? p->bounds.upper[i] : p->bounds.lower[i])) hold(p, i, side);
}

/* Solve for the slopes; 1 where there are none. */
static int invert(place *p)
{
    const int n = p->flight.problem.unknowns;
    double F[GTM_NF], J[GTM_NF * MOST], rows[MOST * MOST] = {0};
    if (p->count + p->are_throttles_joined < p->needed) return 1;
    p->flight.problem.aircraft->jacobian(&p->flight.problem, p->y, F, J);
    memcpy(rows, J, sizeof *J * (size_t)(GTM_NF * n));
    for (int k = 0; k < p->needed; k++) {
        double *row = rows + (GTM_NF + k) * n;
        if (k < p->count) row[p->held[k]] = 1;
        else row[THROTTLE] = 1, row[THROTTLE_RIGHT] = -1;
    }
    for (int c = 0; c < n; c++) {
        double copy[MOST * MOST], column[MOST] = {0};
        memcpy(copy, rows, sizeof copy);
        column[c] = 1;
        if (gtm_solve(n, copy, column)) return 1;
        for (int i = 0; i < n; i++) p->inverse[i][c] = column[i];
    }
    return 0;
}

/* A jam is one value and two numbers. The one counts whose bound would let the objective, `sign` times an unknown, get
   less. */
static void choose_sides_of_jams(place *p, int unknown, double sign)
{
    for (int k = 0; k < p->count; k++)
        if (p->side[k] != NO_BOUND && p->bounds.lower[p->held[k]] == p->bounds.upper[p->held[k]])
            p->side[k] = sign * p->inverse[unknown][GTM_NF + k] < 0;
}

/* ---- Slopes of the accelerations ---- */

static void accelerations(const place *p, const gtm_remainder *left, double altitude, double gamma, double F[GTM_NF])
{
    const gtm_flight flight = gtm_flight_at(gtm_airframe_left(left), left->throttles, altitude, gamma);
    flight.problem.aircraft->residual(&flight.problem, p->y, F);
}

/* With respect to altitude and flight path: central differences, over steps that leave an error near to rounding. */
static void slopes_of_condition(const place *p, int number, double slope[GTM_NF])
{
    const double step = number == GAMMA ? 1e-5 : 1;
    double above[GTM_NF], below[GTM_NF];
    const double up = number == GAMMA ? 0 : step, turned = number == GAMMA ? step : 0;
    accelerations(p, p->left, p->altitude + up, p->gamma + turned, above);
    accelerations(p, p->left, p->altitude - up, p->gamma - turned, below);
    for (int i = 0; i < GTM_NF; i++) slope[i] = (above[i] - below[i]) / (2 * step);
}

/* With respect to a number of the airframe, into the inside of its range: exact where they are linear, as in the tables,
   and at a breakpoint those of the interval that is entered. Whether it has any. */
static int slopes_of_airframe(const place *p, int number, double slope[GTM_NF])
{
    const gtm_failure *f = p->failure;
    const double *const value = (const double *)f + (number - GTM_ASKED);
    const double *const moving[] = {&f->stabilizer, &f->flaps, &f->spoilers, &f->fuel_used};
    int moves = 0;
    for (int k = 0; k < (int)(sizeof moving / sizeof *moving); k++) moves |= value == moving[k];
    if (!moves) return 0;
    const double lower[GTM_NT] = {0}, upper[GTM_NT] = {0};
    for (int way = 1; way >= -1; way -= 2) {
        double F[3][GTM_NF];
        int k = 0;
        for (; k < 3; k++) {
            gtm_failure moved = *f;
            gtm_remainder left;
            ((double *)&moved)[number - GTM_ASKED] += 0.01 * k * way;
            if (gtm_take_failure(&moved, lower, upper, &left)) break;
            accelerations(p, &left, p->altitude, p->gamma, F[k]);
        }
        if (k < 3) continue;
        for (int i = 0; i < GTM_NF; i++) slope[i] = way * (-1.5 * F[0][i] + 2 * F[1][i] - 0.5 * F[2][i]) / 0.01;
        return 1;
    }
    return 0;
}

/* Change of the unknowns by one of a number. */
static void slopes_of_unknowns(const place *p, int number, double dy[MOST])
{
    const int n = p->flight.problem.unknowns;
    double dF[GTM_NF], change[MOST] = {0};
    int has = number <= GAMMA;
    if (has) slopes_of_condition(p, number, dF);
    else if (number >= GTM_ASKED) has = slopes_of_airframe(p, number, dF);
    for (int i = 0; i < GTM_NF && has; i++) change[i] = -dF[i];
    for (int k = 0; k < p->count; k++)
        if (p->side[k] != NO_BOUND) change[GTM_NF + k] = p->left->from[p->held[k]][p->side[k]] == number;
    for (int i = 0; i < n; i++) {
        dy[i] = 0;
        for (int c = 0; c < n; c++) dy[i] += p->inverse[i][c] * change[c];
    }
    if (n < MOST) dy[THROTTLE_RIGHT] = dy[THROTTLE];
}

/* ---- Ends ---- */

/* Towards larger values of a number, where it may grow. */
static double growing(gtm_slope s)
{
    return isfinite(s.above) ? s.above : s.below;
}

/* Of a limit towards smaller values, where it may shrink. */
static double shrinking(gtm_slope s)
{
    return isfinite(s.below) ? s.below : s.above;
}

/* Slopes of the trim y where an unknown ends, the least value (sign 1) or the greatest (-1). Those of limits are inwards;
   of a jam each limit moves outwards. */
static int slopes_of_end(const gtm_failure *f, const gtm_remainder *left, double altitude, double gamma,
                         const double *y, int unknown, double sign, double slopes[GTM_TOLD])
{
    double objective[MOST] = {0};
    gtm_slopes s;
    objective[unknown] = sign;
    gtm_end_slopes(gtm_airframe_left(left), left->throttles, altitude, gamma, left->lower, left->upper, objective, y, &s);
    slopes[0] = growing(s.altitude);
    slopes[GAMMA] = growing(s.gamma);
    const double *const moving[] = {&f->stabilizer, &f->flaps, &f->spoilers, &f->fuel_used};
    const gtm_slope of[] = {s.stabilizer, s.flaps, s.spoilers, s.fuel_used};
    for (int k = 0; k < (int)(sizeof moving / sizeof *moving); k++)
        slopes[GTM_ASKED + (moving[k] - (const double *)f)] = growing(of[k]);
    for (int i = 0; i < GTM_NT - GTM_ONE_THROTTLE + (int)left->throttles; i++) {
        const int *const from = left->from[i];
        if (from[0] >= 0) slopes[from[0]] += growing(s.lower[i]);
        if (from[1] >= 0) slopes[from[1]] += shrinking(s.upper[i]);
    }
    for (int number = 0; number < GTM_TOLD; number++) {
        if (!isfinite(slopes[number])) return GTM_NO_SLOPES;
        slopes[number] *= sign;
    }
    return GTM_LEFT;
}

int gtm_failure_envelope_slopes(const gtm_failure_case *at, const gtm_failure *f, const double lower[GTM_NT],
                                const double upper[GTM_NT], const double end[2][GTM_TWO_THROTTLE_NT],
                                double slopes[2][GTM_TOLD])
{
    gtm_remainder left;
    int fault = gtm_take_case(at, f, lower, upper, &left);
    memset(slopes, 0, 2 * sizeof *slopes);
    for (int k = 0; k < 2 && !fault && end[k][V] > 0; k++)
        fault = slopes_of_end(f, &left, at->altitude, at->gamma, end[k], V, k ? -1 : 1, slopes[k]);
    return fault;
}

int gtm_failure_turn_rate_slopes(const gtm_failure_manoeuvre *at, const gtm_failure *f, const double lower[GTM_NT],
                                 const double upper[GTM_NT], double slopes[2][GTM_TOLD])
{
    gtm_remainder left;
    gtm_intervals found;
    int fault = gtm_take_speed(at, f, lower, upper, &left);
    if (fault) return fault;
    gtm_section(gtm_airframe_left(&left), left.throttles, GTM_TURN_RATES, at->altitude, at->gamma, left.lower, left.upper,
                lower[PSI_DOT], upper[PSI_DOT], &found);
    memset(slopes, 0, 2 * sizeof *slopes);
    for (int k = 0; k < 2 && !fault && found.count; k++) {
        double objective[MOST] = {0}, y[MOST] = {0}, violation; /* the end itself, from a trim a little inside */
        objective[PSI_DOT] = k ? -1 : 1;
        if (gtm_extreme(gtm_airframe_left(&left), left.throttles, at->altitude, at->gamma, left.lower, left.upper,
                        objective, 1, found.y[k ? found.count - 1 : 0][k], y, &violation) != GTM_TRIMMED)
            return GTM_NO_SLOPES;
        fault = slopes_of_end(f, &left, at->altitude, at->gamma, y, PSI_DOT, objective[PSI_DOT], slopes[k]);
    }
    return fault;
}

/* ---- Manoeuvres ---- */

/* Hold what settles a trim: what is asked, jams, no sideslip, throttles together, limits that are met. */
static int settle(place *p)
{
    hold_jams(p);
    if (is_near(p, BETA, 0)) hold(p, BETA, NO_BOUND);
    p->are_throttles_joined = p->count < p->needed && p->left->throttles == GTM_TWO_THROTTLES &&
                              fabs(p->y[THROTTLE] - p->y[THROTTLE_RIGHT]) <= near_bound * gtm_scale[THROTTLE];
    p->needed -= p->are_throttles_joined;
    hold_at_bounds(p);
    p->needed += p->are_throttles_joined;
    if (invert(p)) return GTM_NO_SLOPES;
    choose_sides_of_jams(p, BETA, p->y[BETA] < 0 ? -1 : 1);
    return GTM_LEFT;
}

/* Net thrust, and how much less and more the throttles can give, with y and its bounds moved along by dy of a number. */
static void thrusts(const place *p, int number, const double dy[MOST], double amount, double thrust[3])
{
    const gtm_flight flight = gtm_flight_at(p->flight.configuration, p->left->throttles,
                                            p->altitude + amount * (number == 0), p->gamma + amount * (number == GAMMA));
    double y[3][MOST];
    memcpy(y[0], p->y, sizeof y[0]);
    memcpy(y[1], p->bounds.lower, sizeof y[1]);
    memcpy(y[2], p->bounds.upper, sizeof y[2]);
    for (int i = THROTTLE; i < flight.problem.unknowns; i++) {
        y[0][i] += amount * dy[i];
        for (int side = 0; side < 2; side++) y[1 + side][i] += amount * (p->left->from[i][side] == number);
    }
    for (int k = 0; k < 3; k++) thrust[k] = gtm_thrust(&flight, p->y[V] + amount * dy[V], y[k]);
}

static void slopes_of_answer(const place *p, int number, gtm_failure_answer *slope)
{
    double dy[MOST], above[3], below[3], largest = 1;
    slopes_of_unknowns(p, number, dy);
    for (int k = 0; k < GTM_LIMITED; k++) {
        const int is_shared = gtm_limited[k] == THROTTLE_RIGHT && p->left->throttles == GTM_ONE_THROTTLE;
        const int i = is_shared ? THROTTLE : gtm_limited[k];
        if (p->flight.problem.is_dead[i]) continue;
        slope->margin[k][0] = dy[i] - (p->left->from[i][0] == number);
        slope->margin[k][1] = (p->left->from[i][1] == number) - dy[i];
    }
    for (int i = 0; i < p->flight.problem.unknowns; i++) largest = fmax(largest, fabs(dy[i]) / gtm_scale[i]);
    const double step = (number == GAMMA ? 1e-5 : 1e-3) / largest;
    thrusts(p, number, dy, step, above);
    thrusts(p, number, dy, -step, below);
    for (int k = 0; k < 3; k++) above[k] = (above[k] - below[k]) / (2 * step);
    slope->thrust_margin[0] = above[0] - above[1];
    slope->thrust_margin[1] = above[2] - above[0];
    slope->alpha = dy[ALPHA];
    slope->beta = dy[BETA];
    slope->bank = dy[PHI];
    memcpy(slope->surface, dy + ELEVATOR, sizeof slope->surface);
    memcpy(slope->throttle, dy + THROTTLE, sizeof slope->throttle);
    slope->thrust = above[0];
}

int gtm_failure_query_slopes(const gtm_failure_manoeuvre *at, const gtm_failure *f, const double lower[GTM_NT],
                             const double upper[GTM_NT], double *slopes)
{
    enum { N = sizeof(gtm_failure_answer) / sizeof(double) };
    gtm_remainder left;
    gtm_answer found;
    int fault = gtm_take_manoeuvre(at, f, lower, upper, &left);
    if (fault) return fault;
    gtm_query(gtm_airframe_left(&left), left.throttles, 1, &at->altitude, &at->gamma, left.lower, left.upper, &found);
    memset(slopes, 0, N * GTM_TOLD * sizeof *slopes);
    if (found.status == GTM_NO_TRIM) return GTM_LEFT;
    place p = place_at(f, &left, at->altitude, at->gamma, found.y);
    fault = settle(&p);
    for (int number = 0; number < GTM_TOLD && !fault; number++) {
        gtm_failure_answer slope = {0};
        slopes_of_answer(&p, number, &slope);
        for (int row = 0; row < N; row++) slopes[row * GTM_TOLD + number] = ((double *)&slope)[row];
    }
    return fault;
}
