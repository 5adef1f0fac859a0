"""A* over place, altitude and heading, along manoeuvres that can be flown (hybrid A*).

A state is where flight really leads; states that fall into one cell of place, altitude and heading compete, and the
cheapest is kept. From each state a path of turn, straight and turn to the goal is tried as well, so that the end is
met exactly.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from astar import find_path

from examples.path_planner.planner import dubins
from examples.path_planner.planner.field import CostToGo
from examples.path_planner.planner.primitives import SAMPLES, Leg, Manoeuvre, Primitives, Steps
from examples.path_planner.planner.scenario import Goal, Pose, Scenario
from examples.path_planner.planner.tracks import FT_PER_M, displacement, over_ground
from gtm_fmu.units import M_S_PER_KT, RAD_PER_DEG

_CELL_M, _CELL_FT, _CELL_DEG = 250.0, 100.0, 15.0
MOST_STATES = 20_000
_TOLERANCE = 1.01
"""A path that costs so much more than the least one is good enough."""
_SHOT_SPACING_M = 150.0


@dataclass(eq=False, slots=True)
class State:
    """Where the path has come.

    Attributes:
        cost: of the path up to here.
        estimate: of what is still to come, not more than that.
        legs: that led here from the state before.
        is_goal: whether the goal is met.
    """

    pose: Pose
    cost: float
    estimate: float
    legs: tuple[Leg, ...] = ()
    is_goal: bool = False


Rate = Callable[[float, Manoeuvre, float], float]
"""Cost of a second: of altitude in ft, manoeuvre, and speed over ground in m/s."""


class Search:
    """One search; `run` does it."""

    def __init__(
        self, scenario: Scenario, goal: Goal, primitives: Primitives, rate: Rate, to_go: CostToGo, least_per_m: float
    ) -> None:
        self.scenario, self.goal, self.primitives = scenario, goal, primitives
        self.rate, self.to_go, self.least_per_m = rate, to_go, least_per_m
        self.best: dict[tuple[int, ...], float] = {}
        self.nearest: State | None = None
        self.states = 0
        self.least_cost = math.inf
        self.turns = self._turns(scenario.start.altitude_ft)

    def run(self) -> list[State] | None:
        """States from the start to the goal, or None where no path is found."""
        pose = self.scenario.start
        start = State(pose, 0.0, float(self._estimates(*(np.array([value]) for value in pose))[0]))
        self.nearest = start
        path = find_path(
            start,
            start,
            self._next,
            heuristic_cost_estimate_fnct=lambda state, _: state.estimate,
            distance_between_fnct=lambda a, b: b.cost - a.cost,
            is_goal_reached_fnct=lambda state, _: state.is_goal,
        )
        return None if path is None else list(path)

    def distance_m(self, pose: Pose) -> float:
        """How far a pose is from the goal's circle."""
        away = math.hypot(self.goal.north_m - pose.north_m, self.goal.east_m - pose.east_m)
        return max(0.0, away - self.goal.radius_m)

    def _estimates(
        self, north: np.ndarray, east: np.ndarray, altitude: np.ndarray, heading_deg: np.ndarray
    ) -> np.ndarray:
        """No path from these poses (n) costs less: as far as the goal's circle, or along turn, straight and turn."""
        away = np.maximum(np.hypot(self.goal.north_m - north, self.goal.east_m - east) - self.goal.radius_m, 0.0)
        over_terrain = self.to_go(north, east, altitude) - self.to_go.spacing[0] * self.least_per_m
        least = np.maximum(away * self.least_per_m, over_terrain)
        if self.turns is None:
            return least
        # With wind the goal drifts towards the aircraft or away, at most as long as the way takes.
        speed, wind = self.primitives.tas_kt * M_S_PER_KT, self.scenario.wind
        radii = tuple(speed / abs(rate * RAD_PER_DEG) for rate in self.turns)
        end_heading = None if self.goal.heading_deg is None else self.goal.heading_deg * RAD_PER_DEG
        time = np.zeros(len(north))
        for _ in range(3 if any(wind) else 1):
            end = self.goal.north_m - wind.north_m_s * time, self.goal.east_m - wind.east_m_s * time, end_heading
            length = dubins.lengths_m(north, east, heading_deg * RAD_PER_DEG, end, radii)
            time = np.where(np.isfinite(length), length, 0.0) / speed
        return np.maximum(least, time * speed * self.least_per_m)

    def _turns(self, altitude_ft: float) -> tuple[float, float] | None:
        """The tightest level turns to the left and to the right in deg/s; None where it does not turn to both sides."""
        rates = [leg.manoeuvre.turn_rate_deg_s for leg in self.primitives.steps(altitude_ft).legs]
        left, right = min(rates, default=0.0), max(rates, default=0.0)
        return (left, right) if left < 0 < right and 0.0 in rates else None

    def _cell(self, pose: Pose) -> tuple[int, ...]:
        return (
            round(pose.north_m / _CELL_M),
            round(pose.east_m / _CELL_M),
            round(pose.altitude_ft / _CELL_FT),
            round(pose.heading_deg / _CELL_DEG) % round(360.0 / _CELL_DEG),
        )

    def _next(self, state: State) -> Iterator[State]:
        if self.states >= MOST_STATES or state.cost + state.estimate >= self.least_cost / _TOLERANCE:
            return
        if self.best.get(self._cell(state.pose), math.inf) < state.cost:
            return
        self.states += 1
        if self.distance_m(state.pose) < self.distance_m(self.nearest.pose):  # type: ignore[union-attr]
            self.nearest = state
        if (shot := self._shot(state)) is not None and shot.cost < self.least_cost:
            self.least_cost = shot.cost
            yield shot
        steps = self.primitives.steps(state.pose.altitude_ft)
        if not steps.legs:
            return
        north, east, altitude = self._track(state.pose, steps)
        is_clear = self._is_clear(north, east, altitude)
        heading = (state.pose.heading_deg + steps.turned_deg[:, -1]) % 360.0
        estimates = self._estimates(north[:, -1], east[:, -1], altitude[:, -1], heading)
        for k in np.flatnonzero(is_clear):
            leg = steps.legs[k]
            ground = math.hypot(north[k, -1] - state.pose.north_m, east[k, -1] - state.pose.east_m) / leg.duration_s
            if leg.manoeuvre.turn_rate_deg_s:
                ground = leg.manoeuvre.tas_kt * M_S_PER_KT
            cost = state.cost + leg.duration_s * self.rate(state.pose.altitude_ft, leg.manoeuvre, ground)
            pose = Pose(float(north[k, -1]), float(east[k, -1]), float(altitude[k, -1]), float(heading[k]))
            cell = self._cell(pose)
            if cost < self.best.get(cell, math.inf) and cost + estimates[k] < self.least_cost / _TOLERANCE:
                self.best[cell] = cost
                if is_met := self._is_met(pose):
                    self.least_cost = cost
                yield State(pose, cost, 0.0 if is_met else float(estimates[k]), (leg,), is_met)

    def _track(self, pose: Pose, steps: Steps) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        north, east = over_ground(steps.ahead_m, steps.right_m, pose.heading_deg, steps.time_s, self.scenario.wind)
        return pose.north_m + north, pose.east_m + east, pose.altitude_ft + steps.up_ft

    def _is_clear(self, north: np.ndarray, east: np.ndarray, altitude: np.ndarray) -> np.ndarray:
        ground = self.scenario.terrain.height(north, east)
        return (altitude - ground).min(axis=-1) >= self.scenario.clearance_ft

    def _is_met(self, pose: Pose) -> bool:
        if self.turns is not None:  # then paths of turn, straight and turn meet it exactly
            return False
        low, high = self.goal.altitude_ft
        if self.distance_m(pose) > 0 or not low <= pose.altitude_ft <= high:
            return False
        return self.goal.heading_deg is None or (
            abs((pose.heading_deg - self.goal.heading_deg + 180.0) % 360.0 - 180.0) <= self.goal.heading_tolerance_deg
        )

    def _shot(self, state: State) -> State | None:
        """The goal by turn, straight and turn on one flight path, where that can be flown above the ground."""
        best: State | None = None
        for legs in self._connections(state.pose):
            manoeuvres = [leg.manoeuvre for leg in legs]
            pose, cost, ok = state.pose, state.cost, True
            for leg, manoeuvre in zip(legs, manoeuvres, strict=True):
                count = max(SAMPLES, math.ceil(leg.duration_s * manoeuvre.tas_kt * M_S_PER_KT / _SHOT_SPACING_M))
                time = np.linspace(0.0, leg.duration_s, count)
                north, east, altitude, heading = fly(pose, leg, time, self.scenario)
                end = Pose(float(north[-1]), float(east[-1]), float(altitude[-1]), float(heading[-1]) % 360.0)
                ok = bool(self._is_clear(north, east, altitude)) and self.primitives.can_fly(
                    manoeuvre, pose.altitude_ft, end.altitude_ft
                )
                if not ok:
                    break
                ground = math.hypot(end.north_m - pose.north_m, end.east_m - pose.east_m) / leg.duration_s
                if manoeuvre.turn_rate_deg_s:
                    ground = manoeuvre.tas_kt * M_S_PER_KT
                cost += leg.duration_s * self.rate(0.5 * (pose.altitude_ft + end.altitude_ft), manoeuvre, ground)
                pose = end
            if ok and (best is None or cost < best.cost):
                best = State(pose, cost, 0.0, tuple(legs), is_goal=True)
        return best

    def _connections(self, pose: Pose) -> Iterator[list[Leg]]:
        """Legs to the goal for every kind of path, through moving air."""
        low, high = self.goal.altitude_ft
        goal_ft = min(max(pose.altitude_ft, low), high)
        climb_m = (goal_ft - pose.altitude_ft) / FT_PER_M
        flown = self.distance_m(pose) + 1.0
        if abs(math.atan2(climb_m, flown)) > 15.0 * RAD_PER_DEG and flown > 2000.0:
            return
        if self.turns is None:
            return
        turns = {-1.0: self.turns[0], 1.0: self.turns[1]}
        tas = self.primitives.tas_kt
        for first in range(4 if self.goal.heading_deg is not None else 2):
            legs = self._connection(pose, first, climb_m, turns, tas)
            if legs:
                yield legs

    def _connection(
        self, pose: Pose, kind: int, climb_m: float, turns: dict[float, float], tas: float
    ) -> list[Leg] | None:
        """Of one kind: the goal moves against the wind while the path is flown, so that is found by repetition."""
        speed, wind, gamma, time = tas * M_S_PER_KT, self.scenario.wind, 0.0, 0.0
        heading = None if self.goal.heading_deg is None else self.goal.heading_deg * RAD_PER_DEG
        start = (pose.north_m, pose.east_m, pose.heading_deg * RAD_PER_DEG)
        for _ in range(20):
            along = speed * math.cos(gamma)
            radii = (along / abs(turns[-1.0] * RAD_PER_DEG), along / abs(turns[1.0] * RAD_PER_DEG))
            end = (self.goal.north_m - wind.north_m_s * time, self.goal.east_m - wind.east_m_s * time, heading)
            found = dict(enumerate(_by_kind(start, end, radii)))
            path = found.get(kind)
            if path is None:
                return None
            before, time = time, path.length_m / along
            gamma = math.atan2(climb_m, path.length_m)
            if abs(time - before) < 1e-6:
                break
        else:
            return None
        gamma_deg = gamma / RAD_PER_DEG
        if not self.primitives.gammas_deg[0] <= gamma_deg <= self.primitives.gammas_deg[-1]:
            return None
        parts = (
            (path.first_angle, path.first_m),
            (0.0, path.straight_m),
            (path.last_angle, path.last_m),
        )
        legs = []
        for k, (angle, radius) in enumerate(parts):
            rate = 0.0 if k == 1 else turns[math.copysign(1.0, radius)] if radius else 0.0
            seconds = radius / along if k == 1 else abs(angle / (rate * RAD_PER_DEG)) if rate else 0.0
            if seconds > 1e-6:
                legs.append(Leg(Manoeuvre(gamma_deg, tas, rate), seconds))
        return legs


def _by_kind(
    start: tuple[float, float, float], end: tuple[float, float, float | None], radii: tuple[float, float]
) -> Iterator[dubins.Path | None]:
    return dubins.paths(start, end, radii)


def fly(
    pose: Pose, leg: Leg, time_s: np.ndarray, scenario: Scenario
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """North and east in m, altitude in ft and heading in deg at times into a leg."""
    gamma, tas, rate = leg.manoeuvre
    ahead, right, up, turned = displacement(np.float64(tas), np.float64(gamma), np.float64(rate), time_s)
    north, east = over_ground(ahead, right, pose.heading_deg, time_s, scenario.wind)
    return pose.north_m + north, pose.east_m + east, pose.altitude_ft + up, pose.heading_deg + turned
