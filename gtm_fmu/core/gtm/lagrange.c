#include "gtm/lagrange.h"

double gtm_lagrange(long n, const double *nodes, long i, double x)
{
    double product = 1;
    for (long j = 0; j < n; j++)
        if (j != i) product *= (x - nodes[j]) / (nodes[i] - nodes[j]);
    return product;
}
