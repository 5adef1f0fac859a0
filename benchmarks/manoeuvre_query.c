/* Microseconds of a question to GtmManoeuvreNative by FMI 2.0: new speed and turn rate set; verdict, margins and trim read.
   First with a jammed rudder, then with a range of it, both in rad. */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "fmi2Functions.h"
#include "model.h"

enum { QUESTIONS = 20000, ROUNDS = 5, TOLD = TRIM_THRUST - MARGIN_ALPHA_LOWER + 1 };
static const double RUDDER[2][2] = {{0.07, 0.07}, {0.07, 0.35}};

static double microseconds(fmi2Component c, const double rudder[2])
{
    const unsigned limits[] = {LIMITS_RUDDER_LOWER, LIMITS_RUDDER_UPPER}, asked[] = {TAS, TURN_RATE}, verdict[] = {FEASIBLE};
    unsigned told[TOLD];
    double values[TOLD];
    int feasible, found = 0;
    for (unsigned k = 0; k < TOLD; k++) told[k] = MARGIN_ALPHA_LOWER + k;
    fmi2SetReal(c, limits, 2, rudder);
    srand(1);
    const double start = (double)clock() / CLOCKS_PER_SEC;
    for (int n = 0; n < QUESTIONS; n++) {
        const double given[] = {35 + 30.0 * rand() / RAND_MAX, -0.1 + 0.2 * rand() / RAND_MAX};
        fmi2SetReal(c, asked, 2, given);
        if (fmi2GetReal(c, told, TOLD, values)) exit(1);
        if (fmi2GetBoolean(c, verdict, 1, &feasible)) exit(1);
        found += feasible;
    }
    const double taken = (double)clock() / CLOCKS_PER_SEC - start;
    if (found < QUESTIONS / 10) exit(2);
    return 1e6 * taken / QUESTIONS;
}

int main(void)
{
    const fmi2CallbackFunctions callbacks = {NULL, NULL, NULL, NULL, NULL};
    fmi2Component c = fmi2Instantiate("one", fmi2CoSimulation, MODEL_TOKEN, "", &callbacks, 0, 0);
    fmi2SetupExperiment(c, 0, 0, 0, 0, 0);
    fmi2EnterInitializationMode(c);
    fmi2ExitInitializationMode(c);
    for (int kind = 0; kind < 2; kind++) {
        double best = 1e9;
        for (int round = 0; round < ROUNDS; round++) {
            const double taken = microseconds(c, RUDDER[kind]);
            if (taken < best) best = taken;
        }
        printf("%.2f ", best);
    }
    fmi2FreeInstance(c);
    return 0;
}
