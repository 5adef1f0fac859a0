#include "gtm/configured_motion.h"

#include <string.h>

#include "generated/configured_airframe.h"
#include "gtm/configured_table.h"

typedef const double *arguments[];
typedef double *results[];

void gtm_configured_wind(const gtm_configuration *c, const double x[GTM_NX], double wind[3])
{
    cas_configured_wind((arguments){x, c->parameters}, (results){wind}, 0, 0, 0);
}

int gtm_configured_state_fault(const gtm_configuration *c, const double x[GTM_NX])
{
    double wind[3], relative[GTM_NX];
    gtm_configured_wind(c, x, wind);
    memcpy(relative, x, sizeof relative);
    for (int i = 0; i < 3; i++) relative[i] -= wind[i];
    return gtm_state_fault(relative);
}

void gtm_configured_derivatives(const gtm_configuration *c, const double x[GTM_NX], const double u[GTM_TWO_THROTTLE_NU],
                                double dx[GTM_NX])
{
    double K[GTM_NK], C[GTM_NC];
    cas_configured_lookup((arguments){x, u, c->parameters}, (results){K}, 0, 0, 0);
    gtm_configured_coefficients(c, K, C);
    cas_configured_derivatives((arguments){x, u, c->parameters, C}, (results){dx}, 0, 0, 0);
}

void gtm_configured_outputs(const gtm_configuration *c, const double x[GTM_NX], const double u[GTM_TWO_THROTTLE_NU],
                            double y[GTM_NY])
{
    double K[GTM_NK], C[GTM_NC];
    cas_configured_lookup((arguments){x, u, c->parameters}, (results){K}, 0, 0, 0);
    gtm_configured_coefficients(c, K, C);
    cas_configured_outputs((arguments){x, u, c->parameters, C}, (results){y}, 0, 0, 0);
}

void gtm_configured_jacobian(const gtm_configuration *c, const double x[GTM_NX], const double u[GTM_TWO_THROTTLE_NU],
                             double dx[GTM_NX], double jacobian[GTM_NX * GTM_TWO_THROTTLE_NXU])
{
    double K[GTM_NK], C[GTM_NC], T[GTM_NC * GTM_NK];
    cas_configured_lookup((arguments){x, u, c->parameters}, (results){K}, 0, 0, 0);
    gtm_configured_coefficients_and_slopes(c, K, C, T);
    cas_configured_jacobian((arguments){x, u, c->parameters, C, T}, (results){dx, jacobian}, 0, 0, 0);
}

void gtm_configured_outputs_jacobian(const gtm_configuration *c, const double x[GTM_NX],
                                     const double u[GTM_TWO_THROTTLE_NU], double y[GTM_NY],
                                     double jacobian[GTM_NY * GTM_TWO_THROTTLE_NXU])
{
    double K[GTM_NK], C[GTM_NC], T[GTM_NC * GTM_NK];
    cas_configured_lookup((arguments){x, u, c->parameters}, (results){K}, 0, 0, 0);
    gtm_configured_coefficients_and_slopes(c, K, C, T);
    cas_configured_outputs_jacobian((arguments){x, u, c->parameters, C, T}, (results){y, jacobian}, 0, 0, 0);
}

void gtm_configured_derivatives_batch(const gtm_configuration *c, long n, const double *x, const double *u, double *dx)
{
    for (long i = 0; i < n; i++)
        gtm_configured_derivatives(c, x + i * GTM_NX, u + i * GTM_TWO_THROTTLE_NU, dx + i * GTM_NX);
}

void gtm_configured_outputs_batch(const gtm_configuration *c, long n, const double *x, const double *u, double *y)
{
    for (long i = 0; i < n; i++) gtm_configured_outputs(c, x + i * GTM_NX, u + i * GTM_TWO_THROTTLE_NU, y + i * GTM_NY);
}

void gtm_configured_jacobian_batch(const gtm_configuration *c, long n, const double *x, const double *u, double *dx,
                                   double *jacobian)
{
    for (long i = 0; i < n; i++)
        gtm_configured_jacobian(c, x + i * GTM_NX, u + i * GTM_TWO_THROTTLE_NU, dx + i * GTM_NX,
                          jacobian + i * GTM_NX * GTM_TWO_THROTTLE_NXU);
}

void gtm_configured_outputs_jacobian_batch(const gtm_configuration *c, long n, const double *x, const double *u,
                                           double *y, double *jacobian)
{
    for (long i = 0; i < n; i++)
        gtm_configured_outputs_jacobian(c, x + i * GTM_NX, u + i * GTM_TWO_THROTTLE_NU, y + i * GTM_NY,
                                  jacobian + i * GTM_NY * GTM_TWO_THROTTLE_NXU);
}

void gtm_configured_trim_residual(const gtm_configuration *c, const double y[GTM_TWO_THROTTLE_NT],
                                  const gtm_condition *at, double F[GTM_NF])
{
    double K[GTM_NK], C[GTM_NC];
    cas_configured_trim_lookup((arguments){y, &at->gamma, c->parameters}, (results){K}, 0, 0, 0);
    gtm_configured_coefficients(c, K, C);
    cas_configured_trim_residual((arguments){y, &at->gamma, c->parameters, C}, (results){F}, 0, 0, 0);
}

void gtm_configured_trim_jacobian(const gtm_configuration *c, const double y[GTM_TWO_THROTTLE_NT],
                                  const gtm_condition *at, double F[GTM_NF], double J[GTM_NF * GTM_TWO_THROTTLE_NT])
{
    double K[GTM_NK], C[GTM_NC], T[GTM_NC * GTM_NK];
    cas_configured_trim_lookup((arguments){y, &at->gamma, c->parameters}, (results){K}, 0, 0, 0);
    gtm_configured_coefficients_and_slopes(c, K, C, T);
    cas_configured_trim_jacobian((arguments){y, &at->gamma, c->parameters, C, T}, (results){F, J}, 0, 0, 0);
}

void gtm_configured_trim_residual_batch(const gtm_configuration *c, long n, const double *altitude, const double *gamma,
                                        const double *y, double *F)
{
    for (long i = 0; i < n; i++) {
        const gtm_condition at = gtm_condition_at(altitude[i], gamma[i]);
        gtm_configured_trim_residual(c, y + i * GTM_TWO_THROTTLE_NT, &at, F + i * GTM_NF);
    }
}

void gtm_configured_trim_jacobian_batch(const gtm_configuration *c, long n, const double *altitude, const double *gamma,
                                        const double *y, double *F, double *J)
{
    for (long i = 0; i < n; i++) {
        const gtm_condition at = gtm_condition_at(altitude[i], gamma[i]);
        gtm_configured_trim_jacobian(c, y + i * GTM_TWO_THROTTLE_NT, &at, F + i * GTM_NF,
                                     J + i * GTM_NF * GTM_TWO_THROTTLE_NT);
    }
}

void gtm_configured_trim_state(const gtm_configuration *c, double altitude, double gamma,
                               const double y[GTM_TWO_THROTTLE_NT], double x[GTM_NX], double u[GTM_TWO_THROTTLE_NU])
{
    cas_configured_trim_state((arguments){y, &gamma, &altitude, c->parameters}, (results){x}, 0, 0, 0);
    memcpy(u, y + GTM_TWO_THROTTLE_NT - GTM_TWO_THROTTLE_NU, GTM_TWO_THROTTLE_NU * sizeof *u);
}
