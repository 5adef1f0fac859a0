#include "instance.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MESSAGE_SIZE = 512, RATES = 0, RESULTS = 1 };

/* What a bound or a communication point given by others may be off by, relative to one. */
static const double ROUNDING = 1e-9;

/* LogCategories of the model description, by status; the last is for all. */
static const char *const CATEGORIES[] = {"logAll", "logStatusWarning", "logStatusDiscard", "logStatusError"};
enum { N_CATEGORIES = 4, ALL = 1 };

/* Messages may be format strings to an importer, so they hold no percent sign. Errors are always told. */
static void vsay(const Instance *i, Status status, const char *format, va_list arguments)
{
    if (!(i->logged & (ALL | 1u << status)) && status != ERROR) return;
    char message[MESSAGE_SIZE];
    vsnprintf(message, sizeof message, format, arguments);
    for (char *c = message; (c = strchr(c, '%'));) *c = '_';
    i->logger(i, status, CATEGORIES[status], message);
}

static void say(const Instance *i, Status status, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsay(i, status, format, arguments);
    va_end(arguments);
}

Status instance_refuse(const Instance *i, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsay(i, ERROR, format, arguments);
    va_end(arguments);
    return ERROR;
}

static bool is_missing(const Instance *i, size_t n, const void *pointer)
{
    if (n > 0 && !pointer) instance_refuse(i, "A null pointer was given for %zu values.", n);
    return n > 0 && !pointer;
}

static Status worse(Status a, Status b) { return a > b ? a : b; }

/* ---- Life ---- */

Instance *instance_create(const char *name, const char *token, bool is_model_exchange, bool is_logging, Logger *logger,
                          void (*callback)(void), void *environment)
{
    const bool is_named = name && *name, is_ours = token && !strcmp(token, MODEL_TOKEN);
    const size_t length = is_named ? strlen(name) : 0;
    Instance *i = calloc(1, sizeof *i);
    if (i) i->name = malloc(length + 1);
    if (!i || !i->name) {
        free(i);
        return NULL;
    }
    if (is_named) memcpy(i->name, name, length);
    i->name[length] = '\0';
    i->logger = logger;
    i->callback = callback;
    i->environment = environment;
    i->logged = is_logging ? ALL : 0;
    i->now.is_model_exchange = is_model_exchange;
    instance_reset(i);
    if (!is_named) instance_refuse(i, "An instance needs a name.");
    else if (!is_ours)
        instance_refuse(i, "The token %.80s is not that of this FMU, %s: read modelDescription.xml again.",
                        token ? token : "(null)", MODEL_TOKEN);
    if (is_named && is_ours) return i;
    instance_free(i);
    return NULL;
}

void instance_free(Instance *i)
{
    if (!i) return;
    free(i->name);
    free(i);
}

static void touch(Instance *i)
{
    i->is_stale[RATES] = i->is_stale[RESULTS] = i->is_slope_stale = true;
}

Status instance_reset(Instance *i)
{
    i->now.mode = INSTANTIATED;
    for (int v = 0; v < N_VARIABLES; v++) i->now.values[v] = model_variables[v].start;
    memset(i->now.is_refused, 0, sizeof i->now.is_refused);
    memset(i->now.is_held, 0, sizeof i->now.is_held);
    i->stop_time = INFINITY;
    touch(i);
    return OK;
}

Status instance_initialize(Instance *i)
{
    i->now.mode = i->now.is_model_exchange ? EVENT : STEP;
    return OK;
}

bool instance_allows(const Instance *i, const char *function, unsigned modes)
{
    if (!i) return false;
    if (!(i->now.mode & modes)) {
        const char *const names[] = {"Instantiated", "Initialization Mode", "Step Mode", "Event Mode",
                                     "Continuous-Time Mode", "Terminated"};
        int place = 0;
        while (i->now.mode >> place > 1) place++;
        instance_refuse(i, "%s must not be called in the state %s.", function, names[place]);
        return false;
    }
    return true;
}

Status instance_set_logging(Instance *i, bool is_on, size_t n, const char *const categories[])
{
    if (is_missing(i, n, categories)) return ERROR;
    unsigned logged = n ? 0 : ALL;
    for (size_t k = 0; k < n; k++) {
        unsigned category = 0;
        while (category < N_CATEGORIES && !(categories[k] && !strcmp(categories[k], CATEGORIES[category]))) category++;
        if (category == N_CATEGORIES)
            return instance_refuse(i, "There is no log category %.80s.", categories[k] ? categories[k] : "(null)");
        logged |= 1u << category;
    }
    i->logged = is_on ? logged : 0;
    return OK;
}

