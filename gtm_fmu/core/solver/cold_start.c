#include "solver/cold_start.h"

#include <math.h>
#include <string.h>

static const double degree = 0.017453292519943295;
static const double steepest = 1.2; /* rad, of a guessed bank */

static double clamp(double value, double least, double most)
{
    return fmin(fmax(value, least), most);
}

/* Of a speed that is sought: that of the turn, or that at which the wing carries the weight. */
static double guessed_speed(const gtm_problem *p, const double *y, const int *is_held)
{
    const gtm_point_mass *m = &p->aircraft->point_mass;
    if (is_held[PHI] && is_held[PSI_DOT] && y[PSI_DOT] != 0)
        return clamp(m->gravity * tan(y[PHI]) / y[PSI_DOT], m->slowest, m->fastest);
    const double alpha = is_held[ALPHA] ? y[ALPHA] : m->alpha;
    const double lift = clamp(m->lift + m->lift_slope * alpha, m->least_lift, m->most_lift);
    const double upright = is_held[PHI] ? cos(y[PHI]) : 1;
    return sqrt(2 * p->weight / (p->density * m->wing_area * lift * upright));
}

/* Rough trim of the point mass; guesses differ in sideslip per rudder, and in throttle: where ram drag eats a moderate
   thrust, its slope is zero and Newton needs a guess above. Where alpha is to settle the bank, it has the sign of the
   phi given. */
static void first_guess(const gtm_problem *p, double *y, const int *is_held, const gtm_guess *guess)
{
    const gtm_point_mass *m = &p->aircraft->point_mass;
    const double weight = p->weight;
    if (!is_held[V]) y[V] = guessed_speed(p, y, is_held);
    const double force = 0.5 * p->density * y[V] * y[V] * m->wing_area;
    if (is_held[V] && is_held[ALPHA] && !is_held[PHI] && !is_held[PSI_DOT]) {
        const double lift = fmax(m->lift + m->lift_slope * y[ALPHA], m->least_lift);
        const double bank = acos(fmin(weight / (force * lift), 0.99));
        y[PSI_DOT] = m->gravity * tan(y[PHI] < 0 ? -bank : bank) / y[V];
    }
    if (!is_held[BETA] && is_held[PHI] && is_held[PSI_DOT])
        y[BETA] = weight * sin(y[PHI] - atan(y[V] * y[PSI_DOT] / m->gravity)) / (m->side_force_slope * force);
    if (!is_held[RUDDER]) y[RUDDER] = y[BETA] / (p->aircraft->guess[0].beta_per_rudder * degree);
    if (!is_held[BETA]) y[BETA] = guess->beta_per_rudder * degree * y[RUDDER];
    const double against_slip = asin(clamp(m->side_force_slope * force * y[BETA] / weight, -0.6, 0.6));
    if (!is_held[PHI]) y[PHI] = clamp(atan(y[V] * y[PSI_DOT] / m->gravity) + against_slip, -steepest, steepest);
    if (!is_held[PSI_DOT]) y[PSI_DOT] = m->gravity * tan(y[PHI] - against_slip) / y[V];
    const double alpha = (weight / (force * cos(y[PHI])) - m->lift) / m->lift_slope;
    if (!is_held[ALPHA]) y[ALPHA] = clamp(alpha, m->least_alpha, m->most_alpha);
    if (!is_held[ELEVATOR]) y[ELEVATOR] = m->elevator + m->elevator_per_alpha * y[ALPHA] / degree;
    if (!is_held[AILERON]) y[AILERON] = m->aileron_per_rudder * y[RUDDER];
    for (int i = THROTTLE; i < p->unknowns; i++)
        if (!is_held[i]) y[i] = guess->throttle;
}

int gtm_cold_newton(const gtm_problem *p, double *y, const int held[3])
{
    const size_t row = sizeof *y * (size_t)p->unknowns;
    int is_kept[GTM_MOST_UNKNOWNS];
    double given[GTM_MOST_UNKNOWNS];
    if (!gtm_keeps(p, held, is_kept)) return 1;
    memcpy(given, y, row);
    for (int k = 0; k < GTM_GUESSES; k++) {
        memcpy(y, given, row);
        first_guess(p, y, is_kept, &p->aircraft->guess[k]);
        if (!gtm_newton(p, y, held)) return 0;
    }
    return 1;
}

long gtm_find_starts(const gtm_problem *p, long n, const double *held_values, double *y)
{
    static const int column[3] = {V, PHI, RUDDER}, held[3] = {PHI, RUDDER, V};
    long found = 0;
    for (long i = 0; i < n; i++) {
        double *point = y + found * p->unknowns;
        memset(point, 0, sizeof *point * (size_t)p->unknowns);
        for (int k = 0; k < 3; k++)
            if (!p->is_dead[column[k]]) point[column[k]] = held_values[i * 3 + k];
        if (!gtm_cold_newton(p, point, held)) found++;
    }
    return found;
}
