"""Steady manoeuvres: trims and extremes on the trim manifold, in the specification's units.

An unknown vector y (9) follows `names.TRIM_UNKNOWNS`; bounds lower <= y <= upper, equal bounds hold an unknown.
"""

import ctypes
from typing import NamedTuple

import numpy as np

from gtm_fmu.airframe.names import CONTROLS, STATES, TRIM_UNKNOWNS
from gtm_fmu.core.library import address, library, rows

NT = len(TRIM_UNKNOWNS)
TRIMMED, OUTSIDE, NO_TRIM = 0, 1, 2
"""F = 0 inside the bounds; F = 0 only outside of them; F = 0 nowhere found (``enum gtm_trim_status``)."""


class Solutions(NamedTuple):
    """Unknowns (n, 9), largest acceleration (n), excess over the bounds in scale units (n), status (n)."""

    y: np.ndarray
    residual: np.ndarray
    violation: np.ndarray
    status: np.ndarray


def scale() -> np.ndarray:
    """Typical size of each unknown (9); violations and tolerances are in these units."""
    return np.array((ctypes.c_double * NT).in_dll(library(), "gtm_scale"))


def _bounds(lower, upper) -> tuple[np.ndarray, np.ndarray]:
    return rows(lower, NT, "lower"), rows(upper, NT, "upper")


def trims(altitude, gamma, lower, upper) -> Solutions:
    """Trims with the least sideslip: altitude (n) in ft, gamma (n) in rad, bounds (n, 9) that hold V and psi_dot."""
    altitude, gamma = np.ascontiguousarray(altitude, dtype=float), np.ascontiguousarray(gamma, dtype=float)
    lower, upper = _bounds(lower, upper)
    n = len(altitude)
    if not gamma.shape == (n,) or not lower.shape == upper.shape == (n, NT):
        raise ValueError("altitude, gamma, lower and upper must agree in their number of rows.")
    found = Solutions(np.empty((n, NT)), np.empty(n), np.empty(n), np.empty(n, dtype=np.int32))
    arguments = (altitude, gamma, lower, upper, *found)
    library().gtm_trim_batch(ctypes.c_long(n), *(address(array) for array in arguments))
    return found


def cold_starts(altitude: float, gamma: float, held) -> np.ndarray:
    """Points of the trim manifold (m <= n, 9) at rows (V, phi, rudder) of ``held`` (n, 3), whatever the bounds."""
    held = rows(held, 3, "held")
    y = np.empty((len(held), NT))
    solve = library().gtm_cold_starts
    solve.restype = ctypes.c_long
    count = ctypes.c_long(len(held))
    found = solve(ctypes.c_double(altitude), ctypes.c_double(gamma), count, address(held), address(y))
    return y[:found]


class Extreme(NamedTuple):
    """Best point y (9), its excess over the bounds in scale units and its status."""

    y: np.ndarray
    violation: float
    status: int


def _search(name: str, altitude: float, gamma: float, lower, upper, objective, *starts) -> Extreme:
    lower, upper = _bounds(lower, upper)
    objective = rows(objective, NT, "objective")
    y, violation = np.full(NT, np.nan), ctypes.c_double(np.inf)
    status = getattr(library(), name)(
        ctypes.c_double(altitude),
        ctypes.c_double(gamma),
        address(lower),
        address(upper),
        address(objective),
        *starts,
        address(y),
        ctypes.byref(violation),
    )
    return Extreme(y, violation.value, status)


def extreme(altitude: float, gamma: float, lower, upper, objective, starts) -> Extreme:
    """Least objective.y on the trim manifold inside the bounds, the best of all ``starts`` (n, 9).

    Without a point inside the bounds, the one that exceeds them least.
    """
    starts = rows(starts, NT, "starts")
    count = ctypes.c_long(len(starts))
    return _search("gtm_extreme", altitude, gamma, lower, upper, objective, count, address(starts))


def envelope_end(altitude: float, gamma: float, lower, upper, objective) -> Extreme:
    """The same from starts of its own, over the whole range and then about the best point found."""
    return _search("gtm_envelope_end", altitude, gamma, lower, upper, objective)


def trim_states(altitude: float, gamma: float, y) -> tuple[np.ndarray, np.ndarray]:
    """States x (.., 12) and controls u (.., 4) of steady manoeuvres y (.., 9) at altitude in ft and gamma in rad."""
    y = rows(y, NT, "y")
    leading = y.shape[:-1]
    x, u = np.empty((*leading, len(STATES))), np.empty((*leading, len(CONTROLS)))
    at = ctypes.c_double(altitude), ctypes.c_double(gamma), ctypes.c_long(int(np.prod(leading)))
    library().gtm_trim_states(*at, address(y), address(x), address(u))
    return x, u


class Grid(NamedTuple):
    """Which cells (n, m) of speed and turn rate have a trim, and their unknowns (n, m, 9), NaN elsewhere."""

    feasible: np.ndarray
    y: np.ndarray


def grid(altitude: float, gamma: float, lower, upper, speed, rate, seeds) -> Grid:
    """Trims with the least sideslip at speeds (n) in ft/s and turn rates (m) in rad/s, both rising.

    Cells are reached from the ``seeds`` (k, 9), trims inside the bounds, through neighbours that have a trim.
    """
    lower, upper = _bounds(lower, upper)
    speed, rate = (np.ascontiguousarray(axis, dtype=float) for axis in (speed, rate))
    seeds = rows(seeds, NT, "seeds")
    feasible, y = np.zeros((len(speed), len(rate)), dtype=np.uint8), np.full((len(speed), len(rate), NT), np.nan)
    solve = library().gtm_grid
    solve.restype = ctypes.c_long
    found = solve(
        ctypes.c_double(altitude),
        ctypes.c_double(gamma),
        address(lower),
        address(upper),
        ctypes.c_long(len(speed)),
        address(speed),
        ctypes.c_long(len(rate)),
        address(rate),
        ctypes.c_long(len(seeds)),
        address(seeds),
        address(feasible),
        address(y),
    )
    if found < 0:
        raise MemoryError("No memory for the grid; ask for fewer cells.")
    return Grid(feasible.astype(bool), y)
