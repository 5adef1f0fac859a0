/* Nanoseconds of a step of 0.01 s: the model alone, and through the FMI 2.0 functions with inputs set and states read. */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "fmi2Functions.h"
#include "model.h"

enum { STEPS = 100000, ROUNDS = 7 };
static const double DURATION = 0.01;

static double seconds(void) { return (double)clock() / CLOCKS_PER_SEC; }

static double model_alone(void)
{
    double values[N_VARIABLES], x[N_STATES], u[N_INPUTS], memory[ROOM(N_MEMORY)] = {0};
    for (int v = 0; v < N_VARIABLES; v++) values[v] = model_variables[v].start;
    for (int k = 0; k < N_STATES; k++) x[k] = values[STATES + k] / model_variables[STATES + k].scale;
    for (int k = 0; k < N_INPUTS; k++) u[k] = values[INPUTS + k] / model_variables[INPUTS + k].scale;
    const double start = seconds();
    for (int n = 0; n < STEPS; n++)
        if (model_advance(x, u, values, memory, DURATION)) exit(1);
    return seconds() - start;
}

static double through_fmi(void)
{
    const fmi2CallbackFunctions callbacks = {NULL, NULL, NULL, NULL, NULL};
    fmi2Component c = fmi2Instantiate("one", fmi2CoSimulation, MODEL_TOKEN, "", &callbacks, 0, 0);
    unsigned inputs[N_INPUTS], states[N_STATES];
    double u[N_INPUTS], x[N_STATES];
    for (unsigned k = 0; k < N_INPUTS; k++) u[k] = model_variables[inputs[k] = INPUTS + k].start;
    for (unsigned k = 0; k < N_STATES; k++) states[k] = STATES + k;
    fmi2SetupExperiment(c, 0, 0, 0, 0, 0);
    fmi2EnterInitializationMode(c);
    fmi2ExitInitializationMode(c);
    const double start = seconds();
    for (int n = 0; n < STEPS; n++) {
        fmi2SetReal(c, inputs, N_INPUTS, u);
        if (fmi2DoStep(c, n * DURATION, DURATION, fmi2True)) exit(1);
        fmi2GetReal(c, states, N_STATES, x);
    }
    const double taken = seconds() - start;
    fmi2FreeInstance(c);
    return taken;
}

int main(void)
{
    double alone = 1e9, fmi = 1e9;
    for (int round = 0; round < ROUNDS; round++) {
        const double a = model_alone(), f = through_fmi();
        if (a < alone) alone = a;
        if (f < fmi) fmi = f;
    }
    printf("%.1f %.1f\n", 1e9 * alone / STEPS, 1e9 * fmi / STEPS);
    return 0;
}
