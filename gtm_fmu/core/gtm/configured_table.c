#include "gtm/configured_table.h"

#include "gtm/kernel.h"
#include "gtm/unfold.h"

GTM_AT_LOAD(gtm_unfold_configured_tables)

void gtm_unfold_configured_tables(void)
{
    gtm_unfold(&gtm_aileron_stored, 0, 0, gtm_right_aileron_table);
    gtm_unfold(&gtm_right_spoiler_stored, 0, 0, gtm_right_spoiler_table);
    gtm_unfold(&gtm_tail_stored, 0, 0, gtm_tail_table);
    gtm_unfold(&gtm_gear_stored, 0, 0, gtm_gear_table);
    gtm_unfold(&gtm_damage_increment_stored, 0, 0, gtm_damage_increment_table);
}

/* As `locate`, but at a breakpoint the interval below it: for a surface that moves against its command. */
static inline position locate_below(const gtm_axis *axis, double value)
{
    position at = locate(axis, value);
    if (at.index > 0 && value == axis->point[at.index]) {
        at.index--;
        at.inverse_width = 1.0 / (axis->point[at.index + 1] - axis->point[at.index]);
        at.fraction = 1;
    }
    return at;
}

/* Held at the ends of a range, where slopes end too. */
static inline position locate_clipped(const gtm_axis *axis, double value, double lowest, double highest)
{
    double held = value;
    if (value < lowest) held = lowest;
    else if (value > highest) held = highest;
    position at = locate(axis, held);
    if (value < lowest || value >= highest) at.inverse_width = 0;
    return at;
}

static inline position clipped(const gtm_axis *axis, double value)
{
    return locate_clipped(axis, value, axis->point[0], axis->point[axis->points - 1]);
}

/* The place of -value on an axis symmetric about zero. */
static inline position mirrored(const gtm_axis *axis, position at)
{
    at.index = axis->points - 2 - at.index;
    at.fraction = 1 - at.fraction;
    at.inverse_width = -at.inverse_width;
    return at;
}

/* A table over alpha alone, four components wide. */
static inline void linear(const double *table, int stride, position a, sample *out)
{
    const double *c0 = table + a.index * stride, *c1 = c0 + stride;
    for (int i = 0; i < 4; i++) {
        out->value[i] = c0[i] + a.fraction * (c1[i] - c0[i]);
        out->alpha[i] = (c1[i] - c0[i]) * a.inverse_width;
    }
}

/* One component of a table over (alpha, beta, deflection), to coefficient `to`. */
static inline void add_part(const sample *s, int from, int to, double weight, int column, double gain, int with_slopes,
                            double *C, double *T)
{
    C[to] += weight * s->value[from];
    if (with_slopes) {
        T[to * GTM_NK + K_ALPHA] += weight * s->alpha[from];
        T[to * GTM_NK + K_BETA] += weight * s->beta[from];
        T[to * GTM_NK + column] += weight * gain * s->third[from]; /* a fixed surface has gain 0 */
    }
}

/* Rudder halves, ailerons and spoilers (SPEC 5.2, 5.3, 10.4). */
static inline void add_panels(const gtm_configuration *c, const double *K, position a, position b, int with_slopes,
                              double *C, double *T)
{
    const position b_left = mirrored(&gtm_beta_axis, b);
    sample s;
    for (int k = 0; k < c->panels; k++) {
        const struct gtm_active_panel *active = &c->panel[k];
        const gtm_panel *panel = active->panel;
        const gtm_drive *drive = panel->surface < GTM_COMMANDED ? &gtm_drives[panel->surface] : 0;
        const int column = drive ? drive->command : 0, points = panel->axis->points;
        const double deflection = active->gain * K[column] + active->offset;
        const position d = active->gain < 0 ? locate_below(panel->axis, deflection) : locate(panel->axis, deflection);
        trilinear(panel->table, points * 8, gtm_beta_axis.points * points * 8, 8, a, panel->is_left ? b_left : b, d,
                  with_slopes, &s);
        for (int i = 0; i < GTM_NC; i++)
            add_part(&s, i, i, active->weight[i], column, active->gain, with_slopes, C, T);
    }
}

/* Stabiliser and elevator segments (SPEC 5.4). */
static inline void add_tail(const gtm_configuration *c, const double *K, position a, position b, int with_slopes,
                            double *C, double *T)
{
    const int points = gtm_elevator_axis.points, plane = gtm_alpha_axis.points * gtm_beta_axis.points * points * 4;
    const position t = locate(&gtm_stabilizer_axis, c->stabilizer);
    const sample none = {{0}, {0}, {0}, {0}};
    sample s = none, next = none; /* the vectorised sums read slopes that are not asked for */
    for (int k = 0; k < c->segments; k++) {
        const struct gtm_active_segment *segment = &c->segment[k];
        const position e = locate(&gtm_elevator_axis, segment->gain * K[K_ELEVATOR] + segment->offset);
        const double *table = gtm_tail_table + t.index * plane;
        trilinear(table, points * 4, gtm_beta_axis.points * points * 4, 4, a, b, e, with_slopes, &s);
        if (t.fraction != 0) {
            trilinear(table + plane, points * 4, gtm_beta_axis.points * points * 4, 4, a, b, e, with_slopes, &next);
            for (int i = 0; i < 4; i++) {
                s.value[i] += t.fraction * (next.value[i] - s.value[i]);
                if (with_slopes) {
                    s.alpha[i] += t.fraction * (next.alpha[i] - s.alpha[i]);
                    s.beta[i] += t.fraction * (next.beta[i] - s.beta[i]);
                    s.third[i] += t.fraction * (next.third[i] - s.third[i]);
                }
            }
        }
        for (int i = 0; i < 3; i++)
            add_part(&s, i, longitudinal[i], segment->part, K_ELEVATOR, segment->gain, with_slopes, C, T);
        if (segment->arm != 0) {
            add_part(&s, 1, CL, segment->arm, K_ELEVATOR, segment->gain, with_slopes, C, T);
            add_part(&s, 0, CN, -segment->arm, K_ELEVATOR, segment->gain, with_slopes, C, T);
        }
    }
}

