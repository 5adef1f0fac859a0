/* Accelerations of a steady manoeuvre in any configuration, relative to air that moves steadily. */
#ifndef GTM_CONFIGURED_MOTION_H
#define GTM_CONFIGURED_MOTION_H

#include "gtm/condition.h"
#include "gtm_configuration.h"

void gtm_configured_trim_residual(const gtm_configuration *c, const double y[GTM_TWO_THROTTLE_NT],
                                  const gtm_condition *at, double F[GTM_NF]);
void gtm_configured_trim_jacobian(const gtm_configuration *c, const double y[GTM_TWO_THROTTLE_NT],
                                  const gtm_condition *at, double F[GTM_NF], double J[GTM_NF * GTM_TWO_THROTTLE_NT]);

#endif
