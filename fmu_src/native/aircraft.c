/* The GTM-T2 as it flies: the core's simulation behind the wrappers. Its memory is that of the actuators. */
#include "gtm_simulation.h"
#include "model.h"

/* The first setting, and how many there are. */
enum { SETTINGS = LIMITS_ELEVATOR_LOWER, N_SETTINGS = sizeof(gtm_simulation_settings) / sizeof(double) };

/* The core takes the arrays of the wrappers as they are. */
typedef char inputs_fit[sizeof(gtm_simulation_inputs) == N_INPUTS * sizeof(double) ? 1 : -1];
typedef char outputs_fit[sizeof(gtm_simulation_outputs) == N_OUTPUTS * sizeof(double) ? 1 : -1];
typedef char memory_fits[sizeof(gtm_simulation_memory) == N_MEMORY * sizeof(double) ? 1 : -1];
typedef char states_fit[(int)GTM_SIMULATION_NX == (int)N_STATES ? 1 : -1];

static void load_settings(const double values[], double settings[N_SETTINGS])
{
    for (int k = 0; k < N_SETTINGS; k++) settings[k] = values[SETTINGS + k] / model_variables[SETTINGS + k].scale;
}

static int evaluate(const double x[], const double u[], const double values[], const double memory[], double dx[],
                    double y[])
{
    double settings[N_SETTINGS];
    load_settings(values, settings);
    return gtm_simulation_evaluate(x, (const gtm_simulation_inputs *)u, (const gtm_simulation_settings *)settings,
                                   (const gtm_simulation_memory *)memory, dx, (gtm_simulation_outputs *)y);
}

int model_derivatives(const double x[], const double u[], const double values[], const double memory[], double dx[])
{
    double y[N_OUTPUTS];
    return evaluate(x, u, values, memory, dx, y);
}

int model_outputs(const double x[], const double u[], const double values[], double memory[], double y[])
{
    double dx[N_STATES];
    return evaluate(x, u, values, memory, dx, y);
}

int model_advance(double x[], const double u[], const double values[], double memory[], double duration)
{
    double settings[N_SETTINGS];
    load_settings(values, settings);
    return gtm_simulation_advance(x, (const gtm_simulation_inputs *)u, (const gtm_simulation_settings *)settings,
                                  (gtm_simulation_memory *)memory, duration, values[SOLVER_SUBSTEP]);
}
