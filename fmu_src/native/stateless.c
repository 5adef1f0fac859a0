/* A model without states: nothing moves, its outputs follow the inputs at once. */
#include "model.h"

int model_derivatives(const double x[], const double u[], const double values[], const double memory[], double dx[])
{
    (void)x, (void)u, (void)values, (void)memory, (void)dx;
    return 0;
}

int model_advance(double x[], const double u[], const double values[], double memory[], double duration)
{
    (void)x, (void)u, (void)values, (void)memory, (void)duration;
    return 0;
}
