"""From a pose to a place or a pose by turn, straight and turn on one flight path, through moving air."""

import math
from collections.abc import Iterator
from typing import NamedTuple

from examples.path_planner.planner import dubins
from examples.path_planner.planner.primitives import Leg, Manoeuvre
from examples.path_planner.planner.scenario import Goal, Pose
from examples.path_planner.planner.tracks import FT_PER_M, Wind
from gtm_fmu.units import M_S_PER_KT, RAD_PER_DEG

_REPETITIONS, _SECONDS, _MOST_TURNS = 30, 1e-7, 30
Turns = tuple[float, float]
"""Turn rates to the left and to the right in deg/s."""


class Target(NamedTuple):
    """Where a connection ends; heading None for any."""

    north_m: float
    east_m: float
    altitude_ft: tuple[float, float]
    heading_deg: float | None

    @classmethod
    def of_goal(cls, goal: Goal) -> "Target":
        """The middle of a goal."""
        return cls(goal.north_m, goal.east_m, goal.altitude_ft, goal.heading_deg)

    @classmethod
    def of_pose(cls, pose: Pose) -> "Target":
        """Exactly there."""
        return cls(pose.north_m, pose.east_m, (pose.altitude_ft, pose.altitude_ft), pose.heading_deg)


def connections(
    pose: Pose, target: Target, tas_kt: float, turns: Turns, gammas_deg: tuple[float, ...], wind: Wind
) -> Iterator[list[Leg]]:
    """Legs for every pair of turns that leads there, with whole turns where the flight path would be too steep.

    ``gammas_deg``: none is steeper than the steepest of them; each is tried as the steepest that whole turns lead to.
    """
    climb_m = _climb_m(pose, target)
    steepest = {abs(g) * RAD_PER_DEG for g in gammas_deg if g * climb_m > 0} or {0.0}
    for kind in range(4 if target.heading_deg is not None else 2):
        tried = set()
        for limit in sorted(steepest, reverse=True):
            found = _connection(pose, target, tas_kt, turns, limit, wind, kind)
            if found is None:
                continue
            legs, whole_turns = found
            if legs and whole_turns not in tried:
                tried.add(whole_turns)
                yield legs


def _climb_m(pose: Pose, target: Target) -> float:
    low, high = target.altitude_ft
    return (min(max(pose.altitude_ft, low), high) - pose.altitude_ft) / FT_PER_M


def _connection(
    pose: Pose,
    target: Target,
    tas_kt: float,
    turns: Turns,
    steepest: float,
    wind: Wind,
    kind: int,
) -> tuple[list[Leg], int] | None:
    """Of one pair of turns, with the number of whole turns before it that make it no steeper than an angle in rad.

    The end drifts against the wind while the path is flown, so that is found by repetition.
    """
    speed, gamma, time = tas_kt * M_S_PER_KT, 0.0, 0.0
    climb_m, whole = _climb_m(pose, target), 0
    heading = None if target.heading_deg is None else target.heading_deg * RAD_PER_DEG
    start = (pose.north_m, pose.east_m, pose.heading_deg * RAD_PER_DEG)
    for _ in range(_REPETITIONS):
        along = speed * math.cos(gamma)
        radii = (along / abs(turns[0] * RAD_PER_DEG), along / abs(turns[1] * RAD_PER_DEG))
        end = (target.north_m - wind.north_m_s * time, target.east_m - wind.east_m_s * time, heading)
        path = dubins.path(start, end, radii, kind)
        if path is None or path.length_m <= 0:
            return None
        circle_m = 2.0 * math.pi * abs(path.first_m)
        if abs(climb_m) > 1e-9:
            if steepest <= 0.0:
                return None
            missing_m = abs(climb_m) / math.tan(steepest) - path.length_m
            whole = max(whole, math.ceil(missing_m / circle_m - 1e-9))
        if whole > _MOST_TURNS:
            return None
        length_m = path.length_m + whole * circle_m
        before, time = time, length_m / along
        gamma = math.atan2(climb_m, length_m)
        if abs(time - before) < _SECONDS:
            break
    else:
        return None
    gamma_deg = gamma / RAD_PER_DEG
    first_angle = abs(path.first_angle) + 2.0 * math.pi * whole
    parts = ((path.first_m, first_angle), (0.0, path.straight_m), (path.last_m, path.last_angle))
    legs = []
    for radius, amount in parts:
        rate = (turns[1] if radius > 0 else turns[0]) if radius else 0.0
        seconds = abs(amount) / (abs(rate) * RAD_PER_DEG if radius else along)
        if seconds > _SECONDS:
            legs.append(Leg(Manoeuvre(gamma_deg, tas_kt, rate), seconds))
    return legs, whole
