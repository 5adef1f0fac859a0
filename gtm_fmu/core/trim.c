#include <math.h>
#include <string.h>

#include "solver.h"
#include "table.h"

const double gtm_scale[] = {30, 0.05, 0.05, 0.1, 0.17, 4, 4, 6, 20, 20};

/* A Newton step is limited and its result clamped, so that a bad guess stays where the tables mean something. */
static const double longest_step[GTM_FULL_NT] = {30, 0.1, 0.12, 0.2, 0.25, 10, 8, 8, 40, 40};
static const double least[GTM_FULL_NT] = {20, -0.5, -0.7, -3, -1.4, -60, -60, -60, -60, -60};
static const double most[GTM_FULL_NT] = {600, 0, 0.7, 3, 1.4, 60, 60, 60, 400, 400}; /* alpha: that of the problem */
const double gtm_usual_alpha = 0.34;

static const double converged = 1e-11; /* largest acceleration, ft/s^2 and rad/s^2 */
static const double nearly = 1e-4;     /* so near, one more step converges */
enum { MOST_ITERATIONS = 40, SCANNED = 48 };

double gtm_residual_norm(const double F[GTM_NF])
{
    double norm = 0;
    for (int i = 0; i < GTM_NF; i++) {
        if (!(fabs(F[i]) <= norm)) norm = fabs(F[i]);
    }
    return norm;
}

static inline int eliminate(int n, double *A, double *b)
{
    for (int k = 0; k < n; k++) {
        int pivot = k;
        for (int i = k + 1; i < n; i++)
            if (fabs(A[i * n + k]) > fabs(A[pivot * n + k])) pivot = i;
        if (!(fabs(A[pivot * n + k]) > 1e-14)) return 1;
        if (pivot != k) {
            for (int j = k; j < n; j++) {
                const double kept = A[k * n + j];
                A[k * n + j] = A[pivot * n + j];
                A[pivot * n + j] = kept;
            }
            const double kept = b[k];
            b[k] = b[pivot];
            b[pivot] = kept;
        }
        for (int i = k + 1; i < n; i++) {
            const double factor = A[i * n + k] / A[k * n + k];
            for (int j = k + 1; j < n; j++) A[i * n + j] -= factor * A[k * n + j];
            b[i] -= factor * b[k];
        }
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int j = i + 1; j < n; j++) b[i] -= A[i * n + j] * b[j];
        b[i] /= A[i * n + i];
    }
    return 0;
}

int gtm_solve(int n, double *A, double *b)
{
    return n == GTM_NF ? eliminate(GTM_NF, A, b) : eliminate(n, A, b); /* the first with its loops unrolled */
}

/* Mark what Newton keeps; whether six unknowns are left, two throttles counted as one. */
static int keeps(const gtm_problem *p, const int held[3], int *is_kept)
{
    int count = p->unknowns;
    for (int i = 0; i < p->unknowns; i++) count -= is_kept[i] = p->is_dead[i];
    if (p->unknowns == GTM_FULL_NT && !is_kept[THROTTLE] && !is_kept[THROTTLE_RIGHT]) count--;
    for (int k = 0; k < 3 && count > GTM_NF; k++)
        if (!is_kept[held[k]]) is_kept[held[k]] = 1, count--;
    return count == GTM_NF;
}

