#include "solver/stability.h"

#include <math.h>
#include <string.h>

enum { N = GTM_NL, MOST_ITERATIONS = 60 };

typedef struct {
    double re, im;
} complex_number;

/* ---- Characteristic polynomial s^8 + p[1] s^7 + .. + p[8] ---- */

/* To Hessenberg form by elimination with pivoting, a similarity. */
static void reduce_to_hessenberg(double H[N][N])
{
    for (int k = 1; k < N - 1; k++) {
        int pivot = k;
        for (int i = k + 1; i < N; i++)
            if (fabs(H[i][k - 1]) > fabs(H[pivot][k - 1])) pivot = i;
        if (H[pivot][k - 1] == 0) continue;
        if (pivot != k) {
            for (int j = 0; j < N; j++) {
                const double kept = H[k][j];
                H[k][j] = H[pivot][j];
                H[pivot][j] = kept;
            }
            for (int i = 0; i < N; i++) {
                const double kept = H[i][k];
                H[i][k] = H[i][pivot];
                H[i][pivot] = kept;
            }
        }
        for (int i = k + 1; i < N; i++) {
            const double factor = H[i][k - 1] / H[k][k - 1];
            if (factor == 0) continue;
            for (int j = k - 1; j < N; j++) H[i][j] -= factor * H[k][j];
            for (int j = 0; j < N; j++) H[j][k] += factor * H[j][i];
        }
    }
}

/* From the leading minors of s I - H, one after the other. */
static void characteristic_polynomial(double H[N][N], double *p)
{
    double minor[N + 1][N + 1] = {{1}}; /* by falling powers */
    reduce_to_hessenberg(H);
    for (int k = 1; k <= N; k++) {
        double *at = minor[k];
        memcpy(at, minor[k - 1], sizeof *at * (size_t)k);
        for (int j = 0; j < k; j++) at[j + 1] -= H[k - 1][k - 1] * minor[k - 1][j];
        double below = 1;
        for (int i = k - 1; i > 0; i--) {
            below *= H[i][i - 1];
            const double factor = below * H[i - 1][k - 1];
            for (int j = 0; j < i; j++) at[k - i + 1 + j] -= factor * minor[i - 1][j];
        }
    }
    memcpy(p, minor[N], sizeof minor[N]);
}

/* ---- Its roots ---- */

/* How many have a positive real part: changes of sign in the first column of Routh's array. */
static int count_unstable(const double *p)
{
    double upper[N + 2] = {0}, lower[N + 2] = {0}, first = 1;
    int changes = 0;
    for (int i = 0; i <= N; i++) (i % 2 ? lower : upper)[i / 2] = p[i];
    for (int row = 1; row <= N; row++) {
        const double pivot = lower[0] != 0 ? lower[0] : 1e-300;
        double next[N + 2] = {0};
        changes += (pivot < 0) != (first < 0);
        for (int j = 0; j < N / 2; j++) next[j] = upper[j + 1] - upper[0] * lower[j + 1] / pivot;
        memcpy(upper, lower, sizeof upper);
        memcpy(lower, next, sizeof lower);
        first = upper[0] = pivot;
    }
    return changes;
}

