"""Legs flown from a pose: where they lead, what they cost, whether they keep off the ground and in the envelope."""

import math
from collections.abc import Callable, Sequence

import numpy as np

from examples.path_planner.planner.primitives import SAMPLES, Leg, Manoeuvre, Primitives
from examples.path_planner.planner.scenario import Pose, Scenario
from examples.path_planner.planner.tracks import displacement, over_ground
from gtm_fmu.units import M_S_PER_KT

CHANGE_S = 4.0
"""A change from one manoeuvre to another costs as much as so many seconds: fewer and longer ones are flown better."""
_SPACING_M, _BETWEEN_FT = 60.0, 5.0
"""Between points at which the ground is looked at, and what is kept for the ground between them."""

Rate = Callable[[float, Manoeuvre, float], float]
"""Cost of a second: of altitude in ft, manoeuvre, and speed over ground in m/s."""


def fly(
    pose: Pose, leg: Leg, time_s: np.ndarray, scenario: Scenario
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """North and east in m, altitude in ft and heading in deg at times into a leg."""
    gamma, tas, rate = leg.manoeuvre
    ahead, right, up, turned = displacement(np.float64(tas), np.float64(gamma), np.float64(rate), time_s)
    north, east = over_ground(ahead, right, pose.heading_deg, time_s, scenario.wind)
    return pose.north_m + north, pose.east_m + east, pose.altitude_ft + up, pose.heading_deg + turned


def is_clear(scenario: Scenario, north_m: np.ndarray, east_m: np.ndarray, altitude_ft: np.ndarray) -> np.ndarray:
    """Whether tracks (.., n) keep the clearance everywhere (..)."""
    ground = scenario.terrain.height(north_m, east_m)
    return (altitude_ft - ground).min(axis=-1) >= scenario.clearance_ft + _BETWEEN_FT


def cost_of(leg: Leg, altitude_ft: float, before: Manoeuvre | None, rate: Rate, ground_m_s: float) -> float:
    """Of a leg about an altitude, after another manoeuvre; at the start nothing changes."""
    change = CHANGE_S if before is not None and before != leg.manoeuvre else 0.0
    return (leg.duration_s + change) * rate(altitude_ft, leg.manoeuvre, ground_m_s)


def flown(
    pose: Pose,
    legs: Sequence[Leg],
    before: Manoeuvre | None,
    scenario: Scenario,
    primitives: Primitives,
    rate: Rate,
    most: float = math.inf,
) -> tuple[Pose, float] | None:
    """Where legs end and what they cost; None where they touch the ground, leave the envelope or cost over ``most``."""
    cost = 0.0
    for leg in legs:
        count = max(SAMPLES, math.ceil(leg.duration_s * leg.manoeuvre.tas_kt * M_S_PER_KT / _SPACING_M) + 1)
        north, east, altitude, heading = fly(pose, leg, np.linspace(0.0, leg.duration_s, count), scenario)
        end = Pose(float(north[-1]), float(east[-1]), float(altitude[-1]), float(heading[-1]) % 360.0)
        length = float(np.hypot(np.diff(north), np.diff(east)).sum())
        cost += cost_of(leg, 0.5 * (pose.altitude_ft + end.altitude_ft), before, rate, length / leg.duration_s)
        if cost >= most or not is_clear(scenario, north, east, altitude):
            return None
        if not primitives.can_fly(leg.manoeuvre, pose.altitude_ft, end.altitude_ft):
            return None
        pose, before = end, leg.manoeuvre
    return pose, cost
