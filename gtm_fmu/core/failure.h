/* What questions under a failure and their slopes share. */
#ifndef FAILURE_H
#define FAILURE_H

#include "gtm_failure.h"

/* Bounds and airframe of a case; of a manoeuvre with its speed held, or its turn rate as well. */
int gtm_take_case(const gtm_failure_case *at, const gtm_failure *f, const double lower[GTM_NT],
                  const double upper[GTM_NT], gtm_remainder *left);
int gtm_take_speed(const gtm_failure_manoeuvre *at, const gtm_failure *f, const double lower[GTM_NT],
                   const double upper[GTM_NT], gtm_remainder *left);
int gtm_take_manoeuvre(const gtm_failure_manoeuvre *at, const gtm_failure *f, const double lower[GTM_NT],
                       const double upper[GTM_NT], gtm_remainder *left);

/* The unknowns that an answer tells margins of. */
extern const int gtm_limited[GTM_LIMITED];

#endif
