/* FMI 2.0 for co-simulation over a slave of pythonfmu. */
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"
#include "fmu.h"
#include "location.h"
#include "slave.h"

/* Begin a call that runs Python: `s` is the slave; refused without one, or when the interpreter has ended. */
#define ENTER                            \
    Slave *const s = c;                  \
    int lock;                            \
    if (!s || !python_enter(&lock)) return fmi2Error

#define REQUIRE(condition) \
    if (!(condition)) return c ? slave_refuse(c, "%s was given a null pointer.", __func__) : fmi2Error

static fmi2Status leave(Slave *s, int lock, fmi2Status status)
{
    status = slave_status(s, status);
    python_leave(lock);
    return status;
}

/* Call a method for its status. */
static fmi2Status run(Slave *s, int lock, const char *method, Object *first, Object *second, Object *third)
{
    Object *const result = slave_call(s, method, first, second, third);
    if (result) py.Py_DecRef(result);
    return leave(s, lock, result ? fmi2OK : fmi2Error);
}

/* ---- Life ---- */

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }

const char *fmi2GetVersion(void) { return fmi2Version; }

/* What makes an instance impossible, or NULL. */
static const char *fault_of(const char *name, fmi2Type kind, const char *guid)
{
    if (!*name) return "An instance needs a name.";
    if (kind != fmi2CoSimulation) return "The FMU is for co-simulation only.";
    if (!guid || strcmp(guid, SLAVE_GUID)) return "The GUID is not that of this FMU: read modelDescription.xml again.";
    return python_start();
}

static void create(Slave *s, const char *location, bool is_visible)
{
    const char *fault;
    char *const folder = location_folder(location, &fault);
    int lock;
    if (!folder) slave_refuse(s, "%s It was given as %.500s.", fault, location ? location : "NULL");
    else if (python_enter(&lock)) {
        slave_create(s, folder, is_visible);
        python_leave(lock);
    }
    free(folder);
}

fmi2Component fmi2Instantiate(fmi2String instanceName, fmi2Type fmuType, fmi2String fmuGUID,
                              fmi2String fmuResourceLocation, const fmi2CallbackFunctions *functions,
                              fmi2Boolean visible, fmi2Boolean loggingOn)
{
    const char *const name = instanceName ? instanceName : "";
    Slave *const s = functions ? calloc(1, sizeof *s) : NULL;
    if (!s) return NULL;
    s->name = malloc(strlen(name) + 1);
    if (s->name) strcpy(s->name, name);
    s->logger = functions->logger;
    s->environment = functions->componentEnvironment;
    s->is_logging = loggingOn != fmi2False;
    const char *const fault = s->name ? fault_of(name, fmuType, fmuGUID) : "There is no memory for an instance.";
    if (fault) slave_refuse(s, "%s", fault);
    else create(s, fmuResourceLocation, visible != fmi2False);
    if (s->object) return s;
    fmi2FreeInstance(s);
    return NULL;
}

/* The interpreter of a host may have ended before: then there is nothing left to let go of. */
void fmi2FreeInstance(fmi2Component c)
{
    Slave *const s = c;
    int lock;
    if (!s) return;
    if (python_enter(&lock)) {
        slave_release(s);
        python_leave(lock);
    }
    free(s->name);
    free(s);
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean loggingOn, size_t nCategories, const fmi2String categories[])
{
    REQUIRE(nCategories == 0 || categories);
    ENTER;
    Object *const declared = py.PyObject_GetAttrString(s->object, "log_categories");
    Object *const chosen = nCategories ? py.Py_BuildValue("{}") : NULL;
    fmi2Status status = fmi2OK;
    for (size_t k = 0; k < nCategories && status == fmi2OK; k++)
        if (!declared || !categories[k] || !py.PyMapping_HasKeyString(declared, categories[k]))
            status = slave_refuse(s, "There is no log category %.80s.", categories[k] ? categories[k] : "(null)");
        else if (py.PyMapping_SetItemString(chosen, categories[k], declared))
            status = fmi2Error;
    if (declared) py.Py_DecRef(declared);
    Object *const unused = status == fmi2OK ? s->categories : chosen;
    if (status == fmi2OK) {
        s->categories = chosen;
        s->is_logging = loggingOn != fmi2False;
    }
    if (unused) py.Py_DecRef(unused);
    return leave(s, lock, status);
}

