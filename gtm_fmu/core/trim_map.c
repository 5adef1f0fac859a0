/* V_min and V_max by the trim map. Each box between neighbouring nodes is divided into six tetrahedra, in which all values
   are linear: what the limits leave of one is a polytope, and the speed is extreme at its corners. Boxes that cannot hold a
   better speed than the best so far are passed over. */
#include "trim_map.h"

#include <math.h>
#include <string.h>

#include "gtm/condition.h"
#include "gtm/lagrange.h"

enum { X_ALPHA = GTM_TRIM_VALUES, X_BANK, X_RUDDER, ATTRIBUTES, CORNERS = 4 };

typedef struct {
    double x[ATTRIBUTES];
} corner;

/* weight * x[attribute] + loading * x[GTM_LOADING] - bound is at most zero, or zero. */
typedef struct {
    int attribute, is_equation;
    double weight, loading, bound;
} limit;

enum { LIMITED = 6, LIMITS = 2 * LIMITED };

typedef struct {
    limit limits[LIMITS];
    int count;
    double loading[2]; /* least and greatest so far */
} search;

long gtm_trim_map_memory(const gtm_trim_map *map)
{
    return map->alphas * map->banks * map->rudders * GTM_TRIM_VALUES;
}

/* The values at one altitude and path. */
static void take_values(const gtm_trim_map *map, double density, double gamma, double *values)
{
    const long n = gtm_trim_map_memory(map);
    memset(values, 0, (size_t)n * sizeof *values);
    for (long k = 0; k < map->densities; k++)
        for (long l = 0; l < map->paths; l++) {
            const double weight = gtm_lagrange(map->densities, map->density, k, density) *
                                  gtm_lagrange(map->paths, map->gamma, l, gamma);
            const float *node = map->table + (k * map->paths + l) * n;
            for (long i = 0; i < n; i++) values[i] += weight * node[i];
        }
}

static double excess(const limit *l, const corner *c)
{
    return l->weight * c->x[l->attribute] + l->loading * c->x[GTM_LOADING] - l->bound;
}

/* Where on the way between two corners a limit is met, whose excess has another sign at each. */
static corner met(const corner *a, double excess_a, const corner *b, double excess_b)
{
    const double share = excess_a / (excess_a - excess_b);
    corner c;
    for (int k = 0; k < ATTRIBUTES; k++) c.x[k] = a->x[k] + share * (b->x[k] - a->x[k]);
    return c;
}

static void clip(search *s, int number, int corners, const corner *simplex);

/* The part of a simplex that meets an equation: one or two simplices of a dimension less. */
static void slice(search *s, int number, int corners, const corner *simplex, const double *value)
{
    corner edge[CORNERS];
    int edges = 0, has_above = 0;
    for (int i = 0; i < corners; i++) has_above |= value[i] > 0;
    for (int i = 0; i < corners; i++)
        for (int k = 0; k < corners; k++)
            if (value[i] <= 0 && (has_above ? value[k] > 0 : k == i && value[i] == 0))
                edge[edges++] = has_above ? met(&simplex[i], value[i], &simplex[k], value[k]) : simplex[i];
    if (edges < CORNERS || !has_above) {
        if (edges) clip(s, number + 1, edges, edge);
        return;
    }
    clip(s, number + 1, CORNERS - 1, edge); /* of a quadrangle: edges to the same corner follow each other in pairs */
    clip(s, number + 1, CORNERS - 1, edge + 1);
}

/* The part of a simplex where an excess is at most zero, as simplices. */
static void halve(search *s, int number, int corners, const corner *simplex, const double *value)
{
    int inside = -1, outside = -1, touching = 0;
    for (int i = 0; i < corners; i++) {
        if (value[i] > 0) outside = i;
        if (value[i] < 0) inside = i;
        touching += value[i] == 0;
    }
    if (outside < 0) {
        clip(s, number + 1, corners, simplex);
        return;
    }
    corner part[CORNERS];
    double at_part[CORNERS];
    if (inside < 0) { /* nothing but a side, which other simplices share; at the end of the map none does */
        int count = 0;
        for (int i = 0; i < corners; i++)
            if (value[i] == 0) part[count++] = simplex[i];
        if (count) clip(s, number + 1, count, part);
        return;
    }
    const corner cut = met(&simplex[inside], value[inside], &simplex[outside], value[outside]);
    memcpy(part, simplex, (size_t)corners * sizeof *part);
    memcpy(at_part, value, (size_t)corners * sizeof *at_part);
    part[outside] = cut;
    at_part[outside] = 0;
    halve(s, number, corners, part, at_part);
    if (corners == 2) return;
    part[outside] = simplex[outside];
    at_part[outside] = value[outside];
    part[inside] = cut;
    at_part[inside] = 0;
    halve(s, number, corners, part, at_part);
}

/* What the limits from a number on leave of a simplex, and its extremes. */
static void clip(search *s, int number, int corners, const corner *simplex)
{
    double value[CORNERS];
    if (number == s->count) {
        for (int i = 0; i < corners; i++) {
            s->loading[0] = fmin(s->loading[0], simplex[i].x[GTM_LOADING]);
            s->loading[1] = fmax(s->loading[1], simplex[i].x[GTM_LOADING]);
        }
        return;
    }
    for (int i = 0; i < corners; i++) value[i] = excess(&s->limits[number], &simplex[i]);
    if (s->limits[number].is_equation)
        slice(s, number, corners, simplex, value);
    else
        halve(s, number, corners, simplex, value);
}

