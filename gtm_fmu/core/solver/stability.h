/* Stability and controllability of x' = A x + B u. */
#ifndef GTM_STABILITY_H
#define GTM_STABILITY_H

#include "generated/order.h"

enum { GTM_MOST_COLUMNS = GTM_NL + GTM_TWO_THROTTLE_NU };

/* [A B] in units of typical states and inputs. */
typedef struct {
    int inputs;
    double row[GTM_NL][GTM_MOST_COLUMNS];
} gtm_linear;

typedef struct {
    int is_stable, is_controllable;
} gtm_verdict;

/* Stable: no eigenvalue of A has a positive real part (Routh, from the characteristic polynomial). Controllable: stable,
   or the smallest singular value of [lambda I - A, B] is above `threshold` for every eigenvalue lambda with a positive
   real part (Popov, Belevitch, Hautus). */
gtm_verdict gtm_judge(const gtm_linear *l, double threshold);

#endif
