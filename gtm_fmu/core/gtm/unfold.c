#include "gtm/unfold.h"

#include <string.h>

#ifdef __clang__
#pragma STDC FP_CONTRACT OFF /* the same bits on every platform; GCC contracts nothing in C99 */
#endif

/* Lines that have not been read yet. */
typedef struct {
    const unsigned char *form;
    const double *number;
} reader;

static const double mirror[] = {1, -1, 1, -1, 1, -1, 1, 1}; /* CX CY CZ Cl Cm Cn of a mirrored aircraft, and padding */

/* The next line at all places. Clenshaw's recurrence, in the order of NumPy's chebval. */
static void read_line(const gtm_stored_table *from, const double *x, reader *at, double *line)
{
    const int form = *at->form++;
    double c[GTM_LINE_COEFFICIENTS] = {0};
    if (form == GTM_LINE_VALUES) {
        memcpy(line, at->number, from->places * sizeof *line);
        at->number += from->places;
        return;
    }
    for (int k = 0; k < GTM_LINE_COEFFICIENTS; k++)
        if (form >> k & 1) c[k] = *at->number++;
    for (int j = 0; j < from->places; j++) {
        double c0 = c[GTM_LINE_COEFFICIENTS - 2], c1 = c[GTM_LINE_COEFFICIENTS - 1];
        for (int k = GTM_LINE_COEFFICIENTS - 3; k >= 0; k--) {
            const double next = c0 + c1 * (2 * x[j]);
            c0 = c[k] - c1;
            c1 = next;
        }
        line[j] = c0 + c1 * x[j];
    }
}

/* (1 - fraction) low + fraction high: exact at both ends, linear beyond them (SPEC 1). */
static void between(const double *low, const double *high, double fraction, int count, double *to)
{
    for (int i = 0; i < count; i++) to[i] = (1.0 - fraction) * low[i] + fraction * high[i];
}

/* Mirroring reverses both beta and the deflection, so the image of the n-th entry is the n-th from the end. */
static void add_mirror_image(int entries, double *row)
{
    for (int n = 0; 2 * n < entries; n++) {
        double *one = row + 8 * n, *other = row + 8 * (entries - 1 - n);
        for (int i = 0; i < 8; i++) {
            const double a = one[i], b = other[i];
            one[i] = a + mirror[i] * b;
            other[i] = b + mirror[i] * a;
        }
    }
}

/* The next alpha's part of a table: [place][third][component]. */
static void read_row(const gtm_stored_table *from, const double *x, reader *at, int has_mirror_image,
                     const gtm_axis *places, double *row)
{
    double line[GTM_LONGEST_LINE], own[GTM_LARGEST_ROW] = {0};
    const int step = from->thirds * from->width;
    for (int t = 0; t < from->thirds; t++)
        for (int i = 0; i < from->components; i++) {
            read_line(from, x, at, line);
            for (int j = 0; j < from->places; j++) own[j * step + t * from->width + i] = line[j];
        }
    if (has_mirror_image) add_mirror_image(from->places * from->thirds, own);
    if (!places) {
        memcpy(row, own, from->places * step * sizeof *row);
        return;
    }
    for (int j = 0, k = 0; j < places->points; j++) {
        const double place = places->point[j], *ours = from->place;
        while (k < from->places - 2 && place >= ours[k + 1]) k++;
        between(own + k * step, own + (k + 1) * step, (place - ours[k]) / (ours[k + 1] - ours[k]), step,
                row + j * step);
    }
}

void gtm_unfold(const gtm_stored_table *from, int has_mirror_image, const gtm_axis *places, double *to)
{
    const int size = (places ? places->points : from->places) * from->thirds * from->width;
    const double *alpha = from->alpha;
    double x[GTM_LONGEST_LINE], rows[2][GTM_LARGEST_ROW], *low = rows[0], *high = rows[1];
    reader at = {from->form, from->number};
    for (int j = 0; j < from->places; j++) x[j] = from->place[j] / from->scale;
    for (int block = 0; block < from->blocks; block++) {
        int rows_read = 0;
        for (int i = 0; i < gtm_alpha_axis.points; i++, to += size) {
            const double wanted = gtm_alpha_axis.point[i];
            while (rows_read < 2 || (rows_read < from->alphas && wanted >= alpha[rows_read - 1])) {
                double *const free = low;
                low = high;
                high = free;
                read_row(from, x, &at, has_mirror_image, places, high);
                rows_read++;
            }
            const double *ends = alpha + rows_read - 2;
            between(low, high, (wanted - ends[0]) / (ends[1] - ends[0]), size, to);
        }
    }
}
