/* A fitted model: its outputs, their standard deviations where it has them, whether the inputs are in its domain, and
   safe values where it was calibrated. */
#include <string.h>

#include "form.h"
#include "model.h"

/* The safe values come last, after the flag. */
#if form_has_safe
enum { SAFE = N_OUTPUTS - form_safe_outputs };
#else
enum { SAFE = N_OUTPUTS };
#endif

int model_outputs(const double x[], const double u[], const double values[], double memory[], double y[])
{
    (void)x, (void)values, (void)memory;
    form_predict(u, y);
    y[SAFE - 1] = form_in_range(u, ROUNDING);
#if form_has_safe
    form_safe(y, y + SAFE);
#endif
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
#if form_has_safe
    static const int places[] = form_safe_places; /* of the outputs that are moved by constant margins */
    for (int k = 0; k < form_safe_outputs; k++)
        memcpy(jacobian + (SAFE + k) * N_KNOWNS, jacobian + places[k] * N_KNOWNS, N_KNOWNS * sizeof *jacobian);
#endif
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
