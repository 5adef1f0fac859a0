"""Cost to go over the terrain without regard to turns: what guides the search around mountains.

A coarse grid of place and altitude; every step to a neighbour costs what the manoeuvres on its flight path cost.
Steps to eight sides are up to 8 % longer than the straight line, so costs are divided by that.
"""

import math
from collections.abc import Callable

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from examples.path_planner.planner.scenario import Goal, Scenario
from gtm_fmu.units import M_PER_FT, M_S_PER_KT, RAD_PER_DEG

_CELLS, _LEVELS, _AROUND_M, _ABOVE_FT = 44, 20, 6000.0, 3000.0
_OCTILE = 1.0824
Rate = Callable[[float, float], float | None]
"""Cost of a second, of altitude in ft and flight path in deg; None where that cannot be flown."""


class CostToGo:
    """Of a goal, for any place and altitude."""

    def __init__(self, scenario: Scenario, goal: Goal, tas_kt: float, rate: Rate) -> None:
        self._lay_out(scenario, goal)
        self._costs = self._solve(scenario, goal, tas_kt, rate)

    def __call__(self, north_m: np.ndarray, east_m: np.ndarray, altitude_ft: np.ndarray) -> np.ndarray:
        """Costs (n), infinite where the goal is not reached from."""
        places = zip((north_m, east_m, altitude_ft), self.origin, self.spacing, self._costs.shape, strict=True)
        index = tuple(np.clip(np.rint((x - x0) / dx).astype(int), 0, n - 1) for x, x0, dx, n in places)
        return self._costs[index]

    def _lay_out(self, scenario: Scenario, goal: Goal) -> None:
        places = np.array([scenario.start[:2], (goal.north_m, goal.east_m)])
        ground = scenario.terrain
        low = np.maximum(places.min(axis=0) - _AROUND_M, (ground.north_m[0], ground.east_m[0]))
        high = np.minimum(places.max(axis=0) + _AROUND_M, (ground.north_m[-1], ground.east_m[-1]))
        step = float((high - low).max()) / (_CELLS - 1)
        bottom = min(scenario.start.altitude_ft, *goal.altitude_ft) - 500.0
        top = max(scenario.start.altitude_ft, *goal.altitude_ft) + _ABOVE_FT
        self.spacing = (step, step, (top - bottom) / (_LEVELS - 1))
        self.origin = (float(low[0]), float(low[1]), max(bottom, 0.0))
        self._axes = [
            np.arange(self.origin[0], high[0] + 1e-6, step),
            np.arange(self.origin[1], high[1] + 1e-6, step),
            self.origin[2] + self.spacing[2] * np.arange(_LEVELS),
        ]

    def _solve(self, scenario: Scenario, goal: Goal, tas_kt: float, rate: Rate) -> np.ndarray:
        shape = tuple(len(axis) for axis in self._axes)
        north, east, altitude = np.meshgrid(*self._axes, indexing="ij")
        is_free = altitude >= scenario.terrain.height(north, east) + scenario.clearance_ft
        number = np.arange(north.size).reshape(shape)
        rows, columns, costs = [], [], []
        for i, j in ((i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j):
            run = self.spacing[0] * math.hypot(i, j)
            wind = (scenario.wind.north_m_s * i + scenario.wind.east_m_s * j) / math.hypot(i, j)
            for k in (-1, 0, 1):
                gamma = math.atan2(k * self.spacing[2] * M_PER_FT, run) / RAD_PER_DEG
                seconds = run / (tas_kt * M_S_PER_KT * math.cos(gamma * RAD_PER_DEG) + wind)
                if seconds <= 0:
                    continue
                here = tuple(slice(max(0, -d), n - max(0, d)) for d, n in zip((i, j, k), shape, strict=True))
                there = tuple(slice(max(0, d), n + min(0, d)) for d, n in zip((i, j, k), shape, strict=True))
                layer = np.array([rate(float(h), gamma) or math.inf for h in self._axes[2]])[here[2]]
                cost = np.broadcast_to(seconds * layer, number[here].shape)
                kept = is_free[here] & is_free[there] & np.isfinite(cost)
                rows.append(number[there][kept])  # from the goal backwards
                columns.append(number[here][kept])
                costs.append(cost[kept] / _OCTILE)
        count = number.size
        entries = (np.concatenate(costs), (np.concatenate(rows), np.concatenate(columns)))
        graph = coo_array(entries, shape=(count, count)).tocsr()
        away = np.hypot(north - goal.north_m, east - goal.east_m)
        half = 0.5 * self.spacing[2]
        is_goal = (away <= max(goal.radius_m, 0.75 * self.spacing[0])) & is_free
        is_goal &= (altitude >= goal.altitude_ft[0] - half) & (altitude <= goal.altitude_ft[1] + half)
        if not is_goal.any():
            return np.zeros(shape)
        found = dijkstra(graph, indices=number[is_goal], min_only=True)
        return np.asarray(found).reshape(shape)
