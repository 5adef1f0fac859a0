/* The linear model at a trim, as far as stability and controllability go. */
#ifndef GTM_LINEAR_MODEL_H
#define GTM_LINEAR_MODEL_H

#include "gtm_manoeuvres.h"
#include "solver/stability.h"

/* Of a trim y; the inputs are the controls whose bounds leave them a range. At a breakpoint of the tables slopes have
   two sides: what is said holds on every combination of the sides of all breakpoints that the trim lies on. */
gtm_verdict gtm_judge_trim(const gtm_configuration *c, enum gtm_throttles throttles, double altitude, double gamma,
                           const double *lower, const double *upper, const double *y);

#endif
