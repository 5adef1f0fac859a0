/* The core of gtm-fmu: flight dynamics of the GTM-T2 in plain C99, without dependencies or state. Other configurations
   than the study's are in gtm_configuration.h, trims and envelopes in gtm_manoeuvres.h.

   Units are those of the specification: ft, ft/s, rad, rad/s, surfaces in deg, throttle in %.
   x[12]: u v w p q r latitude longitude altitude phi theta psi      u[4]: elevator aileron rudder throttle
   y[15]: tas eas [kt] alpha beta [deg] mach, dynamic pressure [lbf/ft^2] gamma track [deg] load x y z [g]
          thrust left right [lbf] rotor speed left right [%] */
#ifndef GTM_CORE_H
#define GTM_CORE_H

#include "generated/order.h"

#if defined(_WIN32)
#define GTM_API __declspec(dllexport)
#else
#define GTM_API __attribute__((visibility("default")))
#endif

enum { GTM_NXU = GTM_NX + GTM_NU };

/* Most substeps of one call, which nothing can stop: some seconds of processor time. */
enum { GTM_SUBSTEPS = 1000000 };

/* Why a state has no derivatives. */
enum gtm_fault {
    GTM_FINE = 0,
    GTM_NOT_FINITE = 1,
    GTM_NO_SPEED = 2,     /* V < 1 ft/s */
    GTM_SIDEWAYS = 3,     /* |beta| = 90 deg: alpha is undefined */
    GTM_VERTICAL = 4,     /* theta = +-90 deg: phi and psi are undefined */
    GTM_AT_POLE = 5,      /* latitude = +-90 deg: longitude is undefined */
    GTM_BAD_STEP = 6      /* a substep that is not positive, a negative duration, or more than GTM_SUBSTEPS of them */
};

GTM_API int gtm_state_fault(const double x[GTM_NX]);

GTM_API void gtm_derivatives(const double x[GTM_NX], const double u[GTM_NU], double dx[GTM_NX]);
GTM_API void gtm_outputs(const double x[GTM_NX], const double u[GTM_NU], double y[GTM_NY]);

/* Exact derivatives with respect to (x, u), row by row: jacobian[i*16 + j]. At a table breakpoint they are those of
   the interval above it. */
GTM_API void gtm_jacobian(const double x[GTM_NX], const double u[GTM_NU], double dx[GTM_NX],
                          double jacobian[GTM_NX * GTM_NXU]);
GTM_API void gtm_outputs_jacobian(const double x[GTM_NX], const double u[GTM_NU], double y[GTM_NY],
                                  double jacobian[GTM_NY * GTM_NXU]);

/* Classical Runge-Kutta with constant controls over `duration`, in steps of `substep` (the last one shortened).
   Returns 0, or a fault (of the first state that has no derivatives, or of the steps); x is then left as it was. */
GTM_API int gtm_advance(double x[GTM_NX], const double u[GTM_NU], double duration, double substep);

/* The same functions on n rows. */
GTM_API void gtm_derivatives_batch(long n, const double *x, const double *u, double *dx);
GTM_API void gtm_outputs_batch(long n, const double *x, const double *u, double *y);
GTM_API void gtm_jacobian_batch(long n, const double *x, const double *u, double *dx, double *jacobian);
GTM_API void gtm_outputs_jacobian_batch(long n, const double *x, const double *u, double *y, double *jacobian);

#endif
