#include "solver/ends.h"

#include <math.h>
#include <string.h>

#include "solver/cold_start.h"
#include "solver/descent.h"

enum { MOST_PIECES = 64, MOST_FREE = 3, NEAR_BANKS = 4, NEAR_ROUNDS = 3 };
static const int starts_of[MOST_FREE + 1] = {1, 6, 16, 24}; /* with so many of speed, bank and deflection free */
static const int of_steep = 3;                              /* times as many in steep descents, over more speeds */
enum { MOST_SPREAD = 72, MOST_NEAR = 6 * NEAR_BANKS + GTM_BESIDE + 1 };

int gtm_pieces(const gtm_problem *p, double lower, double upper, int most, double *border)
{
    const double piece = p->aircraft->spacing.rudder_piece;
    int count = 0;
    border[0] = lower;
    do {
        const double next = piece * (floor(border[count] / piece) + 1);
        count++;
        border[count] = count < most ? fmin(next, upper) : upper;
    } while (border[count] < upper);
    return count;
}

/* Cold trims at n speeds, evenly spread or, crowded, closer together where they are slow; their banks and deflections
   follow Roberts's sequence of the plastic number, which fills the plane evenly. */
static long starts_over(const gtm_problem *p, int n, int is_crowded, const double lower[3], const double upper[3],
                        double *starts)
{
    static const double plastic[3] = {0, 0.7548776662466927, 0.5698402909980532};
    double held[3 * MOST_SPREAD];
    for (int k = 0; k < n; k++)
        for (int i = 0; i < 3; i++) {
            double along = i == 0 ? (k + 0.5) / n : fmod(0.5 + k * plastic[i], 1);
            if (i == 0 && is_crowded) along *= along;
            held[3 * k + i] = lower[i] + along * (upper[i] - lower[i]);
        }
    return gtm_find_starts(p, n, held, starts);
}

/* Cold trims about an end y that was found: a little inside and beyond its speed over all banks, with its deflection
   and those of the piece's ends; and at its bank with deflections beside its own, for there may be an optimum on either
   side of a kink. */
static long starts_near(const gtm_problem *p, const double *y, const double *lower, const double *upper,
                        const double *objective, double *starts)
{
    const gtm_spacing *spacing = &p->aircraft->spacing;
    const double outward = (objective[V] < 0) - (objective[V] > 0);
    const double deflection[3] = {y[RUDDER], lower[RUDDER], upper[RUDDER]};
    const int speeds = outward != 0 && lower[V] < upper[V] ? 2 : 1;
    double held[3 * MOST_NEAR], *next = held;
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < NEAR_BANKS && (k == 0 || deflection[k] != deflection[0]); i++)
            for (int j = 0; j < speeds; j++, next += 3) {
                next[0] = y[V] + outward * (j ? spacing->beyond : -spacing->inside);
                next[1] = lower[PHI] + (0.05 + 0.9 * i / (NEAR_BANKS - 1)) * (upper[PHI] - lower[PHI]);
                next[2] = deflection[k];
            }
    for (int k = 0; k < GTM_BESIDE; k++) {
        next[0] = y[V] - outward * spacing->inside;
        next[1] = y[PHI];
        next[2] = y[RUDDER] + spacing->beside[k];
        if (next[2] > lower[RUDDER] && next[2] < upper[RUDDER]) next += 3;
    }
    return gtm_find_starts(p, (next - held) / 3, held, starts);
}

/* With two throttles: every start also with more thrust on the left, and on the right. */
static long with_thrust_apart(const gtm_problem *p, long n, double *starts)
{
    const double apart = p->aircraft->spacing.thrust_apart;
    if (p->throttles == GTM_ONE_THROTTLE) return n;
    for (int side = 0; side < 2; side++) {
        double *copy = starts + (side + 1) * n * GTM_MOST_UNKNOWNS;
        memcpy(copy, starts, sizeof *starts * (size_t)n * GTM_MOST_UNKNOWNS);
        for (long i = 0; i < n; i++, copy += GTM_MOST_UNKNOWNS) {
            copy[THROTTLE] += side ? -apart : apart;
            copy[THROTTLE_RIGHT] += side ? apart : -apart;
        }
    }
    return 3 * n;
}

/* An end and how far it is from one: y inside the bounds with the least objective, or exceeding them least. */
typedef struct {
    int status;
    double y[GTM_MOST_UNKNOWNS], value, violation;
} end;

static const end nothing = {GTM_NO_TRIM, {0}, INFINITY, INFINITY};

static end search(const gtm_problem *p, const double *lower, const double *upper, const double *objective, long n,
                  const double *starts)
{
    end e = nothing;
    e.status = gtm_find_extreme(p, lower, upper, objective, n, starts, e.y, &e.violation);
    e.value = 0;
    for (int i = 0; i < p->unknowns; i++) e.value += objective[i] * e.y[i];
    return e;
}

static int is_better(const end *a, const end *b)
{
    if (a->status != b->status) return a->status < b->status;
    if (a->status == GTM_TRIMMED) return a->value < b->value;
    return a->violation < b->violation;
}

/* The end over one piece of the rudder's range. */
static end search_piece(const gtm_problem *p, const double *lower, const double *upper, const double *objective)
{
    double starts[3 * (MOST_SPREAD > MOST_NEAR ? MOST_SPREAD : MOST_NEAR) * GTM_MOST_UNKNOWNS];
    const gtm_speeds speeds = p->aircraft->speeds(p);
    const double top = fmin(upper[V], speeds.fastest);
    const double low[3] = {fmin(fmax(lower[V], speeds.slowest), top), lower[PHI], lower[RUDDER]};
    const double high[3] = {top, upper[PHI], upper[RUDDER]};
    int is_free = 0;
    for (int i = 0; i < 3; i++) is_free += low[i] < high[i];
    const int count = starts_of[is_free] * (speeds.is_steep && low[0] < high[0] ? of_steep : 1);
    long n = starts_over(p, count, speeds.is_steep, low, high, starts);
    end best = search(p, lower, upper, objective, n, starts);
    for (int round = 0, improves = 1; improves && round < NEAR_ROUNDS && best.status != GTM_NO_TRIM; round++) {
        n = starts_near(p, best.y, lower, upper, objective, starts);
        n = with_thrust_apart(p, n, starts);
        const end before = best, found = search(p, lower, upper, objective, n, starts);
        if (is_better(&found, &best)) best = found;
        improves = best.status != before.status || fabs(best.value - before.value) > 1e-6 * fabs(before.value);
    }
    return best;
}

int gtm_find_end(const gtm_problem *p, const double *lower, const double *upper, const double *objective, double *y,
                 double *violation)
{
    double low[GTM_MOST_UNKNOWNS], high[GTM_MOST_UNKNOWNS], border[MOST_PIECES + 1];
    const size_t row = sizeof *y * (size_t)p->unknowns;
    const int pieces = gtm_pieces(p, lower[RUDDER], upper[RUDDER], MOST_PIECES, border);
    end best = nothing;
    memcpy(low, lower, row);
    memcpy(high, upper, row);
    for (int k = 0; k < pieces; k++) {
        low[RUDDER] = border[k];
        high[RUDDER] = border[k + 1];
        const end found = search_piece(p, low, high, objective);
        if (is_better(&found, &best)) best = found;
    }
    *violation = best.violation;
    if (best.status != GTM_NO_TRIM) memcpy(y, best.y, row);
    return best.status;
}
