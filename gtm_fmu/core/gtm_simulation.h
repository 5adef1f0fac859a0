/* A flight as time goes on (SPEC 10): servos, delays and lag between commands and surfaces, fuel, wind, failures.

   Units as in gtm_core.h. x[13]: the state and the fuel used (lb). Everything is an array of doubles, in the order of
   names.py: SIMULATION_INPUTS, SIMULATION_SETTINGS and SIMULATION_OUTPUTS. */
#ifndef GTM_SIMULATION_H
#define GTM_SIMULATION_H

#include "gtm_core.h"

enum { GTM_SIMULATION_NX = GTM_NX + 1, GTM_RECORDS = 2048 };

/* Inputs, constant over a step. */
typedef struct {
    double control[GTM_NU];                 /* elevator aileron rudder throttle */
    double flaps, spoilers, gear;           /* deg, deg, 0 up .. 1 down */
    double wind[3], gust[3];                /* ft/s: north, east, down; along the body axes */
} gtm_simulation_inputs;

/* Switches are 0 or 1. What begins with the failure, begins at its time. */
typedef struct {
    double limits[GTM_NU][2];               /* failure: inside which each control's command is held */
    double rate_limit[3];                   /* failure: deg/s of elevator, aileron, rudder; 0: they stand still */
    double failure_time;                    /* s after the start */
    double damage_case;                     /* failure: SPEC 10.5 */
    double engine_running[2];               /* failure: left, right */
    double stabilizer;                      /* deg */
    double has_shear, runway_altitude;      /* of the wind; ft */
    double has_stall_asymmetry;
    double has_servos, has_dead_band, has_throttle_lag;
    double command_delay, surface_delay;    /* s */
    double has_fuel_burn;
} gtm_simulation_settings;

typedef struct {
    double flight[GTM_NY];                  /* as those of gtm_core.h */
    double surface[GTM_SERVOS];             /* deg: elevator aileron rudder flaps, spoilers inboard and outboard */
    double throttle;                        /* % after the lag */
    double fuel_flow[2];                    /* lb/min: left, right */
    double authority[GTM_NU][2];            /* what is left of each control now */
} gtm_simulation_outputs;

/* Commands from a time on. */
typedef struct {
    double time, servo[GTM_SERVOS], throttle, gear;
} gtm_commands;

/* Surfaces are those that the airframe feels, so after their delay, and `start` is where they began. */
typedef struct {
    double is_begun, is_delayed, time;
    double surface[GTM_SERVOS], start[GTM_SERVOS], lag[2], throttle, gear;
    double oldest, records;                 /* which of the ring, and how many */
} gtm_actuators;

/* What is remembered; all zero before the first step. Commands are kept in a ring, a change each, from the oldest on.
   The two that a step may add go to free places, so that a step is undone by its actuators alone. */
enum { GTM_RING = GTM_RECORDS + 2 };
typedef struct {
    gtm_actuators now;
    gtm_commands ring[GTM_RING];
} gtm_simulation_memory;

/* Faults beyond those of gtm_core.h. */
enum gtm_simulation_fault {
    GTM_BAD_LIMITS = 7,          /* a lower limit above the upper one */
    GTM_BAD_SETTING = 8,         /* outside airframe/configuration.py, or a delay that is not 0 .. 1 s */
    GTM_TOO_MANY_COMMANDS = 9,   /* more than GTM_RECORDS changes of commands within the delays */
    GTM_BAD_MEMORY = 10          /* not what these functions have left */
};

GTM_API long gtm_simulation_memory_size(void); /* in doubles */

/* Derivatives dx[13] and outputs at the present moment. Before the first step the actuators have settled. */
GTM_API int gtm_simulation_evaluate(const double x[GTM_SIMULATION_NX], const gtm_simulation_inputs *u,
                                    const gtm_simulation_settings *p, const gtm_simulation_memory *memory,
                                    double dx[GTM_SIMULATION_NX], gtm_simulation_outputs *y);

/* Classical Runge-Kutta over `duration` in parts of `substep`, divided where commands arrive or the failure begins;
   actuators move in closed form. On a fault x and memory are left as they were. */
GTM_API int gtm_simulation_advance(double x[GTM_SIMULATION_NX], const gtm_simulation_inputs *u,
                                   const gtm_simulation_settings *p, gtm_simulation_memory *memory, double duration,
                                   double substep);

#endif