int gtm_newton(const gtm_problem *p, double *y, const int held[3])
{
    const int n = p->unknowns;
    int is_kept[GTM_FULL_NT], free_one[GTM_FULL_NT], moving = 0;
    if (!keeps(p, held, is_kept)) return 1;
    for (int i = 0; i < n; i++)
        if (!is_kept[i]) free_one[moving++] = i;
    const int is_joined = moving > GTM_NF; /* the throttles, which come last */

    double best = INFINITY;
    int worse = 0;
    for (int iteration = 0; iteration < MOST_ITERATIONS; iteration++) {
        double F[GTM_NF + 1], J[GTM_NF * GTM_FULL_NT], A[GTM_NF * GTM_NF];
        if (best < nearly) { /* this is the end unless a kink is in the way, and needs no slopes */
            gtm_problem_residual(p, y, F);
            if (gtm_residual_norm(F) < converged) return 0;
        }
        gtm_problem_jacobian(p, y, F, J);
        const double norm = gtm_residual_norm(F);
        if (!isfinite(norm)) return 1;
        if (norm < converged) return 0;
        worse = norm < 0.9 * best ? 0 : worse + 1;
        if (norm < best) best = norm;
        if (worse > 8) return norm < 1e-9 ? 0 : 1; /* rounding floor, or hopping across a kink */
        for (int i = 0; i < GTM_NF; i++) {
            for (int k = 0; k < GTM_NF; k++) A[i * GTM_NF + k] = J[i * n + free_one[k]];
            if (is_joined) A[i * GTM_NF + GTM_NF - 1] += J[i * n + THROTTLE_RIGHT];
        }
        if (gtm_solve(GTM_NF, A, F)) return 1;
        F[GTM_NF] = F[GTM_NF - 1];
        double shorten = 1;
        for (int k = 0; k < GTM_NF; k++) {
            const double length = fabs(F[k]) / longest_step[free_one[k]];
            if (length * shorten > 1) shorten = 1 / length;
        }
        if (worse > 3) shorten *= 0.5;
        for (int k = 0; k < moving; k++) {
            const int i = free_one[k];
            y[i] = fmin(fmax(y[i] - shorten * F[k], least[i]), i == ALPHA ? p->highest_alpha : most[i]);
        }
    }
    return 1;
}

static const double degree = 0.017453292519943295;
static const double lift_0 = 0.2, lift_slope = 4.8, most_lift = 1.1, side_force_slope = 0.56;

/* Of a speed that is sought: that of the turn, or that at which the wing carries the weight. */
static double guessed_speed(const gtm_problem *p, const double *y, const int *is_held, double weight)
{
    if (is_held[PHI] && is_held[PSI_DOT] && y[PSI_DOT] != 0)
        return fmin(fmax(gtm_gravity * tan(y[PHI]) / y[PSI_DOT], 80), 400);
    const double alpha = is_held[ALPHA] ? y[ALPHA] : 4 * degree;
    const double lift = fmin(fmax(lift_0 + lift_slope * alpha, 0.1), most_lift);
    return sqrt(2 * weight / (p->at.density * gtm_wing_area * lift * (is_held[PHI] ? cos(y[PHI]) : 1)));
}

/* Rough trim of a point mass with linear lift and side force; guesses differ in sideslip per rudder, and in throttle:
   where ram drag eats a moderate thrust, its slope is zero and Newton needs a guess above. Where alpha is to settle the
   bank, it has the sign of the phi given. */
static void first_guess(const gtm_problem *p, double *y, const int *is_held, double beta_per_rudder, double throttle)
{
    const double weight = p->configuration ? p->configuration->mass * gtm_gravity : gtm_weight;
    if (!is_held[V]) y[V] = guessed_speed(p, y, is_held, weight);
    const double force = 0.5 * p->at.density * y[V] * y[V] * gtm_wing_area;
    if (is_held[V] && is_held[ALPHA] && !is_held[PHI] && !is_held[PSI_DOT]) {
        const double bank = acos(fmin(weight / (force * fmax(lift_0 + lift_slope * y[ALPHA], 0.1)), 0.99));
        y[PSI_DOT] = gtm_gravity * tan(y[PHI] < 0 ? -bank : bank) / y[V];
    }
    if (!is_held[BETA] && is_held[PHI] && is_held[PSI_DOT])
        y[BETA] = weight * sin(y[PHI] - atan(y[V] * y[PSI_DOT] / gtm_gravity)) / (side_force_slope * force);
    if (!is_held[RUDDER]) y[RUDDER] = y[BETA] / (0.7 * degree);
    if (!is_held[BETA]) y[BETA] = beta_per_rudder * degree * y[RUDDER];
    const double against_slip = asin(fmin(fmax(side_force_slope * force * y[BETA] / weight, -0.6), 0.6));
    if (!is_held[PHI]) y[PHI] = fmin(fmax(atan(y[V] * y[PSI_DOT] / gtm_gravity) + against_slip, -1.2), 1.2);
    if (!is_held[PSI_DOT]) y[PSI_DOT] = gtm_gravity * tan(y[PHI] - against_slip) / y[V];
    const double alpha = (weight / (force * cos(y[PHI])) - lift_0) / lift_slope;
    if (!is_held[ALPHA]) y[ALPHA] = fmin(fmax(alpha, -0.08), 0.2);
    if (!is_held[ELEVATOR]) y[ELEVATOR] = 3 - 0.5 * y[ALPHA] / degree;
    if (!is_held[AILERON]) y[AILERON] = -0.6 * y[RUDDER];
    for (int i = THROTTLE; i < p->unknowns; i++)
        if (!is_held[i]) y[i] = throttle;
}

