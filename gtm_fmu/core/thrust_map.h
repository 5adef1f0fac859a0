/* The thrust map of a control that is jammed or restricted: envelopes by interpolation instead of by search.

   At a given equivalent airspeed and flight-path angle a steady manoeuvre needs nearly the same gross thrust at every
   altitude, while the engines give theirs in proportion to the pressure (SPEC 6). So the map tabulates, over the jammed
   deflection, the range of equivalent airspeeds that the other limits leave and the least gross thrust over it. V_min
   and V_max are where that meets the thrust available, or the ends of the range. */
#ifndef GTM_THRUST_MAP_H
#define GTM_THRUST_MAP_H

#include "gtm_core.h"

enum { GTM_MAP_DEFLECTIONS = 128, GTM_MAP_SPEEDS = 128 }; /* at most */

typedef struct {
    long densities, paths, deflections, speeds;
    const double *density;    /* ratio to that at sea level */
    const double *gamma;      /* deg */
    const double *deflection; /* deg, rising: the nodes where the reach is from the first to the last of them */
    const double *reach;      /* [density][gamma][2]: least and greatest deflection in deg that some manoeuvre has at any
                                 thrust; the nodes lie between them in the same proportions */
    const float *table;       /* [density][gamma][deflection][2 + speeds]: slowest and fastest EAS in kn, and thrusts in
                                 lbf from one to the other, the roots of the steps above the slowest evenly spaced */
    double full_thrust;       /* lbf, of both engines at sea level */
    double tolerance;         /* lbf, of the thrusts, and how many standard deviations of theirs it is */
    double tolerance_deviations;
    double bend_share;        /* standard deviation of the slowest speed between deflections, of its bend there */
    double least_deviation;   /* kn EAS, of V_min and of V_max */
    double reach_tolerance;   /* deg, of the reach where that is not every deflection */
} gtm_thrust_map;

typedef struct {
    double v_min, v_max;         /* true airspeed in kn; 0 without an envelope */
    double v_min_std, v_max_std; /* standard deviations in kn */
    double spare_thrust;         /* lbf left where the least thrust is needed; an envelope exists from 0 on; -infinity
                                    where no thrust is enough */
    double is_fold;              /* 1 if inside the tolerances an end jumps or the envelope vanishes, else 0 */
} gtm_map_envelope;

/* Envelopes of n cases, rows of altitude in ft, gamma in deg, lower and upper limit of the control in deg: finite
   numbers, the lower limit not above the upper one, both from the first to the last deflection. */
GTM_API void gtm_map_envelopes(const gtm_thrust_map *map, long n, const double *cases, gtm_map_envelope *found);

enum { GTM_MAP_GROUPS = 4, GTM_MAP_ENDS = 2 };

typedef struct {
    double v_min, v_max; /* true airspeed in kn; infinity and -infinity where nothing is promised */
} gtm_safe_ends;

/* The groups of n cases: bit 0 a range of the control, bit 1 a fold; -1 where the thrust to spare is within the
   tolerance, so that it is in doubt whether there is an envelope at all. */
GTM_API void gtm_map_groups(const gtm_thrust_map *map, long n, const double *cases, const gtm_map_envelope *found,
                            long *group);

/* Ends of n envelopes that `gtm_map_envelopes` found, moved inwards by the margins of their groups, in standard
   deviations: [group][V_min, V_max], infinite where nothing can be promised. */
GTM_API void gtm_map_safe_ends(const gtm_thrust_map *map, const double *margins, long n, const double *cases,
                               const gtm_map_envelope *found, gtm_safe_ends *safe);

#endif
