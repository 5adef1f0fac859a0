/* Two FMUs of ours in FMI 2.0, one in FMI 3.0 and one that is not ours, in one program: each prints what it says. */
#include <stdio.h>

#include "fmi2FunctionTypes.h"
#include "fmi3FunctionTypes.h"

static void log2(fmi2ComponentEnvironment e, fmi2String name, fmi2Status status, fmi2String category, fmi2String text, ...)
{
    fprintf(stderr, "%s: %s\n", name, text);
}

static void log3(fmi3InstanceEnvironment e, fmi3Status status, fmi3String category, fmi3String text)
{
    fprintf(stderr, "%s\n", text);
}

#define FMU2(name, kind, token, reference)                                                                           \
    {                                                                                                                \
        extern fmi2InstantiateTYPE name##_fmi2Instantiate;                                                           \
        extern fmi2SetupExperimentTYPE name##_fmi2SetupExperiment;                                                   \
        extern fmi2EnterInitializationModeTYPE name##_fmi2EnterInitializationMode;                                   \
        extern fmi2GetRealTYPE name##_fmi2GetReal;                                                                   \
        extern fmi2FreeInstanceTYPE name##_fmi2FreeInstance;                                                         \
        const fmi2ValueReference asked = reference;                                                                  \
        const fmi2CallbackFunctions callbacks = {log2, NULL, NULL, NULL, NULL};                                      \
        fmi2Real value;                                                                                              \
        fmi2Component c = name##_fmi2Instantiate("one", kind, token, NULL, &callbacks, fmi2False, fmi2True);         \
        if (!c || name##_fmi2SetupExperiment(c, fmi2False, 0, 0, fmi2False, 0) ||                                    \
            name##_fmi2EnterInitializationMode(c) || name##_fmi2GetReal(c, &asked, 1, &value))                       \
            return 1;                                                                                                \
        printf("%.17g\n", value);                                                                                    \
        name##_fmi2FreeInstance(c);                                                                                  \
    }

extern fmi3InstantiateModelExchangeTYPE GtmDynamicsNative3_fmi3InstantiateModelExchange;
extern fmi3EnterInitializationModeTYPE GtmDynamicsNative3_fmi3EnterInitializationMode;
extern fmi3GetFloat64TYPE GtmDynamicsNative3_fmi3GetFloat64;
extern fmi3FreeInstanceTYPE GtmDynamicsNative3_fmi3FreeInstance;

int main(void)
{
    FMU2(GtmDynamicsNative, fmi2CoSimulation, TOKEN_DYNAMICS, TAS)
    FMU2(wing, fmi2CoSimulation, TOKEN_WING, LIFT)
    FMU2(VanDerPol, fmi2ModelExchange, "", 3)

    const fmi3ValueReference asked = TAS;
    fmi3Float64 value;
    fmi3Instance instance = GtmDynamicsNative3_fmi3InstantiateModelExchange("one", TOKEN_DYNAMICS3, NULL, fmi3False,
                                                                            fmi3True, NULL, log3);
    if (!instance || GtmDynamicsNative3_fmi3EnterInitializationMode(instance, fmi3False, 0, 0, fmi3False, 0) ||
        GtmDynamicsNative3_fmi3GetFloat64(instance, &asked, 1, &value, 1))
        return 1;
    printf("%.17g\n", value);
    GtmDynamicsNative3_fmi3FreeInstance(instance);
    return 0;
}
