/* Trims just beyond an end of the envelope: at one speed all else follows from bank and deflection, so a grid over these
   two shows every region where the limits are nearly kept. */
#ifndef GTM_BEYOND_H
#define GTM_BEYOND_H

#include "solver/problem.h"

enum { GTM_MOST_BANKS = 32, GTM_MOST_RUDDERS = 48 };

/* A grid: banks and deflections, both rising. */
typedef struct {
    int banks, rudders;
    double bank[GTM_MOST_BANKS], rudder[GTM_MOST_RUDDERS];
} gtm_mesh;

/* Whether bank, deflection and speed settle a trim, so that such a grid holds them all. */
int gtm_can_look_beyond(const gtm_problem *p);

/* Rows (V, phi, rudder) at this speed where the bounds are exceeded less than at the points of the grid around, and
   not by much; `end` is a trim near that speed. Returns their number, at most `most`. */
long gtm_look_beyond(const gtm_problem *p, const double *lower, const double *upper, const double *end, double speed,
                     const gtm_mesh *mesh, long most, double *rows);

#endif
