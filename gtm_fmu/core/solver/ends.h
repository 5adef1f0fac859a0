/* V_min and V_max of a flight condition under limits. Local optima are many. A speed is sought from a few starts; then a
   grid of trims just beyond the best one shows where a better one may lie, and descents from there find it, until there
   is none. Other objectives, and limits that leave slits, take many starts: a range of the rudder is searched in pieces,
   for optima lie on either side of its breakpoints, and each piece from starts spread over all of it, then about the
   best point found (another bank or deflection may do better). */
#ifndef GTM_ENDS_H
#define GTM_ENDS_H

#include "solver/problem.h"

/* The pieces of a range of the rudder, each between two of its breakpoints: the k-th from border[k] to border[k + 1].
   Returns their number, at most `most`: then the last one reaches to the end. */
int gtm_pieces(const gtm_problem *p, double lower, double upper, int most, double *border);

/* What a search found: local optima inside the bounds, best first, and trims outside that exceed the bounds less than all
   around them. When conditions move, any of them may become the best. */
enum { GTM_MOST_KNOWN = 5, GTM_MOST_OUTSIDE = 3 };
typedef struct {
    int inside, outside;
    double y[GTM_MOST_KNOWN + GTM_MOST_OUTSIDE][GTM_MOST_UNKNOWNS]; /* those inside, then those outside */
} gtm_known_ends;

/* The point of least objective.y inside the bounds; without one, `violation` says how far away the best is. `known` is
   left for gtm_follow_end; it may be 0. */
int gtm_find_end(const gtm_problem *p, const double *lower, const double *upper, const double *objective, double *best,
                 double *violation, gtm_known_ends *known);

/* The same from the ends of a problem that differs little, which are moved on; none when one that is nearly as good as
   the best is lost: it left the bounds, or met another one. */
int gtm_follow_end(const gtm_problem *p, const double *lower, const double *upper, const double *objective,
                   gtm_known_ends *known, double *best, double *violation);

/* The same from many starts in every piece, which takes longer. */
int gtm_find_end_thoroughly(const gtm_problem *p, const double *lower, const double *upper, const double *objective,
                            double *best, double *violation, gtm_known_ends *known);

#endif