/* ---- Time ---- */

double instance_time(const Instance *i) { return i->now.values[TIME_REFERENCE]; }

Status instance_set_times(Instance *i, double start, bool has_stop, double stop)
{
    if (!isfinite(start) || (has_stop && !(isfinite(stop) && stop >= start)))
        return instance_refuse(i, "An experiment from %g s to %g s cannot be run.", start, has_stop ? stop : start);
    i->now.values[TIME_REFERENCE] = start;
    i->stop_time = has_stop ? stop : INFINITY;
    return OK;
}

Status instance_set_time(Instance *i, double time)
{
    if (!isfinite(time)) return instance_refuse(i, "The time was given as %g s, allowed is a finite one.", time);
    i->now.values[TIME_REFERENCE] = time;
    return OK;
}

/* ---- Evaluation ---- */

static const double *range_of(const Instance *i, int input, double *command)
{
    const int limits = model_variables[INPUTS + input].limits;
    *command = i->now.values[INPUTS + input];
    return limits < 0 ? NULL : i->now.values + limits;
}

static double held(double command, const double *range)
{
    return range ? fmin(fmax(command, range[0]), range[1]) : command;
}

/* The inputs as the model gets them; each command that leaves its limits is logged once. */
static void note_excursions(Instance *i)
{
    for (int k = 0; k < N_INPUTS; k++) {
        double command;
        const double *range = range_of(i, k, &command);
        const double kept = held(command, range);
        const bool is_out = fabs(command - kept) > ROUNDING;
        if (is_out && !i->now.is_held[k])
            say(i, WARNING, "%s %g is outside its limits and is held at %g (SI).", model_variables[INPUTS + k].name,
                command, kept);
        i->now.is_held[k] = is_out;
    }
}

/* States and held inputs in the model's units; whether they can be used. */
static bool load(Instance *i, double x[], double u[], const char *consequence)
{
    const double *values = i->now.values;
    for (int v = 0; v < N_VARIABLES; v++)
        if (i->now.is_refused[v]) {
            say(i, DISCARD, "%s waits for a value that is allowed. %s", model_variables[v].name, consequence);
            return false;
        }
    for (int k = 0; k < N_INPUTS; k++) {
        double command;
        const double *range = range_of(i, k, &command);
        if (range && range[0] > range[1]) {
            const Variable *lower = model_variables + model_variables[INPUTS + k].limits;
            say(i, DISCARD, "%s %g is above %s %g (SI). %s", lower[0].name, range[0], lower[1].name, range[1],
                consequence);
            return false;
        }
        u[k] = held(command, range) / model_variables[INPUTS + k].scale;
    }
    for (int k = 0; k < N_STATES; k++) x[k] = values[STATES + k] / model_variables[STATES + k].scale;
    note_excursions(i);
    return true;
}

static const char STALE[] = "The outputs cannot be computed.";

/* Derivatives or outputs at the present values; on a fault they stay those of the last good ones. */
static Status update(Instance *i, int part)
{
    if (i->is_stale[part]) {
        const int first = part == RATES ? DERIVATIVES : OUTPUTS, n = part == RATES ? N_STATES : N_OUTPUTS;
        double x[ROOM(N_STATES)], u[ROOM(N_INPUTS)], results[ROOM(N_UNKNOWNS)], values[ROOM(N_UNKNOWNS)];
        i->is_stale[part] = false;
        i->fault[part] = -1;
        if (!load(i, x, u, STALE)) return DISCARD;
        int fault = (part == RATES ? model_derivatives : model_outputs)(x, u, i->now.values, results);
        for (int k = 0; k < n && !fault; k++) {
            values[k] = results[k] * model_variables[first + k].scale;
            if (!isfinite(values[k])) fault = FAULT_NOT_FINITE;
        }
        i->fault[part] = fault;
        if (fault) say(i, DISCARD, "%s %s", model_faults[fault], STALE);
        else memcpy(i->now.values + first, values, (size_t)n * sizeof *values);
    }
    return i->fault[part] ? DISCARD : OK;
}

