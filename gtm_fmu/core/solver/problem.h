/* Steady manoeuvres as points of a manifold: F(y) = 0, six accelerations of nine unknowns, or of ten where each engine
   has a throttle of its own. The solver knows these unknowns (V in ft/s, angles in rad, surfaces in deg, throttles in
   %) and no aircraft: what it needs of one is a gtm_aircraft. */
#ifndef GTM_PROBLEM_H
#define GTM_PROBLEM_H

#include "generated/order.h"
#include "generated/unknowns.h"
#include "solver/terms.h"

enum { GTM_MOST_UNKNOWNS = GTM_TWO_THROTTLE_NT };

typedef struct gtm_aircraft gtm_aircraft;

/* A flight condition of an aircraft. What the aircraft's functions need besides follows it in a larger struct. */
typedef struct {
    const gtm_aircraft *aircraft;
    enum gtm_throttles throttles;                   /* with two THROTTLE is the left one */
    int unknowns;                                   /* that many throttles and eight others */
    unsigned char is_dead[GTM_MOST_UNKNOWNS];       /* controls that move nothing */
    double highest_alpha;                           /* rad; Newton's iterates stay below it */
    double density, weight;                         /* of the air, slug/ft^3; lbf */
} gtm_problem;

/* The interval of one unknown between breakpoints: it holds `value`, or on a breakpoint lies on the given side of it.
   `slack`: this near to a breakpoint is on it. */
typedef struct {
    double value, slack, lower, upper;
    int above;
} gtm_interval;

/* End the interval at a breakpoint, if it reaches as far. */
static inline void gtm_cut(gtm_interval *i, double breakpoint)
{
    const int is_below = i->above ? breakpoint <= i->value + i->slack : breakpoint < i->value - i->slack;
    if (is_below) {
        if (breakpoint > i->lower) i->lower = breakpoint;
    } else if (breakpoint < i->upper) {
        i->upper = breakpoint;
    }
}

/* The aircraft as a point mass with linear lift and side force: its rough trims are first guesses. */
typedef struct {
    double wing_area, gravity;                              /* ft^2, ft/s^2 */
    double lift, lift_slope, least_lift, most_lift;         /* coefficient: at alpha 0, per rad, its range */
    double side_force_slope;                                /* coefficient per rad of sideslip */
    double alpha, least_alpha, most_alpha;                  /* rad: at a guessed speed, and range of guesses */
    double slowest, fastest;                                /* ft/s, of a speed guessed from bank and turn rate */
    double elevator, elevator_per_alpha, aileron_per_rudder; /* deg, deg per deg */
} gtm_point_mass;

/* First guesses differ in sideslip per rudder and in throttle; Newton takes them in this order. */
enum { GTM_GUESSES = 5 };
typedef struct {
    double beta_per_rudder, throttle; /* deg per deg, % */
} gtm_guess;

/* Speeds from which V_min and V_max are sought, in ft/s. */
typedef struct {
    double slowest, fastest;
    int is_steep; /* in a steep descent: more of them, close together where they are slow */
} gtm_speeds;

/* Where trims, V_min and V_max are sought from, beside the bounds. */
enum { GTM_BESIDE = 6 };
typedef struct {
    double glide_sideslip;          /* rad, of a glide without thrust */
    double inside, beyond;          /* ft/s from the speed of an end that was found */
    double beside[GTM_BESIDE];      /* deg from its rudder */
    double thrust_apart;            /* % of two throttles, to either side */
    double rudder_piece;            /* deg, the pieces of the rudder's range; its breakpoints lie between them */
} gtm_spacing;

enum { GTM_KINKED = 6 };

/* What the solver asks of an aircraft. Arrays are in the order of the unknowns. */
struct gtm_aircraft {
    const double *scale;                                    /* typical sizes; the solver works in y / scale */
    const double *longest_step, *least, *most;              /* of Newton, and where its iterates are held */
    int kinked[GTM_KINKED];                                 /* the unknowns with breakpoints */
    gtm_point_mass point_mass;
    gtm_guess guess[GTM_GUESSES];
    gtm_spacing spacing;
    gtm_speeds (*speeds)(const gtm_problem *p);
    void (*cut)(const gtm_problem *p, int unknown, gtm_interval *i); /* at its breakpoints */
    void (*residual)(const gtm_problem *p, const double *y, double F[GTM_NF]);
    /* The Jacobian has a column for each of the problem's unknowns. */
    void (*jacobian)(const gtm_problem *p, const double *y, double F[GTM_NF], double *J);
};

/* Largest |F|, ft/s^2 and rad/s^2 alike. */
double gtm_residual_norm(const double F[GTM_NF]);

/* Largest excess over the bounds, in scaled units; up to gtm_rounding it is none. */
double gtm_violation(const gtm_problem *p, const double *y, const double *lower, const double *upper);
extern const double gtm_rounding;

/* Whether there are two throttles and both move an engine. */
int gtm_has_free_throttles(const gtm_problem *p);

/* Whether the rudder is held and no second throttle is free: a trim at given V and psi_dot is unique then. */
int gtm_rudder_settles(const gtm_problem *p, const double *lower, const double *upper);

#endif
