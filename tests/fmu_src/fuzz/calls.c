/* Sequences of FMI calls read from bytes, in any order and with any values, against a native FMU (FMI is 2 or 3).

   Whatever an FMU writes must be finite. With libFuzzer (FUZZER is defined) it chooses the bytes; otherwise `main` takes the
   files that are named and then `count` random strings:  calls COUNT SEED [FILE ...] */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "variables.h"

#if FMI == 2
#include "fmi2Functions.h"
typedef fmi2Component Component;
typedef fmi2FMUstate State;
typedef fmi2Byte Byte;
#define CALL(name) fmi2##name
#else
#include "fmi3Functions.h"
typedef fmi3Instance Component;
typedef fmi3FMUState State;
typedef fmi3Byte Byte;
#define CALL(name) fmi3##name
#endif

enum { MOST = 64, STATES_KEPT = 3, MOST_CALLS = 400, DISCARDED = 2 };

typedef struct {
    const uint8_t *data;
    size_t size;
} Bytes;

static unsigned take(Bytes *b)
{
    if (!b->size) return 0;
    b->size--;
    return *b->data++;
}

/* A number that breaks things, or one in the range of the variables. */
static double number(Bytes *b)
{
    static const double special[] = {0, -0.0, 1, -1, 1e-300, 1e300, -1e308, 1e9, 5e-324, 0.005, 1e-7, 1e-30};
    const unsigned code = take(b);
    if (code == 255) return NAN;
    if (code == 254) return INFINITY;
    if (code == 253) return -INFINITY;
    if (code < 24) return special[code % 12];
    return ((int)code - 128) * (take(b) / 64.0);
}

static int is_long_step_taken;

/* One long step a string: with solver.tolerance it takes a hundred thousand steps. */
static double duration(Bytes *b)
{
    static const double times[] = {0, 0.001, 0.005, 0.0137, 0.02, 0.1, -0.1, 1e9, 1e300};
    const unsigned code = take(b);
    const double time = code > 250 ? number(b) : times[code % 9];
    return fabs(time) > 10 && is_long_step_taken++ ? 0.05 : time;
}

static size_t references(Bytes *b, unsigned vr[MOST])
{
    const size_t n = take(b) % 8;
    for (size_t k = 0; k < n; k++) {
        const unsigned code = take(b);
        vr[k] = code < 240 ? code % N_VARIABLES : code * 16843009u;
    }
    return n;
}

static void check(const char *what, int status, const double values[], size_t n)
{
    for (size_t k = 0; k < n && status <= DISCARDED; k++)
        if (!isfinite(values[k])) {
            fprintf(stderr, "%s wrote %g with status %d\n", what, values[k], status);
            abort();
        }
}

static unsigned long messages;

#if FMI == 2
static void logger(fmi2ComponentEnvironment e, fmi2String name, fmi2Status s, fmi2String category, fmi2String text, ...)
{
    (void)e, (void)name, (void)s;
    messages += strlen(category) + strlen(text);
}

static const fmi2CallbackFunctions CALLBACKS = {logger, calloc, free, NULL, NULL};

static Component instantiate(Bytes *b)
{
    const unsigned code = take(b);
    return fmi2Instantiate(code == 1 ? NULL : "one", code % 2 ? fmi2CoSimulation : fmi2ModelExchange,
                           code == 2 ? "{}" : code == 3 ? NULL : MODEL_TOKEN, NULL, code == 4 ? NULL : &CALLBACKS, 0,
                           code % 3 == 0);
}

static int enter_initialization(Component c, Bytes *b)
{
    const unsigned code = take(b);
    const int status = fmi2SetupExperiment(c, 0, 0, code == 1 ? number(b) : 0, code == 2, code == 2 ? number(b) : 0);
    return status ? status : (int)fmi2EnterInitializationMode(c);
}
#define GET(vr, n, v) fmi2GetReal(c, vr, n, v)
#define SET(vr, n, v) fmi2SetReal(c, vr, n, v)
#define DIRECTIONAL(u, nu, k, nk, seed, result) fmi2GetDirectionalDerivative(c, u, nu, k, nk, seed, result)
#define DERIVATIVES fmi2GetDerivatives
#define SAVE fmi2GetFMUstate
#define RESTORE fmi2SetFMUstate
#define FREE_STATE fmi2FreeFMUstate
#define SIZE_OF_STATE fmi2SerializedFMUstateSize
#define SERIALIZE fmi2SerializeFMUstate
#define DESERIALIZE fmi2DeSerializeFMUstate

static int step(Component c, double time, double duration) { return fmi2DoStep(c, time, duration, fmi2True); }