Status instance_step(Instance *i, double point, double duration)
{
    const double time = instance_time(i), size = fmax(1, fabs(time));
    if (!(isfinite(duration) && duration >= 0)) {
        say(i, DISCARD, "A step of %g s was asked for, allowed is a finite one that is not negative. The step at %g s is "
            "refused.", duration, point);
        return DISCARD;
    }
    if (!(fabs(point - time) <= ROUNDING * size))
        return instance_refuse(i, "A step at %g s was asked for, but the FMU is at %g s.", point, time);
    if (point + duration > i->stop_time + ROUNDING * size)
        return instance_refuse(i, "A step to %g s was asked for, but the experiment stops at %g s.", point + duration,
                               i->stop_time);
    double x[ROOM(N_STATES)], u[ROOM(N_INPUTS)], moved[ROOM(N_STATES)];
    if (!load(i, x, u, "The step is refused.")) return DISCARD;
    int fault = model_advance(x, u, i->now.values, duration);
    for (int k = 0; k < N_STATES && !fault; k++) {
        moved[k] = x[k] * model_variables[STATES + k].scale;
        if (!isfinite(moved[k])) fault = FAULT_NOT_FINITE;
    }
    if (fault) {
        say(i, DISCARD, "%s The step at %g s is refused.", model_faults[fault], point);
        return DISCARD;
    }
    memcpy(i->now.values + STATES, moved, N_STATES * sizeof *moved);
    i->now.values[TIME_REFERENCE] = point + duration;
    touch(i);
    return OK;
}

/* ---- Values ---- */

static bool is_known(const Instance *i, bool is_boolean, const unsigned references[], size_t n)
{
    for (size_t k = 0; k < n; k++)
        if (references[k] >= N_VARIABLES || (bool)model_variables[references[k]].is_boolean != is_boolean) {
            instance_refuse(i, "There is no %s variable with value reference %u.", is_boolean ? "Boolean" : "real",
                            references[k]);
            return false;
        }
    return true;
}

Status instance_get(Instance *i, bool is_boolean, const unsigned references[], size_t n, double values[])
{
    if (is_missing(i, n, references) || is_missing(i, n, values) || !is_known(i, is_boolean, references, n)) return ERROR;
    Status status = OK;
    for (size_t k = 0; k < n; k++) {
        const Kind kind = model_variables[references[k]].kind;
        if (kind == DERIVATIVE || kind == OUTPUT) status = worse(status, update(i, kind == DERIVATIVE ? RATES : RESULTS));
        values[k] = i->now.values[references[k]];
    }
    return status;
}

static Status take(Instance *i, unsigned v, double value)
{
    const Variable *variable = model_variables + v;
    const double slack = ROUNDING * fmax(1, fabs(value));
    const bool is_bounded = variable->kind == PARAMETER;
    touch(i);
    i->now.is_refused[v] =
        !isfinite(value) || (is_bounded && !(variable->minimum - slack <= value && value <= variable->maximum + slack));
    if (!i->now.is_refused[v]) {
        i->now.values[v] = value;
        return OK;
    }
    if (is_bounded)
        say(i, DISCARD, "%s was given as %g, allowed is %g .. %g %s: %g is kept.", variable->name, value,
            variable->minimum, variable->maximum, variable->unit, i->now.values[v]);
    else
        say(i, DISCARD, "%s was given as %g, allowed is a finite number: %g is kept.", variable->name, value,
            i->now.values[v]);
    return DISCARD;
}

/* Modes in which a variable can be set; zero when never. */
static unsigned settable_modes(Kind kind)
{
    switch (kind) {
    case STATE: return INSTANTIATED | INITIALIZATION | EVENT | CONTINUOUS;
    case INPUT: return INSTANTIATED | INITIALIZATION | INITIALIZED;
    case PARAMETER: return INSTANTIATED | INITIALIZATION | STEP | EVENT;
    default: return 0;
    }
}

Status instance_set(Instance *i, bool is_boolean, const unsigned references[], size_t n, const double values[])
{
    if (is_missing(i, n, references) || is_missing(i, n, values) || !is_known(i, is_boolean, references, n)) return ERROR;
    for (size_t k = 0; k < n; k++) {
        const Variable *variable = model_variables + references[k];
        const unsigned modes = settable_modes(variable->kind);
        if (!modes) return instance_refuse(i, "%s is computed by the FMU and cannot be set.", variable->name);
        if (!(modes & i->now.mode)) return instance_refuse(i, "%s cannot be set in the present mode.", variable->name);
    }
    Status status = OK;
    for (size_t k = 0; k < n; k++) status = worse(status, take(i, references[k], values[k]));
    return status;
}

static bool is_count_wrong(const Instance *i, size_t n)
{
    if (n != N_STATES) instance_refuse(i, "%zu continuous states were asked for, the FMU has %d.", n, N_STATES);
    return n != N_STATES;
}

