/* V_min and V_max of a flight condition after a failure, by the core, and how far a speed is inside. */
#include <string.h>

#include "gtm_failure.h"
#include "model.h"

/* Inputs and outputs by their places in u and y. */
#define IN(name) ((name) - INPUTS)
#define OUT(name) ((name) - OUTPUTS)

/* The core takes the inputs as they are: the flight condition, and after the speed the failure. */
enum { CASE = sizeof(gtm_failure_case) / sizeof(double), FAILURE = IN(TAS) + 1, N_FAILURE = sizeof(gtm_failure) / sizeof(double) };
typedef char the_speed_is_between[CASE == IN(TAS) ? 1 : -1];
typedef char inputs_fit[FAILURE + N_FAILURE == N_INPUTS ? 1 : -1];

/* Places in the memory: the inputs last asked for, and what they gave. */
typedef enum { IS_FILLED, ASKED, LOWEST = ASKED + N_INPUTS, HIGHEST, EXISTS, END } Place;
typedef char memory_fits[(int)END == (int)N_MEMORY ? 1 : -1];

/* Whether nothing but the speed has changed. */
static int is_known(const double memory[], const double u[])
{
    return memory[IS_FILLED] && !memcmp(memory + ASKED, u, CASE * sizeof *u) &&
           !memcmp(memory + ASKED + FAILURE, u + FAILURE, N_FAILURE * sizeof *u);
}

static int find(const double u[], double memory[])
{
    double speed[2];
    int exists;
    const int fault = gtm_failure_envelope((const gtm_failure_case *)u, (const gtm_failure *)(u + FAILURE), model_lower,
                                           model_upper, speed, &exists);
    if (fault) return fault;
    memory[LOWEST] = speed[0];
    memory[HIGHEST] = speed[1];
    memory[EXISTS] = exists;
    memcpy(memory + ASKED, u, N_INPUTS * sizeof *u);
    memory[IS_FILLED] = 1;
    return 0;
}

int model_outputs(const double x[], const double u[], const double values[], double memory[], double y[])
{
    (void)x, (void)values;
    const int fault = is_known(memory, u) ? 0 : find(u, memory);
    if (fault) return fault;
    y[OUT(V_MIN)] = memory[LOWEST];
    y[OUT(V_MAX)] = memory[HIGHEST];
    y[OUT(V_MIN_STD)] = y[OUT(V_MAX_STD)] = 0;
    y[OUT(FEASIBLE)] = memory[EXISTS];
    y[OUT(IN_DOMAIN)] = 1;
    y[OUT(MARGIN_SLOW)] = u[IN(TAS)] - memory[LOWEST];
    y[OUT(MARGIN_FAST)] = memory[HIGHEST] - u[IN(TAS)];
    return 0;
}
