/* One slave of pythonfmu: its object, its log, and calls of its methods. A method's status is the worst that it has logged,
   or Error with the exception that it has raised; a warning is for the log only. */
#ifndef SLAVE_H
#define SLAVE_H

#include <stdbool.h>

#include "fmi2FunctionTypes.h"
#include "python.h"

typedef struct {
    Object *type, *arguments, *object; /* class, named arguments, what the class has made of them */
    Object *categories;                /* names of those that are logged; NULL: all */
    Object *strings;                   /* those last given to the importer */
    bool is_logging, is_interrupted;
    fmi2CallbackLogger logger;
    fmi2ComponentEnvironment environment;
    char *name;
    double time;                       /* reached so far */
    bool has_stopped;                  /* the last step was refused */
} Slave;

/* Log an error, which is always told. */
fmi2Status slave_refuse(const Slave *, const char *format, ...);

/* Import the class from the folder of the resources and make the object; there is none, but a message, if it raises. */
void slave_create(Slave *, const char *resources, bool is_visible);

/* Make the object anew; the old one stays where that fails. */
void slave_renew(Slave *);

/* Let go of what belongs to the interpreter. */
void slave_release(Slave *);

/* Result of a method with up to three arguments, which it takes over; NULL where it raises. */
Object *slave_call(Slave *, const char *method, Object *first, Object *second, Object *third);

/* Tell what the slave has logged or raised; the status of the whole, at least `status`. */
fmi2Status slave_status(Slave *, fmi2Status status);

#endif
