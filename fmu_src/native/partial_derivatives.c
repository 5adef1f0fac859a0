/* Directional and adjoint derivatives from the model's Jacobian. */
#include "internal.h"

#include <math.h>
#include <string.h>

/* Column of the Jacobian that belongs to a known, or -1; the factor is what a held input makes of the known's change. */
static int column_of(const Instance *i, unsigned known, double *factor)
{
    *factor = 1;
    if (model_variables[known].kind == STATE) return (int)known - STATES;
    if (model_variables[known].starts >= 0) return i->now.mode == INITIALIZATION ? model_variables[known].starts - STATES : -1;
    for (int k = 0; k < N_INPUTS; k++) {
        double command;
        const double *range = instance_range_of(i, k, &command), *value = i->now.values + known;
        if ((int)known == model_inputs[k])
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

/* The rows of deferred outputs, or all others. */
static Status update_jacobian(Instance *i, bool is_deferred)
{
    if (!i->is_slope_stale[is_deferred]) return OK;
    double x[ROOM(N_STATES)], u[ROOM(N_INPUTS)], jacobian[ROOM(N_UNKNOWNS * N_KNOWNS)];
    if (!instance_load(i, x, u, "There are no derivatives.")) return DISCARD;
    int fault = is_deferred ? model_deferred_jacobian(x, u, i->now.values, i->now.memory, jacobian)
                            : model_jacobian(x, u, i->now.values, i->now.memory, jacobian);
    for (int row = 0; row < N_UNKNOWNS && !fault; row++) {
        if (instance_is_deferred(OUTPUTS + row - N_STATES) != is_deferred) continue;
        for (int column = 0; column < N_KNOWNS && !fault; column++) {
            const Variable *unknown = model_variables + (row < N_STATES ? DERIVATIVES + row : OUTPUTS + row - N_STATES);
            const Variable *known = model_variables + (column < N_STATES ? STATES + column : model_inputs[column - N_STATES]);
            double *slope = jacobian + row * N_KNOWNS + column;
            *slope *= unknown->scale / known->scale;
            if (!isfinite(*slope)) fault = FAULT_NOT_FINITE;
        }
        if (!fault) memcpy(i->jacobian + row * N_KNOWNS, jacobian + row * N_KNOWNS, N_KNOWNS * sizeof *jacobian);
    }
    if (fault) {
        instance_say(i, DISCARD, "%s There are no derivatives.", model_faults[fault]);
        return DISCARD;
    }
    i->is_slope_stale[is_deferred] = false;
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
    if (instance_is_missing(i, n_unknowns, unknowns) || instance_is_missing(i, n_knowns, knowns) || instance_is_missing(i, n_seed, seed) ||
        instance_is_missing(i, n, sensitivity) || !instance_is_known(i, REAL, unknowns, n_unknowns) ||
        !instance_is_known(i, REAL, knowns, n_knowns) ||
        !are_of_kinds(i, unknowns, n_unknowns, 1u << STATE | 1u << DERIVATIVE | 1u << OUTPUT, "unknown") ||
        !are_of_kinds(i, knowns, n_knowns, 1u << STATE | 1u << INPUT | 1u << PARAMETER | 1u << TIME, "known"))
        return ERROR;
    Status status = OK;
    for (size_t k = 0; k < n_unknowns && status == OK; k++)
        status = update_jacobian(i, instance_is_deferred((int)unknowns[k]));
    for (size_t a = 0; a < n && status == OK; a++) {
        double sum = 0;
        for (size_t b = 0; b < n_seed; b++)
            sum += seed[b] * (is_adjoint ? slope_of(i, unknowns[b], knowns[a]) : slope_of(i, unknowns[a], knowns[b]));
        if (!isfinite(sum)) return instance_refuse(i, "The seed is not finite or too large.");
        sensitivity[a] = sum;
    }
    return status;
}
