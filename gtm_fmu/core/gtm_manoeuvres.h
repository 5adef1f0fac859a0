/* Steady manoeuvres: trims, V_min and V_max, and grids of trims.

   Unknowns y: V alpha beta psi_dot phi elevator aileron rudder, and one throttle or two (ft/s, rad, rad/s, deg, %).
   Bounds lower <= y <= upper; equal bounds hold an unknown. A control that moves nothing (its surfaces are lost or
   jammed, its engine is out) is held as near to zero as its bounds let it. Altitude in ft, flight path gamma in rad.

   The airframe is a completed configuration; or the study's, with one throttle, where `c` is 0. */
#ifndef GTM_MANOEUVRES_H
#define GTM_MANOEUVRES_H

#include "gtm_configuration.h"
#include "solver/terms.h"

/* Typical size of each unknown; the solvers work in y / scale, and violations are in these units. */
extern GTM_API const double gtm_scale[GTM_TWO_THROTTLE_NT];

/* n trims with the least |beta|, whose bounds (rows) hold two or three of V, psi_dot, phi, alpha and beta; where three
   are held, or two and the rudder, there is no choice. Without a trim, `violation` (scaled units, 0 inside the bounds)
   and `residual` (largest acceleration) say how far away y is. Of trims with two throttles and no sideslip, the one
   with the least difference between them is taken. */
GTM_API void gtm_trims(const gtm_configuration *c, enum gtm_throttles throttles, long n, const double *altitude,
                       const double *gamma, const double *lower, const double *upper, double *y, double *residual,
                       double *violation, int *status);

/* Cold trims with V, phi and rudder held, one for each of n rows of held (V, phi, rudder); returns how many converged;
   their y are packed at the front. Bounds are not looked at. */
GTM_API long gtm_cold_starts(const gtm_configuration *c, enum gtm_throttles throttles, double altitude, double gamma,
                             long n, const double *held, double *y);

/* The point of least objective.y inside the bounds, by sequential linear programming from each of n starts (rows of
   y; a start should be near F = 0). The best is left in `best`; without one inside the bounds, `violation` says how far
   away it is. */
GTM_API int gtm_extreme(const gtm_configuration *c, enum gtm_throttles throttles, double altitude, double gamma,
                        const double *lower, const double *upper, const double *objective, long n, const double *starts,
                        double *best, double *violation);

/* The same from starts of its own, for V_min, V_max or the least throttle. */
GTM_API int gtm_envelope_end(const gtm_configuration *c, enum gtm_throttles throttles, double altitude, double gamma,
                             const double *lower, const double *upper, const double *objective, double *best,
                             double *violation);

/* The same from many starts always, which takes six times as long: what gtm_envelope_end is checked against. */
GTM_API int gtm_thorough_end(const gtm_configuration *c, enum gtm_throttles throttles, double altitude, double gamma,
                             const double *lower, const double *upper, const double *objective, double *best,
                             double *violation);

/* The pieces of a range of the rudder in deg between its breakpoints, of whose ends the best is that of the range: the k-th from border[k]
   to border[k + 1]. Returns their number, at most `most`: then the last one reaches to the end. */
GTM_API int gtm_rudder_pieces(double lower, double upper, int most, double *border);

/* Trims (least |beta|) on a grid of speeds and turn rates, both rising: cells connected by a flood to the n seeds (rows
   of y). Fills feasible[speeds*rates] and, where feasible, y[speeds*rates*unknowns]; returns their number, -1 without
   memory. */
GTM_API long gtm_grid(const gtm_configuration *c, enum gtm_throttles throttles, double altitude, double gamma,
                      const double *lower, const double *upper, long speeds, const double *speed, long rates,
                      const double *rate, long n, const double *seeds, unsigned char *feasible, double *y);

/* Which unknowns are controls that move nothing. */
GTM_API void gtm_dead_controls(const gtm_configuration *c, unsigned char is_dead[GTM_TWO_THROTTLE_NT]);

/* Which unknowns of n rows of y lie on a breakpoint of a table, where slopes have two sides; psi_dot does where it is
   0, as every rate then is. */
GTM_API void gtm_on_breakpoints(const gtm_configuration *c, enum gtm_throttles throttles, long n, const double *y,
                                unsigned char *is_on);

/* States x[12] (latitude, longitude and psi zero) and controls u[4] of n steady manoeuvres y (rows) of the study's
   airframe. */
GTM_API void gtm_trim_states(double altitude, double gamma, long n, const double *y, double *x, double *u);

/* The same of a configuration: the velocity is inertial, so with the wind, and the controls are u[5]. */
GTM_API void gtm_configured_trim_states(const gtm_configuration *c, enum gtm_throttles throttles, double altitude,
                                        double gamma, long n, const double *y, double *x, double *u);

#endif
