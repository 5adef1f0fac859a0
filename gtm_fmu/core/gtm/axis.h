/* Axes of the aerodynamic tables, generated from airframe/lookup_axes.py. */
#ifndef GTM_AXIS_H
#define GTM_AXIS_H

/* Breakpoints, and uniform cells no wider than the closest two of them: cell -> interval at the cell's start. */
typedef struct {
    int points, cells;
    double inverse_cell_width;
    const double *point;
    const unsigned char *interval;
} gtm_axis;

extern const gtm_axis gtm_alpha_axis, gtm_beta_axis, gtm_elevator_axis, gtm_aileron_axis, gtm_rudder_axis,
    gtm_p_hat_axis, gtm_q_hat_axis, gtm_r_hat_axis, gtm_omega_hat_axis;

#endif
