/* Processor nanoseconds of a case: outputs, outputs with slopes, standard deviations of an exported model. */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "model.h"

enum { CASES = 20000, ROUNDS = 15 };

static double x[CASES][model_inputs];
static double total; /* so that nothing is left out */

static double seconds(void) { return (double)clock() / CLOCKS_PER_SEC; }

#define MEASURE(statement)                                                        \
    do {                                                                          \
        double best = 1e9;                                                        \
        for (int round = 0; round < ROUNDS; round++) {                            \
            const double start = seconds();                                       \
            for (int n = 0; n < CASES; n++) {                                     \
                statement;                                                        \
                total += y[0];                                                    \
            }                                                                     \
            const double taken = seconds() - start;                               \
            if (taken < best) best = taken;                                       \
        }                                                                         \
        printf("%.2f\n", 1e9 * best / CASES);                                     \
    } while (0)

int main(int argc, char **argv)
{
    double y[model_outputs], dy[model_outputs * model_inputs];
    if (argc < 1 + 2 * model_inputs) return 1;
    for (int n = 0; n < CASES; n++)
        for (int k = 0; k < model_inputs; k++) {
            const double least = atof(argv[1 + 2 * k]), greatest = atof(argv[2 + 2 * k]);
            x[n][k] = least + (greatest - least) * rand() / RAND_MAX;
        }
    MEASURE(model_predict(x[n], y));
    MEASURE(model_gradient(x[n], y, dy));
    MEASURE(model_std(x[n], y));
    return total == 0;
}
