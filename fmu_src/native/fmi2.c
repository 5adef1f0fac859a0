/* FMI 2.0 for model exchange and co-simulation over an instance. The numbers of Status are those of fmi2Status. */
#include "fmi2Functions.h"
#include "instance.h"

/* Refuse a call without an instance, or in a mode in which the standard does not allow it. */
#define ALLOW(modes) \
    if (!instance_allows(c, __func__, modes)) return fmi2Error

#define REQUIRE(pointer) \
    if (!(pointer)) return (fmi2Status)instance_refuse(c, "%s was given a null pointer.", __func__)

#define DONE(call) return (fmi2Status)(call)

static void log_message(const Instance *i, Status status, const char *category, const char *message)
{
    if (i->callback)
        ((fmi2CallbackLogger)i->callback)(i->environment, i->name, (fmi2Status)status, category, message);
}

/* ---- Common functions ---- */

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }

const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean loggingOn, size_t nCategories, const fmi2String categories[])
{
    ALLOW(ANY_MODE);
    DONE(instance_set_logging(c, loggingOn != fmi2False, true, nCategories, categories));
}

fmi2Component fmi2Instantiate(fmi2String instanceName, fmi2Type fmuType, fmi2String fmuGUID,
                              fmi2String fmuResourceLocation, const fmi2CallbackFunctions *functions,
                              fmi2Boolean visible, fmi2Boolean loggingOn)
{
    (void)fmuResourceLocation, (void)visible;
    if (!functions || (fmuType != fmi2ModelExchange && fmuType != fmi2CoSimulation)) return NULL;
    return instance_create(instanceName, fmuGUID, fmuType == fmi2ModelExchange, loggingOn != fmi2False, log_message,
                           (void (*)(void))functions->logger, functions->componentEnvironment);
}

void fmi2FreeInstance(fmi2Component c) { instance_free(c); }

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance, fmi2Real startTime,
                               fmi2Boolean stopTimeDefined, fmi2Real stopTime)
{
    (void)toleranceDefined, (void)tolerance;
    ALLOW(INSTANTIATED);
    DONE(instance_set_times(c, startTime, stopTimeDefined != fmi2False, stopTime));
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    ALLOW(INSTANTIATED);
    instance_enter(c, INITIALIZATION);
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    ALLOW(INITIALIZATION);
    DONE(instance_initialize(c));
}

fmi2Status fmi2Terminate(fmi2Component c)
{
    ALLOW(INITIALIZED);
    instance_enter(c, TERMINATED);
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c)
{
    ALLOW(ANY_MODE);
    DONE(instance_reset(c));
}

/* ---- Values ---- */

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Real value[])
{
    ALLOW(READABLE);
    DONE(instance_get(c, REAL, vr, nvr, value));
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Real value[])
{
    ALLOW(INSTANTIATED | INITIALIZATION | INITIALIZED);
    DONE(instance_set(c, REAL, vr, nvr, value));
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Boolean value[])
{
    ALLOW(READABLE);
    if (!instance_can_get(c, BOOLEAN, vr, nvr, value)) return fmi2Error;
    Status status = OK;
    for (size_t k = 0; k < nvr; k++) {
        bool flag = false;
        const Status one = instance_get_booleans(c, vr + k, 1, &flag);
        value[k] = flag;
        status = one > status ? one : status;
    }
    return (fmi2Status)status;
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Boolean value[])
{
    ALLOW(INSTANTIATED | INITIALIZATION | INITIALIZED);
    if (!instance_can_set(c, BOOLEAN, vr, nvr, value)) return fmi2Error;
    Status status = OK;
    for (size_t k = 0; k < nvr; k++) {
        const bool flag = value[k] != fmi2False;
        const Status one = instance_set_booleans(c, vr + k, 1, &flag);
        status = one > status ? one : status;
    }
    return (fmi2Status)status;
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Integer value[])
{
    ALLOW(READABLE);
    if (!instance_can_get(c, ENUMERATION, vr, nvr, value)) return fmi2Error;
    Status status = OK;
    for (size_t k = 0; k < nvr; k++) {
        double number = 0;
        const Status one = instance_get(c, ENUMERATION, vr + k, 1, &number);
        value[k] = (fmi2Integer)number;
        status = one > status ? one : status;
    }
    return (fmi2Status)status;
}

/* All enumerations are computed. */
fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Integer value[])
{
    ALLOW(INSTANTIATED | INITIALIZATION | INITIALIZED);
    return instance_can_set(c, ENUMERATION, vr, nvr, value) ? fmi2OK : fmi2Error;
}

/* No model has Strings. */
static fmi2Status none(fmi2Component c, size_t n, const char *type)
{
    if (n == 0) return fmi2OK;
    DONE(instance_refuse(c, "There are no %s variables that were asked for.", type));
}

#define NO_VARIABLES(Access, Type, Qualifier, modes)                                                              \
    fmi2Status fmi2##Access##Type(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,                      \
                                  Qualifier fmi2##Type value[])                                                    \
    {                                                                                                              \
        (void)vr, (void)value;                                                                                     \
        ALLOW(modes);                                                                                              \
        return none(c, nvr, #Type);                                                                                \
    }

NO_VARIABLES(Get, String, , READABLE)
NO_VARIABLES(Set, String, const, INSTANTIATED | INITIALIZATION | INITIALIZED)

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference vUnknown_ref[], size_t nUnknown,
                                        const fmi2ValueReference vKnown_ref[], size_t nKnown, const fmi2Real dvKnown[],
                                        fmi2Real dvUnknown[])
{
    ALLOW(READABLE);
    DONE(instance_differentiate(c, vUnknown_ref, nUnknown, vKnown_ref, nKnown, dvKnown, dvUnknown, false));
}

