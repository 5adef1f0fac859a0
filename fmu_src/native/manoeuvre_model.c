/* Whether a manoeuvre can be flown after a failure, by the core. */
#include "gtm_failure.h"
#include "model.h"

/* The core takes the inputs as they are, a manoeuvre and then a failure, and gives the outputs as they are. */
enum { FAILURE = sizeof(gtm_failure_manoeuvre) / sizeof(double), N_ANSWER = sizeof(gtm_failure_answer) / sizeof(double) };
typedef char inputs_fit[FAILURE + sizeof(gtm_failure) / sizeof(double) == N_INPUTS ? 1 : -1];
typedef char outputs_fit[N_ANSWER + N_DEFERRED == N_OUTPUTS ? 1 : -1];
typedef char slopes_fit[(int)GTM_TOLD == (int)N_KNOWNS ? 1 : -1];
typedef double Slopes[GTM_TOLD];
typedef char turn_rates_are_deferred[N_DEFERRED == 2 ? 1 : -1];

int model_outputs(const double x[], const double u[], const double values[], double memory[], double y[])
{
    (void)x, (void)values, (void)memory;
    return gtm_failure_query((const gtm_failure_manoeuvre *)u, (const gtm_failure *)(u + FAILURE), model_lower,
                             model_upper, (gtm_failure_answer *)y);
}

int model_deferred_outputs(const double x[], const double u[], const double values[], double memory[], double y[])
{
    (void)x, (void)values, (void)memory;
    return gtm_failure_turn_rates((const gtm_failure_manoeuvre *)u, (const gtm_failure *)(u + FAILURE), model_lower,
                                  model_upper, y);
}

int model_jacobian(const double x[], const double u[], const double values[], double memory[], double jacobian[])
{
    (void)x, (void)values, (void)memory;
    return gtm_failure_query_slopes((const gtm_failure_manoeuvre *)u, (const gtm_failure *)(u + FAILURE), model_lower,
                                    model_upper, jacobian);
}

int model_deferred_jacobian(const double x[], const double u[], const double values[], double memory[],
                            double jacobian[])
{
    (void)x, (void)values, (void)memory;
    return gtm_failure_turn_rate_slopes((const gtm_failure_manoeuvre *)u, (const gtm_failure *)(u + FAILURE),
                                        model_lower, model_upper, (Slopes *)(jacobian + N_ANSWER * N_KNOWNS));
}