static Object *number_or_none(fmi2Boolean is_defined, double number)
{
    return is_defined ? py.PyFloat_FromDouble(number) : py.Py_BuildValue("");
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance, fmi2Real startTime,
                               fmi2Boolean stopTimeDefined, fmi2Real stopTime)
{
    if (c && (!isfinite(startTime) || (stopTimeDefined && !(stopTime >= startTime))))
        return slave_refuse(c, "An experiment from %.17g s to %.17g s cannot be run.", startTime,
                            stopTimeDefined ? stopTime : startTime);
    ENTER;
    s->time = startTime;
    return run(s, lock, "setup_experiment", py.PyFloat_FromDouble(startTime), number_or_none(stopTimeDefined, stopTime),
               number_or_none(toleranceDefined, tolerance));
}

#define PLAIN(function, method)                    \
    fmi2Status function(fmi2Component c)           \
    {                                              \
        ENTER;                                     \
        return run(s, lock, method, NULL, NULL, NULL); \
    }

PLAIN(fmi2EnterInitializationMode, "enter_initialization_mode")
PLAIN(fmi2ExitInitializationMode, "exit_initialization_mode")
PLAIN(fmi2Terminate, "terminate")

fmi2Status fmi2Reset(fmi2Component c)
{
    ENTER;
    s->has_stopped = false;
    slave_renew(s);
    return leave(s, lock, fmi2OK);
}

/* ---- Values ---- */

static Object *references(const fmi2ValueReference vr[], size_t n)
{
    Object *const list = py.PyList_New((Size)n);
    for (size_t k = 0; list && k < n; k++) py.PyList_SetItem(list, (Size)k, py.PyLong_FromUnsignedLong(vr[k]));
    return list;
}

/* The list that a method gives for value references; NULL, with a message, where it does not have one value for each. */
static Object *given(Slave *s, const char *method, const fmi2ValueReference vr[], size_t n)
{
    Object *const list = slave_call(s, method, references(vr, n), NULL, NULL);
    const Size length = list ? py.PyList_Size(list) : -1;
    if (length == (Size)n) return list;
    if (length >= 0) slave_refuse(s, "%s gave %zu values for %zu value references.", method, (size_t)length, n);
    if (list) py.Py_DecRef(list);
    return NULL;
}

static int to_integer(Object *item)
{
    const long number = py.PyLong_AsLong(item);
    return number < INT_MIN ? INT_MIN : number > INT_MAX ? INT_MAX : (int)number;
}

#define GET(function, method, Type, convert)                                                        \
    fmi2Status function(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, Type value[])   \
    {                                                                                               \
        REQUIRE(nvr == 0 || (vr && value));                                                         \
        ENTER;                                                                                      \
        Object *const list = nvr ? given(s, method, vr, nvr) : NULL;                                \
        for (size_t k = 0; list && k < nvr; k++) value[k] = convert(py.PyList_GetItem(list, (Size)k)); \
        if (list) py.Py_DecRef(list);                                                               \
        return leave(s, lock, list || !nvr ? fmi2OK : fmi2Error);                                   \
    }

GET(fmi2GetReal, "get_real", fmi2Real, py.PyFloat_AsDouble)
GET(fmi2GetInteger, "get_integer", fmi2Integer, to_integer)
GET(fmi2GetBoolean, "get_boolean", fmi2Boolean, py.PyObject_IsTrue)

/* The characters belong to the slave until the next call (FMI 2.0.5, 2.1.7). */
fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2String value[])
{
    REQUIRE(nvr == 0 || (vr && value));
    ENTER;
    Object *const list = nvr ? given(s, "get_string", vr, nvr) : NULL;
    Object *const kept = list ? py.PyList_New((Size)nvr) : NULL;
    for (size_t k = 0; kept && k < nvr && !py.PyErr_Occurred(); k++) {
        Object *const bytes = py.PyUnicode_AsEncodedString(py.PyList_GetItem(list, (Size)k), "utf-8", NULL);
        value[k] = bytes ? py.PyBytes_AsString(bytes) : NULL;
        py.PyList_SetItem(kept, (Size)k, bytes);
    }
    if (list) py.Py_DecRef(list);
    if (s->strings) py.Py_DecRef(s->strings);
    s->strings = kept;
    return leave(s, lock, kept || !nvr ? fmi2OK : fmi2Error);
}

