/* FMI 3.0 for model exchange and co-simulation over an instance. The numbers of Status are those of fmi3Status. */
#include "fmi3Functions.h"
#include "instance.h"

/* Refuse a call without an instance, or in a mode in which the standard does not allow it. */
#define ALLOW(modes) \
    if (!instance_allows(instance, __func__, modes)) return fmi3Error

#define REQUIRE(pointer) \
    if (!(pointer)) return (fmi3Status)instance_refuse(instance, "%s was given a null pointer.", __func__)

#define DONE(call) return (fmi3Status)(call)

/* In Instantiated, start values (FMI 3.0, 2.3.2). */
enum { GETTABLE = INSTANTIATED | READABLE, SETTABLE = INSTANTIATED | INITIALIZATION | INITIALIZED };

static void log_message(const Instance *i, Status status, const char *category, const char *message)
{
    if (i->callback) ((fmi3LogMessageCallback)i->callback)(i->environment, (fmi3Status)status, category, message);
}

/* ---- Common functions ---- */

const char *fmi3GetVersion(void) { return fmi3Version; }

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean loggingOn, size_t nCategories,
                               const fmi3String categories[])
{
    ALLOW(ANY_MODE);
    DONE(instance_set_logging(instance, loggingOn, false, nCategories, categories));
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String instanceName, fmi3String instantiationToken,
                                          fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn,
                                          fmi3InstanceEnvironment instanceEnvironment, fmi3LogMessageCallback logMessage)
{
    (void)resourcePath, (void)visible;
    return instance_create(instanceName, instantiationToken, true, loggingOn, log_message, (void (*)(void))logMessage,
                           instanceEnvironment);
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath,
                                         fmi3Boolean visible, fmi3Boolean loggingOn, fmi3Boolean eventModeUsed,
                                         fmi3Boolean earlyReturnAllowed,
                                         const fmi3ValueReference requiredIntermediateVariables[],
                                         size_t nRequiredIntermediateVariables,
                                         fmi3InstanceEnvironment instanceEnvironment, fmi3LogMessageCallback logMessage,
                                         fmi3IntermediateUpdateCallback intermediateUpdate)
{
    (void)resourcePath, (void)visible, (void)earlyReturnAllowed, (void)intermediateUpdate;
    (void)requiredIntermediateVariables;
    Instance *made = instance_create(instanceName, instantiationToken, false, loggingOn, log_message,
                                     (void (*)(void))logMessage, instanceEnvironment);
    if (made && (eventModeUsed || nRequiredIntermediateVariables)) {
        instance_refuse(made, "The FMU has no Event Mode in co-simulation and no intermediate variables.");
        instance_free(made);
        return NULL;
    }
    return made;
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String instanceName, fmi3String instantiationToken,
                                               fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn,
                                               fmi3InstanceEnvironment instanceEnvironment,
                                               fmi3LogMessageCallback logMessage, fmi3ClockUpdateCallback clockUpdate,
                                               fmi3LockPreemptionCallback lockPreemption,
                                               fmi3UnlockPreemptionCallback unlockPreemption)
{
    (void)instanceName, (void)instantiationToken, (void)resourcePath, (void)visible, (void)loggingOn;
    (void)clockUpdate, (void)lockPreemption, (void)unlockPreemption;
    if (logMessage)
        logMessage(instanceEnvironment, fmi3Error, "logStatusError", "The FMU has no Scheduled Execution.");
    return NULL;
}

void fmi3FreeInstance(fmi3Instance instance) { instance_free(instance); }

static fmi3Status enter(fmi3Instance instance, Mode mode)
{
    instance_enter(instance, mode);
    return fmi3OK;
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean toleranceDefined, fmi3Float64 tolerance,
                                       fmi3Float64 startTime, fmi3Boolean stopTimeDefined, fmi3Float64 stopTime)
{
    (void)toleranceDefined, (void)tolerance;
    ALLOW(INSTANTIATED);
    const Status status = instance_set_times(instance, startTime, stopTimeDefined, stopTime);
    return status == OK ? enter(instance, INITIALIZATION) : (fmi3Status)status;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance)
{
    ALLOW(INITIALIZATION);
    DONE(instance_initialize(instance));
}

fmi3Status fmi3EnterEventMode(fmi3Instance instance)
{
    ALLOW(CONTINUOUS);
    return enter(instance, EVENT);
}

