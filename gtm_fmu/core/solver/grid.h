/* All trims on a grid of speed and turn rate: a flood from known points, each cell solved from a neighbour's trim, and
   from cold where most of its neighbours have one but lead nowhere. */
#ifndef GTM_GRID_H
#define GTM_GRID_H

#include "solver/problem.h"

/* Trims with the least |beta| at speeds and turn rates, both rising, from n seeds (rows of y). Fills
   feasible[speeds*rates] and, where feasible, y[speeds*rates*unknowns]; returns their number, -1 without memory. */
long gtm_find_grid(const gtm_problem *p, const double *lower, const double *upper, long speeds, const double *speed,
                   long rates, const double *rate, long n, const double *seeds, unsigned char *feasible, double *y);

#endif
