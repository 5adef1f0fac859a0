/* Look-up of the aerodynamic coefficients in any configuration (SPEC 5, 10.4, 10.5). */
#ifndef GTM_CONFIGURED_TABLE_H
#define GTM_CONFIGURED_TABLE_H

#include "gtm_configuration.h"
#include "gtm/table.h"

/* A surface with a table over (alpha, beta, its deflection). `surface` counts the signals of SPEC 4; `command` is the
   column of the command in K, 0 where there is none. A left panel takes the right one's table at -beta. */
typedef struct gtm_panel {
    const double *table;
    const gtm_axis *axis;
    int surface, is_left;
    double weight[GTM_NC];
} gtm_panel;

/* A command as the surface bus deals it out. */
typedef struct {
    int command;
    double sign;
} gtm_drive;

typedef struct {
    double lowest, highest;
} gtm_range;

/* Generated from airframe/surfaces.py, damage.py, actuators.py and configuration.py. */
extern const gtm_panel gtm_panels[GTM_PANELS];
extern const gtm_drive gtm_drives[GTM_COMMANDED];
extern const double gtm_elevator_part, gtm_elevator_arm[GTM_SEGMENTS];
extern const unsigned char gtm_has_surface[GTM_DAMAGE_CASES][GTM_AERODYNAMIC];
extern const gtm_range gtm_fuel_used_lb_range, gtm_stabilizer_deg_range, gtm_gear_range, gtm_spoiler_deg_range,
    gtm_flap_deg_range, gtm_surface_gain_range, gtm_surface_offset_deg_range, gtm_wind_ft_s_range,
    gtm_gust_ft_s_range, gtm_runway_altitude_ft_range, gtm_mass_factor_range, gtm_cg_offset_ft_range,
    gtm_coefficient_factor_range;
extern const double gtm_default_runway, gtm_fastest_servo;
extern const gtm_range gtm_servo_range[]; /* in the order of actuators.SERVOS */

/* Generated from airframe/configured_tables.py; six components padded to 8, three to 4. Those that are not constant are
   zero until gtm_unfold_configured_tables, which runs when the library is loaded, has filled them in. */
extern const gtm_axis gtm_stabilizer_axis, gtm_spoiler_axis, gtm_damage_alpha_axis, gtm_damage_beta_axis,
    gtm_stall_alpha_axis, gtm_stall_beta_axis;
extern double gtm_right_aileron_table[], gtm_right_spoiler_table[], gtm_tail_table[], gtm_gear_table[],
    gtm_damage_increment_table[];
extern const double gtm_stall_table[], gtm_damage_table[], gtm_damage_scale_table[], gtm_flap_table[GTM_FLAPS * 8];
extern const gtm_range gtm_rate_alpha[GTM_RATES];

void gtm_unfold_configured_tables(void);

/* Total coefficients C[6] at K[9] (names.LOOKUPS: deflections are the commands), and slopes T[i*9 + j]. */
void gtm_configured_coefficients(const gtm_configuration *c, const double K[GTM_NK], double C[GTM_NC]);
void gtm_configured_coefficients_and_slopes(const gtm_configuration *c, const double K[GTM_NK], double C[GTM_NC],
                                            double T[GTM_NC * GTM_NK]);

#endif
