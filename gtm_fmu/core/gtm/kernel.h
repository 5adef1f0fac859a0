/* Building blocks of the table kernels: multilinear look-ups with slopes, and the terms that all configurations share.

   Inlined with a constant `with_slopes`, so that a look-up without slopes does not compute them. */
#ifndef GTM_KERNEL_H
#define GTM_KERNEL_H

#include <string.h>

#include "gtm/table.h"

/* Index of the interval and the fraction inside it (unclipped), with the inverse width for slopes. */
typedef struct {
    int index;
    double fraction, inverse_width;
} position;

static inline position locate(const gtm_axis *axis, double value)
{
    double cell = (value - axis->point[0]) * axis->inverse_cell_width;
    if (!(cell > 0)) cell = 0; /* NaN too */
    if (cell > axis->cells - 1) cell = axis->cells - 1;
    int i = axis->interval[(int)cell];
    if (i < axis->points - 2 && value >= axis->point[i + 1]) i++;
    position at;
    at.index = i;
    at.inverse_width = 1.0 / (axis->point[i + 1] - axis->point[i]);
    at.fraction = (value - axis->point[i]) * at.inverse_width;
    return at;
}

/* Value and slopes of a table over (alpha, beta[, third]); W components, 4 or 8. */
typedef struct {
    double value[8], alpha[8], beta[8], third[8];
} sample;

/* Trilinear: third axis innermost, so its two neighbours lie side by side. */
static inline void trilinear(const double *table, int beta_stride, int alpha_stride, int W, position a, position b,
                             position t, int with_slopes, sample *out)
{
    const double *low = table + a.index * alpha_stride + b.index * beta_stride + t.index * W;
    const double *c00 = low, *c01 = low + beta_stride, *c10 = low + alpha_stride, *c11 = c10 + beta_stride;
    const double f = t.fraction;
    for (int i = 0; i < W; i++) {
        const double d00 = c00[W + i] - c00[i], d01 = c01[W + i] - c01[i];
        const double d10 = c10[W + i] - c10[i], d11 = c11[W + i] - c11[i];
        const double v00 = c00[i] + f * d00, v01 = c01[i] + f * d01;
        const double v10 = c10[i] + f * d10, v11 = c11[i] + f * d11;
        const double v0 = v00 + b.fraction * (v01 - v00), v1 = v10 + b.fraction * (v11 - v10);
        out->value[i] = v0 + a.fraction * (v1 - v0);
        if (with_slopes) {
            const double g0 = v01 - v00, g1 = v11 - v10;
            const double t0 = d00 + b.fraction * (d01 - d00), t1 = d10 + b.fraction * (d11 - d10);
            out->alpha[i] = (v1 - v0) * a.inverse_width;
            out->beta[i] = (g0 + a.fraction * (g1 - g0)) * b.inverse_width;
            out->third[i] = (t0 + a.fraction * (t1 - t0)) * t.inverse_width;
        }
    }
}

/* Bilinear over (alpha, second): the slope along the second axis goes to `third`. */
static inline void bilinear(const double *table, int alpha_stride, int W, position a, position s, int with_slopes,
                            sample *out)
{
    const double *c0 = table + a.index * alpha_stride + s.index * W, *c1 = c0 + alpha_stride;
    for (int i = 0; i < W; i++) {
        const double d0 = c0[W + i] - c0[i], d1 = c1[W + i] - c1[i];
        const double v0 = c0[i] + s.fraction * d0, v1 = c1[i] + s.fraction * d1;
        out->value[i] = v0 + a.fraction * (v1 - v0);
        if (with_slopes) {
            out->alpha[i] = (v1 - v0) * a.inverse_width;
            out->third[i] = (d0 + a.fraction * (d1 - d0)) * s.inverse_width;
        }
    }
}

enum { CX, CY, CZ, CL, CM, CN };
static const int every[6] = {CX, CY, CZ, CL, CM, CN};
static const int longitudinal[3] = {CX, CZ, CM};
static const int lateral[3] = {CY, CL, CN};

static inline void add(const sample *s, const int *component, int count, int beta_too, int column, int with_slopes,
                       double *C, double *T)
{
    for (int i = 0; i < count; i++) {
        const int c = component[i];
        C[c] += s->value[i];
        if (with_slopes) {
            T[c * GTM_NK + K_ALPHA] += s->alpha[i];
            if (beta_too) T[c * GTM_NK + K_BETA] += s->beta[i];
            if (column) T[c * GTM_NK + column] += s->third[i];
        }
    }
}

/* Basic airframe (SPEC 5.1), where the sums begin. */
static inline void begin_with_basic(position a, position b, int with_slopes, double *C, double *T)
{
    sample s;
    memset(C, 0, GTM_NC * sizeof *C);
    if (with_slopes) memset(T, 0, GTM_NC * GTM_NK * sizeof *T);
    bilinear(gtm_basic_table, gtm_beta_axis.points * 8, 8, a, b, with_slopes, &s);
    if (with_slopes) memcpy(s.beta, s.third, sizeof s.beta);
    add(&s, every, 6, 1, 0, with_slopes, C, T);
}

/* Dynamic terms of the undamaged aircraft (SPEC 5.5). */
static inline void add_dynamic(const double *K, position a, position b, int with_slopes, double *C, double *T)
{
    sample s;
    const position p = locate(&gtm_p_hat_axis, K[K_P_HAT]), q = locate(&gtm_q_hat_axis, K[K_Q_HAT]),
                   r = locate(&gtm_r_hat_axis, K[K_R_HAT]);
    bilinear(gtm_p_table, gtm_p_hat_axis.points * 4, 4, a, p, with_slopes, &s);
    add(&s, lateral, 3, 0, K_P_HAT, with_slopes, C, T);
    bilinear(gtm_q_table, gtm_q_hat_axis.points * 4, 4, a, q, with_slopes, &s);
    add(&s, longitudinal, 3, 0, K_Q_HAT, with_slopes, C, T);
    bilinear(gtm_r_table, gtm_r_hat_axis.points * 4, 4, a, r, with_slopes, &s);
    add(&s, lateral, 3, 0, K_R_HAT, with_slopes, C, T);

    /* The rotary table is zero at zero rotation, and rotation is exactly zero in Kalviste's third case (SPEC 5.5). */
    if (K[K_OMEGA_HAT] != 0) {
        const position o = locate(&gtm_omega_hat_axis, K[K_OMEGA_HAT]);
        trilinear(gtm_omega_table, gtm_omega_hat_axis.points * 8, gtm_beta_axis.points * gtm_omega_hat_axis.points * 8,
                  8, a, b, o, with_slopes, &s);
        add(&s, every, 6, 1, K_OMEGA_HAT, with_slopes, C, T);
    }
}

#endif
