"""Steady manoeuvres: trims and extremes on the trim manifold, in the specification's units.

An unknown vector y (9) follows `names.TRIM_UNKNOWNS`; bounds lower <= y <= upper, equal bounds hold an unknown.

Without a `configuration` the airframe is the study's. With one, y may also have 10 entries, a throttle for each engine
(`names.TWO_THROTTLE_UNKNOWNS`); the width of the bounds tells. With 9 one throttle drives the engines that run.
Controls that move nothing, their surfaces lost or their engines out, are held as near to zero as their bounds let
them.
"""

import ctypes
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from gtm_fmu.airframe.names import CONTROLS, STATES, TRIM_UNKNOWNS, TWO_THROTTLE_CONTROLS, TWO_THROTTLE_UNKNOWNS
from gtm_fmu.core.configuration import Configuration, reference
from gtm_fmu.core.library import address, library, rows

NT, TWO_THROTTLE_NT = len(TRIM_UNKNOWNS), len(TWO_THROTTLE_UNKNOWNS)
TRIMMED, OUTSIDE, NO_TRIM = 0, 1, 2
"""F = 0 inside the bounds; F = 0 only outside of them; F = 0 nowhere found (``enum gtm_trim_status``)."""

_MOST_PIECES = 64  # GTM_MOST_PIECES of solver/terms.h


class Solutions(NamedTuple):
    """Unknowns (n, 9 or 10), largest acceleration (n), excess over the bounds in scale units (n), status (n)."""

    y: np.ndarray
    residual: np.ndarray
    violation: np.ndarray
    status: np.ndarray


def scale(unknowns: int = NT) -> np.ndarray:
    """Typical size of each unknown (9 or 10); violations and tolerances are in these units."""
    return np.array((ctypes.c_double * TWO_THROTTLE_NT).in_dll(library(), "gtm_scale"))[:unknowns]


def with_both_throttles(y) -> np.ndarray:
    """Unknowns (.., 10) of y (.., 9 or 10)."""
    y = np.asarray(y, dtype=float)
    return np.concatenate([y, y[..., -1:]], axis=-1) if y.shape[-1] == NT else y


def dead_controls(configuration: Configuration) -> tuple[bool, ...]:
    """Which of `names.TWO_THROTTLE_CONTROLS` move nothing: their surfaces are lost or jammed, their engine is out."""
    dead = np.zeros(TWO_THROTTLE_NT, dtype=np.uint8)
    library().gtm_dead_controls(reference(configuration), address(dead))
    return tuple(dead[-len(TWO_THROTTLE_CONTROLS) :].astype(bool).tolist())


def on_breakpoints(y, configuration: Configuration | None = None) -> np.ndarray:
    """Which unknowns of y (n, 9 or 10) lie on a breakpoint of an aerodynamic table (n, 9 or 10)."""
    y = rows(y, _width(y), "y")
    is_on = np.empty(y.shape, dtype=np.uint8)
    count = ctypes.c_long(len(y))
    library().gtm_on_breakpoints(*_airframe(configuration, y.shape[-1]), count, address(y), address(is_on))
    return is_on.astype(bool)


def _width(array) -> int:
    """Number of unknowns that bounds or points have."""
    return TWO_THROTTLE_NT if np.shape(array)[-1:] == (TWO_THROTTLE_NT,) else NT


def _airframe(configuration: Configuration | None, unknowns: int) -> tuple:
    """First arguments of the core's solvers."""
    if configuration is None and unknowns == TWO_THROTTLE_NT:
        configuration = Configuration()
    return reference(configuration) if configuration is not None else None, ctypes.c_int(
        2 if unknowns == TWO_THROTTLE_NT else 1
    )


def _bounds(lower, upper) -> tuple[np.ndarray, np.ndarray]:
    return rows(lower, _width(lower), "lower"), rows(upper, _width(lower), "upper")


def trims(altitude, gamma, lower, upper, configuration: Configuration | None = None) -> Solutions:
    """Trims with the least sideslip: altitude (n) in ft, gamma (n) in rad.

    Bounds (n, 9 or 10) hold two or three of V, psi_dot, phi, alpha and beta.
    """
    altitude, gamma = np.ascontiguousarray(altitude, dtype=float), np.ascontiguousarray(gamma, dtype=float)
    lower, upper = _bounds(lower, upper)
    n, unknowns = len(altitude), lower.shape[-1]
    if not gamma.shape == (n,) or not lower.shape == upper.shape == (n, unknowns):
        raise ValueError("altitude, gamma, lower and upper must agree in their number of rows.")
    found = Solutions(np.empty((n, unknowns)), np.empty(n), np.empty(n), np.empty(n, dtype=np.int32))
    arguments = (altitude, gamma, lower, upper, *found)
    airframe = _airframe(configuration, unknowns)
    library().gtm_trims(*airframe, ctypes.c_long(n), *(address(array) for array in arguments))
    return found


