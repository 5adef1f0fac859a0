#include "solver/linear_algebra.h"

#include <math.h>

static inline int eliminate(int n, double *A, double *b)
{
    for (int k = 0; k < n; k++) {
        int pivot = k;
        for (int i = k + 1; i < n; i++)
            if (fabs(A[i * n + k]) > fabs(A[pivot * n + k])) pivot = i;
        if (!(fabs(A[pivot * n + k]) > 1e-14)) return 1;
        if (pivot != k) {
            for (int j = k; j < n; j++) {
                const double kept = A[k * n + j];
                A[k * n + j] = A[pivot * n + j];
                A[pivot * n + j] = kept;
            }
            const double kept = b[k];
            b[k] = b[pivot];
            b[pivot] = kept;
        }
        for (int i = k + 1; i < n; i++) {
            const double factor = A[i * n + k] / A[k * n + k];
            for (int j = k + 1; j < n; j++) A[i * n + j] -= factor * A[k * n + j];
            b[i] -= factor * b[k];
        }
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int j = i + 1; j < n; j++) b[i] -= A[i * n + j] * b[j];
        b[i] /= A[i * n + i];
    }
    return 0;
}

int gtm_solve(int n, double *A, double *b)
{
    if (n == 6) return eliminate(6, A, b); /* with its loops unrolled */
    return eliminate(n, A, b);
}

int gtm_solve_definite(int n, int width, double *H, double *b)
{
    for (int k = 0; k < n; k++) {
        double *row = H + k * width;
        const double diagonal = row[k];
        for (int j = 0; j < k; j++) row[k] -= row[j] * row[j];
        if (!(row[k] > 1e-9 * fabs(diagonal) && row[k] > 1e-12)) return 1;
        row[k] = sqrt(row[k]);
        for (int i = k + 1; i < n; i++) {
            double *below = H + i * width;
            for (int j = 0; j < k; j++) below[k] -= below[j] * row[j];
            below[k] /= row[k];
        }
    }
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < i; j++) b[i] -= H[i * width + j] * b[j];
        b[i] /= H[i * width + i];
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int j = i + 1; j < n; j++) b[i] -= H[j * width + i] * b[j];
        b[i] /= H[i * width + i];
    }
    return 0;
}
