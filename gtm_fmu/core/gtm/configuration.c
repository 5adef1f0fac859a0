#include <math.h>
#include <string.h>

#include "generated/configured_airframe.h"
#include "gtm/configured_table.h"

static int outside(gtm_range range, int n, const double *value)
{
    for (int i = 0; i < n; i++)
        if (!(value[i] >= range.lowest && value[i] <= range.highest)) return 1;
    return 0;
}

static int fault_of(const gtm_configuration *c)
{
    if (c->damage_case < 0 || c->damage_case >= GTM_DAMAGE_CASES) return GTM_BAD_DAMAGE_CASE;
    if (outside(gtm_fuel_used_lb_range, 1, &c->fuel_used)) return GTM_BAD_FUEL_USED;
    if (outside(gtm_stabilizer_deg_range, 1, &c->stabilizer)) return GTM_BAD_STABILIZER;
    if (outside(gtm_gear_range, 1, &c->gear)) return GTM_BAD_GEAR;
    if (outside(gtm_spoiler_deg_range, GTM_SPOILERS, c->spoiler)) return GTM_BAD_SPOILER;
    if (outside(gtm_flap_deg_range, GTM_FLAPS, c->flap)) return GTM_BAD_FLAP;
    if (outside(gtm_surface_gain_range, GTM_COMMANDED, c->surface_gain)) return GTM_BAD_SURFACE_GAIN;
    if (outside(gtm_surface_offset_deg_range, GTM_COMMANDED, c->surface_offset)) return GTM_BAD_SURFACE_OFFSET;
    if (outside(gtm_wind_ft_s_range, 3, c->wind)) return GTM_BAD_WIND;
    if (outside(gtm_gust_ft_s_range, 3, c->gust)) return GTM_BAD_GUST;
    if (outside(gtm_runway_altitude_ft_range, 1, &c->runway_altitude)) return GTM_BAD_RUNWAY_ALTITUDE;
    if (outside(gtm_mass_factor_range, 1, &c->mass_factor)) return GTM_BAD_MASS_FACTOR;
    if (outside(gtm_cg_offset_ft_range, 3, c->cg_offset)) return GTM_BAD_CG_OFFSET;
    if (outside(gtm_coefficient_factor_range, GTM_NC, c->coefficient_factor)) return GTM_BAD_COEFFICIENT_FACTOR;
    return GTM_CONFIGURED;
}

/* SPEC 9: no surface but the commanded ones, these all together, and no other increment. */
static int has_study_aerodynamics(const gtm_configuration *c)
{
    if (c->damage_case || c->has_stall_asymmetry || c->stabilizer != 0 || c->gear != 0) return 0;
    for (int i = 0; i < GTM_SPOILERS; i++)
        if (c->spoiler[i] != 0) return 0;
    for (int i = 0; i < GTM_FLAPS; i++)
        if (c->flap[i] != 0) return 0;
    for (int i = 0; i < GTM_COMMANDED; i++)
        if (c->surface_gain[i] != 1 || c->surface_offset[i] != 0) return 0;
    return 1;
}

/* Panels that do something; those of the same table that always move together become one. */
static void configure_panels(gtm_configuration *c)
{
    const unsigned char *has = gtm_has_surface[c->damage_case];
    c->panels = 0;
    for (int k = 0; k < GTM_PANELS; k++) {
        const gtm_panel *panel = &gtm_panels[k];
        const int i = panel->surface, commanded = i < GTM_COMMANDED;
        const double gain = commanded ? c->surface_gain[i] * gtm_drives[i].sign : 0;
        const double offset = commanded ? c->surface_offset[i] : c->spoiler[i - GTM_COMMANDED];
        if (!has[i] || (gain == 0 && offset == 0)) continue; /* all tables are zero at zero deflection */
        struct gtm_active_panel *active = c->panel;
        while (active < c->panel + c->panels &&
               !(active->panel->table == panel->table && active->panel->is_left == panel->is_left &&
                 active->gain == gain && active->offset == offset))
            active++;
        if (active == c->panel + c->panels) {
            c->panels++;
            memset(active, 0, sizeof *active);
            active->panel = panel;
            active->gain = gain;
            active->offset = offset;
        }
        for (int j = 0; j < GTM_NC; j++) active->weight[j] += panel->weight[j];
    }
}

