#include "solver/newton.h"

#include <math.h>

#include "solver/linear_algebra.h"

static const double converged = 1e-11; /* largest acceleration, ft/s^2 and rad/s^2 */
static const double nearly = 1e-4;     /* so near, one more step converges */
static const double floor_of_rounding = 1e-9;
enum { MOST_ITERATIONS = 40, MOST_WORSE = 8, MOST_STOPPED = 4 };

int gtm_keeps(const gtm_problem *p, const int held[3], int *is_kept)
{
    int count = p->unknowns;
    for (int i = 0; i < p->unknowns; i++) {
        is_kept[i] = p->is_dead[i];
        count -= is_kept[i];
    }
    if (gtm_has_free_throttles(p)) count--;
    for (int k = 0; k < 3 && count > GTM_NF; k++)
        if (!is_kept[held[k]]) {
            is_kept[held[k]] = 1;
            count--;
        }
    return count == GTM_NF;
}

int gtm_newton(const gtm_problem *p, double *y, const int held[3])
{
    const gtm_aircraft *aircraft = p->aircraft;
    const int n = p->unknowns;
    int is_kept[GTM_MOST_UNKNOWNS], free_one[GTM_MOST_UNKNOWNS], moving = 0;
    if (!gtm_keeps(p, held, is_kept)) return 1;
    for (int i = 0; i < n; i++)
        if (!is_kept[i]) free_one[moving++] = i;
    const int is_joined = moving > GTM_NF; /* the throttles, which come last */

    double best = INFINITY;
    int worse = 0, stopped = 0; /* iterations one after the other: without progress, at the end of a range */
    for (int iteration = 0; iteration < MOST_ITERATIONS; iteration++) {
        double F[GTM_NF + 1], J[GTM_NF * GTM_MOST_UNKNOWNS], A[GTM_NF * GTM_NF];
        if (best < nearly) { /* this is the end unless a kink is in the way, and needs no slopes */
            aircraft->residual(p, y, F);
            if (gtm_residual_norm(F) < converged) return 0;
        }
        aircraft->jacobian(p, y, F, J);
        const double norm = gtm_residual_norm(F);
        if (!isfinite(norm)) return 1;
        if (norm < converged) return 0;
        worse = norm < 0.9 * best ? 0 : worse + 1;
        if (norm < best) best = norm;
        if (worse > MOST_WORSE) return norm < floor_of_rounding ? 0 : 1; /* else it hops across a kink */
        for (int i = 0; i < GTM_NF; i++) {
            for (int k = 0; k < GTM_NF; k++) A[i * GTM_NF + k] = J[i * n + free_one[k]];
            if (is_joined) A[i * GTM_NF + GTM_NF - 1] += J[i * n + THROTTLE_RIGHT];
        }
        if (gtm_solve(GTM_NF, A, F)) return 1;
        F[GTM_NF] = F[GTM_NF - 1];
        /* A step is limited and its result clamped, so that a bad guess stays where the tables mean something. */
        double shorten = 1;
        for (int k = 0; k < GTM_NF; k++) {
            const double length = fabs(F[k]) / aircraft->longest_step[free_one[k]];
            if (length * shorten > 1) shorten = 1 / length;
        }
        if (worse > 3) shorten *= 0.5;
        int is_stopped = 0;
        for (int k = 0; k < moving; k++) {
            const int i = free_one[k];
            const double most = i == ALPHA ? p->highest_alpha : aircraft->most[i];
            const double before = y[i];
            y[i] = fmin(fmax(before - shorten * F[k], aircraft->least[i]), most);
            is_stopped |= y[i] == before && F[k] != 0;
        }
        stopped = is_stopped ? stopped + 1 : 0;
        if (stopped > MOST_STOPPED) return 1;
    }
    return 1;
}
