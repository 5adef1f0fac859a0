/* Terms that the solver shares with its callers. */
#ifndef GTM_TERMS_H
#define GTM_TERMS_H

/* How many throttles: one for the engines that run (GTM_NT unknowns), or one for each engine (GTM_TWO_THROTTLE_NT). */
enum gtm_throttles { GTM_ONE_THROTTLE = 1, GTM_TWO_THROTTLES = 2 };

enum gtm_trim_status {
    GTM_TRIMMED = 0,   /* F(y) = 0 inside the bounds */
    GTM_OUTSIDE = 1,   /* F(y) = 0, but only outside the bounds: y is where they are exceeded least */
    GTM_NO_TRIM = 2    /* no y with F(y) = 0 was found */
};

#endif
