/* The interface between a model and the FMI wrappers.

   Each FMU is compiled from the wrapper of its FMI version (fmi2.c or fmi3.c), what the wrappers share (instance.h), one
   model, and its table of variables: variables.h and variables.c are written from the model description when the FMU is
   built. A model works in its own units, those of SI divided by the variables' scales, and keeps nothing between calls but
   its memory. */
#ifndef MODEL_H
#define MODEL_H

#include "variables.h"

/* Length of an array that may be empty. */
#define ROOM(n) ((n) > 0 ? (n) : 1)

/* What a value or a communication point given by others may be off by, relative to one or to a range. */
#define ROUNDING 1e-9

/* Rows and columns of the Jacobian: derivatives and outputs, states and inputs. */
enum { N_UNKNOWNS = N_STATES + N_OUTPUTS, N_KNOWNS = N_STATES + N_INPUTS };

typedef enum { STATE, DERIVATIVE, INPUT, OUTPUT, PARAMETER, TIME } Kind;
typedef enum { REAL, BOOLEAN, ENUMERATION } Type; /* all but real ones are discrete */

/* A variable, by value reference. Start, bounds and nominal are in SI. */
typedef struct {
    const char *name, *unit;
    Kind kind;
    Type type;
    int is_bounded; /* values outside minimum .. maximum are refused */
    int limits; /* value reference of the lower limit that an input is held inside, the upper one's is next; or -1 */
    int starts; /* value reference of the state whose initial value a parameter gives, or -1 */
    double start, minimum, maximum, nominal, scale;
} Variable;

extern const Variable model_variables[N_VARIABLES];

/* Value references of the inputs, in the order of u. The first ones follow each other from INPUTS on. */
extern const int model_inputs[ROOM(N_INPUTS)];

/* What is wrong, in one sentence, by fault; 0 is none, 1 that a number is not finite. */
enum { FAULT_NOT_FINITE = 1 };
extern const char *const model_faults[N_FAULTS];

/* Each function returns 0 or a fault, and leaves its results undefined then. `values` are all variables in SI, where
   a model finds its parameters. `memory` holds N_MEMORY numbers of the instance, all zero at first and saved with its
   state: what the model remembers of its past, or results that it may find again. */

/* dx[N_STATES] at x[N_STATES], u[N_INPUTS]. */
int model_derivatives(const double x[], const double u[], const double values[], const double memory[], double dx[]);

/* y[N_OUTPUTS]. */
int model_outputs(const double x[], const double u[], const double values[], double memory[], double y[]);

/* y[N_DEFERRED], the outputs that cost so much that they are computed only when asked for; `model_outputs` leaves their
   places in y as they are. */
int model_deferred_outputs(const double x[], const double u[], const double values[], double memory[], double y[]);

/* jacobian[N_UNKNOWNS * N_KNOWNS], row by row; not asked for when no partial derivatives are declared. The rows of
   deferred outputs are those of another function, which is asked only for them. */
int model_jacobian(const double x[], const double u[], const double values[], double memory[], double jacobian[]);
int model_deferred_jacobian(const double x[], const double u[], const double values[], double memory[],
                            double jacobian[]);

/* Move x on by `duration` in s with constant u; on a fault the memory stays as it was. */
int model_advance(double x[], const double u[], const double values[], double memory[], double duration);

#endif