fmi3Status fmi3Terminate(fmi3Instance instance)
{
    ALLOW(INITIALIZED);
    return enter(instance, TERMINATED);
}

fmi3Status fmi3Reset(fmi3Instance instance)
{
    ALLOW(ANY_MODE);
    DONE(instance_reset(instance));
}

/* ---- Values ---- */

static bool has_other_count(fmi3Instance instance, size_t references, size_t values)
{
    if (references != values)
        instance_refuse(instance, "%zu values were given for %zu scalar variables.", values, references);
    return references != values;
}

fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          fmi3Float64 values[], size_t nValues)
{
    ALLOW(GETTABLE);
    if (has_other_count(instance, nValueReferences, nValues)) return fmi3Error;
    DONE(instance_get(instance, REAL, valueReferences, nValueReferences, values));
}

fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          const fmi3Float64 values[], size_t nValues)
{
    ALLOW(SETTABLE);
    if (has_other_count(instance, nValueReferences, nValues)) return fmi3Error;
    DONE(instance_set(instance, REAL, valueReferences, nValueReferences, values));
}

fmi3Status fmi3GetBoolean(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          fmi3Boolean values[], size_t nValues)
{
    ALLOW(GETTABLE);
    if (has_other_count(instance, nValueReferences, nValues)) return fmi3Error;
    DONE(instance_get_booleans(instance, valueReferences, nValueReferences, values));
}

fmi3Status fmi3SetBoolean(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          const fmi3Boolean values[], size_t nValues)
{
    ALLOW(SETTABLE);
    if (has_other_count(instance, nValueReferences, nValues)) return fmi3Error;
    DONE(instance_set_booleans(instance, valueReferences, nValueReferences, values));
}

fmi3Status fmi3GetInt64(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        fmi3Int64 values[], size_t nValues)
{
    ALLOW(GETTABLE);
    if (has_other_count(instance, nValueReferences, nValues)) return fmi3Error;
    if (!instance_can_get(instance, ENUMERATION, valueReferences, nValueReferences, values)) return fmi3Error;
    Status status = OK;
    for (size_t k = 0; k < nValueReferences; k++) {
        double number = 0;
        const Status one = instance_get(instance, ENUMERATION, valueReferences + k, 1, &number);
        values[k] = (fmi3Int64)number;
        status = one > status ? one : status;
    }
    return (fmi3Status)status;
}

/* All enumerations are computed. */
fmi3Status fmi3SetInt64(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        const fmi3Int64 values[], size_t nValues)
{
    ALLOW(SETTABLE);
    if (has_other_count(instance, nValueReferences, nValues)) return fmi3Error;
    return instance_can_set(instance, ENUMERATION, valueReferences, nValueReferences, values) ? fmi3OK : fmi3Error;
}

/* No model has variables of other types. */
static fmi3Status none(fmi3Instance instance, size_t n, const char *what)
{
    if (n == 0) return fmi3OK;
    DONE(instance_refuse(instance, "There are no %s that were asked for.", what));
}

