/* States of an FMU. A copy in memory and its bytes have one form, and both are checked before they are used: an importer
   may give the state of another FMU, or bytes that were damaged where they were kept. */
#include "internal.h"

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define WHOLE_WORDS(bytes) (((bytes) + sizeof(uint64_t) - 1) / sizeof(uint64_t) * sizeof(uint64_t))

/* Mode, kind, refusals, holds. */
enum { FLAGS = 2 + N_VARIABLES + N_INPUTS };

/* Whole words, so that nothing lies between the members. */
typedef struct {
    char token[WHOLE_WORDS(sizeof MODEL_TOKEN)];
    uint64_t size;
    unsigned char flags[WHOLE_WORDS(FLAGS)];
    double values[N_VARIABLES], memory[ROOM(N_MEMORY)];
    uint64_t checksum;
} State;

/* Of all that lies before it. Each step is one to one, so that a change within one word never goes unnoticed. */
static uint64_t checksum(const State *state)
{
    uint64_t sum = 0xCBF29CE484222325u;
    for (size_t at = 0; at < offsetof(State, checksum); at += sizeof sum) {
        uint64_t word;
        memcpy(&word, (const char *)state + at, sizeof word);
        sum = (sum ^ word) * 0x9E3779B97F4A7C15u;
        sum ^= sum >> 32;
    }
    return sum;
}

static void pack(const Saved *saved, State *state)
{
    memset(state, 0, sizeof *state);
    memcpy(state->token, MODEL_TOKEN, sizeof MODEL_TOKEN);
    state->size = sizeof *state;
    state->flags[0] = (unsigned char)saved->mode;
    state->flags[1] = saved->is_model_exchange;
    for (int v = 0; v < N_VARIABLES; v++) state->flags[2 + v] = saved->is_refused[v];
    for (int k = 0; k < N_INPUTS; k++) state->flags[2 + N_VARIABLES + k] = saved->is_held[k];
    memcpy(state->values, saved->values, sizeof saved->values);
    memcpy(state->memory, saved->memory, sizeof saved->memory);
    state->checksum = checksum(state);
}

static void unpack(const State *state, Saved *saved)
{
    saved->mode = (Mode)state->flags[0];
    saved->is_model_exchange = state->flags[1] != 0;
    for (int v = 0; v < N_VARIABLES; v++) saved->is_refused[v] = state->flags[2 + v] != 0;
    for (int k = 0; k < N_INPUTS; k++) saved->is_held[k] = state->flags[2 + N_VARIABLES + k] != 0;
    memcpy(saved->values, state->values, sizeof saved->values);
    memcpy(saved->memory, state->memory, sizeof saved->memory);
}

/* Whether what was read can be the state of an instance. */
static bool is_sound(const State *state)
{
    const int mode = state->flags[0], own = state->flags[1] ? EVENT | CONTINUOUS : STEP;
    for (int k = 1; k < FLAGS; k++)
        if (state->flags[k] > 1) return false;
    for (int v = 0; v < N_VARIABLES; v++)
        if (!instance_is_allowed(model_variables + v, state->values[v])) return false;
    for (int k = 0; k < N_MEMORY; k++)
        if (!isfinite(state->memory[k])) return false;
    return mode && !(mode & (mode - 1)) && mode & (INSTANTIATED | INITIALIZATION | TERMINATED | own);
}

/* Whether a state is one of this FMU; of another one no more is read than what differs first. Logs if not. */
static bool is_own(const Instance *i, const State *state)
{
    if (instance_is_missing(i, 1, state)) return false;
    const bool is = !strncmp(state->token, MODEL_TOKEN, sizeof MODEL_TOKEN) && state->size == sizeof *state;
    if (!is) instance_refuse(i, "The FMU state is not one of this FMU: give what GetFMUstate gave for it.");
    return is;
}

/* Whether it can be used as well. */
static bool is_whole(const Instance *i, const State *state)
{
    if (!is_own(i, state)) return false;
    const bool is = state->checksum == checksum(state) && is_sound(state);
    if (!is) instance_refuse(i, "The FMU state is damaged.");
    return is;
}

/* Room for a state where there is none yet; NULL, with a message, when there can be none. */
static State *room(const Instance *i, void **state)
{
    if (*state) return is_own(i, *state) ? *state : NULL;
    *state = malloc(sizeof(State));
    if (!*state) instance_refuse(i, "There is no memory for an FMU state.");
    return *state;
}

Status instance_save(const Instance *i, void **saved)
{
    if (instance_is_missing(i, 1, saved)) return ERROR;
    State *state = room(i, saved);
    if (!state) return ERROR;
    pack(&i->now, state);
    return OK;
}

Status instance_restore(Instance *i, const void *saved)
{
    const State *state = saved;
    if (!is_whole(i, state)) return ERROR;
    if ((state->flags[1] != 0) != i->now.is_model_exchange)
        return instance_refuse(i, "The FMU state is that of an instance of the other kind.");
    unpack(state, &i->now);
    i->is_step_refused = false;
    instance_touch(i);
    return OK;
}

Status instance_free_saved(const Instance *i, void **saved)
{
    if (instance_is_missing(i, 1, saved)) return ERROR;
    if (*saved && !is_own(i, *saved)) return ERROR;
    free(*saved);
    *saved = NULL;
    return OK;
}

Status instance_serialized_size(const Instance *i, const void *saved, size_t *size)
{
    if (instance_is_missing(i, 1, size) || !is_own(i, saved)) return ERROR;
    *size = sizeof(State);
    return OK;
}

Status instance_serialize(const Instance *i, const void *saved, void *bytes, size_t size)
{
    if (instance_is_missing(i, 1, bytes) || !is_whole(i, saved)) return ERROR;
    if (size < sizeof(State))
        return instance_refuse(i, "An FMU state needs %zu bytes, %zu were given.", sizeof(State), size);
    memcpy(bytes, saved, sizeof(State));
    return OK;
}

Status instance_deserialize(const Instance *i, const void *bytes, size_t size, void **saved)
{
    if (instance_is_missing(i, 1, bytes) || instance_is_missing(i, 1, saved)) return ERROR;
    if (size != sizeof(State))
        return instance_refuse(i, "An FMU state of this FMU has %zu bytes, %zu were given.", sizeof(State), size);
    void *read = malloc(sizeof(State)); /* the bytes may lie at any address */
    if (!read) return instance_refuse(i, "There is no memory for an FMU state.");
    memcpy(read, bytes, sizeof(State));
    State *state = is_whole(i, read) ? room(i, saved) : NULL;
    if (state) memcpy(state, read, sizeof *state);
    free(read);
    return state ? OK : ERROR;
}
