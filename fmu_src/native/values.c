/* Values by value reference and continuous states. */
#include "internal.h"

#include <math.h>
#include <string.h>

bool instance_is_known(const Instance *i, Type type, const unsigned references[], size_t n)
{
    for (size_t k = 0; k < n; k++)
        if (references[k] >= N_VARIABLES || model_variables[references[k]].type != type) {
            static const char *const names[] = {"real", "Boolean", "enumeration"};
            instance_refuse(i, "There is no %s variable with value reference %u.", names[type], references[k]);
            return false;
        }
    return true;
}

bool instance_is_allowed(const Variable *variable, double value)
{
    const double slack = ROUNDING * fmax(1, fabs(value));
    if (!variable->is_bounded) return isfinite(value);
    return isfinite(value) && variable->minimum - slack <= value && value <= variable->maximum + slack;
}

static Status worse(Status a, Status b) { return a > b ? a : b; }

/* Whether all variables have start values; logs if not. */
static bool have_starts(const Instance *i, const unsigned references[], size_t n)
{
    for (size_t k = 0; k < n; k++) {
        const Variable *variable = model_variables + references[k];
        if (variable->kind == DERIVATIVE || variable->kind == OUTPUT) {
            instance_refuse(i, "%s has no start value: it is computed from Initialization Mode on.", variable->name);
            return false;
        }
    }
    return true;
}

/* Whether references and values are there, and the variables known; logs if not. */
static bool are_given(const Instance *i, Type type, const unsigned references[], size_t n, const void *values)
{
    return !instance_is_missing(i, n, references) && !instance_is_missing(i, n, values) &&
           instance_is_known(i, type, references, n);
}

bool instance_can_get(const Instance *i, Type type, const unsigned references[], size_t n, const void *values)
{
    return are_given(i, type, references, n, values) &&
           (i->now.mode != INSTANTIATED || have_starts(i, references, n));
}

Status instance_get(Instance *i, Type type, const unsigned references[], size_t n, double values[])
{
    if (!instance_can_get(i, type, references, n, values)) return ERROR;
    Status status = OK;
    for (size_t k = 0; k < n; k++) {
        const Kind kind = model_variables[references[k]].kind;
        const int part = kind == DERIVATIVE ? RATES : instance_is_deferred((int)references[k]) ? LATER : RESULTS;
        if (kind == DERIVATIVE || kind == OUTPUT) status = worse(status, instance_update(i, part));
        values[k] = i->now.values[references[k]];
    }
    return status;
}

static Status take(Instance *i, unsigned v, double value)
{
    const Variable *variable = model_variables + v;
    const bool is_allowed = instance_is_allowed(variable, value);
    if (!is_allowed || i->now.is_refused[v] || value != i->now.values[v]) instance_touch(i);
    i->now.is_refused[v] = !is_allowed;
    if (is_allowed) {
        const bool is_start = variable->starts >= 0 && value != i->now.values[v]; /* unchanged, the state is its own */
        i->now.values[v] = value;
        return is_start ? take(i, (unsigned)variable->starts, value) : OK;
    }
    if (variable->is_bounded)
        instance_say(i, DISCARD, "%s was given as %s, allowed is %s .. %s %s: %s is kept.", variable->name, SHORTEST(value),
            SHORTEST(variable->minimum), SHORTEST(variable->maximum), variable->unit, SHORTEST(i->now.values[v]));
    else
        instance_say(i, DISCARD, "%s was given as %s, allowed is a finite number: %s is kept.", variable->name,
            SHORTEST(value), SHORTEST(i->now.values[v]));
    return DISCARD;
}

/* Modes in which a variable can be set; zero when never. */
static unsigned settable_modes(const Variable *variable)
{
    switch (variable->kind) {
    case STATE: return INSTANTIATED | INITIALIZATION | EVENT | CONTINUOUS;
    case INPUT: return INSTANTIATED | INITIALIZATION | STEP | EVENT | (variable->type == REAL ? CONTINUOUS : 0);
    case PARAMETER: return INSTANTIATED | INITIALIZATION | (variable->starts < 0 ? STEP | EVENT : 0);
    default: return 0;
    }
}

bool instance_can_set(const Instance *i, Type type, const unsigned references[], size_t n, const void *values)
{
    if (!are_given(i, type, references, n, values)) return false;
    for (size_t k = 0; k < n; k++) {
        const Variable *variable = model_variables + references[k];
        const unsigned modes = settable_modes(variable);
        if (modes & i->now.mode) continue;
        instance_refuse(i, modes ? "%s cannot be set in the present mode." : "%s is computed by the FMU and cannot be set.",
                        variable->name);
        return false;
    }
    return true;
}

Status instance_set(Instance *i, Type type, const unsigned references[], size_t n, const double values[])
{
    if (!instance_can_set(i, type, references, n, values)) return ERROR;
    Status status = OK;
    for (size_t k = 0; k < n; k++) status = worse(status, take(i, references[k], values[k]));
    return status;
}

Status instance_get_booleans(Instance *i, const unsigned references[], size_t n, bool values[])
{
    if (!instance_can_get(i, BOOLEAN, references, n, values)) return ERROR;
    Status status = OK;
    for (size_t k = 0; k < n; k++) {
        double number;
        status = worse(status, instance_get(i, BOOLEAN, references + k, 1, &number));
        values[k] = number != 0;
    }
    return status;
}

Status instance_set_booleans(Instance *i, const unsigned references[], size_t n, const bool values[])
{
    if (!instance_can_set(i, BOOLEAN, references, n, values)) return ERROR;
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
    if (is_count_wrong(i, n) || instance_is_missing(i, n, x)) return ERROR;
    if (n) memcpy(x, i->now.values + STATES, n * sizeof *x);
    return OK;
}

Status instance_set_states(Instance *i, const double x[], size_t n)
{
    if (is_count_wrong(i, n) || instance_is_missing(i, n, x)) return ERROR;
    Status status = OK;
    for (unsigned k = 0; k < n; k++) status = worse(status, take(i, STATES + k, x[k]));
    return status;
}

Status instance_get_derivatives(Instance *i, double dx[], size_t n)
{
    if (is_count_wrong(i, n) || instance_is_missing(i, n, dx)) return ERROR;
    const Status status = instance_update(i, RATES);
    if (n) memcpy(dx, i->now.values + DERIVATIVES, n * sizeof *dx);
    return status;
}

Status instance_get_nominals(const Instance *i, double x[], size_t n)
{
    if (is_count_wrong(i, n) || instance_is_missing(i, n, x)) return ERROR;
    for (size_t k = 0; k < n; k++) x[k] = model_variables[STATES + k].nominal;
    return OK;
}