def cold_starts(
    altitude: float, gamma: float, held, configuration: Configuration | None = None, unknowns: int = NT
) -> np.ndarray:
    """Points of the trim manifold (m <= n, 9) at rows (V, phi, rudder) of ``held`` (n, 3), whatever the bounds."""
    held = rows(held, 3, "held")
    y = np.empty((len(held), unknowns))
    solve = library().gtm_cold_starts
    solve.restype = ctypes.c_long
    at = ctypes.c_double(altitude), ctypes.c_double(gamma), ctypes.c_long(len(held))
    found = solve(*_airframe(configuration, unknowns), *at, address(held), address(y))
    return y[:found]


class Extreme(NamedTuple):
    """Best point y (9 or 10), its excess over the bounds in scale units and its status."""

    y: np.ndarray
    violation: float
    status: int


def _search(name: str, configuration, altitude: float, gamma: float, lower, upper, objective, *starts) -> Extreme:
    lower, upper = _bounds(lower, upper)
    unknowns = lower.shape[-1]
    objective = rows(objective, unknowns, "objective")
    y, violation = np.full(unknowns, np.nan), ctypes.c_double(np.inf)
    status = getattr(library(), name)(
        *_airframe(configuration, unknowns),
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


def extreme(
    altitude: float, gamma: float, lower, upper, objective, starts, configuration: Configuration | None = None
) -> Extreme:
    """Least objective.y on the trim manifold inside the bounds, the best of all ``starts`` (n, 9).

    Without a point inside the bounds, the one that exceeds them least.
    """
    starts = rows(starts, _width(lower), "starts")
    at = configuration, altitude, gamma, lower, upper, objective
    return _search("gtm_extreme", *at, ctypes.c_long(len(starts)), address(starts))


def envelope_end(
    altitude: float, gamma: float, lower, upper, objective, configuration: Configuration | None = None
) -> Extreme:
    """The same from starts of its own, over each of the `rudder_pieces` and then about the best point found."""
    return _search("gtm_envelope_end", configuration, altitude, gamma, lower, upper, objective)


def rudder_pieces(lower: float, upper: float) -> list[tuple[float, float]]:
    """The pieces in which `envelope_end` searches a range of the rudder in deg; the best of their ends is its own."""
    border = (ctypes.c_double * (_MOST_PIECES + 1))()
    count = library().gtm_rudder_pieces(ctypes.c_double(lower), ctypes.c_double(upper), border)
    return list(pairwise(border[: count + 1]))


def trim_states(
    altitude: float, gamma: float, y, configuration: Configuration | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """States x (.., 12) and controls u (.., 4) of steady manoeuvres y (.., 9) at altitude in ft and gamma in rad.

    With a configuration u (.., 5) follows `names.TWO_THROTTLE_CONTROLS`, and x moves with its wind.
    """
    y = rows(y, NT if configuration is None else _width(y), "y")
    leading = y.shape[:-1]
    x = np.empty((*leading, len(STATES)))
    u = np.empty((*leading, len(CONTROLS if configuration is None else TWO_THROTTLE_CONTROLS)))
    at = ctypes.c_double(altitude), ctypes.c_double(gamma), ctypes.c_long(int(np.prod(leading)))
    arrays = address(y), address(x), address(u)
    if configuration is None:
        library().gtm_trim_states(*at, *arrays)
    else:
        library().gtm_configured_trim_states(*_airframe(configuration, y.shape[-1]), *at, *arrays)
    return x, u


class Grid(NamedTuple):
    """Which cells (n, m) of speed and turn rate have a trim, and their unknowns (n, m, 9 or 10), NaN elsewhere."""

    feasible: np.ndarray
    y: np.ndarray


def grid(
    altitude: float, gamma: float, lower, upper, speed, rate, seeds, configuration: Configuration | None = None
) -> Grid:
    """Trims with the least sideslip at speeds (n) in ft/s and turn rates (m) in rad/s, both rising.

    Cells are reached from the ``seeds`` (k, 9), trims inside the bounds, through neighbours that have a trim.
    """
    lower, upper = _bounds(lower, upper)
    speed, rate = (np.ascontiguousarray(axis, dtype=float) for axis in (speed, rate))
    unknowns = lower.shape[-1]
    seeds = rows(seeds, unknowns, "seeds")
    feasible = np.zeros((len(speed), len(rate)), dtype=np.uint8)
    y = np.full((len(speed), len(rate), unknowns), np.nan)
    solve = library().gtm_grid
    solve.restype = ctypes.c_long
    found = solve(
        *_airframe(configuration, unknowns),
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
