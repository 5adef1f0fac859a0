#include <math.h>
#include <string.h>

#include "generated/airframe.h"
#include "gtm/table.h"
#include "gtm_core.h"

int gtm_state_fault(const double x[GTM_NX])
{
    for (int i = 0; i < GTM_NX; i++)
        if (!isfinite(x[i])) return GTM_NOT_FINITE;
    const double in_plane = x[X_U] * x[X_U] + x[X_W] * x[X_W], V2 = in_plane + x[X_V] * x[X_V];
    if (!isfinite(V2)) return GTM_NOT_FINITE;
    if (V2 < 1) return GTM_NO_SPEED;
    if (in_plane < 1e-24 * V2) return GTM_SIDEWAYS;
    if (fabs(cos(x[X_THETA])) < 1e-12) return GTM_VERTICAL;
    if (fabs(cos(x[X_LATITUDE])) < 1e-12) return GTM_AT_POLE;
    return GTM_FINE;
}

void gtm_derivatives(const double x[GTM_NX], const double u[GTM_NU], double dx[GTM_NX])
{
    double K[GTM_NK], C[GTM_NC];
    cas_lookup((const double *[]){x, u}, (double *[]){K}, 0, 0, 0);
    gtm_coefficients(K, C);
    cas_derivatives((const double *[]){x, u, C}, (double *[]){dx}, 0, 0, 0);
}

void gtm_outputs(const double x[GTM_NX], const double u[GTM_NU], double y[GTM_NY])
{
    double K[GTM_NK], C[GTM_NC];
    cas_lookup((const double *[]){x, u}, (double *[]){K}, 0, 0, 0);
    gtm_coefficients(K, C);
    cas_outputs((const double *[]){x, u, C}, (double *[]){y}, 0, 0, 0);
}

void gtm_jacobian(const double x[GTM_NX], const double u[GTM_NU], double dx[GTM_NX], double jacobian[GTM_NX * GTM_NXU])
{
    double K[GTM_NK], C[GTM_NC], T[GTM_NC * GTM_NK];
    cas_lookup((const double *[]){x, u}, (double *[]){K}, 0, 0, 0);
    gtm_coefficients_and_slopes(K, C, T);
    cas_jacobian((const double *[]){x, u, C, T}, (double *[]){dx, jacobian}, 0, 0, 0);
}

void gtm_outputs_jacobian(const double x[GTM_NX], const double u[GTM_NU], double y[GTM_NY],
                          double jacobian[GTM_NY * GTM_NXU])
{
    double K[GTM_NK], C[GTM_NC], T[GTM_NC * GTM_NK];
    cas_lookup((const double *[]){x, u}, (double *[]){K}, 0, 0, 0);
    gtm_coefficients_and_slopes(K, C, T);
    cas_outputs_jacobian((const double *[]){x, u, C, T}, (double *[]){y, jacobian}, 0, 0, 0);
}

/* Derivatives of a state that may have none. */
static int safe_derivatives(const double *x, const double *u, double *dx)
{
    const int fault = gtm_state_fault(x);
    if (!fault) gtm_derivatives(x, u, dx);
    return fault;
}

static int runge_kutta_4(double *x, const double *u, double dt)
{
    double k1[GTM_NX], k2[GTM_NX], k3[GTM_NX], k4[GTM_NX], stage[GTM_NX];
    int fault = safe_derivatives(x, u, k1);
    if (fault) return fault;
    for (int i = 0; i < GTM_NX; i++) stage[i] = x[i] + 0.5 * dt * k1[i];
    fault = safe_derivatives(stage, u, k2);
    if (fault) return fault;
    for (int i = 0; i < GTM_NX; i++) stage[i] = x[i] + 0.5 * dt * k2[i];
    fault = safe_derivatives(stage, u, k3);
    if (fault) return fault;
    for (int i = 0; i < GTM_NX; i++) stage[i] = x[i] + dt * k3[i];
    fault = safe_derivatives(stage, u, k4);
    if (fault) return fault;
    for (int i = 0; i < GTM_NX; i++) x[i] += dt / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
    return gtm_state_fault(x);
}

int gtm_advance(double x[GTM_NX], const double u[GTM_NU], double duration, double substep)
{
    if (!(substep > 0 && duration >= 0 && duration / substep <= GTM_SUBSTEPS * (1 + 1e-9))) return GTM_BAD_STEP;
    double moved[GTM_NX];
    memcpy(moved, x, sizeof moved);
    /* A duration that is a whole number of substeps but for rounding gets no sliver of a last step. */
    const double whole = floor(duration / substep * (1 + 1e-12));
    const double rest = duration - whole * substep;
    int fault = gtm_state_fault(moved);
    for (double i = 0; i < whole && !fault; i++) fault = runge_kutta_4(moved, u, substep);
    if (!fault && rest > 1e-9 * substep) fault = runge_kutta_4(moved, u, rest);
    if (!fault) memcpy(x, moved, sizeof moved);
    return fault;
}

void gtm_derivatives_batch(long n, const double *x, const double *u, double *dx)
{
    for (long i = 0; i < n; i++) gtm_derivatives(x + i * GTM_NX, u + i * GTM_NU, dx + i * GTM_NX);
}

void gtm_outputs_batch(long n, const double *x, const double *u, double *y)
{
    for (long i = 0; i < n; i++) gtm_outputs(x + i * GTM_NX, u + i * GTM_NU, y + i * GTM_NY);
}

void gtm_jacobian_batch(long n, const double *x, const double *u, double *dx, double *jacobian)
{
    for (long i = 0; i < n; i++)
        gtm_jacobian(x + i * GTM_NX, u + i * GTM_NU, dx + i * GTM_NX, jacobian + i * GTM_NX * GTM_NXU);
}

void gtm_outputs_jacobian_batch(long n, const double *x, const double *u, double *y, double *jacobian)
{
    for (long i = 0; i < n; i++)
        gtm_outputs_jacobian(x + i * GTM_NX, u + i * GTM_NU, y + i * GTM_NY, jacobian + i * GTM_NY * GTM_NXU);
}
