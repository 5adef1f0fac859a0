"""Between commands and surfaces: servos, dead band and the lag of the throttle (SPEC 10.1, 10.2), in deg, % and s.

Commands are constant between two moments, so every motion is given in closed form over the time elapsed.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gtm_fmu.airframe.names import SERVO_GROUPS
from gtm_fmu.airframe.quantity import Quantity, ca
from gtm_fmu.airframe.surfaces import ALLOCATION, COMMANDED

BANDWIDTH_RAD_S = 2 * np.pi * 5.0
RATE_LIMIT_DEG_S = 300.0


class Servo(NamedTuple):
    """Lowest and highest position in deg."""

    lowest: float
    highest: float


_TRAVEL = ((-30.0, 20.0), (-20.0, 20.0), (-30.0, 30.0), (0.0, 30.0), (0.0, 15.0), (0.0, 45.0))
SERVOS = {name: Servo(*ends) for name, ends in zip(SERVO_GROUPS, _TRAVEL, strict=True)}

DEAD_BAND_DEG = {
    **dict.fromkeys(("ELLOB", "ELROB"), 0.3),
    **dict.fromkeys(("ELLIB", "ELRIB"), 0.6),
    **dict.fromkeys(("AILL", "AILR"), 0.25),
    "RUDU": 0.4,
    "RUDL": 0.3,
}
FLAPS_DEAD_BAND_DEG = 0.4

LAG = (1.336, 0.7314)  # of dz1/dt
LAG_OUTPUT = (-0.1474, 0.7314)  # of z1 and z2


def servo(position: Quantity, command: Quantity, elapsed: Quantity, rate_limit: Quantity, ends: Servo) -> ca.SX:
    """Position after ``elapsed`` under a constant command: at the limit of its rate, then exponentially."""
    error = ca.fabs(command - position)
    too_much = ca.fmax(0, error - rate_limit / BANDWIDTH_RAD_S)
    at_limit = ca.fmin(elapsed, too_much / ca.fmax(rate_limit, 1e-300))
    remaining = (error - rate_limit * at_limit) * ca.exp(-BANDWIDTH_RAD_S * (elapsed - at_limit))
    return ca.fmin(ca.fmax(command - ca.sign(command - position) * remaining, ends.lowest), ends.highest)


def dead_band(position: Quantity, half_width: Quantity) -> ca.SX:
    """Zero inside the band; outside it half its width is lost."""
    return ca.fmax(position - half_width, 0) + ca.fmin(position + half_width, 0)


def servos(positions: ca.SX, commands: ca.SX, elapsed: Quantity, rate_limits: ca.SX) -> ca.SX:
    """Positions (6) of the `SERVOS` after ``elapsed``."""
    each = zip(*map(ca.vertsplit, (positions, commands, rate_limits)), SERVOS.values(), strict=True)
    return ca.vertcat(*(servo(position, command, elapsed, rate, ends) for position, command, rate, ends in each))


def surface_positions(positions: ca.SX, has_dead_band: Quantity) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Commanded surfaces (8), spoilers (4) and flaps (4) of the bus at positions (6) of the `SERVOS`."""
    groups = dict(zip(SERVOS, ca.vertsplit(positions), strict=True))
    commanded = []
    for name in COMMANDED:
        position = ALLOCATION[name].sign * groups[ALLOCATION[name].command]
        commanded.append(ca.if_else(has_dead_band, dead_band(position, DEAD_BAND_DEG[name]), position))
    spoilers = [groups["spoilers_inboard"], groups["spoilers_outboard"]] * 2
    flap = ca.if_else(has_dead_band, dead_band(groups["flaps"], FLAPS_DEAD_BAND_DEG), groups["flaps"])
    return ca.vertcat(*commanded), ca.vertcat(*spoilers), ca.vertcat(*[flap] * 4)


def settled_lag(throttle: Quantity) -> ca.SX:
    """State (2) of the lag in which a throttle command has settled."""
    return ca.vertcat(0, throttle / LAG[1])


def throttle_lag(z: ca.SX, throttle: Quantity, elapsed: Quantity) -> tuple[ca.SX, ca.SX]:
    """State (2) of the lag and its output in %, not limited again, after ``elapsed`` under a constant command.

    About its equilibrium z2 is a damped oscillation, and z1 is its slope.
    """
    damping = LAG[0] / 2
    frequency = np.sqrt(LAG[1] - damping**2)
    equilibrium = throttle / LAG[1]
    decay, cos, sin = (
        f(factor * elapsed) for f, factor in ((ca.exp, -damping), (ca.cos, frequency), (ca.sin, frequency))
    )
    slope, away = z[0], z[1] - equilibrium
    z1 = decay * (slope * cos - (damping * slope + LAG[1] * away) / frequency * sin)
    z2 = equilibrium + decay * (away * cos + (slope + damping * away) / frequency * sin)
    return ca.vertcat(z1, z2), LAG_OUTPUT[0] * z1 + LAG_OUTPUT[1] * z2