Status instance_get_states(Instance *i, double x[], size_t n)
{
    if (is_count_wrong(i, n) || is_missing(i, n, x)) return ERROR;
    if (n) memcpy(x, i->now.values + STATES, n * sizeof *x);
    return OK;
}

Status instance_set_states(Instance *i, const double x[], size_t n)
{
    if (is_count_wrong(i, n) || is_missing(i, n, x)) return ERROR;
    Status status = OK;
    for (unsigned k = 0; k < n; k++) status = worse(status, take(i, STATES + k, x[k]));
    return status;
}

Status instance_get_derivatives(Instance *i, double dx[], size_t n)
{
    if (is_count_wrong(i, n) || is_missing(i, n, dx)) return ERROR;
    const Status status = update(i, RATES);
    if (n) memcpy(dx, i->now.values + DERIVATIVES, n * sizeof *dx);
    return status;
}

Status instance_get_nominals(const Instance *i, double x[], size_t n)
{
    if (is_count_wrong(i, n) || is_missing(i, n, x)) return ERROR;
    for (size_t k = 0; k < n; k++) x[k] = model_variables[STATES + k].nominal;
    return OK;
}

/* ---- Partial derivatives ---- */

/* Column of the Jacobian that belongs to a known, or -1; the factor is what a held input makes of the known's change. */
static int column_of(const Instance *i, unsigned known, double *factor)
{
    *factor = 1;
    if (model_variables[known].kind == STATE) return (int)known - STATES;
    for (int k = 0; k < N_INPUTS; k++) {
        double command;
        const double *range = range_of(i, k, &command), *value = i->now.values + known;
        if ((int)known == INPUTS + k)
            *factor = !range || (range[0] < range[1] && range[0] <= command && command <= range[1]);
        else if (range && value == range) *factor = command < range[0];
        else if (range && value == range + 1) *factor = command > range[1];
        else continue;
        return N_STATES + k;
    }
    return -1;
}

static int row_of(unsigned unknown)
{
    const Kind kind = model_variables[unknown].kind;
    return kind == DERIVATIVE ? (int)unknown - DERIVATIVES : kind == OUTPUT ? N_STATES + (int)unknown - OUTPUTS : -1;
}

static Status update_jacobian(Instance *i)
{
    if (!i->is_slope_stale) return OK;
    double x[ROOM(N_STATES)], u[ROOM(N_INPUTS)], jacobian[ROOM(N_UNKNOWNS * N_KNOWNS)];
    if (!load(i, x, u, "There are no derivatives.")) return DISCARD;
    int fault = model_jacobian(x, u, i->now.values, jacobian);
    for (int row = 0; row < N_UNKNOWNS && !fault; row++)
        for (int column = 0; column < N_KNOWNS && !fault; column++) {
            const Variable *unknown = model_variables + (row < N_STATES ? DERIVATIVES + row : OUTPUTS + row - N_STATES);
            const Variable *known = model_variables + (column < N_STATES ? STATES + column : INPUTS + column - N_STATES);
            double *slope = jacobian + row * N_KNOWNS + column;
            *slope *= unknown->scale / known->scale;
            if (!isfinite(*slope)) fault = FAULT_NOT_FINITE;
        }
    if (fault) {
        say(i, DISCARD, "%s There are no derivatives.", model_faults[fault]);
        return DISCARD;
    }
    memcpy(i->jacobian, jacobian, sizeof jacobian);
    i->is_slope_stale = false;
    return OK;
}

static double slope_of(const Instance *i, unsigned unknown, unsigned known)
{
    if (unknown == known) return 1;
    double factor;
    const int row = row_of(unknown), column = column_of(i, known, &factor);
    return row < 0 || column < 0 ? 0 : factor * i->jacobian[row * N_KNOWNS + column];
}

static bool are_of_kinds(const Instance *i, const unsigned references[], size_t n, unsigned kinds, const char *role)
{
    for (size_t k = 0; k < n; k++)
        if (!(1u << model_variables[references[k]].kind & kinds)) {
            instance_refuse(i, "%s is no %s of partial derivatives.", model_variables[references[k]].name, role);
            return false;
        }
    return true;
}