int gtm_cold_newton(const gtm_problem *p, double *y, const int held[3])
{
    static const double beta_per_rudder[] = {0.7, 0.7, 0.4, 1, 0}, throttle[] = {50, 100, 100, 100, 100};
    int is_kept[GTM_FULL_NT];
    double given[GTM_FULL_NT];
    if (!keeps(p, held, is_kept)) return 1;
    memcpy(given, y, sizeof *y * (size_t)p->unknowns);
    for (int guess = 0; guess < 5; guess++) {
        memcpy(y, given, sizeof *y * (size_t)p->unknowns);
        first_guess(p, y, is_kept, beta_per_rudder[guess], throttle[guess]);
        if (!gtm_newton(p, y, held)) return 0;
    }
    return 1;
}

double gtm_violation(const gtm_problem *p, const double *y, const double *lower, const double *upper)
{
    double violation = 0;
    for (int i = 0; i < p->unknowns; i++) {
        const double excess = fmax(lower[i] - y[i], y[i] - upper[i]) / gtm_scale[i];
        if (excess > violation) violation = excess;
    }
    return violation;
}

long gtm_find_starts(const gtm_problem *p, long n, const double *held_values, double *y)
{
    static const int column[3] = {V, PHI, RUDDER}, held[3] = {PHI, RUDDER, V};
    long found = 0;
    for (long i = 0; i < n; i++) {
        double *point = y + found * p->unknowns;
        memset(point, 0, sizeof *point * (size_t)p->unknowns);
        for (int k = 0; k < 3; k++)
            if (!p->is_dead[column[k]]) point[column[k]] = held_values[i * 3 + k];
        if (!gtm_cold_newton(p, point, held)) found++;
    }
    return found;
}

const int gtm_usual[2] = {V, PSI_DOT};

/* The values that the bounds hold, or the nearest to zero, and the side of a bank that is sought. */
static void take_given(const double *lower, const double *upper, int count, const int *given, double *y)
{
    y[PHI] = upper[PHI] <= 0 && lower[PHI] < 0 ? -1 : 0;
    for (int k = 0; k < count; k++) y[given[k]] = fmin(fmax(0, lower[given[k]]), upper[given[k]]);
}

static const double glide_sideslip = 0.2; /* rad, to start from */

