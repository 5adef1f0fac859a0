/* Can this be flown? Manoeuvres at a given altitude, flight path, speed and turn rate under the limits that a failure
   leaves: feasible or not, how far every limit is, stable, controllable. Units as in gtm_manoeuvres.h; no memory is
   taken, and any thread may call these functions.

   With a jam of the rudder there is one trim at most. A range leaves a choice: the trim with the least sideslip is
   reported, and margins are those of that trim, but a manoeuvre is feasible if any trim keeps all limits. */
#ifndef GTM_QUERY_H
#define GTM_QUERY_H

#include "gtm_manoeuvres.h"

enum gtm_side { GTM_LOWER = 0, GTM_UPPER = 1 };

typedef struct {
    int status;                             /* enum gtm_trim_status: GTM_TRIMMED is feasible */
    int stable, controllable;               /* as of a linear model; 0 where it is not feasible */
    int binding, side;                      /* the unknown and enum gtm_side of the least margin in scale units (see
                                               gtm_scale), held unknowns that are met aside; where it is not feasible
                                               the limit that is exceeded most; -1 without a trim */
    double least_margin;                    /* that margin, in scale units */
    double y[GTM_TWO_THROTTLE_NT];          /* the trim, or where F = 0 exceeds the limits least; in the order of
                                               gtm_manoeuvres.h, with one throttle its last one repeats it */
    double margin[GTM_TWO_THROTTLE_NT][2];  /* of each unknown, y - lower and upper - y, in its unit; negative where a
                                               limit is exceeded; 0 of held ones that are met, and without a trim */
    double thrust;                          /* net, of the engines that run, lbf */
    double thrust_margin[2];                /* lbf less at the lower limits of the throttles, lbf more at the upper */
    double residual, violation;             /* as of gtm_trims; violation is infinite where no F = 0 was found */
} gtm_answer;

GTM_API long gtm_answer_size(void);

/* n manoeuvres: altitude (ft) and gamma (rad), and rows of bounds (GTM_NT or GTM_TWO_THROTTLE_NT), which hold V and
   psi_dot at what is asked; bounds of alpha, beta, phi and the controls are the limits. */
GTM_API void gtm_query(const gtm_configuration *c, enum gtm_throttles throttles, long n, const double *altitude,
                       const double *gamma, const double *lower, const double *upper, gtm_answer *answer);

/* Stability and controllability of n trims y (rows) under the same bounds, whose controls of equal bounds are no
   inputs. */
GTM_API void gtm_assess(const gtm_configuration *c, enum gtm_throttles throttles, double altitude, double gamma,
                        const double *lower, const double *upper, long n, const double *y, unsigned char *stable,
                        unsigned char *controllable);

#endif
