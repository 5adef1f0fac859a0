#include "gtm/condition.h"

#include "generated/atmosphere.h"

gtm_condition gtm_condition_at(double altitude, double gamma)
{
    gtm_condition at = {gamma, 0, 0};
    const double *given[] = {&altitude};
    double *found[] = {&at.density, &at.pressure_ratio};
    cas_atmosphere(given, found, 0, 0, 0);
    return at;
}
