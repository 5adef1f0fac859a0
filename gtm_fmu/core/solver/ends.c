#include "solver/ends.h"

#include <math.h>
#include <string.h>

#include "solver/beyond.h"
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

static double value_of(const gtm_problem *p, const double *objective, const double *y)
{
    double value = 0;
    for (int i = 0; i < p->unknowns; i++) value += objective[i] * y[i];
    return value;
}

static end search(const gtm_problem *p, const double *lower, const double *upper, const double *objective, long n,
                  const double *starts)
{
    end e = nothing;
    e.status = gtm_find_extreme(p, lower, upper, objective, n, starts, e.y, &e.violation);
    e.value = value_of(p, objective, e.y);
    return e;
}

/* By small steps, which lead to the local optimum next to the start. */
static end move(const gtm_problem *p, const double *lower, const double *upper, const double *objective, double stride,
                const double *start)
{
    end e = nothing;
    memcpy(e.y, start, sizeof *start * (size_t)p->unknowns);
    e.status = gtm_move_extreme(p, lower, upper, objective, stride, e.y, &e.violation);
    e.value = value_of(p, objective, e.y);
    return e;
}

static int is_better(const end *a, const end *b)
{
    if (a->status != b->status) return a->status < b->status;
    if (a->status == GTM_TRIMMED) return a->value < b->value;
    return a->violation < b->violation;
}

/* The ends that are found in a search, and the best of them. */
typedef struct {
    end best;
    int inside, outside;
    end of_inside[GTM_MOST_KNOWN], of_outside[GTM_MOST_OUTSIDE]; /* in different places, best first */
} finds;

static int same_place(const gtm_problem *p, const end *a, const end *b)
{
    for (int i = 0; i < p->unknowns; i++)
        if (fabs(a->y[i] - b->y[i]) > 1e-2 * p->aircraft->scale[i]) return 0;
    return 1;
}

/* Put an end where it ranks, unless one in the same place is there. */
static void insert(const gtm_problem *p, const end *found, int most, int *count, end *ranked)
{
    for (int k = 0; k < *count; k++)
        if (same_place(p, ranked + k, found)) return;
    int rank = *count;
    while (rank > 0 && is_better(found, ranked + rank - 1)) rank--;
    if (rank == most) return;
    if (*count < most) ++*count;
    memmove(ranked + rank + 1, ranked + rank, sizeof *found * (size_t)(*count - 1 - rank));
    ranked[rank] = *found;
}

static void take(const gtm_problem *p, const end *found, finds *f)
{
    static const double far = 0.5; /* outside, in scale units */
    if (is_better(found, &f->best)) f->best = *found;
    if (found->status == GTM_TRIMMED) insert(p, found, GTM_MOST_KNOWN, &f->inside, f->of_inside);
    if (found->status == GTM_OUTSIDE && found->violation < far)
        insert(p, found, GTM_MOST_OUTSIDE, &f->outside, f->of_outside);
}

static int hand_over(const gtm_problem *p, const finds *f, double *y, double *violation, gtm_known_ends *known)
{
    const size_t row = sizeof *y * (size_t)p->unknowns;
    *violation = f->best.violation;
    if (f->best.status != GTM_NO_TRIM) memcpy(y, f->best.y, row);
    if (!known) return f->best.status;
    known->inside = f->inside;
    known->outside = f->outside;
    for (int k = 0; k < f->inside; k++) memcpy(known->y[k], f->of_inside[k].y, row);
    for (int k = 0; k < f->outside; k++) memcpy(known->y[f->inside + k], f->of_outside[k].y, row);
    return f->best.status;
}

/* The same over all that the bounds leave. */
static long starts_in(const gtm_problem *p, int n, const double *lower, const double *upper, double *starts)
{
    const gtm_speeds speeds = p->aircraft->speeds(p);
    const double top = fmin(upper[V], speeds.fastest);
    const double low[3] = {fmin(fmax(lower[V], speeds.slowest), top), lower[PHI], lower[RUDDER]};
    const double high[3] = {top, upper[PHI], upper[RUDDER]};
    return starts_over(p, n, speeds.is_steep, low, high, starts);
}

/* The end over one piece of the rudder's range. */
static void search_piece(const gtm_problem *p, const double *lower, const double *upper, const double *objective, finds *f)
{
    double starts[3 * (MOST_SPREAD > MOST_NEAR ? MOST_SPREAD : MOST_NEAR) * GTM_MOST_UNKNOWNS];
    const gtm_speeds speeds = p->aircraft->speeds(p);
    const int is_free = (lower[V] < upper[V]) + (lower[PHI] < upper[PHI]) + (lower[RUDDER] < upper[RUDDER]);
    const int count = starts_of[is_free] * (speeds.is_steep && lower[V] < upper[V] ? of_steep : 1);
    long n = starts_in(p, count, lower, upper, starts);
    end best = search(p, lower, upper, objective, n, starts);
    take(p, &best, f);
    for (int round = 0, improves = 1; improves && round < NEAR_ROUNDS && best.status != GTM_NO_TRIM; round++) {
        n = starts_near(p, best.y, lower, upper, objective, starts);
        n = with_thrust_apart(p, n, starts);
        const end before = best, found = search(p, lower, upper, objective, n, starts);
        take(p, &found, f);
        if (is_better(&found, &best)) best = found;
        improves = best.status != before.status || fabs(best.value - before.value) > 1e-6 * fabs(before.value);
    }
}