#define NO_VARIABLES(Access, Type, Qualifier, modes)                                                               \
    fmi3Status fmi3##Access##Type(fmi3Instance instance, const fmi3ValueReference valueReferences[],               \
                                  size_t nValueReferences, Qualifier fmi3##Type values[], size_t nValues)          \
    {                                                                                                              \
        (void)valueReferences, (void)values, (void)nValues;                                                        \
        ALLOW(modes);                                                                                              \
        return none(instance, nValueReferences, #Type " variables");                                               \
    }

#define NO_TYPE(Type)                          \
    NO_VARIABLES(Get, Type, , GETTABLE)        \
    NO_VARIABLES(Set, Type, const, SETTABLE)

NO_TYPE(Float32)
NO_TYPE(Int8)
NO_TYPE(UInt8)
NO_TYPE(Int16)
NO_TYPE(UInt16)
NO_TYPE(Int32)
NO_TYPE(UInt32)
NO_TYPE(UInt64)
NO_TYPE(String)

/* Functions of what no model has: binary variables, clocks, output derivatives. */
#define NOTHING(name, what, modes, ...)                                                                              \
    fmi3Status name(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,      \
                    __VA_ARGS__)                                                                                     \
    {                                                                                                                \
        (void)valueReferences;                                                                                       \
        ALLOW(modes);                                                                                                \
        return none(instance, nValueReferences, what);                                                               \
    }

#if defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif
NOTHING(fmi3GetBinary, "Binary variables", GETTABLE, size_t sizes[], fmi3Binary values[], size_t nValues)
NOTHING(fmi3SetBinary, "Binary variables", SETTABLE, const size_t sizes[], const fmi3Binary values[], size_t nValues)
NOTHING(fmi3GetClock, "clocks", GETTABLE, fmi3Clock values[])
NOTHING(fmi3SetClock, "clocks", SETTABLE, const fmi3Clock values[])
NOTHING(fmi3GetIntervalDecimal, "clocks", READABLE, fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[])
NOTHING(fmi3GetIntervalFraction, "clocks", READABLE, fmi3UInt64 counters[], fmi3UInt64 resolutions[],
        fmi3IntervalQualifier qualifiers[])
NOTHING(fmi3GetShiftDecimal, "clocks", READABLE, fmi3Float64 shifts[])
NOTHING(fmi3GetShiftFraction, "clocks", READABLE, fmi3UInt64 counters[], fmi3UInt64 resolutions[])
NOTHING(fmi3SetIntervalDecimal, "clocks", SETTABLE, const fmi3Float64 intervals[])
NOTHING(fmi3SetIntervalFraction, "clocks", SETTABLE, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
NOTHING(fmi3SetShiftDecimal, "clocks", SETTABLE, const fmi3Float64 shifts[])
NOTHING(fmi3SetShiftFraction, "clocks", SETTABLE, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
NOTHING(fmi3GetOutputDerivatives, "output derivatives", STEP | TERMINATED, const fmi3Int32 orders[],
        fmi3Float64 values[], size_t nValues)

/* Functions of capabilities that no model has. */
#define UNSUPPORTED(name, ...)                                                                    \
    fmi3Status name(__VA_ARGS__)                                                                  \
    {                                                                                             \
        if (!instance) return fmi3Error;                                                          \
        DONE(instance_refuse(instance, "%s is not supported, as the model description says.", __func__)); \
    }

UNSUPPORTED(fmi3GetNumberOfVariableDependencies, fmi3Instance instance, fmi3ValueReference valueReference,
            size_t *nDependencies)
UNSUPPORTED(fmi3GetVariableDependencies, fmi3Instance instance, fmi3ValueReference dependent,
            size_t elementIndicesOfDependent[], fmi3ValueReference independents[], size_t elementIndicesOfIndependents[],
            fmi3DependencyKind dependencyKinds[], size_t nDependencies)
UNSUPPORTED(fmi3EnterConfigurationMode, fmi3Instance instance)
UNSUPPORTED(fmi3ExitConfigurationMode, fmi3Instance instance)
UNSUPPORTED(fmi3EnterStepMode, fmi3Instance instance)
UNSUPPORTED(fmi3EvaluateDiscreteStates, fmi3Instance instance)
UNSUPPORTED(fmi3ActivateModelPartition, fmi3Instance instance, fmi3ValueReference clockReference,
            fmi3Float64 activationTime)

/* ---- Partial derivatives ---- */

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns,
                                        const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[],
                                        size_t nSeed, fmi3Float64 sensitivity[], size_t nSensitivity)
{
    ALLOW(READABLE);
    if (has_other_count(instance, nKnowns, nSeed) || has_other_count(instance, nUnknowns, nSensitivity)) return fmi3Error;
    DONE(instance_differentiate(instance, unknowns, nUnknowns, knowns, nKnowns, seed, sensitivity, false));
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns,
                                    const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[],
                                    size_t nSeed, fmi3Float64 sensitivity[], size_t nSensitivity)
{
    ALLOW(READABLE);
    if (has_other_count(instance, nUnknowns, nSeed) || has_other_count(instance, nKnowns, nSensitivity)) return fmi3Error;
    DONE(instance_differentiate(instance, unknowns, nUnknowns, knowns, nKnowns, seed, sensitivity, true));
}

/* ---- FMU states ---- */

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *FMUState)
{
    ALLOW(ANY_MODE);
    DONE(instance_save(instance, FMUState));
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState FMUState)
{
    ALLOW(ANY_MODE);
    DONE(instance_restore(instance, FMUState));
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *FMUState)
{
    ALLOW(ANY_MODE);
    DONE(instance_free_saved(instance, FMUState));
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState FMUState, size_t *size)
{
    ALLOW(ANY_MODE);
    DONE(instance_serialized_size(instance, FMUState, size));
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState FMUState, fmi3Byte serializedState[], size_t size)
{
    ALLOW(ANY_MODE);
    DONE(instance_serialize(instance, FMUState, serializedState, size));
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte serializedState[], size_t size,
                                   fmi3FMUState *FMUState)
{
    ALLOW(ANY_MODE);
    DONE(instance_deserialize(instance, serializedState, size, FMUState));
}

/* ---- Model exchange ---- */

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *discreteStatesNeedUpdate,
                                    fmi3Boolean *terminateSimulation, fmi3Boolean *nominalsOfContinuousStatesChanged,
                                    fmi3Boolean *valuesOfContinuousStatesChanged, fmi3Boolean *nextEventTimeDefined,
                                    fmi3Float64 *nextEventTime)
{
    ALLOW(EVENT);
    REQUIRE(discreteStatesNeedUpdate && terminateSimulation && nominalsOfContinuousStatesChanged &&
            valuesOfContinuousStatesChanged && nextEventTimeDefined && nextEventTime);
    *discreteStatesNeedUpdate = *terminateSimulation = *nominalsOfContinuousStatesChanged = false;
    *valuesOfContinuousStatesChanged = *nextEventTimeDefined = false;
    *nextEventTime = 0;
    return fmi3OK;
}

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance instance)
{
    ALLOW(EVENT);
    return enter(instance, CONTINUOUS);
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance, fmi3Boolean noSetFMUStatePriorToCurrentPoint,
                                       fmi3Boolean *enterEventMode, fmi3Boolean *terminateSimulation)
{
    ALLOW(CONTINUOUS);
    REQUIRE(enterEventMode && terminateSimulation);
    *enterEventMode = instance_needs_event(instance);
    *terminateSimulation = false;
    return fmi3OK;
}

fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 time)
{
    ALLOW(EVENT | CONTINUOUS);
    DONE(instance_set_time(instance, time));
}

fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64 continuousStates[], size_t nContinuousStates)
{
    ALLOW(CONTINUOUS);
    DONE(instance_set_states(instance, continuousStates, nContinuousStates));
}

/* Modes in which an instance for model exchange answers; STEP is one for co-simulation. */
enum { ANSWERS = INITIALIZATION | EVENT | CONTINUOUS | TERMINATED };

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance, fmi3Float64 derivatives[], size_t nContinuousStates)
{
    ALLOW(ANSWERS);
    DONE(instance_get_derivatives(instance, derivatives, nContinuousStates));
}

fmi3Status fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64 eventIndicators[], size_t nEventIndicators)
{
    ALLOW(ANSWERS);
    return none(instance, nEventIndicators, "event indicators");
}

fmi3Status fmi3GetContinuousStates(fmi3Instance instance, fmi3Float64 continuousStates[], size_t nContinuousStates)
{
    ALLOW(ANSWERS);
    DONE(instance_get_states(instance, continuousStates, nContinuousStates));
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance, fmi3Float64 nominals[], size_t nContinuousStates)
{
    ALLOW(INSTANTIATED | ANSWERS);
    DONE(instance_get_nominals(instance, nominals, nContinuousStates));
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t *nEventIndicators)
{
    ALLOW(INSTANTIATED | ANSWERS);
    REQUIRE(nEventIndicators);
    *nEventIndicators = 0;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t *nContinuousStates)
{
    ALLOW(INSTANTIATED | ANSWERS);
    REQUIRE(nContinuousStates);
    *nContinuousStates = N_STATES;
    return fmi3OK;
}

/* ---- Co-simulation ---- */

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 currentCommunicationPoint, fmi3Float64 communicationStepSize,
                      fmi3Boolean noSetFMUStatePriorToCurrentPoint, fmi3Boolean *eventHandlingNeeded,
                      fmi3Boolean *terminateSimulation, fmi3Boolean *earlyReturn, fmi3Float64 *lastSuccessfulTime)
{
    ALLOW(STEP);
    REQUIRE(eventHandlingNeeded && terminateSimulation && earlyReturn && lastSuccessfulTime);
    *eventHandlingNeeded = *terminateSimulation = *earlyReturn = false;
    const Status status = instance_step(instance, currentCommunicationPoint, communicationStepSize);
    *lastSuccessfulTime = instance_time(instance);
    return (fmi3Status)status;
}