/* Least |beta| under the bounds when neither the rudder nor beta = 0 settles it: the best of both signs. */
static int least_sideslip(const gtm_problem *p, const double *lower, const double *upper, const int given[2], double *y,
                          double *violation)
{
    const int held[3] = {given[0], given[1], RUDDER};
    const size_t row = sizeof *y * (size_t)p->unknowns;
    double starts[7 * GTM_FULL_NT];
    long n = 0;
    for (int side = -1; side <= 1; side += 2) {
        /* In a glide without net thrust the throttle moves nothing, and only sideslip makes drag. */
        const int idle[3] = {given[0], given[1], THROTTLE};
        double *start = starts + n * p->unknowns;
        memset(start, 0, row);
        take_given(lower, upper, 2, given, start);
        start[THROTTLE] = lower[THROTTLE];
        start[BETA] = side * glide_sideslip;
        if (lower[RUDDER] < upper[RUDDER] && !gtm_cold_newton(p, start, idle)) n++;
    }
    for (int k = 0; k < 5; k++) {
        double *start = starts + n * p->unknowns;
        memset(start, 0, row);
        take_given(lower, upper, 2, given, start);
        start[RUDDER] = lower[RUDDER] + 0.25 * k * (upper[RUDDER] - lower[RUDDER]);
        if (!gtm_cold_newton(p, start, held)) n++;
        if (lower[RUDDER] == upper[RUDDER]) break;
    }
    int status = GTM_NO_TRIM;
    for (int side = 0; side < 2; side++) {
        double one_sided[GTM_FULL_NT], other[GTM_FULL_NT], objective[GTM_FULL_NT] = {0}, point[GTM_FULL_NT], excess;
        memcpy(one_sided, lower, row);
        memcpy(other, upper, row);
        if (side) {
            other[BETA] = fmin(other[BETA], 0);
            objective[BETA] = -1;
        } else {
            one_sided[BETA] = fmax(one_sided[BETA], 0);
            objective[BETA] = 1;
        }
        const int found = gtm_find_extreme(p, one_sided, other, objective, n, starts, point, &excess);
        if (found == GTM_NO_TRIM) continue;
        const int better = status == GTM_NO_TRIM || found < status ||
                           (found == status && (found == GTM_TRIMMED ? fabs(point[BETA]) < fabs(y[BETA])
                                                                     : excess < *violation));
        if (better) {
            memcpy(y, point, row);
            *violation = excess;
            status = found;
        }
    }
    return status;
}

static const double inside = 1e-9; /* of a scale unit: rounding, not a violation */

void gtm_join_throttles(const gtm_problem *p, const double *lower, const double *upper, double *y)
{
    if (p->unknowns < GTM_FULL_NT || p->is_dead[THROTTLE] || p->is_dead[THROTTLE_RIGHT]) return;
    if (fabs(y[BETA]) > inside || y[THROTTLE] == y[THROTTLE_RIGHT]) return;
    double held_lower[GTM_FULL_NT], held_upper[GTM_FULL_NT], objective[GTM_FULL_NT] = {0}, joined[GTM_FULL_NT], excess;
    memcpy(held_lower, lower, sizeof held_lower);
    memcpy(held_upper, upper, sizeof held_upper);
    held_lower[BETA] = held_upper[BETA] = 0;
    objective[THROTTLE] = y[THROTTLE] > y[THROTTLE_RIGHT] ? 1 : -1;
    objective[THROTTLE_RIGHT] = -objective[THROTTLE];
    if (gtm_find_extreme(p, held_lower, held_upper, objective, 1, y, joined, &excess) == GTM_TRIMMED)
        memcpy(y, joined, sizeof joined);
}

int gtm_rudder_settles(const gtm_problem *p, const double *lower, const double *upper)
{
    const int has_one_throttle = p->unknowns == GTM_NT || p->is_dead[THROTTLE] || p->is_dead[THROTTLE_RIGHT];
    return lower[RUDDER] == upper[RUDDER] && has_one_throttle;
}

/* Whether a control but the rudder has hardly any range: then only single deflections of the rudder give a trim. */
static int is_narrow(const gtm_problem *p, const double *lower, const double *upper)
{
    for (int i = ELEVATOR; i < p->unknowns; i++)
        if (i != RUDDER && !p->is_dead[i] && upper[i] - lower[i] < gtm_scale[i]) return 1;
    return 0;
}

/* Keep a trim inside the bounds that has less sideslip than the best so far. */
static void keep_better(const gtm_problem *p, const double *lower, const double *upper, const double *trial, int *status,
                        double *y)
{
    if (gtm_violation(p, trial, lower, upper) > inside) return;
    if (*status == GTM_TRIMMED && fabs(trial[BETA]) >= fabs(y[BETA])) return;
    memcpy(y, trial, sizeof *y * (size_t)p->unknowns);
    *status = GTM_TRIMMED;
}