/* A table of a rate, held inside its ranges and scaled by the damage. */
static inline void add_damaged_rate(const gtm_configuration *c, const double *K, int rate, const double *table,
                                    const gtm_axis *axis, const int *component, position a_damage, int with_slopes,
                                    double *C, double *T)
{
    const gtm_range range = gtm_rate_alpha[rate];
    const int column = K_P_HAT + rate, stride = GTM_RATES * 4, block = gtm_damage_alpha_axis.points * stride;
    sample s, scale;
    bilinear(table, axis->points * 4, 4, locate_clipped(&gtm_alpha_axis, K[K_ALPHA], range.lowest, range.highest),
             clipped(axis, K[column]), with_slopes, &s);
    linear(gtm_damage_scale_table + (c->damage_case - 1) * block + rate * 4, stride, a_damage, &scale);
    for (int i = 0; i < 3; i++) {
        const int to = component[i];
        C[to] += s.value[i] * scale.value[i];
        if (with_slopes) {
            T[to * GTM_NK + K_ALPHA] += s.alpha[i] * scale.value[i] + s.value[i] * scale.alpha[i];
            T[to * GTM_NK + column] += s.third[i] * scale.value[i];
        }
    }
}

/* Increments and dynamic terms of a damaged aircraft (SPEC 10.5). */
static inline void add_damage(const gtm_configuration *c, const double *K, position a, int with_slopes, double *C,
                              double *T)
{
    const position a_damage = clipped(&gtm_damage_alpha_axis, K[K_ALPHA]);
    const position b_damage = clipped(&gtm_damage_beta_axis, K[K_BETA]);
    const int stride = gtm_damage_beta_axis.points * 8, block = gtm_damage_alpha_axis.points * stride;
    sample s;
    bilinear(gtm_damage_table + (c->damage_case - 1) * block, stride, 8, a_damage, b_damage, with_slopes, &s);
    if (with_slopes) memcpy(s.beta, s.third, sizeof s.beta);
    add(&s, every, 6, 1, 0, with_slopes, C, T);

    add_damaged_rate(c, K, 0, gtm_p_table, &gtm_p_hat_axis, lateral, a_damage, with_slopes, C, T);
    add_damaged_rate(c, K, 1, gtm_q_table, &gtm_q_hat_axis, longitudinal, a_damage, with_slopes, C, T);
    add_damaged_rate(c, K, 2, gtm_r_table, &gtm_r_hat_axis, lateral, a_damage, with_slopes, C, T);

    linear(gtm_damage_increment_table + (c->damage_case - 1) * gtm_alpha_axis.points * 4, 4, a, &s);
    for (int rate = 0; rate < GTM_RATES; rate++) {
        C[CY] += s.value[rate] * K[K_P_HAT + rate];
        if (with_slopes) {
            T[CY * GTM_NK + K_ALPHA] += s.alpha[rate] * K[K_P_HAT + rate];
            T[CY * GTM_NK + K_P_HAT + rate] += s.value[rate];
        }
    }
}

static inline void look_up(const gtm_configuration *c, const double *K, int with_slopes, double *C, double *T)
{
    const position a = locate(&gtm_alpha_axis, K[K_ALPHA]), b = locate(&gtm_beta_axis, K[K_BETA]);
    sample s;
    begin_with_basic(a, b, with_slopes, C, T);
    add_panels(c, K, a, b, with_slopes, C, T);
    add_tail(c, K, a, b, with_slopes, C, T);
    for (int i = 0; i < GTM_NC; i++) C[i] += c->flap_coefficients[i];
    if (c->gear != 0) {
        linear(gtm_gear_table, 4, a, &s);
        add(&s, longitudinal, 3, 0, 0, with_slopes, C, T);
    }
    if (c->damage_case)
        add_damage(c, K, a, with_slopes, C, T);
    else
        add_dynamic(K, a, b, with_slopes, C, T);
    if (c->has_stall_asymmetry) {
        bilinear(gtm_stall_table, gtm_stall_beta_axis.points * 8, 8, clipped(&gtm_stall_alpha_axis, K[K_ALPHA]),
                 clipped(&gtm_stall_beta_axis, K[K_BETA]), with_slopes, &s);
        if (with_slopes) memcpy(s.beta, s.third, sizeof s.beta);
        add(&s, every, 6, 1, 0, with_slopes, C, T);
    }
}

void gtm_configured_coefficients(const gtm_configuration *c, const double K[GTM_NK], double C[GTM_NC])
{
    if (c->is_folded)
        gtm_coefficients(K, C);
    else
        look_up(c, K, 0, C, 0);
    for (int i = 0; i < GTM_NC; i++) C[i] *= c->coefficient_factor[i];
}

void gtm_configured_coefficients_and_slopes(const gtm_configuration *c, const double K[GTM_NK], double C[GTM_NC],
                                            double T[GTM_NC * GTM_NK])
{
    if (c->is_folded)
        gtm_coefficients_and_slopes(K, C, T);
    else
        look_up(c, K, 1, C, T);
    for (int i = 0; i < GTM_NC; i++) {
        C[i] *= c->coefficient_factor[i];
        for (int j = 0; j < GTM_NK; j++) T[i * GTM_NK + j] *= c->coefficient_factor[i];
    }
}
