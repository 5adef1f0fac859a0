/* The GTM-T2 as the solver takes it: its constants, its six accelerations with their slopes, its breakpoints. */
#ifndef GTM_T2_H
#define GTM_T2_H

#include "gtm/condition.h"
#include "gtm_configuration.h"
#include "solver/problem.h"

/* A flight condition. The solver's view of it comes first: the solver hands it back to the aircraft's functions. */
typedef struct {
    gtm_problem problem;
    gtm_condition at;
    const gtm_configuration *configuration; /* 0: the study's */
} gtm_flight;

gtm_flight gtm_flight_at(const gtm_configuration *c, enum gtm_throttles throttles, double altitude, double gamma);

/* Bounds of the unknowns, which hold a dead control as near to zero as the given ones let it; alpha is allowed as far. */
typedef struct {
    double lower[GTM_MOST_UNKNOWNS], upper[GTM_MOST_UNKNOWNS];
} gtm_bounds;

gtm_bounds gtm_bounds_of(gtm_flight *flight, const double *lower, const double *upper);

/* All ten unknowns of a configuration. */
const double *gtm_with_both_throttles(enum gtm_throttles throttles, const double *y, double both[GTM_MOST_UNKNOWNS]);

/* Net thrust in lbf at speed V of the engines that run, with the throttles of y. */
double gtm_thrust(const gtm_flight *flight, double V_ft_s, const double *y);

#endif
