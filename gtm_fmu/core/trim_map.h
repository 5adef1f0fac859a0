/* The trim map: envelopes with limits of every control, by interpolation in one table of trims instead of by search.

   At a given altitude and flight path the trims of the airframe form one manifold of three dimensions, whatever has
   failed; a failure only says which part of it is left. Angle of attack, bank and rudder are its coordinates: each point
   of them has one trim. The map tabulates over them what the limits ask about. V_min and V_max are the extremes over the
   part that is left of the interpolated manifold, found exactly, so that wider limits never shrink an envelope.

   What is tabulated hardly bends: 1 / EAS^2, which is lift over weight, and thrust / EAS^2, which is drag; and at a given
   EAS it hardly depends on the density, for only the rate of turn knows it. */
#ifndef GTM_TRIM_MAP_H
#define GTM_TRIM_MAP_H

#include "gtm_core.h"

enum { GTM_LOADING, GTM_DRAG, GTM_TRIM_ELEVATOR, GTM_TRIM_AILERON, GTM_TRIM_VALUES };

typedef struct {
    long densities, paths, alphas, banks, rudders;
    const double *density;                  /* ratio to that at sea level */
    const double *gamma;                    /* deg */
    const double *alpha, *bank, *rudder;    /* deg, rising */
    const float *table;                     /* [density][gamma][alpha][bank][rudder][GTM_TRIM_VALUES]: 1 / EAS^2 in
                                               1/kn^2, gross thrust of both engines / EAS^2 in lbf/kn^2, deg, deg */
} gtm_trim_map;

/* Lower and upper limits; those of the thrust at sea level, in lbf. */
typedef struct {
    double altitude, gamma;                 /* ft, deg */
    double alpha[2], bank[2];               /* deg */
    double elevator[2], aileron[2], rudder[2];
    double thrust[2];
} gtm_trim_map_case;

/* Numbers of memory that a map needs for its values at one altitude and path. */
GTM_API long gtm_trim_map_memory(const gtm_trim_map *map);

/* V_min and V_max in kn true airspeed of n cases; zeros without an envelope. Cases of equal altitude and path that
   follow each other share their values. */
GTM_API void gtm_trim_map_envelopes(const gtm_trim_map *map, long n, const gtm_trim_map_case *cases, double *memory,
                                    double (*speeds)[2]);

#endif
