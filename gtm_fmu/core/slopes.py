"""Slopes of an envelope's ends by the multipliers of the optimum, in the core's units."""

import ctypes

import numpy as np
from numpy.typing import ArrayLike

from gtm_fmu.airframe.names import TWO_THROTTLE_UNKNOWNS
from gtm_fmu.core.library import address, library
from gtm_fmu.core.solver import STUDY, Airframe

_UNKNOWNS = len(TWO_THROTTLE_UNKNOWNS)
QUANTITIES = ("altitude", "gamma", "stabilizer", "flaps", "spoilers", "fuel_used")
"""Beside the bounds, as in gtm_slopes.h: ft, rad, deg, deg, deg, lb."""
SLOPES = np.dtype(
    [
        *((bound, float, (_UNKNOWNS, 2)) for bound in ("lower", "upper", "held")),
        *((name, float, (2,)) for name in QUANTITIES),
    ]
)
"""``gtm_slopes``: each pair is (below, above), where the quantity shrinks and where it grows."""


def end_slopes(
    altitude: float,
    gamma: float,
    lower: ArrayLike,
    upper: ArrayLike,
    objective: ArrayLike,
    y: ArrayLike,
    airframe: Airframe = STUDY,
) -> np.ndarray:
    """Derivatives (a `SLOPES`) of the least objective.y, of which y is the point that `solver.envelope_end` found.

    NaN where a quantity can not go, or where no manoeuvre is left inside the bounds.
    """
    given = [
        airframe.rows(values, name)
        for values, name in ((lower, "lower"), (upper, "upper"), (objective, "objective"), (y, "y"))
    ]
    found = np.zeros((), SLOPES)
    at = ctypes.c_double(altitude), ctypes.c_double(gamma)
    library().gtm_end_slopes(*airframe.arguments, *at, *(address(array) for array in given), address(found))
    return found