/* ---- FMU states ---- */

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *FMUstate)
{
    ALLOW(ANY_MODE);
    DONE(instance_save(c, FMUstate));
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate FMUstate)
{
    ALLOW(ANY_MODE);
    DONE(instance_restore(c, FMUstate));
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *FMUstate)
{
    ALLOW(ANY_MODE);
    DONE(instance_free_saved(c, FMUstate));
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate FMUstate, size_t *size)
{
    ALLOW(ANY_MODE);
    DONE(instance_serialized_size(c, FMUstate, size));
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate FMUstate, fmi2Byte serializedState[], size_t size)
{
    ALLOW(ANY_MODE);
    DONE(instance_serialize(c, FMUstate, serializedState, size));
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte serializedState[], size_t size, fmi2FMUstate *FMUstate)
{
    ALLOW(ANY_MODE);
    DONE(instance_deserialize(c, serializedState, size, FMUstate));
}

/* ---- Model exchange ---- */

fmi2Status fmi2EnterEventMode(fmi2Component c)
{
    ALLOW(EVENT | CONTINUOUS);
    instance_enter(c, EVENT);
    return fmi2OK;
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *fmi2eventInfo)
{
    ALLOW(EVENT);
    REQUIRE(fmi2eventInfo);
    *fmi2eventInfo = (fmi2EventInfo){fmi2False, fmi2False, fmi2False, fmi2False, fmi2False, 0};
    return fmi2OK;
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c)
{
    ALLOW(EVENT);
    instance_enter(c, CONTINUOUS);
    return fmi2OK;
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean noSetFMUStatePriorToCurrentPoint,
                                       fmi2Boolean *enterEventMode, fmi2Boolean *terminateSimulation)
{
    (void)noSetFMUStatePriorToCurrentPoint;
    ALLOW(CONTINUOUS);
    REQUIRE(enterEventMode && terminateSimulation);
    *enterEventMode = instance_needs_event(c);
    *terminateSimulation = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time)
{
    ALLOW(EVENT | CONTINUOUS);
    DONE(instance_set_time(c, time));
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t nx)
{
    ALLOW(CONTINUOUS);
    DONE(instance_set_states(c, x, nx));
}

/* Modes in which an instance for model exchange answers; STEP is one for co-simulation. */
#define ANSWERS (INITIALIZATION | EVENT | CONTINUOUS | TERMINATED)

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real derivatives[], size_t nx)
{
    ALLOW(ANSWERS);
    DONE(instance_get_derivatives(c, derivatives, nx));
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real eventIndicators[], size_t ni)
{
    (void)eventIndicators;
    ALLOW(ANSWERS);
    return none(c, ni, "event indicator");
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t nx)
{
    ALLOW(ANSWERS);
    DONE(instance_get_states(c, x, nx));
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x_nominal[], size_t nx)
{
    ALLOW(INSTANTIATED | ANSWERS);
    DONE(instance_get_nominals(c, x_nominal, nx));
}

/* ---- Co-simulation ---- */

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                       const fmi2Integer order[], const fmi2Real value[])
{
    (void)vr, (void)order, (void)value;
    ALLOW(INSTANTIATED | INITIALIZATION | STEP);
    return none(c, nvr, "input derivative");
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                        const fmi2Integer order[], fmi2Real value[])
{
    (void)vr, (void)order, (void)value;
    ALLOW(STEP | TERMINATED);
    return none(c, nvr, "output derivative");
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real currentCommunicationPoint, fmi2Real communicationStepSize,
                      fmi2Boolean noSetFMUStatePriorToCurrentPoint)
{
    (void)noSetFMUStatePriorToCurrentPoint;
    ALLOW(STEP);
    DONE(instance_step(c, currentCommunicationPoint, communicationStepSize));
}

fmi2Status fmi2CancelStep(fmi2Component c)
{
    if (!c) return fmi2Error;
    DONE(instance_refuse(c, "There is no step to cancel: all steps are synchronous."));
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind s, fmi2Real *value)
{
    ALLOW(STEP | TERMINATED);
    REQUIRE(value);
    if (s != fmi2LastSuccessfulTime) return fmi2Discard;
    *value = instance_time(c);
    return fmi2OK;
}

/* A step that is refused is not done at any size: the FMU asks to stop (FMI 2.0.5, 4.2.2), at the time that it has
   reached. */
fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind s, fmi2Boolean *value)
{
    ALLOW(STEP | TERMINATED);
    REQUIRE(value);
    if (s != fmi2Terminated) return fmi2Discard;
    *value = ((Instance *)c)->is_step_refused;
    return fmi2OK;
}

/* Statuses of asynchronous steps only. */
#define NO_STATUS(name, Type)                                                    \
    fmi2Status name(fmi2Component c, const fmi2StatusKind s, Type *value)        \
    {                                                                            \
        (void)s;                                                                 \
        ALLOW(STEP | TERMINATED);                                                \
        REQUIRE(value);                                                          \
        return fmi2Discard;                                                      \
    }

NO_STATUS(fmi2GetStatus, fmi2Status)
NO_STATUS(fmi2GetIntegerStatus, fmi2Integer)
NO_STATUS(fmi2GetStringStatus, fmi2String)
