/* What a failure leaves of the aircraft, and envelopes and manoeuvres under it, as plain numbers: what FMUs are told and
   tell.

   Units as in gtm_core.h. The numbers are in the order of names.py: FAILURE. */
#ifndef GTM_FAILURE_H
#define GTM_FAILURE_H

#include "gtm_query.h"

typedef struct {
    double limits[GTM_NU][2];               /* inside which each control is held: lower, upper */
    double engine_limits[2][2];             /* of each engine's throttle, left and right, besides those of both */
    double alpha[2], bank[2];               /* rad */
    double has_two_throttles;               /* whether each engine has a throttle of its own */
    double damage_case;                     /* SPEC 10.5 */
    double engine_running[2];               /* left, right */
    double stabilizer, flaps, spoilers;     /* deg, all panels alike */
    double gear;                            /* 0 up .. 1 down */
    double fuel_used;                       /* lb */
} gtm_failure;

/* What is wrong with it. GTM_REVERSED + k: of its k-th pair, lower is above upper. */
enum gtm_failure_fault {
    GTM_LEFT = 0,
    GTM_REVERSED = 2,
    GTM_NO_THROTTLE = GTM_REVERSED + 8,     /* none is inside the limits of both engines and of each that it drives */
    GTM_BAD_DAMAGE,                         /* no whole number, or no such case */
    GTM_BAD_AIRFRAME,                       /* stabiliser, flaps, spoilers, gear or fuel out of range */
    GTM_RUDDER_REVERSED,                    /* of a case */
    GTM_NO_RUDDER,                          /* no deflection is inside the limits of a case and of its failure */
    GTM_NO_SLOPES                           /* what is asked about has none: nothing settles it, or too much */
};

/* A question has four numbers, then those of the failure. */
enum { GTM_ASKED = 4, GTM_TOLD = GTM_ASKED + sizeof(gtm_failure) / sizeof(double) };

/* What the solvers take: bounds of a steady manoeuvre, and the airframe. */
typedef struct {
    enum gtm_throttles throttles;
    double lower[GTM_TWO_THROTTLE_NT], upper[GTM_TWO_THROTTLE_NT];
    int from[GTM_TWO_THROTTLE_NT][2];       /* which number of a question each bound is, -1: none */
    int is_study;                           /* the study's airframe, which the solvers know best */
    gtm_configuration configuration;        /* if not */
} gtm_remainder;

/* Bounds lower[9] and upper[9] of the undamaged aircraft give those of V, beta and psi_dot. */
GTM_API int gtm_take_failure(const gtm_failure *f, const double lower[GTM_NT], const double upper[GTM_NT],
                             gtm_remainder *left);

/* The airframe that the solvers take. */
GTM_API const gtm_configuration *gtm_airframe_left(const gtm_remainder *left);

/* A flight condition, and limits of the rudder besides those of the failure. */
typedef struct {
    double altitude, gamma, rudder[2];      /* ft, rad, deg */
} gtm_failure_case;

/* What the next envelope may be followed from; all zero at first. The numbers of the question that the ends were sought
   for, and for V_min and V_max the ends that were found, moved on since. Doubles all, and finite, to be kept as such. */
enum { GTM_KNOWN = 8 };
typedef struct {
    gtm_failure_case at;
    gtm_failure failure;
    double speed[2];                    /* of V_min and V_max there, ft/s */
    double inside[2], outside[2];       /* how many of the ends keep the limits, and how many nearly; at first none */
    double y[2][GTM_KNOWN][GTM_TWO_THROTTLE_NT];
} gtm_envelope_memory;

GTM_API long gtm_envelope_memory_size(void); /* in doubles */

/* The trims at V_min and V_max, all zero where there is no envelope; an enum gtm_failure_fault. With a `memory`, which may
   be 0, the ends are followed from those known as long as the question differs little from that they were sought for. */
GTM_API int gtm_failure_envelope(const gtm_failure_case *at, const gtm_failure *f, const double lower[GTM_NT],
                                 const double upper[GTM_NT], gtm_envelope_memory *memory,
                                 double end[2][GTM_TWO_THROTTLE_NT]);

/* Slopes of V_min and V_max with respect to the numbers of the question, at the trims above: V_min's, then V_max's. */
GTM_API int gtm_failure_envelope_slopes(const gtm_failure_case *at, const gtm_failure *f, const double lower[GTM_NT],
                                        const double upper[GTM_NT], const double end[2][GTM_TWO_THROTTLE_NT],
                                        double slopes[2][GTM_TOLD]);

/* A manoeuvre that is asked for. */
typedef struct {
    double altitude, gamma, tas, turn_rate; /* ft, rad, ft/s, rad/s */
} gtm_failure_manoeuvre;

/* The answer of gtm_query as doubles. Without a trim, inside the limits or not, all numbers are zero. */
enum { GTM_LIMITED = GTM_TWO_THROTTLE_NT - 2 }; /* alpha beta phi, surfaces, throttles left and right (one is both) */
typedef struct {
    double is_feasible, is_stable, is_controllable, is_found;
    double binding;                         /* names.py: BINDING, counted from 1 */
    double margin[GTM_LIMITED][2];          /* rad, deg, %: to the lower and to the upper limit, negative beyond it */
    double thrust_margin[2];                /* lbf */
    double alpha, beta, bank, surface[3], throttle[2], thrust;
} gtm_failure_answer;

GTM_API int gtm_failure_query(const gtm_failure_manoeuvre *at, const gtm_failure *f, const double lower[GTM_NT],
                              const double upper[GTM_NT], gtm_failure_answer *answer);

/* Slopes of an answer, number by number, with respect to those of the question; zero for what is no real number. Those of
   the damage case, the gear and switches are zero. */
GTM_API int gtm_failure_query_slopes(const gtm_failure_manoeuvre *at, const gtm_failure *f, const double lower[GTM_NT],
                                     const double upper[GTM_NT], double *slopes);

/* Least and greatest turn rate (rad/s) at the speed of a manoeuvre. There is none where the first is above the second:
   then they are the bounds of the undamaged aircraft, reversed. */
GTM_API int gtm_failure_turn_rates(const gtm_failure_manoeuvre *at, const gtm_failure *f, const double lower[GTM_NT],
                                   const double upper[GTM_NT], double rate[2]);

/* Their slopes; zero where there are none. */
GTM_API int gtm_failure_turn_rate_slopes(const gtm_failure_manoeuvre *at, const gtm_failure *f,
                                         const double lower[GTM_NT], const double upper[GTM_NT],
                                         double slopes[2][GTM_TOLD]);

#endif
