"""A* over place, altitude and heading, along manoeuvres that can be flown (hybrid A*).

A state is where flight really leads; states that fall into one cell of place, altitude and heading compete, and the
cheapest is kept. From each state a path of turn, straight and turn to the goal is tried as well, so that the end is
met exactly. What a path of the grid has too many is cut off in the end: a part that one such connection replaces at
less cost.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from astar import find_path

from examples.path_planner.planner import dubins
from examples.path_planner.planner.connections import Target, connections
from examples.path_planner.planner.field import CostToGo
from examples.path_planner.planner.flight import Rate, cost_of, flown, is_clear
from examples.path_planner.planner.primitives import Leg, Manoeuvre, Primitives, Steps
from examples.path_planner.planner.scenario import Goal, Pose, Scenario
from examples.path_planner.planner.tracks import over_ground
from gtm_fmu.units import M_PER_FT, M_S_PER_KT, RAD_PER_DEG

_CELL_M, _CELL_FT, _CELL_DEG = 250.0, 100.0, 15.0
MOST_STATES, _ENOUGH_STATES = 10_000, 4_000
"""How many are looked at until there is a path, and until the best path so far is taken."""
_TOLERANCE = 1.01
"""A path that costs so much more than the least one is good enough."""


@dataclass(eq=False, slots=True)
class State:
    """Where the path has come.

    Attributes:
        cost: of the path up to here.
        estimate: of what is still to come.
        legs: that led here from the state before.
        is_goal: whether the goal is met.
    """

    pose: Pose
    cost: float
    estimate: float
    legs: tuple[Leg, ...] = ()
    is_goal: bool = False

    @property
    def manoeuvre(self) -> Manoeuvre | None:
        """The last one that was flown; None at the start."""
        return self.legs[-1].manoeuvre if self.legs else None


class Search:
    """One search; `run` does it.

    Attributes:
        turns: level turns to the left and to the right in deg/s; None where the aircraft cannot fly straight or turns
            to one side only.
        nearest: the state that came nearest to the goal.
        states: how many were looked at.
    """

    def __init__(
        self,
        scenario: Scenario,
        goal: Goal,
        primitives: Primitives,
        rate: Rate,
        to_go: CostToGo,
        least_per_m: float,
        least_per_s: float,
    ) -> None:
        self.scenario, self.goal, self.primitives = scenario, goal, primitives
        self.rate, self.to_go, self.least_per_m, self.least_per_s = rate, to_go, least_per_m, least_per_s
        self.turns = self._turns(scenario.start.altitude_ft)
        self.nearest = self._start()
        self.states = 0
        self._best: dict[tuple[int, ...], float] = {}
        self._least_cost = math.inf

    def run(self) -> list[State] | None:
        """States from the start to the goal, or None where no path is found."""
        path = find_path(
            start := self._start(),
            start,
            self._next,
            heuristic_cost_estimate_fnct=lambda state, _: state.estimate,
            distance_between_fnct=lambda a, b: b.cost - a.cost,
            is_goal_reached_fnct=lambda state, _: state.is_goal,
        )
        return None if path is None else self._shortened(list(path))

    def distance_m(self, pose: Pose) -> float:
        """How far a pose is from the goal's circle."""
        away = math.hypot(self.goal.north_m - pose.north_m, self.goal.east_m - pose.east_m)
        return max(0.0, away - self.goal.radius_m)

    def _shortfall_m(self, pose: Pose) -> float:
        """How far the goal is, with the height that is missing counted as the way that a climb of 6 deg takes."""
        low, high = self.goal.altitude_ft
        missing_ft = max(low - pose.altitude_ft, pose.altitude_ft - high, 0.0)
        return self.distance_m(pose) + 10.0 * missing_ft * M_PER_FT

    def _start(self) -> State:
        pose = self.scenario.start
        return State(pose, 0.0, float(self._estimates(*(np.array([value]) for value in pose))[0]))

    def _turns(self, altitude_ft: float) -> tuple[float, float] | None:
        rates = [leg.manoeuvre.turn_rate_deg_s for leg in self.primitives.steps(altitude_ft).legs]
        left, right = min(rates, default=0.0), max(rates, default=0.0)
        return (left, right) if left < 0 < right and 0.0 in rates else None

    def _estimates(
        self, north: np.ndarray, east: np.ndarray, altitude: np.ndarray, heading_deg: np.ndarray
    ) -> np.ndarray:
        """What paths from these poses (n) cost at least: over the terrain, or along turn, straight and turn."""
        away = np.maximum(np.hypot(self.goal.north_m - north, self.goal.east_m - east) - self.goal.radius_m, 0.0)
        over_terrain = self.to_go(north, east, altitude) - self.to_go.spacing[0] * self.least_per_m
        over_terrain[np.isinf(over_terrain)] = 0.0  # the grid is too coarse to say that nothing leads on
        least = np.maximum(away * self.least_per_m, over_terrain)
        if self.turns is None:
            return least
        speed, wind = self.primitives.tas_kt * M_S_PER_KT, self.scenario.wind
        radii = (speed / abs(self.turns[0] * RAD_PER_DEG), speed / abs(self.turns[1] * RAD_PER_DEG))
        end_heading = None if self.goal.heading_deg is None else self.goal.heading_deg * RAD_PER_DEG
        time = np.zeros(len(north))
        for _ in range(3 if any(wind) else 1):
            end = self.goal.north_m - wind.north_m_s * time, self.goal.east_m - wind.east_m_s * time, end_heading
            length = dubins.lengths_m(north, east, heading_deg * RAD_PER_DEG, end, radii)
            time = np.where(np.isfinite(length), length, 0.0) / speed
        return np.maximum(least, time * self.least_per_s)

    def _cell(self, pose: Pose) -> tuple[int, ...]:
        return (
            round(pose.north_m / _CELL_M),
            round(pose.east_m / _CELL_M),
            round(pose.altitude_ft / _CELL_FT),
            round(pose.heading_deg / _CELL_DEG) % round(360.0 / _CELL_DEG),
        )

    def _next(self, state: State) -> Iterator[State]:
        if self.states >= (MOST_STATES if math.isinf(self._least_cost) else _ENOUGH_STATES):
            return
        if state.cost + state.estimate >= self._least_cost / _TOLERANCE:
            return
        if self._best.get(self._cell(state.pose), math.inf) < state.cost:
            return
        self.states += 1
        if self._shortfall_m(state.pose) < self._shortfall_m(self.nearest.pose):
            self.nearest = state
        if self.turns is not None:
            end = self._connected(state, Target.of_goal(self.goal), self._least_cost - state.cost)
            if end is not None:
                self._least_cost = end.cost
                yield end
        yield from self._neighbours(state)

    def _neighbours(self, state: State) -> Iterator[State]:
        """One manoeuvre further."""
        steps = self.primitives.steps(state.pose.altitude_ft)
        if not steps.legs:
            return
        north, east, altitude = self._track(state.pose, steps)
        heading = (state.pose.heading_deg + steps.turned_deg[:, -1]) % 360.0
        estimates = self._estimates(north[:, -1], east[:, -1], altitude[:, -1], heading)
        lengths = np.hypot(np.diff(north, axis=1), np.diff(east, axis=1)).sum(axis=1)
        speeds = lengths / (steps.time_s[:, -1] - steps.time_s[:, 0])
        for k in np.flatnonzero(is_clear(self.scenario, north, east, altitude)):
            leg = steps.legs[k]
            cost = state.cost + cost_of(leg, state.pose.altitude_ft, state.manoeuvre, self.rate, float(speeds[k]))
            pose = Pose(float(north[k, -1]), float(east[k, -1]), float(altitude[k, -1]), float(heading[k]))
            cell = self._cell(pose)
            if cost < self._best.get(cell, math.inf) and cost + estimates[k] < self._least_cost / _TOLERANCE:
                self._best[cell] = cost
                if is_met := self._is_met(pose):
                    self._least_cost = cost
                yield State(pose, cost, 0.0 if is_met else float(estimates[k]), (leg,), is_met)

    def _track(self, pose: Pose, steps: Steps) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        north, east = over_ground(steps.ahead_m, steps.right_m, pose.heading_deg, steps.time_s, self.scenario.wind)
        return pose.north_m + north, pose.east_m + east, pose.altitude_ft + steps.up_ft

    def _is_met(self, pose: Pose) -> bool:
        """Whether the goal is met near enough, for an aircraft that cannot meet it exactly."""
        low, high = self.goal.altitude_ft
        if self.turns is not None or self.distance_m(pose) > 0 or not low <= pose.altitude_ft <= high:
            return False
        return self.goal.heading_deg is None or (
            abs((pose.heading_deg - self.goal.heading_deg + 180.0) % 360.0 - 180.0) <= self.goal.heading_tolerance_deg
        )

    def _connected(self, state: State, target: Target, most: float) -> State | None:
        """The cheapest connection of a state with a target that costs less than ``most``."""
        assert self.turns is not None
        best: State | None = None
        gammas, wind = self.scenario.gammas_deg, self.scenario.wind
        for legs in connections(state.pose, target, self.primitives.tas_kt, self.turns, gammas, wind):
            if sum(leg.duration_s for leg in legs) * self.least_per_s >= most:
                continue
            found = flown(state.pose, legs, state.manoeuvre, self.scenario, self.primitives, self.rate, most)
            if found is not None:
                pose, most = found
                best = State(pose, state.cost + most, 0.0, tuple(legs), is_goal=True)
        return best

    def _shortened(self, path: list[State]) -> list[State]:
        """The path with parts replaced by connections that cost less, from the start on the longest that does."""
        if self.turns is None:
            return path
        kept = [path[0]]
        k = 0
        while k < len(path) - 1:
            for j in range(len(path) - 1, k + 1, -1):
                most = path[j].cost - path[k].cost + 1e-9
                ending = Target.of_goal(self.goal) if path[j].is_goal else Target.of_pose(path[j].pose)
                found = self._connected(State(path[k].pose, kept[-1].cost, 0.0, kept[-1].legs), ending, most)
                if found is not None:
                    kept.append(found)
                    k = j
                    break
            else:
                k += 1
                cost = kept[-1].cost + path[k].cost - path[k - 1].cost
                kept.append(State(path[k].pose, cost, 0.0, path[k].legs, path[k].is_goal))
        return kept