static void add_segment(gtm_configuration *c, double gain, double offset, double part, double arm)
{
    struct gtm_active_segment *segment = c->segment;
    while (segment < c->segment + c->segments && !(segment->gain == gain && segment->offset == offset)) segment++;
    if (segment == c->segment + c->segments) {
        c->segments++;
        memset(segment, 0, sizeof *segment);
        segment->gain = gain;
        segment->offset = offset;
    }
    segment->part += part;
    segment->arm += arm;
}

/* SPEC 5.4 with st = table(STAB, 0): the sum of has_i (table(STAB, e_i) - st)/4 and of st. Pairs left and right, so
   that equal segments have no arm. */
static void configure_tail(gtm_configuration *c)
{
    static const int pair[2][2] = {{0, 2}, {1, 3}}; /* outboard, inboard */
    const unsigned char *has = gtm_has_surface[c->damage_case];
    const double part = gtm_elevator_part;
    double stabilizer_part = has[GTM_AERODYNAMIC - 1], stabilizer_arm = 0;
    c->segments = 0;
    for (int k = 0; k < 2; k++) {
        for (int side = 0; side < 2; side++) {
            const int i = pair[k][side];
            if (!has[i]) continue;
            add_segment(c, c->surface_gain[i], c->surface_offset[i], part, part * gtm_elevator_arm[i]);
            stabilizer_part -= part;
            stabilizer_arm -= part * gtm_elevator_arm[i];
        }
    }
    if (stabilizer_part != 0 || stabilizer_arm != 0) add_segment(c, 0, 0, stabilizer_part, stabilizer_arm);
}

static void configure_flaps(gtm_configuration *c)
{
    const unsigned char *has = gtm_has_surface[c->damage_case] + GTM_COMMANDED + GTM_SPOILERS;
    memset(c->flap_coefficients, 0, sizeof c->flap_coefficients);
    for (int k = 0; k < GTM_FLAPS; k++)
        for (int j = 0; j < GTM_NC; j++)
            c->flap_coefficients[j] += has[k] * c->flap[k] * gtm_flap_table[k * 8 + j];
}

int gtm_configure(gtm_configuration *c)
{
    const int fault = fault_of(c);
    if (fault) return fault;
    configure_panels(c);
    configure_tail(c);
    configure_flaps(c);
    c->is_folded = has_study_aerodynamics(c);
    const double damage_case = c->damage_case, has_shear = c->has_shear != 0;
    const double running[2] = {c->engine_running[0] != 0, c->engine_running[1] != 0};
    cas_configured_parameters((const double *[]){&c->fuel_used, &c->gear, &damage_case, running, c->wind, c->gust,
                                           &has_shear, &c->runway_altitude, &c->mass_factor, c->cg_offset},
                        (double *[]){c->parameters, &c->mass, c->cg, c->inertia}, 0, 0, 0);
    return GTM_CONFIGURED;
}

void gtm_study_configuration(gtm_configuration *c)
{
    memset(c, 0, sizeof *c);
    for (int i = 0; i < GTM_COMMANDED; i++) c->surface_gain[i] = 1;
    c->engine_running[0] = c->engine_running[1] = 1;
    c->has_shear = 1;
    c->runway_altitude = gtm_default_runway;
    c->mass_factor = 1;
    for (int j = 0; j < GTM_NC; j++) c->coefficient_factor[j] = 1;
    gtm_configure(c);
}

long gtm_configuration_size(void)
{
    return sizeof(gtm_configuration);
}
