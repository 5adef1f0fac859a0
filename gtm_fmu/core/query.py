"""Can manoeuvres be flown: trims with margins to every limit, stability and controllability; the core's units."""

import ctypes

import numpy as np
from numpy.typing import ArrayLike

from gtm_fmu.airframe.names import TWO_THROTTLE_UNKNOWNS
from gtm_fmu.core.library import address, library
from gtm_fmu.core.solver import STUDY, Airframe

_UNKNOWNS = len(TWO_THROTTLE_UNKNOWNS)

ANSWER = np.dtype(
    [
        *((name, np.int32) for name in ("status", "stable", "controllable", "binding", "side")),
        ("least_margin", float),
        ("y", float, _UNKNOWNS),
        ("margin", float, (_UNKNOWNS, 2)),
        ("thrust", float),
        ("thrust_margin", float, 2),
        ("residual", float),
        ("violation", float),
    ],
    align=True,
)
"""``gtm_answer`` of gtm_query.h, which says what each means."""


def query(
    altitude: ArrayLike, gamma: ArrayLike, lower: ArrayLike, upper: ArrayLike, airframe: Airframe = STUDY
) -> np.ndarray:
    """Answers (n) of `ANSWER`, for altitude (n) in ft and gamma (n) in rad.

    Bounds (n, 9 or 10) hold V and psi_dot at what is asked; the others are the limits.
    """
    altitude, gamma = np.ascontiguousarray(altitude, dtype=float), np.ascontiguousarray(gamma, dtype=float)
    lower, upper = airframe.rows(lower, "lower"), airframe.rows(upper, "upper")
    n = len(altitude)
    if not gamma.shape == (n,) or not lower.shape == upper.shape == (n, len(airframe.unknowns)):
        raise ValueError("altitude, gamma, lower and upper must agree in their number of rows.")
    answers = np.zeros(n, ANSWER)
    arrays = (altitude, gamma, lower, upper, answers)
    library().gtm_query(*airframe.arguments, ctypes.c_long(n), *(address(array) for array in arrays))
    return answers


def assess(
    altitude: float, gamma: float, lower: ArrayLike, upper: ArrayLike, y: ArrayLike, airframe: Airframe = STUDY
) -> tuple[np.ndarray, np.ndarray]:
    """Whether trims y (n, 9 or 10) are stable (n) and controllable (n), on all sides of the breakpoints they lie on.

    Controls whose bounds (9 or 10) are equal are no inputs.
    """
    lower, upper, y = airframe.rows(lower, "lower"), airframe.rows(upper, "upper"), airframe.rows(y, "y")
    verdicts = np.empty((2, len(y)), dtype=bool)
    at = ctypes.c_double(altitude), ctypes.c_double(gamma), address(lower), address(upper), ctypes.c_long(len(y))
    library().gtm_assess(*airframe.arguments, *at, address(y), address(verdicts[0]), address(verdicts[1]))
    return verdicts[0], verdicts[1]
