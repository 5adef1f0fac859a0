"""Slopes of an envelope's ends by the multipliers of the optimum, in the core's units."""

import ctypes

import numpy as np
from numpy.typing import ArrayLike

from gtm_fmu.airframe.names import COEFFICIENTS, TWO_THROTTLE_UNKNOWNS
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


TOLERANCES = ("mass", *(f"cg_{axis}" for axis in "xyz"), *COEFFICIENTS)
"""What is not known for sure of a configuration, in the order of ``gtm_tolerance_slopes``: 1, ft, 1."""


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
    found = np.zeros((), SLOPES)
    _solve("gtm_end_slopes", found, altitude, gamma, (lower, upper, objective, y), airframe)
    return found


def tolerance_slopes(
    altitude: float,
    gamma: float,
    lower: ArrayLike,
    upper: ArrayLike,
    objective: ArrayLike,
    y: ArrayLike,
    airframe: Airframe = STUDY,
) -> np.ndarray:
    """The same with respect to each of `TOLERANCES`: (10, 2), each (below, above)."""
    found = np.zeros((len(TOLERANCES), 2))
    _solve("gtm_tolerance_slopes", found, altitude, gamma, (lower, upper, objective, y), airframe)
    return found


def _solve(
    name: str, found: np.ndarray, altitude: float, gamma: float, given: tuple[ArrayLike, ...], airframe: Airframe
) -> None:
    names = ("lower", "upper", "objective", "y")
    arrays = [airframe.rows(values, name) for values, name in zip(given, names, strict=True)]
    at = ctypes.c_double(altitude), ctypes.c_double(gamma)
    getattr(library(), name)(*airframe.arguments, *at, *(address(array) for array in arrays), address(found))