static void others(Component c, Bytes *b)
{
    const unsigned code = take(b), vr[1] = {take(b)};
    fmi2EventInfo info;
    fmi2Boolean flags[2];
    fmi2Integer integer[1] = {0};
    fmi2String string[1] = {"x"};
    fmi2Status status;
    double value[1] = {0};
    switch (code % 12) {
    case 0: fmi2NewDiscreteStates(c, code == 12 ? NULL : &info); break;
    case 1: fmi2CompletedIntegratorStep(c, 1, code == 13 ? NULL : flags, flags + 1); break;
    case 2: fmi2GetInteger(c, vr, 1, integer); break;
    case 3: fmi2SetInteger(c, vr, 1, integer); break;
    case 4: fmi2GetBoolean(c, vr, 1, integer); break;
    case 5: fmi2SetString(c, vr, 1, string); break;
    case 6: fmi2GetString(c, vr, 1, string); break;
    case 7: fmi2GetStatus(c, fmi2DoStepStatus, &status); break;
    case 8: fmi2GetRealStatus(c, fmi2LastSuccessfulTime, value); break;
    case 9: fmi2CancelStep(c); break;
    case 10: fmi2GetRealOutputDerivatives(c, vr, code % 2, integer, value); break;
    default: fmi2SetRealInputDerivatives(c, vr, code % 2, integer, value);
    }
}
#else
static void logger(fmi3InstanceEnvironment e, fmi3Status s, fmi3String category, fmi3String text)
{
    (void)e, (void)s;
    messages += strlen(category) + strlen(text);
}

static Component instantiate(Bytes *b)
{
    const unsigned code = take(b);
    const char *name = code == 1 ? NULL : "one", *token = code == 2 ? "{}" : code == 3 ? NULL : MODEL_TOKEN;
    const fmi3LogMessageCallback log = code == 4 ? NULL : logger;
    if (code == 5)
        return fmi3InstantiateScheduledExecution(name, token, NULL, false, true, NULL, log, NULL, NULL, NULL);
    if (code % 2 == 0) return fmi3InstantiateModelExchange(name, token, NULL, false, code % 3 == 0, NULL, log);
    return fmi3InstantiateCoSimulation(name, token, NULL, false, code % 3 == 0, code == 7, false, NULL, 0, NULL, log, NULL);
}

static int enter_initialization(Component c, Bytes *b)
{
    const unsigned code = take(b);
    return fmi3EnterInitializationMode(c, false, 0, code == 1 ? number(b) : 0, code == 2, code == 2 ? number(b) : 0);
}
#define GET(vr, n, v) fmi3GetFloat64(c, vr, n, v, n)
#define SET(vr, n, v) fmi3SetFloat64(c, vr, n, v, n)
#define DIRECTIONAL(u, nu, k, nk, seed, result) fmi3GetDirectionalDerivative(c, u, nu, k, nk, seed, nk, result, nu)
#define DERIVATIVES fmi3GetContinuousStateDerivatives
#define SAVE fmi3GetFMUState
#define RESTORE fmi3SetFMUState
#define FREE_STATE fmi3FreeFMUState
#define SIZE_OF_STATE fmi3SerializedFMUStateSize
#define SERIALIZE fmi3SerializeFMUState
#define DESERIALIZE fmi3DeserializeFMUState

static int step(Component c, double time, double duration)
{
    fmi3Boolean flags[3];
    fmi3Float64 last = 0;
    const int status = fmi3DoStep(c, time, duration, true, flags, flags + 1, flags + 2, &last);
    check("DoStep", status, &last, 1);
    return status;
}

static void others(Component c, Bytes *b)
{
    const unsigned code = take(b);
    fmi3ValueReference vr[2];
    vr[0] = take(b);
    vr[1] = take(b);
    fmi3Boolean flags[5];
    fmi3Int32 integer[1] = {0};
    fmi3Float64 value[2] = {0}, seed[2] = {number(b), 1};
    size_t count;
    switch (code % 12) {
    case 0: fmi3UpdateDiscreteStates(c, code == 12 ? NULL : flags, flags + 1, flags + 2, flags + 3, flags + 4, value); break;
    case 1: fmi3CompletedIntegratorStep(c, true, code == 13 ? NULL : flags, flags + 1); break;
    case 2: fmi3GetInt32(c, vr, 1, integer, 1); break;
    case 3: fmi3SetInt32(c, vr, 1, integer, 1); break;
    case 4: fmi3GetBoolean(c, vr, 1, flags, 1); break;
    case 5: fmi3EnterConfigurationMode(c); break;
    case 6: fmi3EnterStepMode(c); break;
    case 7: fmi3GetNumberOfContinuousStates(c, &count); break;
    case 8: fmi3GetNumberOfVariableDependencies(c, vr[0], &count); break;
    case 9: fmi3GetFloat64(c, vr, 2, value, code % 3); break;
    case 10: fmi3GetOutputDerivatives(c, vr, code % 2, integer, value, 1); break;
    default: {
        const int status = fmi3GetAdjointDerivative(c, vr, 1, vr + 1, 1, seed, 1, value, 1);
        check("GetAdjointDerivative", status, value, status ? 0 : 1);
    }
    }
}
#endif

