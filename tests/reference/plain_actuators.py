"""What lies between commands and the surface bus, and what the engines burn: SPEC 10.1-10.3 as plain functions.

Written from the specification alone. Surfaces in deg, throttle and rotor speed in %, time in s.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

Array = np.ndarray

# SPEC 10.1; positions in deg
POSITION_LIMITS = {
    **dict.fromkeys(("ELLOB", "ELLIB", "ELROB", "ELRIB"), (-30.0, 20.0)),
    **dict.fromkeys(("AILL", "AILR"), (-20.0, 20.0)),
    **dict.fromkeys(("RUDU", "RUDL"), (-30.0, 30.0)),
    **dict.fromkeys(("SPLLIB", "SPLRIB"), (0.0, 15.0)),
    **dict.fromkeys(("SPLLOB", "SPLROB"), (0.0, 45.0)),
    **dict.fromkeys(("FLAPLIB", "FLAPLOB", "FLAPRIB", "FLAPROB"), (0.0, 30.0)),
    "STEER": (-30.0, 30.0),
}
RATE_LIMIT = 300.0  # deg/s


def servo_rate(signal: str, position: float, command: float) -> float:
    """d position / d t of a servo, which stops at the end of its travel (SPEC 10.1)."""
    low, high = POSITION_LIMITS[signal]
    bandwidth = 10 if signal == "STEER" else 5  # Hz
    rate = min(max(2 * np.pi * bandwidth * (command - position), -RATE_LIMIT), RATE_LIMIT)
    if (position >= high and rate > 0) or (position <= low and rate < 0):
        return 0.0
    return rate


def throttle_lag_start(u: float) -> Array:
    """(z1, z2) in which a command u has settled (SPEC 10.2)."""
    return np.array([0.0, u / 0.7314])


def throttle_lag_rate(z: ArrayLike, u: float) -> Array:
    """d (z1, z2) / d t under the command u (SPEC 10.2)."""
    z1, z2 = np.asarray(z)
    return np.array([-1.336 * z1 - 0.7314 * z2 + u, z1])


def throttle_lag_output(z: ArrayLike) -> float:
    """The throttle position that the engine follows; not limited (SPEC 10.2)."""
    z1, z2 = np.asarray(z)
    return -0.1474 * z1 + 0.7314 * z2


def fuel_flow(N: float) -> float:
    """Of one engine in lb/min (SPEC 10.3)."""
    return 0.000046800927870 * N**2 - 0.000779344124807 * N + 0.122178501497750


def fuel_used_rate(N: Sequence[float], engines_on: Sequence[bool] = (True, True)) -> float:
    """d f / d t in lb/s of the left and the right engine; one that is switched off burns nothing (SPEC 10.2, 10.3)."""
    return sum(on * fuel_flow(speed) for on, speed in zip(engines_on, N, strict=True)) / 60


def exhaust_temperature(N: float) -> float:
    """In deg C (SPEC 10.3)."""
    return 2e-5 * N**4 - 0.0036 * N**3 + 0.2342 * N**2 - 8.0496 * N + 664.99
