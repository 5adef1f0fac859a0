/* The flight dynamics of the GTM-T2: the compiled core behind the wrappers. */
#include "dormand_prince.h"
#include "gtm_core.h"
#include "model.h"

/* The fault after those of enum gtm_fault. */
enum { FAULT_TOLERANCE_MISSED = GTM_BAD_STEP + 1 };

int model_derivatives(const double x[], const double u[], const double values[], const double memory[], double dx[])
{
    (void)values, (void)memory;
    const int fault = gtm_state_fault(x);
    if (!fault) gtm_derivatives(x, u, dx);
    return fault;
}

int model_outputs(const double x[], const double u[], const double values[], double memory[], double y[])
{
    (void)values, (void)memory;
    const int fault = gtm_state_fault(x);
    if (!fault) gtm_outputs(x, u, y);
    return fault;
}

int model_jacobian(const double x[], const double u[], const double values[], double memory[], double jacobian[])
{
    (void)values, (void)memory;
    double dx[N_STATES], y[N_OUTPUTS];
    const int fault = gtm_state_fault(x);
    if (fault) return fault;
    gtm_jacobian(x, u, dx, jacobian);
    gtm_outputs_jacobian(x, u, y, jacobian + N_STATES * N_KNOWNS);
    return 0;
}

int model_advance(double x[], const double u[], const double values[], double memory[], double duration)
{
    const double tolerance = values[SOLVER_TOLERANCE];
    if (!(tolerance > 0)) return gtm_advance(x, u, duration, values[SOLVER_SUBSTEP]);
    double size[N_STATES];
    for (int k = 0; k < N_STATES; k++) size[k] = model_variables[STATES + k].nominal / model_variables[STATES + k].scale;
    return dormand_prince(x, u, values, memory, duration, tolerance, size, FAULT_TOLERANCE_MISSED);
}