#define SET(function, method, Type, convert)                                                              \
    fmi2Status function(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const Type value[])   \
    {                                                                                                     \
        REQUIRE(nvr == 0 || (vr && value));                                                               \
        ENTER;                                                                                            \
        if (!nvr) return leave(s, lock, fmi2OK);                                                          \
        Object *const list = py.PyList_New((Size)nvr);                                                    \
        for (size_t k = 0; list && k < nvr; k++) py.PyList_SetItem(list, (Size)k, convert(value[k]));     \
        return run(s, lock, method, references(vr, nvr), list, NULL);                                     \
    }

static Object *from_string(const char *text) { return py.PyUnicode_FromString(text ? text : ""); }

SET(fmi2SetReal, "set_real", fmi2Real, py.PyFloat_FromDouble)
SET(fmi2SetInteger, "set_integer", fmi2Integer, py.PyLong_FromLong)
SET(fmi2SetBoolean, "set_boolean", fmi2Boolean, py.PyBool_FromLong)
SET(fmi2SetString, "set_string", fmi2String, from_string)

/* ---- States ---- */

/* What an importer holds as a state; its first member tells those of this FMU from others. */
typedef struct {
    const void *owner;
    Object *content;
} Saved;

static const char OWNER;

static Saved *ours(Slave *s, fmi2FMUstate state)
{
    Saved *const saved = state;
    if (saved && saved->owner == &OWNER) return saved;
    slave_refuse(s, "This is no state of the FMU.");
    return NULL;
}

/* Put content, which it takes over, into a state. */
static fmi2Status keep(Slave *s, fmi2FMUstate *state, Object *content)
{
    if (!content) return fmi2Error;
    Saved *const saved = *state ? ours(s, *state) : calloc(1, sizeof *saved);
    if (!saved) {
        py.Py_DecRef(content);
        return fmi2Error;
    }
    if (saved->content) py.Py_DecRef(saved->content);
    *saved = (Saved){&OWNER, content};
    *state = saved;
    return fmi2OK;
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *FMUstate)
{
    REQUIRE(FMUstate);
    ENTER;
    const fmi2Status status = keep(s, FMUstate, slave_call(s, "_get_fmu_state", NULL, NULL, NULL));
    return leave(s, lock, status);
}

static Object *shared(Object *object)
{
    py.Py_IncRef(object);
    return object;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate FMUstate)
{
    ENTER;
    Saved *const saved = ours(s, FMUstate);
    if (!saved) return leave(s, lock, fmi2Error);
    return run(s, lock, "_set_fmu_state", shared(saved->content), NULL, NULL);
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *FMUstate)
{
    REQUIRE(FMUstate);
    ENTER;
    Saved *const saved = *FMUstate ? ours(s, *FMUstate) : NULL;
    const fmi2Status status = saved || !*FMUstate ? fmi2OK : fmi2Error;
    if (saved) {
        py.Py_DecRef(saved->content);
        saved->owner = NULL;
        free(saved);
        *FMUstate = NULL;
    }
    return leave(s, lock, status);
}