int gtm_scan_rudder(const gtm_problem *p, const double *lower, const double *upper, const int given[2],
                    const double *start, double *y)
{
    const int rudder_held[3] = {given[0], given[1], RUDDER};
    const size_t row = sizeof *y * (size_t)p->unknowns;
    double before[GTM_FULL_NT], at[GTM_FULL_NT], trial[GTM_FULL_NT];
    int status = GTM_NO_TRIM;
    if (!is_narrow(p, lower, upper)) return status;
    for (int k = 0, had = 0; k <= SCANNED; k++) {
        memcpy(at, had ? before : start, row);
        for (int g = 0; g < 2; g++) at[given[g]] = lower[given[g]];
        at[RUDDER] = lower[RUDDER] + (upper[RUDDER] - lower[RUDDER]) * k / SCANNED;
        const int has = !(had && !gtm_newton(p, at, rudder_held)) ? !gtm_cold_newton(p, at, rudder_held) : 1;
        if (has) keep_better(p, lower, upper, at, &status, y);
        for (int i = V; has && had && i < p->unknowns; i++) { /* where a bound is crossed on the way */
            if (i == given[0] || i == given[1] || i == RUDDER || p->is_dead[i]) continue;
            for (int side = 0; side < 1 + (lower[i] < upper[i]); side++) {
                const double bound = side ? upper[i] : lower[i];
                const double share = (bound - before[i]) / (at[i] - before[i]);
                if (!(share >= 0 && share <= 1)) continue;
                const int bound_held[3] = {given[0], given[1], i};
                for (int j = 0; j < p->unknowns; j++) trial[j] = before[j] + share * (at[j] - before[j]);
                trial[i] = bound;
                if (!gtm_newton(p, trial, bound_held)) keep_better(p, lower, upper, trial, &status, y);
            }
        }
        had = has;
        memcpy(before, at, row);
    }
    return status;
}

/* The unknowns besides the controls that the bounds hold, at most three; where they are fewer beta and psi_dot follow,
   which are sought at zero. */
static int conditions(const double *lower, const double *upper, int held[3])
{
    static const int order[] = {V, PSI_DOT, PHI, ALPHA, BETA}, sought[] = {BETA, PSI_DOT, V};
    int count = 0;
    for (int k = 0; k < 5 && count < 3; k++)
        if (lower[order[k]] == upper[order[k]]) held[count++] = order[k];
    for (int k = 0, n = count; n < 3 && k < 3; k++)
        if (lower[sought[k]] != upper[sought[k]]) held[n++] = sought[k];
    return count;
}

int gtm_find_trim(const gtm_problem *p, const double *lower, const double *upper, double *y, double *residual,
                  double *violation)
{
    int held[3];
    const int given = conditions(lower, upper, held);
    const int settled = given < 3 && gtm_rudder_settles(p, lower, upper);
    double F[GTM_NF];
    if (settled) held[2] = RUDDER;

    memset(y, 0, sizeof *y * (size_t)p->unknowns);
    for (int i = 0; i < p->unknowns; i++)
        if (p->is_dead[i]) y[i] = lower[i];
    take_given(lower, upper, 3, held, y);
    int status = gtm_cold_newton(p, y, held) ? GTM_NO_TRIM : GTM_OUTSIDE;
    if (status == GTM_OUTSIDE) {
        *violation = gtm_violation(p, y, lower, upper);
        if (*violation <= inside) status = GTM_TRIMMED;
    }
    if (status != GTM_TRIMMED) {
        /* With the rudder held the manifold point is unique; otherwise another sideslip may lie inside the bounds. */
        double other[GTM_FULL_NT], excess = INFINITY;
        int found = settled && status == GTM_OUTSIDE ? GTM_NO_TRIM
                                                     : least_sideslip(p, lower, upper, held, other, &excess);
        if (!settled && found != GTM_TRIMMED && gtm_scan_rudder(p, lower, upper, held, y, other) == GTM_TRIMMED) {
            found = GTM_TRIMMED;
            excess = gtm_violation(p, other, lower, upper);
        }
        if (found != GTM_NO_TRIM) {
            memcpy(y, other, sizeof *y * (size_t)p->unknowns);
            *violation = excess;
            status = found;
            if (status == GTM_TRIMMED) gtm_join_throttles(p, lower, upper, y);
        }
    }
    if (status == GTM_NO_TRIM) *violation = gtm_violation(p, y, lower, upper);
    gtm_problem_residual(p, y, F);
    *residual = gtm_residual_norm(F);
    return status;
}
