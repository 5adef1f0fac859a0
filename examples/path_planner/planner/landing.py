"""Landing with a thrust that cannot be chosen: which ground is in reach, which runways, and the path to one of them.

Height is what there is to spend. A path to a runway is a straight start, whole turns, then turn, straight, turn and a
straight final; whole turns and the straight start are as many and as long as spend what is too much. Glides are those
with the least sideslip; a little more is in reach with sideslip, which stays as a reserve.
"""

import math
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.optimize import brentq

from examples.path_planner.planner import dubins
from examples.path_planner.planner.flight import fly
from examples.path_planner.planner.glides import Glides
from examples.path_planner.planner.plan import NoPathError
from examples.path_planner.planner.primitives import Leg, Manoeuvre
from examples.path_planner.planner.scenario import Goal, Pose, Runway, Scenario
from examples.path_planner.planner.tracks import FT_PER_M, heading_for_track
from gtm_fmu.units import M_S_PER_KT, RAD_PER_DEG

FINAL_M = 600.0
_FINAL_DEG, _ABOVE_CLEARANCE_FT = -3.0, 60.0
_PART_S = 20.0
"""The glide is asked for again at least so often."""
_NEAR_M = 2000.0
"""This near to a threshold the clearance shrinks to none."""
_AIMS, _AIM_M = 12, 0.05
_LONGEST_START_M, _START_STEP_M, _MOST_TURNS = 6000.0, 250.0, 12
_BEARINGS = 72
Move = tuple[float, float]
"""A turn rate in deg/s and for how many seconds."""


@dataclass(frozen=True)
class Reach:
    """A runway, and the height in ft above it of the best glide: negative out of reach, -inf behind ground."""

    runway: Runway
    excess_ft: float

    @property
    def is_reached(self) -> bool:
        """Whether a glide gets there."""
        return self.excess_ft >= 0.0


@dataclass(frozen=True)
class Footprint:
    """What a glide reaches from the start.

    Attributes:
        north_m, east_m: where glides of every bearing meet the clearance, after the better of both turns (n each).
        tas_kt, gamma_deg: of the straight glide at the start.
        turns_deg_s: to the left and to the right.
        runways: of the scenario, the one with the most height first.
    """

    north_m: np.ndarray
    east_m: np.ndarray
    tas_kt: float
    gamma_deg: float
    turns_deg_s: tuple[float, float]
    runways: tuple[Reach, ...]


def is_clear_to(runway: Runway, legs: list[Leg], pose: Pose, scenario: Scenario) -> bool:
    """Whether a path keeps its clearance, which shrinks to none over the last part before the threshold."""
    for leg in legs:
        north, east, altitude, heading = fly(pose, leg, np.linspace(0.0, leg.duration_s, 9), scenario)
        away = np.hypot(north - runway.north_m, east - runway.east_m)
        needed = scenario.clearance_ft * np.clip(away / _NEAR_M - 0.5, 0.0, 1.0)
        height = altitude - scenario.terrain.height(north, east)
        if (height < needed - 1.0).any():
            return False
        pose = Pose(float(north[-1]), float(east[-1]), float(altitude[-1]), float(heading[-1]))
    return True


def final_approach(runway: Runway, tas_kt: float, scenario: Scenario) -> tuple[Goal, Leg] | None:
    """Where a powered final begins, and the final itself, on the runway's track; None where the wind is too strong."""
    gamma = _FINAL_DEG * RAD_PER_DEG
    along = tas_kt * M_S_PER_KT * math.cos(gamma)
    held = heading_for_track(runway.heading_deg, along, scenario.wind)
    if held is None:
        return None
    heading_deg, ground_m_s = held
    height_ft = scenario.clearance_ft + _ABOVE_CLEARANCE_FT
    seconds = height_ft / FT_PER_M / (tas_kt * M_S_PER_KT * math.sin(-gamma))
    track, away = runway.heading_deg * RAD_PER_DEG, ground_m_s * seconds
    north_m, east_m = runway.north_m - away * math.cos(track), runway.east_m - away * math.sin(track)
    altitude_ft = runway.altitude_ft + height_ft
    goal = Goal(north_m, east_m, 1.0, (altitude_ft, altitude_ft), heading_deg % 360.0)
    return goal, Leg(Manoeuvre(_FINAL_DEG, tas_kt, 0.0), seconds)