/* ---- Every piece from many starts ---- */

static void search_pieces(const gtm_problem *p, const double *lower, const double *upper, const double *objective,
                          finds *f)
{
    double low[GTM_MOST_UNKNOWNS], high[GTM_MOST_UNKNOWNS], border[MOST_PIECES + 1];
    const size_t row = sizeof *low * (size_t)p->unknowns;
    const int pieces = gtm_pieces(p, lower[RUDDER], upper[RUDDER], MOST_PIECES, border);
    memcpy(low, lower, row);
    memcpy(high, upper, row);
    for (int k = 0; k < pieces; k++) {
        low[RUDDER] = border[k];
        high[RUDDER] = border[k + 1];
        search_piece(p, low, high, objective, f);
    }
}

int gtm_find_end_thoroughly(const gtm_problem *p, const double *lower, const double *upper, const double *objective,
                            double *y, double *violation, gtm_known_ends *known)
{
    finds f = {.best = nothing};
    search_pieces(p, lower, upper, objective, &f);
    return hand_over(p, &f, y, violation, known);
}

/* ---- From a few starts, then beyond the end found ---- */

enum { FEW = 8, MOST_BEYOND = 12, LOOKS = 8 };
static const double just_beyond = 0.01; /* ft/s */
static const double stride_from_mesh = 0.1; /* scale units */
static const double narrow = 2;         /* scale units */

/* Better than a trim inside the bounds by more than the precision of a descent. */
static int improves_on(const end *found, const end *best)
{
    return found->status == GTM_TRIMMED && best->value - found->value > 1e-6 * fabs(best->value);
}

/* Values from lower to upper by at most `step`; their number. */
static int spread(double lower, double upper, double step, int most, double *values)
{
    const int intervals = (int)fmin(ceil((upper - lower) / step), most - 1);
    for (int k = 0; k <= intervals; k++) values[k] = intervals ? lower + k * (upper - lower) / intervals : lower;
    return intervals + 1;
}

/* Over all banks and deflections; on either side of the rudder's breakpoints, not on them, for drag has kinks there. */
static gtm_mesh wide_mesh(const gtm_problem *p, const double *lower, const double *upper)
{
    const double *scale = p->aircraft->scale;
    const double aside = 0.05 * scale[RUDDER], step = 0.4 * scale[RUDDER];
    gtm_mesh m;
    double border[MOST_PIECES + 1];
    const int pieces = gtm_pieces(p, lower[RUDDER], upper[RUDDER], MOST_PIECES, border);
    m.banks = spread(lower[PHI], upper[PHI], 0.3 * scale[PHI], GTM_MOST_BANKS, m.bank);
    m.rudders = 0;
    for (int k = 0; k < pieces && m.rudders < GTM_MOST_RUDDERS; k++) {
        const double inside = fmin(aside, 0.25 * (border[k + 1] - border[k]));
        m.rudders += spread(border[k] + inside, border[k + 1] - inside, step, GTM_MOST_RUDDERS - m.rudders,
                            m.rudder + m.rudders);
    }
    return m;
}

/* Near an end. */
static gtm_mesh close_mesh(const gtm_problem *p, const double *lower, const double *upper, const double *y)
{
    const double bank_reach = 0.2 * p->aircraft->scale[PHI], rudder_reach = 0.12 * p->aircraft->scale[RUDDER];
    gtm_mesh m;
    m.banks = spread(fmax(lower[PHI], y[PHI] - bank_reach), fmin(upper[PHI], y[PHI] + bank_reach), bank_reach / 4,
                     GTM_MOST_BANKS, m.bank);
    m.rudders = spread(fmax(lower[RUDDER], y[RUDDER] - rudder_reach), fmin(upper[RUDDER], y[RUDDER] + rudder_reach),
                       rudder_reach / 4, GTM_MOST_RUDDERS, m.rudder);
    return m;
}

/* From the trims just beyond the best end that exceed the limits least, each inside its piece of the rudder's range;
   1 when one of them leads to a better end. */
