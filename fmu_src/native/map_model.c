/* V_min and V_max of a flight condition with a failed control, by its thrust map, how far a speed is inside, and speeds
   that are safe to use. */
#include <math.h>
#include <string.h>

#include "map.h"
#include "model.h"

/* The fault after FAULT_NOT_FINITE. */
enum { FAULT_REVERSED = 2 };

/* A case, which is the first inputs: altitude, gamma, limits of the control. */
enum { LOWER = 2, UPPER, CASE };

/* Inputs and outputs by their places in u and y. */
#define IN(name) ((name) - INPUTS)
#define OUT(name) ((name) - OUTPUTS)

static int is_inside(const double given[CASE])
{
    for (int k = 0; k < CASE; k++) {
        const double slack = ROUNDING * (model_upper[k] - model_lower[k]);
        if (given[k] < model_lower[k] - slack || given[k] > model_upper[k] + slack) return 0;
    }
    return 1;
}

int model_outputs(const double x[], const double u[], const double values[], double memory[], double y[])
{
    (void)x, (void)values, (void)memory;
    if (u[LOWER] > u[UPPER]) return FAULT_REVERSED;
    double asked[CASE];
    memcpy(asked, u, sizeof asked);
    y[OUT(IN_DOMAIN)] = is_inside(asked);
    for (int k = LOWER; k <= UPPER; k++) /* a rounding beyond the map's deflections */
        asked[k] = fmin(fmax(asked[k], model_lower[k]), model_upper[k]);
    gtm_map_envelope found;
    gtm_map_envelopes(&map, 1, asked, &found);
    y[OUT(V_MIN)] = found.v_min;
    y[OUT(V_MAX)] = found.v_max;
    y[OUT(FEASIBLE)] = found.spare_thrust >= 0;
    const int is_known = y[OUT(IN_DOMAIN)] || !y[OUT(FEASIBLE)];
    y[OUT(V_MIN_STD)] = is_known ? found.v_min_std : model_unknown_std_kt[0];
    y[OUT(V_MAX_STD)] = is_known ? found.v_max_std : model_unknown_std_kt[0];
    y[OUT(MARGIN_SLOW)] = u[IN(TAS)] - found.v_min;
    y[OUT(MARGIN_FAST)] = found.v_max - u[IN(TAS)];
    y[OUT(FOLD)] = found.is_fold;
    gtm_safe_ends safe = {INFINITY, -INFINITY};
    if (y[OUT(IN_DOMAIN)]) gtm_map_safe_ends(&map, map_margins, 1, asked, &found, &safe);
    y[OUT(FEASIBLE_SAFE)] = isfinite(safe.v_min);
    y[OUT(V_MIN_SAFE)] = y[OUT(FEASIBLE_SAFE)] ? safe.v_min : model_unknown_std_kt[0];
    y[OUT(V_MAX_SAFE)] = y[OUT(FEASIBLE_SAFE)] ? safe.v_max : 0;
    return 0;
}
