/* States of an FMU: copies of what an instance holds, and their bytes. */
#include "internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

Status instance_save(const Instance *i, void **saved)
{
    if (instance_is_missing(i, 1, saved)) return ERROR;
    if (!*saved) *saved = malloc(sizeof i->now);
    if (!*saved) return instance_refuse(i, "There is no memory for an FMU state.");
    *(Saved *)*saved = i->now;
    return OK;
}

Status instance_restore(Instance *i, const void *saved)
{
    if (instance_is_missing(i, 1, saved)) return ERROR;
    if (((const Saved *)saved)->is_model_exchange != i->now.is_model_exchange)
        return instance_refuse(i, "The FMU state is that of an instance of the other kind.");
    i->now = *(const Saved *)saved;
    i->is_step_refused = false;
    instance_touch(i);
    return OK;
}

Status instance_free_saved(const Instance *i, void **saved)
{
    if (instance_is_missing(i, 1, saved)) return ERROR;
    free(*saved);
    *saved = NULL;
    return OK;
}

/* Token, mode, kind, refusals, holds, values, memory; nothing between them. */
enum { TOKEN_SIZE = sizeof MODEL_TOKEN, FLAGS = 2 + N_VARIABLES + N_INPUTS };

size_t instance_serialized_size(void) { return TOKEN_SIZE + FLAGS + (N_VARIABLES + N_MEMORY) * sizeof(double); }

Status instance_serialize(const Instance *i, const void *state, void *bytes, size_t size)
{
    if (instance_is_missing(i, 1, state) || instance_is_missing(i, 1, bytes)) return ERROR;
    if (size < instance_serialized_size())
        return instance_refuse(i, "An FMU state needs %zu bytes, %zu were given.", instance_serialized_size(), size);
    const Saved *saved = state;
    unsigned char *out = bytes, flags[FLAGS];
    flags[0] = (unsigned char)saved->mode;
    flags[1] = saved->is_model_exchange;
    for (int v = 0; v < N_VARIABLES; v++) flags[2 + v] = saved->is_refused[v];
    for (int k = 0; k < N_INPUTS; k++) flags[2 + N_VARIABLES + k] = saved->is_held[k];
    memcpy(out, MODEL_TOKEN, TOKEN_SIZE);
    memcpy(out + TOKEN_SIZE, flags, FLAGS);
    memcpy(out + TOKEN_SIZE + FLAGS, saved->values, sizeof saved->values);
    memcpy(out + TOKEN_SIZE + FLAGS + sizeof saved->values, saved->memory, N_MEMORY * sizeof(double));
    return OK;
}

/* Whether what was read can be the state of an instance. */
static bool is_sound(const Saved *saved, const unsigned char flags[])
{
    const int own = saved->is_model_exchange ? EVENT | CONTINUOUS : STEP;
    for (int k = 1; k < FLAGS; k++)
        if (flags[k] > 1) return false;
    for (int v = 0; v < N_VARIABLES; v++)
        if (!instance_is_allowed(model_variables + v, saved->values[v])) return false;
    for (int k = 0; k < N_MEMORY; k++)
        if (!isfinite(saved->memory[k])) return false;
    const int mode = flags[0];
    return mode && !(mode & (mode - 1)) && mode & (INSTANTIATED | INITIALIZATION | TERMINATED | own);
}

Status instance_deserialize(const Instance *i, const void *bytes, size_t size, void **state)
{
    if (instance_is_missing(i, 1, bytes) || instance_is_missing(i, 1, state)) return ERROR;
    const unsigned char *in = bytes, *flags = in + TOKEN_SIZE;
    if (size != instance_serialized_size() || memcmp(in, MODEL_TOKEN, TOKEN_SIZE))
        return instance_refuse(i, "The bytes are no state of this FMU.");
    Saved saved;
    saved.mode = (Mode)flags[0];
    saved.is_model_exchange = flags[1] != 0;
    for (int v = 0; v < N_VARIABLES; v++) saved.is_refused[v] = flags[2 + v] != 0;
    for (int k = 0; k < N_INPUTS; k++) saved.is_held[k] = flags[2 + N_VARIABLES + k] != 0;
    memcpy(saved.values, flags + FLAGS, sizeof saved.values);
    memcpy(saved.memory, flags + FLAGS + sizeof saved.values, N_MEMORY * sizeof(double));
    if (!is_sound(&saved, flags)) return instance_refuse(i, "The bytes are damaged and no state of this FMU.");
    if (!*state) *state = malloc(sizeof saved);
    if (!*state) return instance_refuse(i, "There is no memory for an FMU state.");
    *(Saved *)*state = saved;
    return OK;
}