static int search_beyond(const gtm_problem *p, const double *lower, const double *upper, const double *objective,
                         const gtm_mesh *mesh, finds *f)
{
    double held[3 * MOST_BEYOND], start[GTM_MOST_UNKNOWNS], low[GTM_MOST_UNKNOWNS], high[GTM_MOST_UNKNOWNS];
    double border[MOST_PIECES + 1];
    const size_t row = sizeof *start * (size_t)p->unknowns;
    const int pieces = gtm_pieces(p, lower[RUDDER], upper[RUDDER], MOST_PIECES, border);
    const end before = f->best;
    const double speed = before.y[V] + (objective[V] < 0 ? just_beyond : -just_beyond);
    if (!(lower[V] <= speed && speed <= upper[V])) return 0;
    const long n = gtm_look_beyond(p, lower, upper, before.y, speed, mesh, MOST_BEYOND, held);
    memcpy(low, lower, row);
    memcpy(high, upper, row);
    for (long k = 0; k < n; k++) {
        int piece = 0;
        while (piece < pieces - 1 && held[3 * k + 2] > border[piece + 1]) piece++;
        low[RUDDER] = border[piece];
        high[RUDDER] = border[piece + 1];
        if (!gtm_find_starts(p, 1, held + 3 * k, start)) continue;
        end found = move(p, low, high, objective, stride_from_mesh, start);
        take(p, &found, f);
        if (found.status == GTM_TRIMMED) continue;
        found = search(p, low, high, objective, 1, start);
        take(p, &found, f);
    }
    return improves_on(&f->best, &before);
}

/* Whether a few starts will do: a speed is sought, all else follows from it with bank and deflection, and no other
   control is held in a narrow range, which may leave slits at several speeds. */
static int is_plain(const gtm_problem *p, const double *lower, const double *upper, const double *objective)
{
    static const int other[] = {ELEVATOR, AILERON, THROTTLE};
    for (int i = 0; i < p->unknowns; i++)
        if ((objective[i] != 0) != (i == V)) return 0;
    for (int k = 0; k < (int)(sizeof other / sizeof *other); k++)
        if (upper[other[k]] - lower[other[k]] < narrow * p->aircraft->scale[other[k]]) return 0;
    return lower[V] < upper[V] && gtm_can_look_beyond(p) && !p->aircraft->speeds(p).is_steep;
}

/* Thrust holds the lowest speed, as near the ceiling: there may be a slower piece of the envelope beyond a gap. */
static int is_held_by_thrust(const gtm_problem *p, const double *lower, const double *upper, const double *objective,
                             const double *y)
{
    const double near = 1e-3 * p->aircraft->scale[THROTTLE];
    return objective[V] > 0 && (y[THROTTLE] < lower[THROTTLE] + near || y[THROTTLE] > upper[THROTTLE] - near);
}

int gtm_find_end(const gtm_problem *p, const double *lower, const double *upper, const double *objective, double *y,
                 double *violation, gtm_known_ends *known)
{
    double starts[FEW * GTM_MOST_UNKNOWNS];
    finds f = {.best = nothing};
    if (!is_plain(p, lower, upper, objective))
        return gtm_find_end_thoroughly(p, lower, upper, objective, y, violation, known);
    const long n = starts_in(p, FEW, lower, upper, starts);
    for (long k = 0; k < n; k++) {
        const end found = search(p, lower, upper, objective, 1, starts + k * p->unknowns);
        take(p, &found, &f);
    }
    if (f.best.status != GTM_TRIMMED)
        return gtm_find_end_thoroughly(p, lower, upper, objective, y, violation, known);
    const gtm_mesh wide = wide_mesh(p, lower, upper);
    for (int look = 0; look < LOOKS; look++) {
        if (search_beyond(p, lower, upper, objective, &wide, &f)) continue;
        const gtm_mesh close = close_mesh(p, lower, upper, f.best.y);
        if (!search_beyond(p, lower, upper, objective, &close, &f)) break;
    }
    if (is_held_by_thrust(p, lower, upper, objective, f.best.y)) search_pieces(p, lower, upper, objective, &f);
    return hand_over(p, &f, y, violation, known);
}

/* ---- From known ends ---- */

static const double stride_to_follow = 0.03; /* scale units: optima on either side of a kink lie so near */

int gtm_follow_end(const gtm_problem *p, const double *lower, const double *upper, const double *objective,
                   gtm_known_ends *known, double *y, double *violation)
{
    finds f = {.best = nothing};
    for (int k = 0; k < known->inside + known->outside; k++) {
        const end moved = move(p, lower, upper, objective, stride_to_follow, known->y[k]);
        const int before = f.inside;
        take(p, &moved, &f);
        const int is_lost = k < known->inside && f.inside == before;
        if (is_lost && fabs(known->y[k][V] - known->y[0][V]) < p->aircraft->spacing.beyond) return GTM_NO_TRIM;
        if (moved.status != GTM_NO_TRIM) memcpy(known->y[k], moved.y, sizeof *y * (size_t)p->unknowns);
    }
    return hand_over(p, &f, y, violation, 0);
}
