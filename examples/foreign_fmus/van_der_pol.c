/* An FMU that is not ours: van der Pol's oscillator x'' = mu (1 - x^2) x' - x + force, FMI 2.0 model exchange. */
#include "fmi2Functions.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { X, V, DER_X, DER_V, FORCE, MU, N };

static double rate(const double *v)
{
    return v[MU] * (1 - v[X] * v[X]) * v[V] - v[X] + v[FORCE];
}

static void update(double *v)
{
    v[DER_X] = v[V];
    v[DER_V] = rate(v);
}

fmi2Status fmi2Reset(fmi2Component c)
{
    memcpy(c, (double[N]){[X] = 2, [MU] = 1}, N * sizeof(double));
    return fmi2OK;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging)
{
    double *v = malloc(N * sizeof *v);
    fmi2Reset(v);
    return v;
}
void fmi2FreeInstance(fmi2Component c) { free(c); }
const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Real value[])
{
    update(c);
    for (size_t k = 0; k < n; k++) value[k] = ((double *)c)[r[k]];
    return fmi2OK;
}
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Real value[])
{
    for (size_t k = 0; k < n; k++) ((double *)c)[r[k]] = value[k];
    return fmi2OK;
}
fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[], size_t n_unknown,
                                        const fmi2ValueReference known[], size_t n_known, const fmi2Real seed[],
                                        fmi2Real out[])
{
#ifndef WITHOUT_SLOPES
    const double *v = c;
    for (size_t a = 0; a < n_unknown; a++) {
        out[a] = 0;
        for (size_t b = 0; b < n_known; b++) {
            const fmi2ValueReference k = known[b];
            double slope = k == V ? v[MU] * (1 - v[X] * v[X]) : k == X ? -2 * v[MU] * v[X] * v[V] - 1 : k == FORCE;
            if (unknown[a] == DER_X) slope = k == V;
            out[a] += slope * seed[b];
        }
    }
    return fmi2OK;
#else
    return fmi2Error;
#endif
}

/* What the standard asks for besides, and nothing here needs. */
#define NOTHING(name, ...) fmi2Status name(__VA_ARGS__) { return fmi2OK; }
NOTHING(fmi2SetDebugLogging, fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[])
NOTHING(fmi2SetupExperiment, fmi2Component c, fmi2Boolean is, fmi2Real tolerance, fmi2Real start, fmi2Boolean s, fmi2Real stop)
NOTHING(fmi2EnterInitializationMode, fmi2Component c)
NOTHING(fmi2ExitInitializationMode, fmi2Component c)
NOTHING(fmi2Terminate, fmi2Component c)
NOTHING(fmi2GetInteger, fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Integer v[])
NOTHING(fmi2GetBoolean, fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Boolean v[])
NOTHING(fmi2GetString, fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2String v[])
NOTHING(fmi2SetInteger, fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Integer v[])
NOTHING(fmi2SetBoolean, fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Boolean v[])
NOTHING(fmi2SetString, fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2String v[])
NOTHING(fmi2GetFMUstate, fmi2Component c, fmi2FMUstate *s)
NOTHING(fmi2SetFMUstate, fmi2Component c, fmi2FMUstate s)
NOTHING(fmi2FreeFMUstate, fmi2Component c, fmi2FMUstate *s)
NOTHING(fmi2SerializedFMUstateSize, fmi2Component c, fmi2FMUstate s, size_t *n)
NOTHING(fmi2SerializeFMUstate, fmi2Component c, fmi2FMUstate s, fmi2Byte b[], size_t n)
NOTHING(fmi2DeSerializeFMUstate, fmi2Component c, const fmi2Byte b[], size_t n, fmi2FMUstate *s)
NOTHING(fmi2EnterEventMode, fmi2Component c)
NOTHING(fmi2NewDiscreteStates, fmi2Component c, fmi2EventInfo *info)
NOTHING(fmi2EnterContinuousTimeMode, fmi2Component c)
NOTHING(fmi2CompletedIntegratorStep, fmi2Component c, fmi2Boolean no, fmi2Boolean *enter, fmi2Boolean *terminate)
NOTHING(fmi2SetTime, fmi2Component c, fmi2Real t)
NOTHING(fmi2SetContinuousStates, fmi2Component c, const fmi2Real x[], size_t n)
NOTHING(fmi2GetDerivatives, fmi2Component c, fmi2Real dx[], size_t n)
NOTHING(fmi2GetEventIndicators, fmi2Component c, fmi2Real z[], size_t n)
NOTHING(fmi2GetContinuousStates, fmi2Component c, fmi2Real x[], size_t n)
NOTHING(fmi2GetNominalsOfContinuousStates, fmi2Component c, fmi2Real x[], size_t n)
