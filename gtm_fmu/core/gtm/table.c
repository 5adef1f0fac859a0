#include "gtm/kernel.h"
#include "gtm/unfold.h"

GTM_AT_LOAD(gtm_unfold_tables)

void gtm_unfold_tables(void)
{
    gtm_unfold(&gtm_basic_stored, 0, 0, gtm_basic_table);
    gtm_unfold(&gtm_elevator_stored, 0, 0, gtm_elevator_table);
    gtm_unfold(&gtm_aileron_stored, 1, 0, gtm_aileron_table);
    gtm_unfold(&gtm_rudder_stored, 1, 0, gtm_rudder_table);
    gtm_unfold(&gtm_p_stored, 0, 0, gtm_p_table);
    gtm_unfold(&gtm_q_stored, 0, 0, gtm_q_table);
    gtm_unfold(&gtm_r_stored, 0, 0, gtm_r_table);
    gtm_unfold(&gtm_omega_stored, 0, &gtm_beta_axis, gtm_omega_table);
}

static inline void look_up(const double *K, int with_slopes, double *C, double *T)
{
    const position a = locate(&gtm_alpha_axis, K[K_ALPHA]), b = locate(&gtm_beta_axis, K[K_BETA]);
    const int betas = gtm_beta_axis.points;
    sample s;

    begin_with_basic(a, b, with_slopes, C, T);

    const position e = locate(&gtm_elevator_axis, K[K_ELEVATOR]);
    trilinear(gtm_elevator_table, gtm_elevator_axis.points * 4, betas * gtm_elevator_axis.points * 4, 4, a, b, e,
              with_slopes, &s);
    add(&s, longitudinal, 3, 1, K_ELEVATOR, with_slopes, C, T);

    const position l = locate(&gtm_aileron_axis, K[K_AILERON]);
    trilinear(gtm_aileron_table, gtm_aileron_axis.points * 8, betas * gtm_aileron_axis.points * 8, 8, a, b, l,
              with_slopes, &s);
    add(&s, every, 6, 1, K_AILERON, with_slopes, C, T);

    const position d = locate(&gtm_rudder_axis, K[K_RUDDER]);
    trilinear(gtm_rudder_table, gtm_rudder_axis.points * 8, betas * gtm_rudder_axis.points * 8, 8, a, b, d,
              with_slopes, &s);
    add(&s, every, 6, 1, K_RUDDER, with_slopes, C, T);

    add_dynamic(K, a, b, with_slopes, C, T);
}

void gtm_coefficients(const double K[GTM_NK], double C[GTM_NC])
{
    look_up(K, 0, C, 0);
}

void gtm_coefficients_and_slopes(const double K[GTM_NK], double C[GTM_NC], double T[GTM_NC * GTM_NK])
{
    look_up(K, 1, C, T);
}
