/* A model whose outputs are all computed at once. */
#include "model.h"

int model_deferred_outputs(const double x[], const double u[], const double values[], double memory[], double y[])
{
    (void)x, (void)u, (void)values, (void)memory, (void)y;
    return 0;
}

int model_deferred_jacobian(const double x[], const double u[], const double values[], double memory[],
                            double jacobian[])
{
    (void)x, (void)u, (void)values, (void)memory, (void)jacobian;
    return 0;
}