static Object *bytes_of(Slave *s, fmi2FMUstate state)
{
    Saved *const saved = ours(s, state);
    return saved ? slave_call(s, "_fmu_state_to_bytes", shared(saved->content), NULL, NULL) : NULL;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate FMUstate, size_t *size)
{
    REQUIRE(size);
    ENTER;
    Object *const bytes = bytes_of(s, FMUstate);
    if (bytes) *size = (size_t)py.PyBytes_Size(bytes);
    if (bytes) py.Py_DecRef(bytes);
    return leave(s, lock, bytes ? fmi2OK : fmi2Error);
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate FMUstate, fmi2Byte serializedState[], size_t size)
{
    REQUIRE(serializedState);
    ENTER;
    Object *const bytes = bytes_of(s, FMUstate);
    const size_t needed = bytes ? (size_t)py.PyBytes_Size(bytes) : 0;
    fmi2Status status = bytes ? fmi2OK : fmi2Error;
    if (needed > size) status = slave_refuse(s, "An FMU state needs %zu bytes, %zu were given.", needed, size);
    else if (bytes) memcpy(serializedState, py.PyBytes_AsString(bytes), needed);
    if (bytes) py.Py_DecRef(bytes);
    return leave(s, lock, status);
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte serializedState[], size_t size, fmi2FMUstate *FMUstate)
{
    REQUIRE(serializedState && FMUstate);
    ENTER;
    Object *const bytes = py.PyBytes_FromStringAndSize(serializedState, (Size)size);
    Object *const content = slave_call(s, "_fmu_state_from_bytes", bytes, NULL, NULL);
    if (!content || py.PyObject_IsTrue(content) == 1) return leave(s, lock, keep(s, FMUstate, content));
    py.Py_DecRef(content);
    return leave(s, lock, slave_refuse(s, "The bytes are no state of this FMU."));
}

/* ---- Co-simulation ---- */

/* A step that a slave refuses is not done at any size: the FMU asks to stop (FMI 2.0.5, 4.2.2), at the time that it has
   reached. */
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real currentCommunicationPoint, fmi2Real communicationStepSize,
                      fmi2Boolean noSetFMUStatePriorToCurrentPoint)
{
    (void)noSetFMUStatePriorToCurrentPoint;
    ENTER;
    Object *const point = py.PyFloat_FromDouble(currentCommunicationPoint);
    Object *const done = slave_call(s, "do_step", point, py.PyFloat_FromDouble(communicationStepSize), NULL);
    const bool is_done = done && py.PyObject_IsTrue(done) == 1;
    if (done) py.Py_DecRef(done);
    const fmi2Status status = leave(s, lock, is_done ? fmi2OK : fmi2Discard);
    s->has_stopped = status != fmi2OK;
    s->time = currentCommunicationPoint + (s->has_stopped ? 0 : communicationStepSize);
    return status;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value)
{
    REQUIRE(c && value);
    if (kind != fmi2Terminated) return fmi2Discard;
    *value = ((Slave *)c)->has_stopped;
    return fmi2OK;
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
{
    REQUIRE(c && value);
    if (kind != fmi2LastSuccessfulTime) return fmi2Discard;
    *value = ((Slave *)c)->time;
    return fmi2OK;
}

/* Statuses of asynchronous steps only. */
#define NO_STATUS(function, Type)                                               \
    fmi2Status function(fmi2Component c, const fmi2StatusKind kind, Type *value) \
    {                                                                           \
        (void)kind;                                                             \
        REQUIRE(c && value);                                                    \
        return fmi2Discard;                                                     \
    }

NO_STATUS(fmi2GetStatus, fmi2Status)
NO_STATUS(fmi2GetIntegerStatus, fmi2Integer)
NO_STATUS(fmi2GetStringStatus, fmi2String)

fmi2Status fmi2CancelStep(fmi2Component c)
{
    return c ? slave_refuse(c, "There is no step to cancel: all steps are synchronous.") : fmi2Error;
}

/* ---- What the model description does not offer ---- */

#define REFUSED(function, what, ...)                                                     \
    fmi2Status function(__VA_ARGS__)                                                     \
    {                                                                                    \
        return c ? slave_refuse(c, "The FMU has no %s.", what) : fmi2Error;              \
    }
#define VALUES const fmi2ValueReference vr[], size_t nvr

REFUSED(fmi2GetDirectionalDerivative, "directional derivatives", fmi2Component c, VALUES,
        const fmi2ValueReference vKnown_ref[], size_t nKnown, const fmi2Real dvKnown[], fmi2Real dvUnknown[])
REFUSED(fmi2SetRealInputDerivatives, "input derivatives", fmi2Component c, VALUES, const fmi2Integer order[],
        const fmi2Real value[])
REFUSED(fmi2GetRealOutputDerivatives, "output derivatives", fmi2Component c, VALUES, const fmi2Integer order[],
        fmi2Real value[])
