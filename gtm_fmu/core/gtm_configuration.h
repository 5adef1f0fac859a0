/* Flight dynamics of every configuration: damage, fuel, fixed surfaces, separate surfaces and engines, wind.

   Units as in gtm_core.h, with one throttle per engine: u[5]: elevator aileron rudder throttle_left throttle_right,
   y[10]: V alpha beta psi_dot phi and these five. Fill in a configuration, let gtm_configure complete it, then use it
   from as many threads as you like. */
#ifndef GTM_CONFIGURATION_H
#define GTM_CONFIGURATION_H

#include "gtm_core.h"

enum { GTM_TWO_THROTTLE_NXU = GTM_NX + GTM_TWO_THROTTLE_NU };

/* A table panel or an elevator segment that can move or is deflected: deflection = gain * command + offset. */
struct gtm_active_panel {
    const struct gtm_panel *panel;
    double gain, offset, weight[GTM_NC];
};
struct gtm_active_segment {
    double gain, offset, part, arm;
};

typedef struct gtm_configuration {
    int damage_case;                        /* SPEC 10.5; 0: none */
    double fuel_used;                       /* lb */
    double stabilizer;                      /* deg */
    double gear;                            /* 0 up .. 1 down */
    double spoiler[GTM_SPOILERS];           /* deg: left inboard, left outboard, right inboard, right outboard */
    double flap[GTM_FLAPS];                 /* deg, in the same order */
    /* Elevator left outboard, left inboard, right outboard, right inboard; aileron left, right; rudder upper, lower:
       position in deg = gain * (command with its sign, SPEC 4) + offset. Gain 0 jams a surface at its offset. */
    double surface_gain[GTM_COMMANDED], surface_offset[GTM_COMMANDED];
    int engine_running[2];                  /* left, right */
    double wind[3], gust[3];                /* ft/s: north, east, down; along the body axes x, y, z (SPEC 10.6) */
    int has_shear;                          /* whether the wind (not the gust) grows with height */
    double runway_altitude;                 /* ft, where the shear begins */
    int has_stall_asymmetry;                /* SPEC 5.6 */
    /* What is not known for sure: mass and inertia by a factor, the centre of gravity moved (ft), each total coefficient
       of SPEC 5 by a factor. */
    double mass_factor, cg_offset[3], coefficient_factor[GTM_NC];

    /* Filled in by gtm_configure. */
    double mass, cg[3], inertia[6];         /* slug; ft in the frame of SPEC 1; Ixx Iyy Izz Ixz Iyz Ixy in slug ft^2 */
    /* For the core alone. */
    double parameters[GTM_PARAMETERS];      /* of the generated functions */
    int is_folded;                          /* the study's aerodynamics: its folded tables serve */
    int panels, segments;
    struct gtm_active_panel panel[GTM_PANELS];
    struct gtm_active_segment segment[GTM_SEGMENTS + 1]; /* and the stabiliser */
    double flap_coefficients[GTM_NC];
} gtm_configuration;

/* What a configuration holds that is not allowed (airframe/configuration.py has the ranges). */
enum gtm_configuration_fault {
    GTM_CONFIGURED = 0,
    GTM_BAD_DAMAGE_CASE = 1,
    GTM_BAD_FUEL_USED = 2,
    GTM_BAD_STABILIZER = 3,
    GTM_BAD_GEAR = 4,
    GTM_BAD_SPOILER = 5,
    GTM_BAD_FLAP = 6,
    GTM_BAD_SURFACE_GAIN = 7,
    GTM_BAD_SURFACE_OFFSET = 8,
    GTM_BAD_WIND = 9,
    GTM_BAD_GUST = 10,
    GTM_BAD_RUNWAY_ALTITUDE = 11,
    GTM_BAD_MASS_FACTOR = 12,
    GTM_BAD_CG_OFFSET = 13,
    GTM_BAD_COEFFICIENT_FACTOR = 14
};

GTM_API long gtm_configuration_size(void);

/* The study's configuration (SPEC 9), completed. */
GTM_API void gtm_study_configuration(gtm_configuration *c);

/* Complete c; 0, or what is wrong with it. */
GTM_API int gtm_configure(gtm_configuration *c);

/* Air velocity in body axes at a state (SPEC 10.6), ft/s. */
GTM_API void gtm_configured_wind(const gtm_configuration *c, const double x[GTM_NX], double wind[3]);

/* enum gtm_fault; the speed and the flow angles are those relative to the air. */
GTM_API int gtm_configured_state_fault(const gtm_configuration *c, const double x[GTM_NX]);

GTM_API void gtm_configured_derivatives(const gtm_configuration *c, const double x[GTM_NX],
                                        const double u[GTM_TWO_THROTTLE_NU], double dx[GTM_NX]);
GTM_API void gtm_configured_outputs(const gtm_configuration *c, const double x[GTM_NX],
                                    const double u[GTM_TWO_THROTTLE_NU], double y[GTM_NY]);

/* Exact derivatives with respect to (x, u), row by row: jacobian[i*17 + j]; one-sided at a breakpoint as in
   gtm_core.h. */
GTM_API void gtm_configured_jacobian(const gtm_configuration *c, const double x[GTM_NX],
                                     const double u[GTM_TWO_THROTTLE_NU], double dx[GTM_NX],
                                     double jacobian[GTM_NX * GTM_TWO_THROTTLE_NXU]);
GTM_API void gtm_configured_outputs_jacobian(const gtm_configuration *c, const double x[GTM_NX],
                                             const double u[GTM_TWO_THROTTLE_NU], double y[GTM_NY],
                                             double jacobian[GTM_NY * GTM_TWO_THROTTLE_NXU]);

/* The same functions on n rows. */
GTM_API void gtm_configured_derivatives_batch(const gtm_configuration *c, long n, const double *x, const double *u,
                                              double *dx);
GTM_API void gtm_configured_outputs_batch(const gtm_configuration *c, long n, const double *x, const double *u,
                                          double *y);
GTM_API void gtm_configured_jacobian_batch(const gtm_configuration *c, long n, const double *x, const double *u,
                                           double *dx, double *jacobian);
GTM_API void gtm_configured_outputs_jacobian_batch(const gtm_configuration *c, long n, const double *x, const double *u,
                                                   double *y, double *jacobian);

/* Steady manoeuvres are relative to the air, so that the wind does not enter: V, alpha, beta and gamma are, and F[6]
   are the accelerations relative to air that moves steadily. F and J[6*10] at n rows of (altitude, gamma, y). */
GTM_API void gtm_configured_trim_residual_batch(const gtm_configuration *c, long n, const double *altitude,
                                                const double *gamma, const double *y, double *F);
GTM_API void gtm_configured_trim_jacobian_batch(const gtm_configuration *c, long n, const double *altitude,
                                                const double *gamma, const double *y, double *F, double *J);

/* State x[12] (latitude, longitude and psi zero; inertial velocity, so with the wind) and controls u[5]. */
GTM_API void gtm_configured_trim_state(const gtm_configuration *c, double altitude, double gamma,
                                       const double y[GTM_TWO_THROTTLE_NT], double x[GTM_NX],
                                       double u[GTM_TWO_THROTTLE_NU]);

#endif