/* Whether a box may hold a better speed. */
static int is_promising(const search *s, const corner box[8])
{
    double least = box[0].x[GTM_LOADING], greatest = least;
    for (int i = 1; i < 8; i++) {
        least = fmin(least, box[i].x[GTM_LOADING]);
        greatest = fmax(greatest, box[i].x[GTM_LOADING]);
    }
    if (least >= s->loading[0] && greatest <= s->loading[1]) return 0;
    for (int k = 0; k < s->count; k++) {
        int is_below = 0, is_above = 0;
        for (int i = 0; i < 8; i++) {
            const double value = excess(&s->limits[k], &box[i]);
            is_below |= value <= 0;
            is_above |= value >= 0;
        }
        if (!is_below || (s->limits[k].is_equation && !is_above)) return 0;
    }
    return 1;
}

static void add_limits(search *s, int attribute, double loading_weight, const double ends[2])
{
    const int is_jam = ends[0] == ends[1];
    for (int is_upper = is_jam; is_upper < 2; is_upper++) {
        const double sign = is_upper ? 1 : -1, end = sign * ends[is_upper];
        limit *l = &s->limits[s->count++];
        *l = (limit){.attribute = attribute, .is_equation = is_jam, .weight = sign};
        *(loading_weight != 0 ? &l->loading : &l->bound) = loading_weight != 0 ? -end * loading_weight : end;
    }
}

/* Nodes between which a coordinate can be inside its limits: from the first one, below the last one. */
static void boxes_of(long n, const double *nodes, const double ends[2], long *first, long *last)
{
    *first = 0;
    *last = n - 1;
    while (*first < n - 2 && nodes[*first + 1] <= ends[0]) ++*first;
    while (*last > *first + 1 && nodes[*last - 1] >= ends[1]) --*last;
}

static const int tetrahedra[6][CORNERS] = {{0, 1, 3, 7}, {0, 1, 5, 7}, {0, 2, 3, 7},
                                           {0, 2, 6, 7}, {0, 4, 5, 7}, {0, 4, 6, 7}};

static void search_map(const gtm_trim_map *map, const gtm_trim_map_case *at, const double *values, search *s)
{
    long first[3], last[3];
    boxes_of(map->alphas, map->alpha, at->alpha, &first[0], &last[0]);
    boxes_of(map->banks, map->bank, at->bank, &first[1], &last[1]);
    boxes_of(map->rudders, map->rudder, at->rudder, &first[2], &last[2]);
    for (long i = first[0]; i < last[0]; i++)
        for (long j = first[1]; j < last[1]; j++)
            for (long k = first[2]; k < last[2]; k++) {
                corner box[8];
                for (int c = 0; c < 8; c++) {
                    const long a = i + (c >> 2), b = j + (c >> 1 & 1), r = k + (c & 1);
                    memcpy(box[c].x, values + ((a * map->banks + b) * map->rudders + r) * GTM_TRIM_VALUES,
                           GTM_TRIM_VALUES * sizeof *values);
                    box[c].x[X_ALPHA] = map->alpha[a];
                    box[c].x[X_BANK] = map->bank[b];
                    box[c].x[X_RUDDER] = map->rudder[r];
                }
                if (!is_promising(s, box)) continue;
                for (int t = 0; t < 6; t++) {
                    corner simplex[CORNERS];
                    for (int c = 0; c < CORNERS; c++) simplex[c] = box[tetrahedra[t][c]];
                    clip(s, 0, CORNERS, simplex);
                }
            }
}

void gtm_trim_map_envelopes(const gtm_trim_map *map, long n, const gtm_trim_map_case *cases, double *memory,
                            double (*speeds)[2])
{
    for (long i = 0; i < n; i++) {
        const gtm_trim_map_case *at = &cases[i];
        const gtm_condition air = gtm_condition_at(at->altitude, 0);
        const double density = air.density / gtm_condition_at(0, 0).density;
        if (i == 0 || at->altitude != at[-1].altitude || at->gamma != at[-1].gamma)
            take_values(map, density, at->gamma, memory);
        const double thrust[2] = {at->thrust[0] * air.pressure_ratio, at->thrust[1] * air.pressure_ratio};
        search s = {.loading = {INFINITY, -INFINITY}};
        add_limits(&s, X_RUDDER, 0, at->rudder);
        add_limits(&s, GTM_TRIM_AILERON, 0, at->aileron);
        add_limits(&s, GTM_TRIM_ELEVATOR, 0, at->elevator);
        add_limits(&s, GTM_DRAG, 1, thrust);
        add_limits(&s, X_ALPHA, 0, at->alpha);
        add_limits(&s, X_BANK, 0, at->bank);
        search_map(map, at, memory, &s);
        const int is_found = s.loading[0] <= s.loading[1] && s.loading[0] > 0;
        speeds[i][0] = is_found ? sqrt(1 / (s.loading[1] * density)) : 0;
        speeds[i][1] = is_found ? sqrt(1 / (s.loading[0] * density)) : 0;
    }
}
