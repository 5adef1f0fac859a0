#include "solver/linear_program.h"

#include <math.h>

enum { MOST_ROWS = 64, MOST_VARIABLES = 5 };
static const double tolerance = 1e-12;

static int optimum_on_interval(int rows, const double *A, const double *b, double c, double lower, double upper,
                               double *x)
{
    for (int i = 0; i < rows; i++) {
        if (A[i] > tolerance) {
            if (b[i] / A[i] < upper) upper = b[i] / A[i];
        } else if (A[i] < -tolerance) {
            if (b[i] / A[i] > lower) lower = b[i] / A[i];
        } else if (b[i] < -1e-9) {
            return 1;
        }
    }
    if (lower > upper) {
        if (lower - upper > 1e-9) return 1;
        lower = upper = 0.5 * (lower + upper);
    }
    *x = c > 0 ? lower : upper;
    return 0;
}

/* Seidel's incremental algorithm: when a row cuts the optimum off, the new one lies on that row, so one variable is
   eliminated and the problem of the rows before it is solved there. */
int gtm_linear_program(int d, int rows, const double *A, const double *b, const double *c, const double *lower,
                       const double *upper, double *x)
{
    if (d == 1) return optimum_on_interval(rows, A, b, c[0], lower[0], upper[0], x);
    for (int j = 0; j < d; j++) x[j] = c[j] > 0 ? lower[j] : upper[j];
    for (int i = 0; i < rows; i++) {
        const double *row = A + i * d;
        double value = 0, largest = 0;
        int e = 0;
        for (int j = 0; j < d; j++) {
            value += row[j] * x[j];
            if (fabs(row[j]) > largest) {
                largest = fabs(row[j]);
                e = j;
            }
        }
        if (value <= b[i] + tolerance * (1 + fabs(b[i]))) continue;
        if (largest < tolerance) {
            if (b[i] < -1e-9) return 1;
            continue;
        }
        /* x_e = (b_i - sum of the others) / row_e; its bounds become two rows more. */
        double A_sub[(MOST_ROWS + 8) * (MOST_VARIABLES - 1)], b_sub[MOST_ROWS + 8];
        double c_sub[MOST_VARIABLES], lower_sub[MOST_VARIABLES], upper_sub[MOST_VARIABLES], x_sub[MOST_VARIABLES];
        const int n = d - 1;
        int m = 0;
        for (int k = 0; k < i; k++, m++) {
            const double factor = A[k * d + e] / row[e];
            for (int j = 0, s = 0; j < d; j++)
                if (j != e) A_sub[m * n + s++] = A[k * d + j] - factor * row[j];
            b_sub[m] = b[k] - factor * b[i];
        }
        for (int side = 0; side < 2; side++, m++) {
            const double sign = side ? -1 : 1;
            for (int j = 0, s = 0; j < d; j++)
                if (j != e) A_sub[m * n + s++] = -sign * row[j] / row[e];
            b_sub[m] = sign * ((side ? lower[e] : upper[e]) - b[i] / row[e]);
        }
        for (int j = 0, s = 0; j < d; j++) {
            if (j == e) continue;
            c_sub[s] = c[j] - c[e] * row[j] / row[e];
            lower_sub[s] = lower[j];
            upper_sub[s++] = upper[j];
        }
        if (gtm_linear_program(n, m, A_sub, b_sub, c_sub, lower_sub, upper_sub, x_sub)) return 1;
        double rest = b[i];
        for (int j = 0, s = 0; j < d; j++)
            if (j != e) {
                x[j] = x_sub[s++];
                rest -= row[j] * x[j];
            }
        x[e] = rest / row[e];
    }
    return 0;
}