Status instance_differentiate(Instance *i, const unsigned unknowns[], size_t n_unknowns, const unsigned knowns[],
                              size_t n_knowns, const double seed[], double sensitivity[], bool is_adjoint)
{
    const size_t n_seed = is_adjoint ? n_unknowns : n_knowns, n = is_adjoint ? n_knowns : n_unknowns;
    if (is_missing(i, n_unknowns, unknowns) || is_missing(i, n_knowns, knowns) || is_missing(i, n_seed, seed) ||
        is_missing(i, n, sensitivity) || !is_known(i, false, unknowns, n_unknowns) ||
        !is_known(i, false, knowns, n_knowns) ||
        !are_of_kinds(i, unknowns, n_unknowns, 1u << STATE | 1u << DERIVATIVE | 1u << OUTPUT, "unknown") ||
        !are_of_kinds(i, knowns, n_knowns, 1u << STATE | 1u << INPUT | 1u << PARAMETER | 1u << TIME, "known"))
        return ERROR;
    Status status = update_jacobian(i);
    for (size_t a = 0; a < n && status == OK; a++) {
        double sum = 0;
        for (size_t b = 0; b < n_seed; b++)
            sum += seed[b] * (is_adjoint ? slope_of(i, unknowns[b], knowns[a]) : slope_of(i, unknowns[a], knowns[b]));
        if (!isfinite(sum)) return instance_refuse(i, "The seed is not finite or too large.");
        sensitivity[a] = sum;
    }
    return status;
}

/* ---- FMU states ---- */

Status instance_save(const Instance *i, void **saved)
{
    if (is_missing(i, 1, saved)) return ERROR;
    if (!*saved) *saved = malloc(sizeof i->now);
    if (!*saved) return instance_refuse(i, "There is no memory for an FMU state.");
    *(Saved *)*saved = i->now;
    return OK;
}

Status instance_restore(Instance *i, const void *saved)
{
    if (is_missing(i, 1, saved)) return ERROR;
    if (((const Saved *)saved)->is_model_exchange != i->now.is_model_exchange)
        return instance_refuse(i, "The FMU state is that of an instance of the other kind.");
    i->now = *(const Saved *)saved;
    touch(i);
    return OK;
}

Status instance_free_saved(const Instance *i, void **saved)
{
    if (is_missing(i, 1, saved)) return ERROR;
    free(*saved);
    *saved = NULL;
    return OK;
}

/* Token, mode, kind, values, refusals, holds; nothing between them. */
enum { TOKEN_SIZE = sizeof MODEL_TOKEN, FLAGS = 2 + N_VARIABLES + N_INPUTS };

size_t instance_serialized_size(void) { return TOKEN_SIZE + FLAGS + N_VARIABLES * sizeof(double); }

Status instance_serialize(const Instance *i, const void *state, void *bytes, size_t size)
{
    if (is_missing(i, 1, state) || is_missing(i, 1, bytes)) return ERROR;
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
    return OK;
}

/* Whether what was read can be the state of an instance. */
static bool is_sound(const Saved *saved, const unsigned char flags[])
{
    const int own = saved->is_model_exchange ? EVENT | CONTINUOUS : STEP;
    for (int k = 1; k < FLAGS; k++)
        if (flags[k] > 1) return false;
    for (int v = 0; v < N_VARIABLES; v++) {
        const Variable *variable = model_variables + v;
        const double value = saved->values[v], slack = ROUNDING * fmax(1, fabs(value));
        if (!isfinite(value)) return false;
        if (variable->kind == PARAMETER && !(variable->minimum - slack <= value && value <= variable->maximum + slack))
            return false;
    }
    const int mode = flags[0];
    return mode && !(mode & (mode - 1)) && mode & (INSTANTIATED | INITIALIZATION | TERMINATED | own);
}

Status instance_deserialize(const Instance *i, const void *bytes, size_t size, void **state)
{
    if (is_missing(i, 1, bytes) || is_missing(i, 1, state)) return ERROR;
    const unsigned char *in = bytes, *flags = in + TOKEN_SIZE;
    if (size != instance_serialized_size() || memcmp(in, MODEL_TOKEN, TOKEN_SIZE))
        return instance_refuse(i, "The bytes are no state of this FMU.");
    Saved saved;
    saved.mode = (Mode)flags[0];
    saved.is_model_exchange = flags[1] != 0;
    for (int v = 0; v < N_VARIABLES; v++) saved.is_refused[v] = flags[2 + v] != 0;
    for (int k = 0; k < N_INPUTS; k++) saved.is_held[k] = flags[2 + N_VARIABLES + k] != 0;
    memcpy(saved.values, flags + FLAGS, sizeof saved.values);
    if (!is_sound(&saved, flags)) return instance_refuse(i, "The bytes are damaged and no state of this FMU.");
    if (!*state) *state = malloc(sizeof saved);
    if (!*state) return instance_refuse(i, "There is no memory for an FMU state.");
    *(Saved *)*state = saved;
    return OK;
}
