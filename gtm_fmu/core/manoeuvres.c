#include "gtm_manoeuvres.h"

#include <math.h>
#include <string.h>

#include "generated/airframe.h"
#include "gtm_t2.h"
#include "solver/cell.h"
#include "solver/cold_start.h"
#include "solver/descent.h"
#include "solver/ends.h"
#include "solver/grid.h"
#include "solver/trim.h"

void gtm_trims(const gtm_configuration *c, enum gtm_throttles throttles, long n, const double *altitude,
               const double *gamma, const double *lower, const double *upper, double *y, double *residual,
               double *violation, int *status)
{
    for (long k = 0; k < n; k++) {
        gtm_flight flight = gtm_flight_at(c, throttles, altitude[k], gamma[k]);
        const long row = k * flight.problem.unknowns;
        const gtm_bounds b = gtm_bounds_of(&flight, lower + row, upper + row);
        status[k] = gtm_find_trim(&flight.problem, b.lower, b.upper, y + row, residual + k, violation + k);
    }
}

long gtm_cold_starts(const gtm_configuration *c, enum gtm_throttles throttles, double altitude, double gamma, long n,
                     const double *held, double *y)
{
    const gtm_flight flight = gtm_flight_at(c, throttles, altitude, gamma);
    return gtm_find_starts(&flight.problem, n, held, y);
}

int gtm_extreme(const gtm_configuration *c, enum gtm_throttles throttles, double altitude, double gamma,
                const double *lower, const double *upper, const double *objective, long n, const double *starts,
                double *best, double *violation)
{
    gtm_flight flight = gtm_flight_at(c, throttles, altitude, gamma);
    const gtm_bounds b = gtm_bounds_of(&flight, lower, upper);
    return gtm_find_extreme(&flight.problem, b.lower, b.upper, objective, n, starts, best, violation);
}

int gtm_envelope_end(const gtm_configuration *c, enum gtm_throttles throttles, double altitude, double gamma,
                     const double *lower, const double *upper, const double *objective, double *best, double *violation)
{
    gtm_flight flight = gtm_flight_at(c, throttles, altitude, gamma);
    const gtm_bounds b = gtm_bounds_of(&flight, lower, upper);
    return gtm_find_end(&flight.problem, b.lower, b.upper, objective, best, violation, 0);
}

int gtm_thorough_end(const gtm_configuration *c, enum gtm_throttles throttles, double altitude, double gamma,
                     const double *lower, const double *upper, const double *objective, double *best, double *violation)
{
    gtm_flight flight = gtm_flight_at(c, throttles, altitude, gamma);
    const gtm_bounds b = gtm_bounds_of(&flight, lower, upper);
    return gtm_find_end_thoroughly(&flight.problem, b.lower, b.upper, objective, best, violation, 0);
}

int gtm_rudder_pieces(double lower, double upper, int most, double *border)
{
    const gtm_flight flight = gtm_flight_at(0, GTM_ONE_THROTTLE, 0, 0);
    return gtm_pieces(&flight.problem, lower, upper, most, border);
}

long gtm_grid(const gtm_configuration *c, enum gtm_throttles throttles, double altitude, double gamma,
              const double *lower, const double *upper, long speeds, const double *speed, long rates,
              const double *rate, long n, const double *seeds, unsigned char *feasible, double *y)
{
    gtm_flight flight = gtm_flight_at(c, throttles, altitude, gamma);
    const gtm_bounds b = gtm_bounds_of(&flight, lower, upper);
    return gtm_find_grid(&flight.problem, b.lower, b.upper, speeds, speed, rates, rate, n, seeds, feasible, y);
}

void gtm_dead_controls(const gtm_configuration *c, unsigned char is_dead[GTM_TWO_THROTTLE_NT])
{
    const gtm_flight flight = gtm_flight_at(c, GTM_TWO_THROTTLES, 0, 0);
    memcpy(is_dead, flight.problem.is_dead, sizeof flight.problem.is_dead);
}

void gtm_on_breakpoints(const gtm_configuration *c, enum gtm_throttles throttles, long n, const double *y,
                        unsigned char *is_on)
{
    const gtm_flight flight = gtm_flight_at(c, throttles, 0, 0);
    const int unknowns = flight.problem.unknowns;
    for (long k = 0; k < n; k++) gtm_find_breakpoints(&flight.problem, y + k * unknowns, is_on + k * unknowns);
}

void gtm_trim_states(double altitude, double gamma, long n, const double *y, double *x, double *u)
{
    for (long k = 0; k < n; k++, y += GTM_NT) {
        cas_trim_state((const double *[]){y, &gamma, &altitude}, (double *[]){x + k * GTM_NX}, 0, 0, 0);
        memcpy(u + k * GTM_NU, y + ELEVATOR, GTM_NU * sizeof *u);
    }
}

void gtm_configured_trim_states(const gtm_configuration *c, enum gtm_throttles throttles, double altitude, double gamma,
                                long n, const double *y, double *x, double *u)
{
    const int unknowns = gtm_flight_at(c, throttles, altitude, gamma).problem.unknowns;
    double both[GTM_TWO_THROTTLE_NT];
    for (long k = 0; k < n; k++)
        gtm_configured_trim_state(c, altitude, gamma, gtm_with_both_throttles(throttles, y + k * unknowns, both),
                                  x + k * GTM_NX, u + k * GTM_TWO_THROTTLE_NU);
}
