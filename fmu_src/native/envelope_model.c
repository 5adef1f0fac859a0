/* V_min and V_max of a flight condition after a failure, by the core, and how far a speed is inside. */
#include <string.h>

#include "generated/unknowns.h"
#include "gtm_failure.h"
#include "model.h"

/* Inputs and outputs by their places in u and y. */
#define IN(name) ((name) - INPUTS)
#define OUT(name) ((name) - OUTPUTS)

/* The core takes the inputs as they are: the flight condition, and after the speed the failure. */
enum { CASE = sizeof(gtm_failure_case) / sizeof(double), FAILURE = IN(TAS) + 1, N_FAILURE = sizeof(gtm_failure) / sizeof(double) };
typedef char the_speed_is_between[CASE == IN(TAS) ? 1 : -1];
typedef char inputs_fit[FAILURE + N_FAILURE == N_INPUTS ? 1 : -1];

/* Places in the memory: the inputs last asked for, the trims at both ends that they gave, and what the next ones may be
   followed from. */
enum { N_KNOWN = sizeof(gtm_envelope_memory) / sizeof(double) };
typedef enum {
    IS_FILLED,
    ASKED,
    ENDS = ASKED + N_INPUTS,
    KNOWN = ENDS + 2 * GTM_TWO_THROTTLE_NT,
    END = KNOWN + N_KNOWN
} Place;
typedef char memory_fits[(int)END == (int)N_MEMORY ? 1 : -1];
typedef double Trim[GTM_TWO_THROTTLE_NT];

/* Whether nothing but the speed has changed. */
static int is_known(const double memory[], const double u[])
{
    return memory[IS_FILLED] && !memcmp(memory + ASKED, u, CASE * sizeof *u) &&
           !memcmp(memory + ASKED + FAILURE, u + FAILURE, N_FAILURE * sizeof *u);
}

/* Find the ends if they are not known yet. */
static int find(const double u[], double memory[])
{
    if (is_known(memory, u)) return 0;
    const int fault = gtm_failure_envelope((const gtm_failure_case *)u, (const gtm_failure *)(u + FAILURE), model_lower,
                                           model_upper, (gtm_envelope_memory *)(memory + KNOWN), (Trim *)(memory + ENDS));
    if (fault) return fault; /* the ends known before stay */
    memory[IS_FILLED] = 1;
    memcpy(memory + ASKED, u, N_INPUTS * sizeof *u);
    return 0;
}

int model_outputs(const double x[], const double u[], const double values[], double memory[], double y[])
{
    (void)x, (void)values;
    const int fault = find(u, memory);
    if (fault) return fault;
    const Trim *const end = (const Trim *)(memory + ENDS);
    y[OUT(V_MIN)] = end[0][V];
    y[OUT(V_MAX)] = end[1][V];
    y[OUT(V_MIN_STD)] = y[OUT(V_MAX_STD)] = 0;
    y[OUT(FEASIBLE)] = end[0][V] > 0;
    y[OUT(IN_DOMAIN)] = 1;
    y[OUT(MARGIN_SLOW)] = u[IN(TAS)] - end[0][V];
    y[OUT(MARGIN_FAST)] = end[1][V] - u[IN(TAS)];
    return 0;
}

/* Slopes of an output: a sign times those of an end, and one with respect to the speed. */
static void put_row(double jacobian[], int output, double sign, const double slopes[GTM_TOLD], double of_tas)
{
    double *const row = jacobian + output * N_KNOWNS;
    for (int k = 0; k < GTM_TOLD; k++) row[k < CASE ? k : k + FAILURE - CASE] = sign * slopes[k];
    row[IN(TAS)] = of_tas;
}

int model_jacobian(const double x[], const double u[], const double values[], double memory[], double jacobian[])
{
    (void)x, (void)values;
    double slopes[2][GTM_TOLD];
    int fault = find(u, memory);
    if (!fault)
        fault = gtm_failure_envelope_slopes((const gtm_failure_case *)u, (const gtm_failure *)(u + FAILURE), model_lower,
                                            model_upper, (const Trim *)(memory + ENDS), slopes);
    if (fault) return fault;
    memset(jacobian, 0, N_UNKNOWNS * N_KNOWNS * sizeof *jacobian);
    put_row(jacobian, OUT(V_MIN), 1, slopes[0], 0);
    put_row(jacobian, OUT(V_MAX), 1, slopes[1], 0);
    put_row(jacobian, OUT(MARGIN_SLOW), -1, slopes[0], 1);
    put_row(jacobian, OUT(MARGIN_FAST), 1, slopes[1], -1);
    return 0;
}
