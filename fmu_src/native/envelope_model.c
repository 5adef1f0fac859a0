/* V_min and V_max of a flight condition with a failed rudder, by the core, and how far a speed is inside. */
#include <math.h>
#include <string.h>

#include "generated/unknowns.h"
#include "gtm_manoeuvres.h"
#include "model.h"

/* The fault after FAULT_NOT_FINITE. */
enum { FAULT_REVERSED = 2 };

/* Places in the memory: the condition last asked for, and what it gave. */
enum { CONDITION = 4 };
typedef enum { IS_FILLED, ASKED, LOWEST = ASKED + CONDITION, HIGHEST, EXISTS } Place;

/* Inputs and outputs by their places in u and y. */
#define IN(name) ((name) - INPUTS)
#define OUT(name) ((name) - OUTPUTS)

static int find_end(const double u[], double sign, double *speed)
{
    double lower[GTM_NT], upper[GTM_NT], objective[GTM_NT] = {0}, best[GTM_NT] = {0}, violation;
    memcpy(lower, model_lower, sizeof lower);
    memcpy(upper, model_upper, sizeof upper);
    lower[RUDDER] = u[IN(RUDDER_LOWER)];
    upper[RUDDER] = u[IN(RUDDER_UPPER)];
    objective[V] = sign;
    const int status = gtm_envelope_end(0, GTM_ONE_THROTTLE, u[IN(ALTITUDE)], u[IN(GAMMA)], lower, upper, objective, best,
                                        &violation);
    *speed = best[V];
    return status == GTM_TRIMMED;
}

int model_outputs(const double x[], const double u[], const double values[], double memory[], double y[])
{
    (void)x, (void)values;
    if (u[IN(RUDDER_LOWER)] > u[IN(RUDDER_UPPER)]) return FAULT_REVERSED;
    if (!memory[IS_FILLED] || memcmp(memory + ASKED, u, CONDITION * sizeof *u)) {
        memory[EXISTS] = find_end(u, 1, memory + LOWEST) && find_end(u, -1, memory + HIGHEST);
        if (!memory[EXISTS]) memory[LOWEST] = memory[HIGHEST] = 0;
        memcpy(memory + ASKED, u, CONDITION * sizeof *u);
        memory[IS_FILLED] = 1;
    }
    y[OUT(V_MIN)] = memory[LOWEST];
    y[OUT(V_MAX)] = memory[HIGHEST];
    y[OUT(V_MIN_STD)] = y[OUT(V_MAX_STD)] = 0;
    y[OUT(FEASIBLE)] = memory[EXISTS];
    y[OUT(IN_DOMAIN)] = 1;
    y[OUT(MARGIN_SLOW)] = u[IN(TAS)] - memory[LOWEST];
    y[OUT(MARGIN_FAST)] = memory[HIGHEST] - u[IN(TAS)];
    return 0;
}
