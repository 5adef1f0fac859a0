#include <string.h>

#include "full_table.h"
#include "generated/full_airframe.h"
#include "solver.h"

typedef const double *arguments[];
typedef double *results[];

void gtm_full_wind(const gtm_configuration *c, const double x[GTM_NX], double wind[3])
{
    cas_full_wind((arguments){x, c->parameters}, (results){wind}, 0, 0, 0);
}

int gtm_full_state_fault(const gtm_configuration *c, const double x[GTM_NX])
{
    double wind[3], relative[GTM_NX];
    gtm_full_wind(c, x, wind);
    memcpy(relative, x, sizeof relative);
    for (int i = 0; i < 3; i++) relative[i] -= wind[i];
    return gtm_state_fault(relative);
}

void gtm_full_derivatives(const gtm_configuration *c, const double x[GTM_NX], const double u[GTM_FULL_NU],
                          double dx[GTM_NX])
{
    double K[GTM_NK], C[GTM_NC];
    cas_full_lookup((arguments){x, u, c->parameters}, (results){K}, 0, 0, 0);
    gtm_full_coefficients(c, K, C);
    cas_full_derivatives((arguments){x, u, c->parameters, C}, (results){dx}, 0, 0, 0);
}

void gtm_full_outputs(const gtm_configuration *c, const double x[GTM_NX], const double u[GTM_FULL_NU],
                      double y[GTM_NY])
{
    double K[GTM_NK], C[GTM_NC];
    cas_full_lookup((arguments){x, u, c->parameters}, (results){K}, 0, 0, 0);
    gtm_full_coefficients(c, K, C);
    cas_full_outputs((arguments){x, u, c->parameters, C}, (results){y}, 0, 0, 0);
}

void gtm_full_jacobian(const gtm_configuration *c, const double x[GTM_NX], const double u[GTM_FULL_NU],
                       double dx[GTM_NX], double jacobian[GTM_NX * GTM_FULL_NXU])
{
    double K[GTM_NK], C[GTM_NC], T[GTM_NC * GTM_NK];
    cas_full_lookup((arguments){x, u, c->parameters}, (results){K}, 0, 0, 0);
    gtm_full_coefficients_and_slopes(c, K, C, T);
    cas_full_jacobian((arguments){x, u, c->parameters, C, T}, (results){dx, jacobian}, 0, 0, 0);
}

void gtm_full_outputs_jacobian(const gtm_configuration *c, const double x[GTM_NX], const double u[GTM_FULL_NU],
                               double y[GTM_NY], double jacobian[GTM_NY * GTM_FULL_NXU])
{
    double K[GTM_NK], C[GTM_NC], T[GTM_NC * GTM_NK];
    cas_full_lookup((arguments){x, u, c->parameters}, (results){K}, 0, 0, 0);
    gtm_full_coefficients_and_slopes(c, K, C, T);
    cas_full_outputs_jacobian((arguments){x, u, c->parameters, C, T}, (results){y, jacobian}, 0, 0, 0);
}

void gtm_full_derivatives_batch(const gtm_configuration *c, long n, const double *x, const double *u, double *dx)
{
    for (long i = 0; i < n; i++) gtm_full_derivatives(c, x + i * GTM_NX, u + i * GTM_FULL_NU, dx + i * GTM_NX);
}

void gtm_full_outputs_batch(const gtm_configuration *c, long n, const double *x, const double *u, double *y)
{
    for (long i = 0; i < n; i++) gtm_full_outputs(c, x + i * GTM_NX, u + i * GTM_FULL_NU, y + i * GTM_NY);
}

void gtm_full_jacobian_batch(const gtm_configuration *c, long n, const double *x, const double *u, double *dx,
                             double *jacobian)
{
    for (long i = 0; i < n; i++)
        gtm_full_jacobian(c, x + i * GTM_NX, u + i * GTM_FULL_NU, dx + i * GTM_NX,
                          jacobian + i * GTM_NX * GTM_FULL_NXU);
}

void gtm_full_outputs_jacobian_batch(const gtm_configuration *c, long n, const double *x, const double *u, double *y,
                                     double *jacobian)
{
    for (long i = 0; i < n; i++)
        gtm_full_outputs_jacobian(c, x + i * GTM_NX, u + i * GTM_FULL_NU, y + i * GTM_NY,
                                  jacobian + i * GTM_NY * GTM_FULL_NXU);
}

void gtm_full_trim_residual(const gtm_configuration *c, const double y[GTM_FULL_NT], const gtm_condition *at,
                            double F[GTM_NF])
{
    double K[GTM_NK], C[GTM_NC];
    cas_full_trim_lookup((arguments){y, &at->gamma, c->parameters}, (results){K}, 0, 0, 0);
    gtm_full_coefficients(c, K, C);
    cas_full_trim_residual((arguments){y, &at->gamma, c->parameters, C}, (results){F}, 0, 0, 0);
}

void gtm_full_trim_jacobian(const gtm_configuration *c, const double y[GTM_FULL_NT], const gtm_condition *at,
                            double F[GTM_NF], double J[GTM_NF * GTM_FULL_NT])
{
    double K[GTM_NK], C[GTM_NC], T[GTM_NC * GTM_NK];
    cas_full_trim_lookup((arguments){y, &at->gamma, c->parameters}, (results){K}, 0, 0, 0);
    gtm_full_coefficients_and_slopes(c, K, C, T);
    cas_full_trim_jacobian((arguments){y, &at->gamma, c->parameters, C, T}, (results){F, J}, 0, 0, 0);
}

void gtm_full_trim_residual_batch(const gtm_configuration *c, long n, const double *altitude, const double *gamma,
                                  const double *y, double *F)
{
    for (long i = 0; i < n; i++) {
        const gtm_condition at = gtm_condition_at(altitude[i], gamma[i]);
        gtm_full_trim_residual(c, y + i * GTM_FULL_NT, &at, F + i * GTM_NF);
    }
}

void gtm_full_trim_jacobian_batch(const gtm_configuration *c, long n, const double *altitude, const double *gamma,
                                  const double *y, double *F, double *J)
{
    for (long i = 0; i < n; i++) {
        const gtm_condition at = gtm_condition_at(altitude[i], gamma[i]);
        gtm_full_trim_jacobian(c, y + i * GTM_FULL_NT, &at, F + i * GTM_NF, J + i * GTM_NF * GTM_FULL_NT);
    }
}

void gtm_full_trim_state(const gtm_configuration *c, double altitude, double gamma, const double y[GTM_FULL_NT],
                         double x[GTM_NX], double u[GTM_FULL_NU])
{
    cas_full_trim_state((arguments){y, &gamma, &altitude, c->parameters}, (results){x}, 0, 0, 0);
    memcpy(u, y + GTM_FULL_NT - GTM_FULL_NU, GTM_FULL_NU * sizeof *u);
}
