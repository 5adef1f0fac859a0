#include <math.h>
#include <string.h>

#include "generated/airframe.h"
#include "solver.h"
#include "table.h"

enum { V, ALPHA, BETA, PSI_DOT, PHI, ELEVATOR, AILERON, RUDDER, THROTTLE };

const double gtm_scale[GTM_NT] = {30, 0.05, 0.05, 0.1, 0.17, 4, 4, 6, 20};

/* A Newton step is limited and its result clamped, so that a bad guess stays where the tables mean something. */
static const double longest_step[GTM_NT] = {30, 0.1, 0.12, 0.2, 0.25, 10, 8, 8, 40};
static const double least[GTM_NT] = {20, -0.5, -0.7, -3, -1.4, -60, -60, -60, -60};
static const double most[GTM_NT] = {600, 0.34, 0.7, 3, 1.4, 60, 60, 60, 400};

static const double converged = 1e-11; /* largest acceleration, ft/s^2 and rad/s^2 */
enum { MOST_ITERATIONS = 40 };

gtm_condition gtm_condition_at(double altitude, double gamma)
{
    gtm_condition at = {gamma, 0, 0};
    cas_atmosphere((const double *[]){&altitude}, (double *[]){&at.density, &at.pressure_ratio}, 0, 0, 0);
    return at;
}

void gtm_trim_residual(const double y[GTM_NT], const gtm_condition *at, double F[GTM_NF])
{
    double K[GTM_NK], C[GTM_NC];
    cas_trim_lookup((const double *[]){y, &at->gamma}, (double *[]){K}, 0, 0, 0);
    gtm_coefficients(K, C);
    cas_trim_residual((const double *[]){y, &at->gamma, C}, (double *[]){F}, 0, 0, 0);
}

void gtm_trim_jacobian(const double y[GTM_NT], const gtm_condition *at, double F[GTM_NF], double J[GTM_NF * GTM_NT])
{
    double K[GTM_NK], C[GTM_NC], T[GTM_NC * GTM_NK];
    cas_trim_lookup((const double *[]){y, &at->gamma}, (double *[]){K}, 0, 0, 0);
    gtm_coefficients_and_slopes(K, C, T);
    cas_trim_jacobian((const double *[]){y, &at->gamma, C, T}, (double *[]){F, J}, 0, 0, 0);
}

double gtm_residual_norm(const double F[GTM_NF])
{
    double norm = 0;
    for (int i = 0; i < GTM_NF; i++) {
        if (!(fabs(F[i]) <= norm)) norm = fabs(F[i]);
    }
    return norm;
}

int gtm_solve(int n, double *A, double *b)
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

int gtm_newton(double y[GTM_NT], const gtm_condition *at, const int held[3])
{
    int free_one[GTM_NF];
    for (int i = 0, k = 0; i < GTM_NT; i++)
        if (i != held[0] && i != held[1] && i != held[2]) free_one[k++] = i;

    double best = INFINITY;
    int worse = 0;
    for (int iteration = 0; iteration < MOST_ITERATIONS; iteration++) {
        double F[GTM_NF], J[GTM_NF * GTM_NT], A[GTM_NF * GTM_NF];
        gtm_trim_jacobian(y, at, F, J);
        const double norm = gtm_residual_norm(F);
        if (!isfinite(norm)) return 1;
        if (norm < converged) return 0;
        worse = norm < 0.9 * best ? 0 : worse + 1;
        if (norm < best) best = norm;
        if (worse > 8) return norm < 1e-9 ? 0 : 1; /* rounding floor, or hopping across a kink */
        for (int i = 0; i < GTM_NF; i++)
            for (int k = 0; k < GTM_NF; k++) A[i * GTM_NF + k] = J[i * GTM_NT + free_one[k]];
        if (gtm_solve(GTM_NF, A, F)) return 1;
        double shorten = 1;
        for (int k = 0; k < GTM_NF; k++) {
            const double length = fabs(F[k]) / longest_step[free_one[k]];
            if (length * shorten > 1) shorten = 1 / length;
        }
        if (worse > 3) shorten *= 0.5;
        for (int k = 0; k < GTM_NF; k++) {
            const int i = free_one[k];
            y[i] = fmin(fmax(y[i] - shorten * F[k], least[i]), most[i]);
        }
    }
    return 1;
}

