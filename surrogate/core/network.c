/* Outputs of a network of tansig neurons (paper eqs. 12, 13, 43), many samples at a time.
 *
 * Blocks of samples go through all layers, so that they stay in the processor's cache. Inside a block the values of one
 * neuron lie side by side, which a compiler turns into vector instructions: the last block is filled up, so a sample's
 * outputs do not depend on its place.
 */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { BLOCK = 128 };

/* One version of a function for each kind of vector instructions; the processor's is chosen when the library is loaded. */
#if defined(__GNUC__) && !defined(__clang__) && __GNUC__ >= 12 && defined(__x86_64__) && defined(__gnu_linux__)
#define FOR_EACH_PROCESSOR __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define FOR_EACH_PROCESSOR
#endif
#if defined(_WIN32)
#define EXPORTED __declspec(dllexport)
#else
#define EXPORTED __attribute__((visibility("default")))
#endif

/* tanh of each z, to 4 units in the last place.
 *
 * With x = k ln(2)/2 + h, |h| <= ln(2)/4, the addition theorem tanh(a + h) = (tanh a + tanh h) / (1 + tanh a tanh h)
 * has tanh a = (2^k - 1) / (2^k + 1). tanh h = h P(h^2) / Q(h^2) is Lambert's continued fraction
 * h/(1 + h^2/(3 + h^2/(5 + ...))) up to 11, whose error here is 5e-19. Beyond 20 tanh is 1 to the last bit.
 */
FOR_EACH_PROCESSOR
static void tanh_of_each(long n, double *restrict z)
{
    const double ends = 20.0, two_over_ln2 = 2.8853900817779268;
    const double half_ln2 = 0.3465735901845619, half_ln2_rest = 9.541074646352939e-11; /* k times the first is exact */
    const double to_integer = 6755399441055744.0; /* 3 * 2^51: what is added to it is rounded to a whole number */
    for (long j = 0; j < n; j++) {
        double x = z[j];
        x = x > ends ? ends : x;
        x = x < -ends ? -ends : x;
        const double shifted = x * two_over_ln2 + to_integer, k = shifted - to_integer;
        const double h = (x - k * half_ln2) - k * half_ln2_rest, hh = h * h;
        uint64_t bits;
        double power;
        memcpy(&bits, &shifted, sizeof bits);
        bits = (bits << 52) + ((uint64_t)1023 << 52); /* k, the lowest bits of `shifted`, as an exponent: 2^k */
        memcpy(&power, &bits, sizeof power);
        const double P = h * (10395.0 + hh * (1260.0 + hh * 21.0));
        const double Q = 10395.0 + hh * (4725.0 + hh * (210.0 + hh));
        z[j] = ((power - 1.0) * Q + (power + 1.0) * P) / ((power + 1.0) * Q + (power - 1.0) * P);
    }
}

/* z = W a + b: a (before, BLOCK), W (size, before), b (size), z (size, BLOCK). */
FOR_EACH_PROCESSOR
static void layer(long size, long before, const double *W, const double *b, const double *restrict a, double *restrict z)
{
    for (long s = 0; s < size; s++, W += before, z += BLOCK) {
        long i = 0;
        for (int j = 0; j < BLOCK; j++) z[j] = b[s];
        for (; i + 4 <= before; i += 4) { /* four at a time, since z is loaded and stored each time */
            const double w0 = W[i], w1 = W[i + 1], w2 = W[i + 2], w3 = W[i + 3];
            const double *restrict a0 = a + i * BLOCK, *a1 = a0 + BLOCK, *a2 = a1 + BLOCK, *a3 = a2 + BLOCK;
            for (int j = 0; j < BLOCK; j++) z[j] += w0 * a0[j] + w1 * a1[j] + w2 * a2[j] + w3 * a3[j];
        }
        for (; i < before; i++)
            for (int j = 0; j < BLOCK; j++) z[j] += W[i] * a[i * BLOCK + j];
    }
}

/* Outputs y (n, m) in their units at the inputs x (n, d) in theirs.
 *
 * sizes (layers + 1): d, the neurons of each hidden layer, m. parameters: W_1 row by row, b_1, W_2, b_2, ...
 * Scaled inputs are (x - least) factor - 1; outputs are (scaled + 1) factor + least, each with its own.
 * Returns 0, or 1 where there is no memory.
 */
EXPORTED int network_outputs(long n, const double *x, double *y, int layers, const int *sizes, const double *parameters,
                             const double *input_least, const double *input_factor, const double *output_least,
                             const double *output_factor)
{
    const int d = sizes[0], m = sizes[layers];
    size_t widest = 0;
    for (int l = 0; l <= layers; l++) widest = (size_t)sizes[l] > widest ? (size_t)sizes[l] : widest;
    double *const memory = malloc(2 * widest * BLOCK * sizeof *memory);
    if (!memory) return 1;
    for (long first = 0; first < n; first += BLOCK) {
        const int rows = n - first < BLOCK ? (int)(n - first) : BLOCK;
        const double *at = x + first * d, *w = parameters;
        double *out = y + first * m, *a = memory, *z = memory + widest * BLOCK;
        if (rows < BLOCK) memset(a, 0, (size_t)d * BLOCK * sizeof *a);
        for (int i = 0; i < d; i++)
            for (int j = 0; j < rows; j++) a[i * BLOCK + j] = (at[j * (long)d + i] - input_least[i]) * input_factor[i] - 1.0;
        for (int l = 1; l <= layers; l++) {
            const long size = sizes[l], before = sizes[l - 1];
            layer(size, before, w, w + size * before, a, z);
            if (l < layers) tanh_of_each(size * BLOCK, z);
            w += size * (before + 1);
            double *const outputs = z;
            z = a;
            a = outputs;
        }
        for (int o = 0; o < m; o++)
            for (int j = 0; j < rows; j++) out[j * (long)m + o] = (a[o * BLOCK + j] + 1.0) * output_factor[o] + output_least[o];
    }
    free(memory);
    return 0;
}
