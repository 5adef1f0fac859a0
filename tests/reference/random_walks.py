"""Random walks of a flight condition and the limits of the rudder, as envelope FMUs are asked step by step."""

from collections.abc import Iterator

import numpy as np

from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.airframe.names import AILERON, ALPHA, ELEVATOR, FAILURE, PHI, RUDDER, THROTTLE
from gtm_fmu.trims import manoeuvre
from gtm_fmu.units import RAD_PER_DEG

WIDE = manoeuvre.bounds(ControlLimits())
"""Bounds of the undamaged aircraft's unknowns."""

_BOUNDED = {
    **{"alpha": ALPHA, "bank": PHI, "elevator": ELEVATOR, "aileron": AILERON, "rudder": RUDDER, "throttle": THROTTLE},
    **{"throttle_left": THROTTLE, "throttle_right": THROTTLE},
}
_NUMBERS = {
    **{f"{name}_lower": WIDE[0][unknown] for name, unknown in _BOUNDED.items()},
    **{f"{name}_upper": WIDE[1][unknown] for name, unknown in _BOUNDED.items()},
    **{"engine_left_running": 1.0, "engine_right_running": 1.0},
}
UNDAMAGED = np.array([_NUMBERS.get(name, 0.0) for name in FAILURE])
"""No failure, as the core is told it."""

STEP = np.array([20.0, 0.02 * RAD_PER_DEG, 0.1, 0.1])
"""Standard deviation of a step: altitude in ft, gamma in rad, limits of the rudder in deg."""


def walk(rng: np.random.Generator, steps: int, jumps: float, size: float = 1.0) -> Iterator[np.ndarray]:
    """Questions (altitude in ft, gamma in rad, lower and upper limit of the rudder in deg), each near the one before.

    With the probability ``jumps`` a question is anywhere; a step is ``size`` times `STEP`.
    """
    lowest, highest = np.array([0, -5 * RAD_PER_DEG, -30, -30]), np.array([33000, 5 * RAD_PER_DEG, 30, 30])
    case = lowest
    for number in range(steps):
        if number == 0 or rng.random() < jumps:
            case = rng.uniform(lowest, highest)
        else:
            case = np.clip(case + size * STEP * rng.normal(size=4), lowest, highest)
        case[2:].sort()
        yield case.copy()
