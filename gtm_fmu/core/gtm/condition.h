/* The air at a flight condition. */
#ifndef GTM_CONDITION_H
#define GTM_CONDITION_H

/* What a trim takes as given, in the order of the generated functions: flight-path angle in rad, air density in
   slug/ft^3, pressure ratio. */
typedef struct {
    double gamma, density, pressure_ratio;
} gtm_condition;

gtm_condition gtm_condition_at(double altitude, double gamma);

#endif
