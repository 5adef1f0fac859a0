/* Sections of the envelope of steady manoeuvres over speed, flight path, altitude and turn rate: where along one of them,
   the others given, a manoeuvre is inside the limits. Units as in gtm_manoeuvres.h. */
#ifndef GTM_SECTIONS_H
#define GTM_SECTIONS_H

#include "gtm_manoeuvres.h"

enum gtm_section_kind {
    GTM_TURN_RATES = 0,     /* rad/s, at a speed */
    GTM_SPEEDS = 1,         /* ft/s, at a turn rate */
    GTM_CLIMBS = 2          /* gamma in rad, at a speed and a turn rate */
};
enum { GTM_MOST_INTERVALS = 8 };

/* Intervals in rising order, with the trims (as of gtm_trims) inside their ends. */
typedef struct {
    int count;
    double end[GTM_MOST_INTERVALS][2];
    double y[GTM_MOST_INTERVALS][2][GTM_TWO_THROTTLE_NT];
} gtm_intervals;

GTM_API long gtm_intervals_size(void);

/* The intervals between `least` and `most` of what the kind names. The bounds hold V (not of GTM_SPEEDS) and psi_dot
   (not of GTM_TURN_RATES) at what is given; gamma is not looked at by GTM_CLIMBS. An end is found to 1e-5 of its scale
   (gtm_scale; of gamma that of alpha). Gaps and intervals by themselves are seen from about half a scale on, where every
   trim is settled by its deflection of the rudder (a jam) much narrower ones. */
GTM_API void gtm_section(const gtm_configuration *c, enum gtm_throttles throttles, enum gtm_section_kind kind,
                         double altitude, double gamma, const double *lower, const double *upper, double least,
                         double most, gtm_intervals *found);

#endif