static complex_number product(complex_number a, complex_number b)
{
    return (complex_number){a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}

static complex_number quotient(complex_number a, complex_number b)
{
    const double square = b.re * b.re + b.im * b.im;
    return (complex_number){(a.re * b.re + a.im * b.im) / square, (a.im * b.re - a.re * b.im) / square};
}

static complex_number square_root(complex_number a)
{
    const double size = sqrt(a.re * a.re + a.im * a.im), re = sqrt(fmax(0.5 * (size + a.re), 0));
    const double im = sqrt(fmax(0.5 * (size - a.re), 0));
    return (complex_number){re, a.im < 0 ? -im : im};
}

/* A root of a polynomial of this degree, a small one first (Laguerre). */
static complex_number small_root(int degree, const double *p)
{
    complex_number z = {0, 0};
    for (int iteration = 0; iteration < MOST_ITERATIONS; iteration++) {
        complex_number value = {p[0], 0}, slope = {0, 0}, half_curvature = {0, 0};
        for (int i = 1; i <= degree; i++) {
            half_curvature = product(half_curvature, z);
            half_curvature.re += slope.re;
            half_curvature.im += slope.im;
            slope = product(slope, z);
            slope.re += value.re;
            slope.im += value.im;
            value = product(value, z);
            value.re += p[i];
        }
        if (value.re == 0 && value.im == 0) break;
        const complex_number square = product(slope, slope), other = product(value, half_curvature);
        const double n = degree;
        const complex_number root = square_root((complex_number){
            (n - 1) * ((n - 1) * square.re - 2 * n * other.re), (n - 1) * ((n - 1) * square.im - 2 * n * other.im)});
        const double sign = slope.re * root.re + slope.im * root.im < 0 ? -1 : 1;
        const complex_number below = {slope.re + sign * root.re, slope.im + sign * root.im};
        if (below.re == 0 && below.im == 0) {
            z.re += 1e-3; /* a saddle */
            continue;
        }
        const complex_number step = quotient((complex_number){n * value.re, n * value.im}, below);
        z.re -= step.re;
        z.im -= step.im;
        if (fabs(step.re) + fabs(step.im) <= 1e-12 * (fabs(z.re) + fabs(z.im))) break;
    }
    return z;
}

/* Divide a root out, with its conjugate if it is complex; the degree left. */
static int deflate(int degree, double *p, complex_number *root)
{
    if (degree == 1 || fabs(root->im) <= 1e-9 * (fabs(root->re) + fabs(root->im))) {
        root->im = 0;
        for (int i = 1; i < degree; i++) p[i] += root->re * p[i - 1];
        return degree - 1;
    }
    const double twice = 2 * root->re, square = root->re * root->re + root->im * root->im;
    for (int i = 1; i < degree - 1; i++) p[i] += twice * p[i - 1] - (i > 1 ? square * p[i - 2] : 0);
    return degree - 2;
}

/* ---- Controllability ---- */

/* Whether the smallest singular value of [lambda I - A, B] is above the threshold: whether its product with its own
   adjoint, less the threshold's square, is positive definite (Cholesky). `square`: A A' + B B'. */
static int is_controlled(const gtm_linear *l, double square[N][N], complex_number lambda, double threshold)
{
    double re[N][N], im[N][N];
    const double diagonal = lambda.re * lambda.re + lambda.im * lambda.im - threshold * threshold;
    for (int i = 0; i < N; i++)
        for (int j = 0; j <= i; j++) {
            double real = square[i][j] - lambda.re * (l->row[i][j] + l->row[j][i]) + (i == j ? diagonal : 0);
            double imaginary = lambda.im * (l->row[i][j] - l->row[j][i]);
            for (int k = 0; k < j; k++) {
                real -= re[i][k] * re[j][k] + im[i][k] * im[j][k];
                imaginary -= im[i][k] * re[j][k] - re[i][k] * im[j][k];
            }
            if (i == j) {
                if (!(real > 0)) return 0;
                re[i][i] = sqrt(real);
                im[i][i] = 0;
            } else {
                re[i][j] = real / re[j][j];
                im[i][j] = imaginary / re[j][j];
            }
        }
    return 1;
}

gtm_verdict gtm_judge(const gtm_linear *l, double threshold)
{
    double H[N][N], p[N + 1], square[N][N];
    for (int i = 0; i < N; i++) memcpy(H[i], l->row[i], sizeof H[i]);
    characteristic_polynomial(H, p);
    int unstable = count_unstable(p);
    if (!unstable) return (gtm_verdict){1, 1};
    for (int i = 0; i < N; i++)
        for (int j = 0; j <= i; j++) {
            square[i][j] = 0;
            for (int k = 0; k < N + l->inputs; k++) square[i][j] += l->row[i][k] * l->row[j][k];
        }
    for (int degree = N; unstable > 0 && degree > 0;) {
        complex_number root = small_root(degree, p);
        degree = deflate(degree, p, &root);
        if (!(root.re > 0)) continue;
        if (!is_controlled(l, square, root, threshold)) return (gtm_verdict){0, 0};
        unstable -= root.im != 0 ? 2 : 1;
    }
    return (gtm_verdict){0, 1};
}
