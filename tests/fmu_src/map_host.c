/* Cases through the thrust map in a thread with little stack, with traps for invalid numbers, overflow and division by
   zero; prints V_max of each. Rows of four numbers come in. */
#define _GNU_SOURCE
#include <fenv.h>
#include <pthread.h>
#include <stdio.h>

#include "map.h"

enum { STACK = 64 * 1024 };

static void *run(void *nothing)
{
    double given[4];
    gtm_map_envelope found;
    gtm_safe_ends safe;
    feenableexcept(FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW);
    while (scanf("%lf %lf %lf %lf", given, given + 1, given + 2, given + 3) == 4) {
        gtm_map_envelopes(&map, 1, given, &found);
        gtm_map_safe_ends(&map, map_margins, 1, given, &found, &safe);
        printf("%.17g\n", found.v_max);
    }
    return nothing;
}

int main(void)
{
    pthread_attr_t attributes;
    pthread_t thread;
    pthread_attr_init(&attributes);
    pthread_attr_setstacksize(&attributes, STACK);
    return pthread_create(&thread, &attributes, run, 0) || pthread_join(thread, 0);
}
