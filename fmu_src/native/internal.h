/* What the files of an instance share. */
#ifndef INTERNAL_H
#define INTERNAL_H

#include "instance.h"

/* Parts of the results, which are computed when they are asked for. */
enum { RATES, RESULTS, LATER };

/* The shortest text that reads back as the number, with a point in every locale; it lives as long as the block around it. */
#define SHORTEST(number) write_shortest((char[32]){""}, number)
const char *write_shortest(char text[32], double number);

/* Log a message in its category; errors are always told. */
void instance_say(const Instance *, Status, const char *format, ...);

/* Whether a pointer to n values is null, or a value reference unknown; logs if so, or if not. */
bool instance_is_missing(const Instance *, size_t n, const void *pointer);
bool instance_is_known(const Instance *, Type type, const unsigned references[], size_t n);

/* Whether a number may be the value of a variable. */
bool instance_is_allowed(const Variable *, double value);

/* Everything computed is to be computed again. */
void instance_touch(Instance *);

/* Limits {lower, upper} and command of an input; NULL without limits. */
const double *instance_range_of(const Instance *, int input, double *command);

/* States and held inputs in the model's units; whether they can be used, with what follows if not. */
bool instance_load(Instance *, double x[], double u[], const char *consequence);

/* Whether an output is computed only when it is asked for itself. */
bool instance_is_deferred(int v);

/* Derivatives (RATES), outputs (RESULTS) or deferred ones (LATER) at the present values; on a fault they stay those of
   the last good ones. */
Status instance_update(Instance *, int part);

#endif
