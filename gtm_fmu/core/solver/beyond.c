#include "solver/beyond.h"

#include <math.h>
#include <string.h>

#include "solver/manifold.h"

static const double much = 0.4;    /* an excess that a step of the grid does not take away, in scale units */
static const double enough = 1e-3; /* largest |F| of a point of the grid */

int gtm_can_look_beyond(const gtm_problem *p)
{
    int dead = 0;
    for (int i = 0; i < p->unknowns; i++) dead += p->is_dead[i];
    return p->throttles == GTM_ONE_THROTTLE && !dead;
}

static int nearest(int n, const double *values, double value)
{
    int k = 0;
    for (int i = 1; i < n; i++)
        if (fabs(values[i] - value) < fabs(values[k] - value)) k = i;
    return k;
}

/* By how much the bounds are exceeded, row by row of equal deflection; infinite where no trim was found. */
typedef struct {
    const gtm_problem *problem;
    const double *lower, *upper;
    const gtm_mesh *mesh;
    double speed, excess[GTM_MOST_RUDDERS][GTM_MOST_BANKS];
    int movable[GTM_MOST_UNKNOWNS];
} grid;

/* Settle a point from the guess y; 0 when it is found. */
static int settle(grid *g, int r, int k, double *y)
{
    double J[GTM_NF * GTM_MOST_UNKNOWNS];
    y[V] = g->speed;
    y[PHI] = g->mesh->bank[k];
    y[RUDDER] = g->mesh->rudder[r];
    if (gtm_project(y, g->problem, g->movable, enough, J)) return 1;
    g->excess[r][k] = gtm_violation(g->problem, y, g->lower, g->upper);
    return 0;
}

/* A row from the trim at its column `from` on to one side, each point on the line through the two before it, to where
   trims end (the wing carries no more). */
static void fill_side(grid *g, int r, int from, int side, const double *trim)
{
    const size_t row = sizeof *trim * (size_t)g->problem->unknowns;
    double before[GTM_MOST_UNKNOWNS], last[GTM_MOST_UNKNOWNS], y[GTM_MOST_UNKNOWNS];
    memcpy(before, trim, row);
    memcpy(last, trim, row);
    for (int k = from + side; k >= 0 && k < g->mesh->banks; k += side) {
        for (int i = 0; i < g->problem->unknowns; i++) y[i] = 2 * last[i] - before[i];
        if (settle(g, r, k, y)) return;
        memcpy(before, last, row);
        memcpy(last, y, row);
    }
}

/* From the row of the end on to both sides, and in each row from the end's bank. */
static void fill(grid *g, const double *end)
{
    const size_t row = sizeof *end * (size_t)g->problem->unknowns;
    const int first = nearest(g->mesh->rudders, g->mesh->rudder, end[RUDDER]);
    const int from = nearest(g->mesh->banks, g->mesh->bank, end[PHI]);
    double y[GTM_MOST_UNKNOWNS];
    for (int r = 0; r < GTM_MOST_RUDDERS; r++)
        for (int k = 0; k < GTM_MOST_BANKS; k++) g->excess[r][k] = INFINITY;
    for (int side = 1; side >= -1; side -= 2) {
        memcpy(y, end, row);
        for (int r = side > 0 ? first : first - 1; r >= 0 && r < g->mesh->rudders; r += side) {
            if (settle(g, r, from, y)) break;
            fill_side(g, r, from, 1, y);
            fill_side(g, r, from, -1, y);
        }
    }
}

static int is_least(const grid *g, int r, int k)
{
    for (int i = -1; i <= 1; i++)
        for (int j = -1; j <= 1; j++) {
            const int row = r + i, column = k + j, is_earlier = i < 0 || (i == 0 && j < 0);
            if (row < 0 || row >= g->mesh->rudders || column < 0 || column >= g->mesh->banks || (!i && !j)) continue;
            if (g->excess[row][column] < g->excess[r][k]) return 0;
            if (is_earlier && g->excess[row][column] == g->excess[r][k]) return 0;
        }
    return 1;
}

long gtm_look_beyond(const gtm_problem *p, const double *lower, const double *upper, const double *end, double speed,
                     const gtm_mesh *mesh, long most, double *rows)
{
    long found = 0;
    grid g = {.problem = p, .lower = lower, .upper = upper, .mesh = mesh, .speed = speed};
    for (int i = 0; i < p->unknowns; i++) g.movable[i] = i != V && i != PHI && i != RUDDER;
    fill(&g, end);
    for (int r = 0; r < mesh->rudders; r++)
        for (int k = 0; k < mesh->banks && found < most; k++) {
            if (!(g.excess[r][k] < much) || !is_least(&g, r, k)) continue;
            const double at[3] = {speed, mesh->bank[k], mesh->rudder[r]};
            memcpy(rows + 3 * found++, at, sizeof at);
        }
    return found;
}
