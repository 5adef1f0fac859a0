/* What the page asks the core for beside its public functions: structs from plain numbers. */
#include <stddef.h>

#include "gtm_configuration.h"
#include "thrust_map.h"

/* The configuration of a failure, completed; all flaps and all spoilers alike. Null if it is not allowed. Lives until
   the next call. */
GTM_API const gtm_configuration *explorer_configuration(int damage_case, double fuel_used, double stabilizer,
                                                        double gear, double flaps, double spoilers, int left_runs,
                                                        int right_runs)
{
    static gtm_configuration c;
    int i;
    gtm_study_configuration(&c);
    c.damage_case = damage_case;
    c.fuel_used = fuel_used;
    c.stabilizer = stabilizer;
    c.gear = gear;
    for (i = 0; i < GTM_FLAPS; i++)
        c.flap[i] = flaps;
    for (i = 0; i < GTM_SPOILERS; i++)
        c.spoiler[i] = spoilers;
    c.engine_running[0] = left_runs;
    c.engine_running[1] = right_runs;
    return gtm_configure(&c) == GTM_CONFIGURED ? &c : NULL;
}

/* The thrust map of a page. */
GTM_API const gtm_thrust_map *explorer_map(long densities, long paths, long deflections, long speeds,
                                           const double *density, const double *gamma, const double *deflection,
                                           const double *reach, const float *table, double full_thrust,
                                           double tolerance, double tolerance_deviations, double bend_share,
                                           double least_deviation, double reach_tolerance)
{
    static gtm_thrust_map map;
    map.densities = densities;
    map.paths = paths;
    map.deflections = deflections;
    map.speeds = speeds;
    map.density = density;
    map.gamma = gamma;
    map.deflection = deflection;
    map.reach = reach;
    map.table = table;
    map.full_thrust = full_thrust;
    map.tolerance = tolerance;
    map.tolerance_deviations = tolerance_deviations;
    map.bend_share = bend_share;
    map.least_deviation = least_deviation;
    map.reach_tolerance = reach_tolerance;
    return &map;
}