/* Serialise a state, damage some of its bytes, and read it back. */
static void copy_state(Component c, Bytes *b, State from, State *to)
{
    size_t size = 0;
    if (SIZE_OF_STATE(c, from, &size)) return;
    Byte *bytes = calloc(size, 1);
    SERIALIZE(c, from, bytes, size);
    for (unsigned n = take(b) % 4; n; n--) {
        const size_t place = take(b) * 3u % size;
        bytes[place] = (Byte)take(b);
    }
    DESERIALIZE(c, bytes, take(b) == 1 ? size - 1 : size, to);
    free(bytes);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    Bytes bytes = {data, size}, *b = &bytes;
    is_long_step_taken = 0;
    Component c = instantiate(b);
    State saved[STATES_KEPT] = {NULL};
    double values[MOST] = {0}, seed[MOST] = {0};
    unsigned vr[MOST], other[MOST];
    int status;
    for (int calls = 0; c && b->size && calls < MOST_CALLS; calls++) {
        size_t n, m;
        switch (take(b) % 20) {
        case 0: enter_initialization(c, b); break;
        case 1: CALL(ExitInitializationMode)(c); break;
        case 2: CALL(EnterContinuousTimeMode)(c); break;
        case 3: CALL(EnterEventMode)(c); break;
        case 4:
            if (take(b) > 200) CALL(Terminate)(c);
            break;
        case 5:
            if (take(b) > 200) CALL(Reset)(c);
            break;
        case 6:
        case 7:
            n = references(b, vr);
            for (size_t k = 0; k < n; k++) values[k] = number(b);
            SET(vr, n, values);
            break;
        case 8:
        case 9:
            n = references(b, vr);
            status = GET(vr, n, values);
            check("get", status, values, n);
            break;
        case 10:
        case 11:
            vr[0] = TIME_REFERENCE;
            values[0] = 0;
            GET(vr, 1, values);
            if (take(b) == 1) values[0] = number(b);
            step(c, values[0], duration(b));
            break;
        case 12:
            for (int k = 0; k < N_STATES; k++) values[k] = number(b);
            CALL(SetContinuousStates)(c, values, take(b) == 1 ? N_STATES + 1 : N_STATES);
            break;
        case 13:
            status = DERIVATIVES(c, values, N_STATES);
            check("derivatives", status, values, N_STATES);
            status = CALL(GetContinuousStates)(c, values, N_STATES);
            check("states", status, values, N_STATES);
            break;
        case 14:
            n = references(b, vr);
            m = references(b, other);
            for (size_t k = 0; k < m; k++) seed[k] = number(b);
            status = DIRECTIONAL(vr, n, other, m, seed, values);
            check("directional", status, values, status ? 0 : n);
            break;
        case 15: SAVE(c, &saved[take(b) % STATES_KEPT]); break;
        case 16: RESTORE(c, saved[take(b) % STATES_KEPT]); break;
        case 17: copy_state(c, b, saved[take(b) % STATES_KEPT], &saved[take(b) % STATES_KEPT]); break;
        case 18: FREE_STATE(c, &saved[take(b) % STATES_KEPT]); break;
        default: others(c, b);
        }
    }
    for (int k = 0; c && k < STATES_KEPT; k++) FREE_STATE(c, &saved[k]);
    CALL(FreeInstance)(c);
    return 0;
}

#ifndef FUZZER
static uint64_t next(uint64_t *state)
{
    *state ^= *state << 13;
    *state ^= *state >> 7;
    return *state ^= *state << 17;
}

int main(int argc, char **argv)
{
    static uint8_t data[4096];
    const long count = argc > 1 ? atol(argv[1]) : 0;
    uint64_t state = argc > 2 ? strtoull(argv[2], NULL, 10) : 1;
    for (int k = 3; k < argc; k++) {
        FILE *file = fopen(argv[k], "rb");
        if (!file) return 2;
        LLVMFuzzerTestOneInput(data, fread(data, 1, sizeof data, file));
        fclose(file);
    }
    for (long n = 0; n < count; n++) {
        const size_t size = 16 + next(&state) % 512;
        for (size_t k = 0; k < size; k++) data[k] = (uint8_t)(next(&state) >> 24);
        /* Half of the strings begin in order, so that more of them get to steps and derivatives. */
        if (n % 2) memcpy(data + 1, (const uint8_t[]){0, 0, 1, n % 4 == 1 ? 2 : 8}, 4);
        LLVMFuzzerTestOneInput(data, size);
    }
    printf("%ld strings, %lu characters of log\n", count, messages);
    return messages == 0;
}
#endif