class Descent:
    """Glides of one speed from the start of a scenario."""

    def __init__(self, scenario: Scenario, glides: Glides) -> None:
        """Settle the speed and the turns.

        Raises:
            NoPathError: no straight glide, or no turns to both sides.
        """
        self.scenario, self.glides = scenario, glides
        altitude = scenario.start.altitude_ft
        best = glides.speed_kt(round(altitude / 500.0) * 500.0)
        if scenario.tas_kt is not None:
            gamma = glides.gamma_deg(altitude, scenario.tas_kt, 0.0)
            best = None if gamma is None else (scenario.tas_kt, gamma)
        if best is None:
            raise NoPathError(f"No straight flight is left at {altitude:g} ft with this thrust.")
        self.tas_kt, self.gamma_deg = best
        turns = glides.turns_deg_s(round(altitude / 500.0) * 500.0, self.tas_kt, scenario.reserve)
        if turns is None:
            raise NoPathError(f"At {self.tas_kt:g} kn no turns to both sides are left with this thrust.")
        self.turns = turns

    def legs(self, pose: Pose, moves: list[Move]) -> tuple[list[Leg], Pose] | None:
        """Moves as legs of no more than some seconds on the flight paths that are left there, and where they end."""
        legs = []
        for rate, seconds in moves:
            count = max(1, math.ceil(seconds / _PART_S - 1e-9))
            for _ in range(count if seconds > 1e-9 else 0):
                gamma = self.glides.gamma_deg(pose.altitude_ft, self.tas_kt, rate)
                if gamma is None:
                    return None
                leg = Leg(Manoeuvre(gamma, self.tas_kt, rate), seconds / count)
                legs.append(leg)
                pose = Pose(*(float(v) for v in fly(pose, leg, np.float64(leg.duration_s), self.scenario)))
        return legs, pose

    def approach(self, runway: Runway, kind: int, turns: int, start_m: float) -> tuple[list[Leg], Pose] | None:
        """Legs over a threshold on its heading, and where they end; aimed again until the end is met.

        Args:
            kind: the pair of turns, as in `dubins.path`.
            turns: whole turns after the straight start, to the side of the first turn.
            start_m: length of the straight start through the air.
        """
        speed = self.tas_kt * M_S_PER_KT * math.cos(self.gamma_deg * RAD_PER_DEG)
        start, held = self.scenario.start, heading_for_track(runway.heading_deg, speed, self.scenario.wind)
        if held is None:
            return None
        heading = held[0] * RAD_PER_DEG
        before: list[Move] = [(0.0, start_m / speed)]
        first = self.turns[kind // 2]
        before += [(first, 360.0 / abs(first))] * turns
        begun = self.legs(start, before)
        if begun is None:
            return None
        legs, pose = begun
        radii = (speed / abs(self.turns[0] * RAD_PER_DEG), speed / abs(self.turns[1] * RAD_PER_DEG))
        aim = np.array([runway.north_m, runway.east_m])
        for _ in range(_AIMS):
            end = (*(aim - FINAL_M * np.array([math.cos(heading), math.sin(heading)])), heading)
            path = dubins.path((pose.north_m, pose.east_m, pose.heading_deg * RAD_PER_DEG), end, radii, kind)
            if path is None:
                return None
            moves = [
                (first, abs(path.first_angle) / abs(first * RAD_PER_DEG)),
                (0.0, path.straight_m / speed),
                (self.turns[kind % 2], abs(path.last_angle) / abs(self.turns[kind % 2] * RAD_PER_DEG)),
                (0.0, FINAL_M / speed),
            ]
            found = self.legs(pose, moves)
            if found is None:
                return None
            miss = np.array([found[1].north_m - runway.north_m, found[1].east_m - runway.east_m])
            if np.hypot(*miss) < _AIM_M:
                return legs + found[0], found[1]
            aim -= miss
        return None

    def reach(self, runway: Runway) -> Reach:
        """The height of the best approach without anything that spends height."""
        found = [self.approach(runway, kind, 0, 0.0) for kind in range(4)]
        clear = [
            pose.altitude_ft - runway.altitude_ft
            for legs, pose in filter(None, found)
            if is_clear_to(runway, legs, self.scenario.start, self.scenario)
        ]
        low = [pose.altitude_ft - runway.altitude_ft for _, pose in filter(None, found)]
        return Reach(runway, max(clear, default=min(max(low, default=-math.inf), -0.0) or -math.inf))

    def path_to(self, runway: Runway) -> list[Leg] | None:
        """The shortest of the paths that end on the threshold, on its heading and at its altitude."""
        found: list[tuple[int, float, list[Leg]]] = []
        for kind, turns in product(range(4), range(_MOST_TURNS + 1)):
            if (legs := self._spending_all(runway, kind, turns)) is not None:
                found.append((turns, sum(leg.duration_s for leg in legs), legs))
        return min(found)[-1] if found else None

    def _spending_all(self, runway: Runway, kind: int, turns: int) -> list[Leg] | None:
        """With the straight start that spends all height, if there is one that keeps its clearance."""

        def excess(start_m: float) -> float:
            found = self.approach(runway, kind, turns, start_m)
            return math.nan if found is None else found[1].altitude_ft - runway.altitude_ft

        before = excess(0.0)
        if not before >= 0.0:
            return None
        for start in np.arange(_START_STEP_M, _LONGEST_START_M + 1.0, _START_STEP_M).tolist():
            now = excess(start)
            if math.isnan(now):
                return None
            if before >= 0.0 > now and before - now < 500.0:  # more than that is a jump to another path
                length = brentq(excess, start - _START_STEP_M, start, xtol=1e-3)
                found = self.approach(runway, kind, turns, float(length))
                if found is not None and abs(found[1].altitude_ft - runway.altitude_ft) < 5.0:
                    return found[0] if is_clear_to(runway, found[0], self.scenario.start, self.scenario) else None
            before = now
        return None

    def footprint(self) -> Footprint:
        """The ground in reach and the runways in it."""
        ends = np.array([self._furthest(bearing) for bearing in np.arange(_BEARINGS) * 360.0 / _BEARINGS])
        reaches = sorted((self.reach(runway) for runway in self.scenario.runways), key=lambda each: -each.excess_ft)
        return Footprint(*ends.T, self.tas_kt, self.gamma_deg, self.turns, tuple(reaches))

    def _furthest(self, bearing_deg: float) -> tuple[float, float]:
        """Where the glide on a heading meets the clearance, after the turn that leads further."""
        best, start = (-math.inf, (self.scenario.start.north_m, self.scenario.start.east_m)), self.scenario.start
        for rate in self.turns:
            angle = math.copysign(1.0, rate) * (bearing_deg - start.heading_deg) % 360.0
            place = self._glide_until_clearance([(rate, angle / abs(rate)), (0.0, 3600.0)])
            along = RAD_PER_DEG * bearing_deg
            ahead = (place[0] - start.north_m) * math.cos(along) + (place[1] - start.east_m) * math.sin(along)
            best = max(best, (ahead, place))
        return best[1]

    def _glide_until_clearance(self, moves: list[Move]) -> tuple[float, float]:
        pose = self.scenario.start
        for rate, seconds in moves:
            while seconds > 1e-9:
                gamma = self.glides.gamma_deg(pose.altitude_ft, self.tas_kt, rate)
                if gamma is None:
                    return pose.north_m, pose.east_m
                leg = Leg(Manoeuvre(gamma, self.tas_kt, rate), min(seconds, _PART_S))
                times = np.linspace(0.0, leg.duration_s, 9)
                north, east, altitude, heading = fly(pose, leg, times, self.scenario)
                low = altitude < self.scenario.terrain.height(north, east) + self.scenario.clearance_ft
                if low.any():
                    k = int(np.argmax(low))
                    return float(north[k]), float(east[k])
                pose = Pose(float(north[-1]), float(east[-1]), float(altitude[-1]), float(heading[-1]))
                if pose.altitude_ft <= 0.0:
                    return pose.north_m, pose.east_m
                seconds -= leg.duration_s
        return pose.north_m, pose.east_m


def path_to_a_runway(descent: Descent) -> tuple[Runway, list[Leg]]:
    """To the runway with most height to spare, or to the next one where no path spends it.

    Raises:
        NoPathError: none; with the one that is missed least.
    """
    reaches = sorted(map(descent.reach, descent.scenario.runways), key=lambda each: -each.excess_ft)
    for reach in reaches:
        legs = descent.path_to(reach.runway) if reach.is_reached else None
        if legs is not None:
            return reach.runway, legs
    nearest = reaches[0]
    if nearest.is_reached:
        raise NoPathError(
            f"Runway {nearest.runway.name} is in reach with {nearest.excess_ft:.0f} ft to spare, but no path that "
            "spends them keeps the clearance."
        )
    missed = f"is missed by {-nearest.excess_ft:.0f} ft" if math.isfinite(nearest.excess_ft) else "lies behind ground"
    raise NoPathError(f"No runway is in reach of a glide; the nearest, {nearest.runway.name}, {missed}.")