/* Rough trim of a point mass with linear lift and side force; guesses differ in sideslip per rudder, and in throttle:
   where ram drag eats a moderate thrust, its slope is zero and Newton needs a guess above. */
static void first_guess(double y[GTM_NT], const gtm_condition *at, const int held[3], double beta_per_rudder,
                        double throttle)
{
    static const double degree = 0.017453292519943295;
    static const double lift_0 = 0.2, lift_slope = 4.8, side_force_slope = 0.56;
    int is_held[GTM_NT] = {0};
    for (int k = 0; k < 3; k++) is_held[held[k]] = 1;

    const double force = 0.5 * at->density * y[V] * y[V] * gtm_wing_area;
    if (!is_held[RUDDER]) y[RUDDER] = y[BETA] / (0.7 * degree);
    if (!is_held[BETA]) y[BETA] = beta_per_rudder * degree * y[RUDDER];
    const double against_slip = asin(fmin(fmax(side_force_slope * force * y[BETA] / gtm_weight, -0.6), 0.6));
    if (!is_held[PHI]) y[PHI] = fmin(fmax(atan(y[V] * y[PSI_DOT] / gtm_gravity) + against_slip, -1.2), 1.2);
    if (!is_held[PSI_DOT]) y[PSI_DOT] = gtm_gravity * tan(y[PHI] - against_slip) / y[V];
    const double alpha = (gtm_weight / (force * cos(y[PHI])) - lift_0) / lift_slope;
    y[ALPHA] = fmin(fmax(alpha, -0.08), 0.2);
    y[ELEVATOR] = 3 - 0.5 * y[ALPHA] / degree;
    y[AILERON] = -0.6 * y[RUDDER];
    y[THROTTLE] = throttle;
}

int gtm_cold_newton(double y[GTM_NT], const gtm_condition *at, const int held[3])
{
    static const double beta_per_rudder[] = {0.7, 0.7, 0.4, 1, 0}, throttle[] = {50, 100, 100, 100, 100};
    double given[GTM_NT];
    memcpy(given, y, sizeof given);
    for (int guess = 0; guess < 5; guess++) {
        memcpy(y, given, sizeof given);
        first_guess(y, at, held, beta_per_rudder[guess], throttle[guess]);
        if (!gtm_newton(y, at, held)) return 0;
    }
    return 1;
}

double gtm_violation(const double y[GTM_NT], const double lower[GTM_NT], const double upper[GTM_NT])
{
    double violation = 0;
    for (int i = 0; i < GTM_NT; i++) {
        const double excess = fmax(lower[i] - y[i], y[i] - upper[i]) / gtm_scale[i];
        if (excess > violation) violation = excess;
    }
    return violation;
}

long gtm_cold_starts(double altitude, double gamma, long n, const double *held_values, double *y)
{
    static const int held[3] = {V, PHI, RUDDER};
    const gtm_condition at = gtm_condition_at(altitude, gamma);
    long found = 0;
    for (long i = 0; i < n; i++) {
        double *point = y + found * GTM_NT;
        memset(point, 0, GTM_NT * sizeof *point);
        for (int k = 0; k < 3; k++) point[held[k]] = held_values[i * 3 + k];
        if (!gtm_cold_newton(point, &at, held)) found++;
    }
    return found;
}

void gtm_trim_states(double altitude, double gamma, long n, const double *y, double *x, double *u)
{
    for (long i = 0; i < n; i++, y += GTM_NT) {
        cas_trim_state((const double *[]){y, &gamma, &altitude}, (double *[]){x + i * GTM_NX}, 0, 0, 0);
        memcpy(u + i * GTM_NU, y + ELEVATOR, GTM_NU * sizeof *u);
    }
}

