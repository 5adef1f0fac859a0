/* A fitted model: its outputs, their standard deviations where it has them, and whether the inputs are in its domain. */
#include <string.h>

#include "form.h"
#include "model.h"

int model_outputs(const double x[], const double u[], const double values[], double memory[], double y[])
{
    (void)x, (void)values, (void)memory;
    form_predict(u, y);
    y[N_OUTPUTS - 1] = form_in_range(u, ROUNDING);
    return 0;
}

int model_deferred_outputs(const double x[], const double u[], const double values[], double memory[], double y[])
{
    (void)x, (void)u, (void)values, (void)memory, (void)y;
#if form_has_std
    form_std(u, y);
#endif
    return 0;
}

int model_jacobian(const double x[], const double u[], const double values[], double memory[], double jacobian[])
{
    (void)x, (void)values, (void)memory;
    double y[form_outputs];
    memset(jacobian, 0, N_UNKNOWNS * N_KNOWNS * sizeof *jacobian);
    form_gradient(u, y, jacobian);
    return 0;
}

int model_deferred_jacobian(const double x[], const double u[], const double values[], double memory[],
                            double jacobian[])
{
    (void)x, (void)u, (void)values, (void)memory, (void)jacobian;
#if form_has_std
    double y[form_outputs];
    form_std_gradient(u, y, jacobian + form_outputs * N_KNOWNS);
#endif
    return 0;
}
