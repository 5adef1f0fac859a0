/* The model at the values of an instance: results and steps. */
#include "internal.h"

#include <math.h>
#include <string.h>

const double *instance_range_of(const Instance *i, int input, double *command)
{
    const int limits = model_variables[model_inputs[input]].limits;
    *command = i->now.values[model_inputs[input]];
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
        const double *range = instance_range_of(i, k, &command);
        const double kept = held(command, range);
        const bool is_out = fabs(command - kept) > ROUNDING;
        if (is_out && !i->now.is_held[k])
            instance_say(i, WARNING, "%s %s is outside its limits and is held at %s (SI).", model_variables[model_inputs[k]].name,
                SHORTEST(command), SHORTEST(kept));
        i->now.is_held[k] = is_out;
    }
}

bool instance_load(Instance *i, double x[], double u[], const char *consequence)
{
    const double *values = i->now.values;
    for (int v = 0; v < N_VARIABLES; v++)
        if (i->now.is_refused[v]) {
            instance_say(i, DISCARD, "%s waits for a value that is allowed. %s", model_variables[v].name, consequence);
            return false;
        }
    for (int k = 0; k < N_INPUTS; k++) {
        double command;
        const double *range = instance_range_of(i, k, &command);
        if (range && range[0] > range[1]) {
            const Variable *lower = model_variables + model_variables[model_inputs[k]].limits;
            instance_say(i, DISCARD, "%s %s is above %s %s (SI). %s", lower[0].name, SHORTEST(range[0]), lower[1].name,
                SHORTEST(range[1]), consequence);
            return false;
        }
        u[k] = held(command, range) / model_variables[model_inputs[k]].scale;
    }
    for (int k = 0; k < N_STATES; k++) x[k] = values[STATES + k] / model_variables[STATES + k].scale;
    note_excursions(i);
    return true;
}

bool instance_is_deferred(int v) { return DEFERRED <= v && v < DEFERRED + N_DEFERRED; }

/* Whether an output keeps its value until the next event. */
static bool is_kept(const Instance *i, int v)
{
    return model_variables[v].type != REAL && i->now.is_model_exchange && i->now.mode & (CONTINUOUS | TERMINATED);
}

static const char STALE[] = "The outputs cannot be computed.";

Status instance_update(Instance *i, int part)
{
    if (i->is_stale[part]) {
        const int firsts[] = {DERIVATIVES, OUTPUTS, DEFERRED}, counts[] = {N_STATES, N_OUTPUTS, N_DEFERRED};
        const int first = firsts[part], n = counts[part];
        double x[ROOM(N_STATES)], u[ROOM(N_INPUTS)], results[ROOM(N_UNKNOWNS)], values[ROOM(N_UNKNOWNS)];
        i->is_stale[part] = false;
        i->fault[part] = -1;
        if (!instance_load(i, x, u, STALE)) return DISCARD;
        int fault = part == RATES     ? model_derivatives(x, u, i->now.values, i->now.memory, results)
                    : part == RESULTS ? model_outputs(x, u, i->now.values, i->now.memory, results)
                                      : model_deferred_outputs(x, u, i->now.values, i->now.memory, results);
        if (part == RESULTS) i->is_event_due = false;
        for (int k = 0; k < n && !fault; k++) {
            const double old = i->now.values[first + k];
            const bool is_later = part == RESULTS && instance_is_deferred(first + k);
            values[k] = is_later ? old : results[k] * model_variables[first + k].scale;
            if (!isfinite(values[k])) fault = FAULT_NOT_FINITE;
            if (is_kept(i, first + k) && values[k] != old) {
                i->is_event_due = true;
                values[k] = old;
            }
        }
        i->fault[part] = fault;
        if (fault) instance_say(i, DISCARD, "%s %s", model_faults[fault], STALE);
        else memcpy(i->now.values + first, values, (size_t)n * sizeof *values);
    }
    return i->fault[part] ? DISCARD : OK;
}

static Status take_step(Instance *i, double point, double duration)
{
    const double time = instance_time(i), size = fmax(1, fabs(time));
    if (!(isfinite(duration) && duration >= 0)) {
        instance_say(i, DISCARD, "A step of %s s was asked for, allowed is a finite one that is not negative. The step at "
            "%s s is refused.", SHORTEST(duration), SHORTEST(point));
        return DISCARD;
    }
    if (!isfinite(point) || fabs(point - time) > ROUNDING * size) /* a trap may wait for what compares NaN */
        return instance_refuse(i, "A step at %s s was asked for, but the FMU is at %s s.", SHORTEST(point), SHORTEST(time));
    if (point + duration > i->stop_time + ROUNDING * size)
        return instance_refuse(i, "A step to %s s was asked for, but the experiment stops at %s s.",
                               SHORTEST(point + duration), SHORTEST(i->stop_time));
    double x[ROOM(N_STATES)], u[ROOM(N_INPUTS)], moved[ROOM(N_STATES)];
    if (!instance_load(i, x, u, "The step is refused.")) return DISCARD;
    int fault = model_advance(x, u, i->now.values, i->now.memory, duration);
    for (int k = 0; k < N_STATES && !fault; k++) {
        moved[k] = x[k] * model_variables[STATES + k].scale;
        if (!isfinite(moved[k])) fault = FAULT_NOT_FINITE;
    }
    if (fault) {
        instance_say(i, DISCARD, "%s The step at %s s is refused and the FMU stays there: give other inputs or parameters, "
            "go back to a saved state, or end the simulation.", model_faults[fault], SHORTEST(point));
        return DISCARD;
    }
    if (N_STATES == 0) { /* a step is as good as its outputs, which stay those of the inputs */
        const Status status = instance_update(i, RESULTS);
        if (status != OK) return status;
    } else {
        memcpy(i->now.values + STATES, moved, N_STATES * sizeof *moved);
        instance_touch(i);
    }
    i->now.values[TIME_REFERENCE] = point + duration;
    return OK;
}

Status instance_step(Instance *i, double point, double duration)
{
    const Status status = take_step(i, point, duration);
    i->is_step_refused = status != OK;
    return status;
}