/* Least |beta| under the bounds when neither the rudder nor beta = 0 settles it: the best of both signs. */
static int least_sideslip(double altitude, double gamma, const double *lower, const double *upper, double *y,
                          double *violation)
{
    const gtm_condition at = gtm_condition_at(altitude, gamma);
    static const int held[3] = {V, PSI_DOT, RUDDER};
    double starts[5 * GTM_NT];
    long n = 0;
    for (int k = 0; k < 5; k++) {
        double *start = starts + n * GTM_NT;
        memset(start, 0, GTM_NT * sizeof *start);
        start[V] = lower[V];
        start[PSI_DOT] = lower[PSI_DOT];
        start[RUDDER] = lower[RUDDER] + 0.25 * k * (upper[RUDDER] - lower[RUDDER]);
        if (!gtm_cold_newton(start, &at, held)) n++;
        if (lower[RUDDER] == upper[RUDDER]) break;
    }
    int status = GTM_NO_TRIM;
    for (int side = 0; side < 2; side++) {
        double one_sided[GTM_NT], other[GTM_NT], objective[GTM_NT] = {0}, point[GTM_NT], excess;
        memcpy(one_sided, lower, sizeof one_sided);
        memcpy(other, upper, sizeof other);
        if (side) {
            other[BETA] = fmin(other[BETA], 0);
            objective[BETA] = -1;
        } else {
            one_sided[BETA] = fmax(one_sided[BETA], 0);
            objective[BETA] = 1;
        }
        const int found = gtm_extreme(altitude, gamma, one_sided, other, objective, n, starts, point, &excess);
        if (found == GTM_NO_TRIM) continue;
        const int better = status == GTM_NO_TRIM || found < status ||
                           (found == status && (found == GTM_TRIMMED ? fabs(point[BETA]) < fabs(y[BETA])
                                                                     : excess < *violation));
        if (better) {
            memcpy(y, point, sizeof point);
            *violation = excess;
            status = found;
        }
    }
    return status;
}

static const double inside = 1e-9; /* of a scale unit: rounding, not a violation */

int gtm_trim(double altitude, double gamma, const double lower[GTM_NT], const double upper[GTM_NT],
             double y[GTM_NT], double *residual, double *violation)
{
    static const int rudder_held[3] = {V, PSI_DOT, RUDDER}, beta_held[3] = {V, PSI_DOT, BETA};
    const gtm_condition at = gtm_condition_at(altitude, gamma);
    const int jammed = lower[RUDDER] == upper[RUDDER];
    double F[GTM_NF];

    memset(y, 0, GTM_NT * sizeof *y);
    y[V] = lower[V];
    y[PSI_DOT] = lower[PSI_DOT];
    y[RUDDER] = jammed ? lower[RUDDER] : 0;
    int status = gtm_cold_newton(y, &at, jammed ? rudder_held : beta_held) ? GTM_NO_TRIM : GTM_OUTSIDE;
    if (status == GTM_OUTSIDE) {
        *violation = gtm_violation(y, lower, upper);
        if (*violation <= inside) status = GTM_TRIMMED;
    }
    if (status != GTM_TRIMMED) {
        /* With the rudder held the manifold point is unique; otherwise another sideslip may lie inside the bounds. */
        double other[GTM_NT], excess;
        const int found = jammed && status == GTM_OUTSIDE ? GTM_NO_TRIM
                                                          : least_sideslip(altitude, gamma, lower, upper, other, &excess);
        if (found != GTM_NO_TRIM) {
            memcpy(y, other, sizeof other);
            *violation = excess;
            status = found;
        }
    }
    if (status == GTM_NO_TRIM) *violation = gtm_violation(y, lower, upper);
    gtm_trim_residual(y, &at, F);
    *residual = gtm_residual_norm(F);
    return status;
}

void gtm_trim_batch(long n, const double *altitude, const double *gamma, const double *lower, const double *upper,
                    double *y, double *residual, double *violation, int *status)
{
    for (long i = 0; i < n; i++)
        status[i] = gtm_trim(altitude[i], gamma[i], lower + i * GTM_NT, upper + i * GTM_NT, y + i * GTM_NT,
                             residual + i, violation + i);
}
