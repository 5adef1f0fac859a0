/* One instance of an FMU: its values, its mode, its log. What FMI 2.0 and FMI 3.0 have in common.

   A call that is refused (status Error) changes nothing. A value that is refused (status Discard) leaves the old one,
   and nothing is computed until a good one comes. Nothing that leaves an instance is not finite. */
#ifndef INSTANCE_H
#define INSTANCE_H

#include <stdbool.h>
#include <stddef.h>

#include "model.h"

/* As in both standards. */
typedef enum { OK, WARNING, DISCARD, ERROR } Status;

typedef enum {
    INSTANTIATED = 1,
    INITIALIZATION = 2,
    STEP = 4,        /* co-simulation */
    EVENT = 8,       /* model exchange, like the next */
    CONTINUOUS = 16,
    TERMINATED = 32
} Mode;

enum { ANY_MODE = 63, INITIALIZED = STEP | EVENT | CONTINUOUS, READABLE = INITIALIZATION | INITIALIZED | TERMINATED };

/* What an FMU state saves. */
typedef struct {
    Mode mode;
    bool is_model_exchange;
    double values[N_VARIABLES];                /* SI, by value reference */
    bool is_refused[N_VARIABLES];              /* the last value given */
    bool is_held[ROOM(N_INPUTS)];              /* inside its limits, and logged */
    double memory[ROOM(N_MEMORY)];             /* the model's */
} Saved;

typedef struct Instance Instance;
typedef void Logger(const Instance *, Status, const char *category, const char *message);

struct Instance {
    Saved now;
    double stop_time;                          /* infinite if not given */
    bool is_step_refused;                      /* the last one */
    bool is_event_due;                         /* a discrete output is to change, when not stale */
    bool is_stale[3];                          /* derivatives, outputs, deferred outputs */
    bool is_slope_stale[2];                    /* those of deferred outputs by themselves */
    int fault[3];                              /* of the same, when not stale */
    double jacobian[ROOM(N_UNKNOWNS * N_KNOWNS)];
    unsigned logged;                           /* bit by category */
    Logger *logger;
    void (*callback)(void);                    /* the importer's, of the type that the wrapper knows */
    void *environment;
    char *name;
};

/* NULL, with one message, when the token is not that of this FMU or there is no name. */
Instance *instance_create(const char *name, const char *token, bool is_model_exchange, bool is_logging, Logger *logger,
                          void (*callback)(void), void *environment);
void instance_free(Instance *);

/* Whether `function` may be called in the present mode; logs if not. */
bool instance_allows(const Instance *, const char *function, unsigned modes);
Status instance_refuse(const Instance *, const char *format, ...);

/* Switch the named log categories on or off, all of them for n = 0; an exclusive call switches all others off. */
Status instance_set_logging(Instance *, bool is_on, bool is_exclusive, size_t n, const char *const categories[]);
Status instance_set_times(Instance *, double start, bool has_stop, double stop);
Status instance_reset(Instance *);
Status instance_initialize(Instance *);

/* Go to a mode of the instance's life. In model exchange discrete outputs change in Event Mode only (FMI 2.0.5, 2.2.7;
   FMI 3.0, 2.4.7.4): when an integrator step is completed, the instance says whether it needs one for that. */
void instance_enter(Instance *, Mode);
bool instance_needs_event(Instance *);

Status instance_get(Instance *, Type type, const unsigned references[], size_t n, double values[]);
Status instance_set(Instance *, Type type, const unsigned references[], size_t n, const double values[]);
/* Whether all of the variables can be got, or set, now; logs if not. Where it is true, the calls above and below are
   refused for none of them. */
bool instance_can_get(const Instance *, Type type, const unsigned references[], size_t n, const void *values);
bool instance_can_set(const Instance *, Type type, const unsigned references[], size_t n, const void *values);
Status instance_get_booleans(Instance *, const unsigned references[], size_t n, bool values[]);
Status instance_set_booleans(Instance *, const unsigned references[], size_t n, const bool values[]);

/* Derivatives (or, transposed, adjoint derivatives) of unknowns with respect to knowns, in SI. */
Status instance_differentiate(Instance *, const unsigned unknowns[], size_t n_unknowns, const unsigned knowns[],
                              size_t n_knowns, const double seed[], double sensitivity[], bool is_adjoint);

/* The n continuous states, and what belongs to them. */
Status instance_get_states(Instance *, double x[], size_t n);
Status instance_set_states(Instance *, const double x[], size_t n);
Status instance_get_derivatives(Instance *, double dx[], size_t n);
Status instance_get_nominals(const Instance *, double x[], size_t n);
Status instance_set_time(Instance *, double time);

/* A step that is not done leaves the instance where it was. */
Status instance_step(Instance *, double point, double duration);

Status instance_save(const Instance *, void **saved);
Status instance_restore(Instance *, const void *saved);
Status instance_free_saved(const Instance *, void **saved);
Status instance_serialized_size(const Instance *, const void *saved, size_t *size);
Status instance_serialize(const Instance *, const void *saved, void *bytes, size_t size);
Status instance_deserialize(const Instance *, const void *bytes, size_t size, void **saved);

double instance_time(const Instance *);

#endif
