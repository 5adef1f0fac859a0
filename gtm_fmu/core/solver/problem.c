#include "solver/problem.h"

#include <math.h>

const double gtm_rounding = 1e-9;

double gtm_residual_norm(const double F[GTM_NF])
{
    double norm = 0;
    for (int i = 0; i < GTM_NF; i++) {
        if (!(fabs(F[i]) <= norm)) norm = fabs(F[i]);
    }
    return norm;
}

double gtm_violation(const gtm_problem *p, const double *y, const double *lower, const double *upper)
{
    const double *scale = p->aircraft->scale;
    double violation = 0;
    for (int i = 0; i < p->unknowns; i++) {
        const double excess = fmax(lower[i] - y[i], y[i] - upper[i]) / scale[i];
        if (excess > violation) violation = excess;
    }
    return violation;
}

int gtm_has_free_throttles(const gtm_problem *p)
{
    return p->throttles == GTM_TWO_THROTTLES && !p->is_dead[THROTTLE] && !p->is_dead[THROTTLE_RIGHT];
}

int gtm_rudder_settles(const gtm_problem *p, const double *lower, const double *upper)
{
    return lower[RUDDER] == upper[RUDDER] && !gtm_has_free_throttles(p);
}
