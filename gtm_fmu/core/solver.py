"""Steady manoeuvres: trims and extremes on the trim manifold, in the specification's units.

An unknown vector y follows the `unknowns` of an `Airframe`; bounds lower <= y <= upper, equal bounds hold an unknown.
Controls that move nothing, their surfaces lost or their engines out, are held as near to zero as their bounds let
them.
"""

import ctypes
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from gtm_fmu.airframe.names import CONTROLS, STATES, TRIM_UNKNOWNS, TWO_THROTTLE_CONTROLS, TWO_THROTTLE_UNKNOWNS
from gtm_fmu.core.configuration import Configuration, reference
from gtm_fmu.core.library import address, library, rows

NT, TWO_THROTTLE_NT = len(TRIM_UNKNOWNS), len(TWO_THROTTLE_UNKNOWNS)
ONE_THROTTLE, TWO_THROTTLES = 1, 2
"""For the engines that run; one for each engine (``enum gtm_throttles``)."""
TRIMMED, OUTSIDE, NO_TRIM = 0, 1, 2
"""F = 0 inside the bounds; F = 0 only outside of them; F = 0 nowhere found (``enum gtm_trim_status``)."""


class Airframe(NamedTuple):
    """What is trimmed: a configuration, or the study's (None), which the core knows best; and how many throttles."""

    configuration: Configuration | None = None
    throttles: int = ONE_THROTTLE

    @property
    def unknowns(self) -> tuple[str, ...]:
        """Names of the unknowns (9 or 10) of a trim."""
        return TRIM_UNKNOWNS if self.throttles == ONE_THROTTLE else TWO_THROTTLE_UNKNOWNS

    def rows(self, values: ArrayLike, name: str) -> np.ndarray:
        """Values as an array (.., 9 or 10).

        Raises:
            ValueError: there is another number of unknowns.
        """
        return rows(values, len(self.unknowns), name)

    @property
    def arguments(self) -> tuple:
        """The first arguments of the core's solvers."""
        configuration = self.configuration
        if configuration is None and self.throttles == TWO_THROTTLES:
            configuration = Configuration()
        return reference(configuration) if configuration is not None else None, ctypes.c_int(self.throttles)


STUDY = Airframe()


class Solutions(NamedTuple):
    """Unknowns (n, 9 or 10), largest acceleration (n), excess over the bounds in scale units (n), status (n)."""

    y: np.ndarray
    residual: np.ndarray
    violation: np.ndarray
    status: np.ndarray


def scale(airframe: Airframe = STUDY) -> np.ndarray:
    """Typical size of each unknown (9 or 10); violations and tolerances are in these units."""
    return np.array((ctypes.c_double * TWO_THROTTLE_NT).in_dll(library(), "gtm_scale"))[: len(airframe.unknowns)]


def with_both_throttles(y: ArrayLike, airframe: Airframe = STUDY) -> np.ndarray:
    """Unknowns (.., 10) of y (.., 9 or 10)."""
    y = airframe.rows(y, "y")
    return np.concatenate([y, y[..., -1:]], axis=-1) if airframe.throttles == ONE_THROTTLE else y


def dead_controls(configuration: Configuration) -> tuple[bool, ...]:
    """Which of `names.TWO_THROTTLE_CONTROLS` move nothing: their surfaces are lost or jammed, their engine is out."""
    dead = np.zeros(TWO_THROTTLE_NT, dtype=np.uint8)
    library().gtm_dead_controls(reference(configuration), address(dead))
    return tuple(dead[-len(TWO_THROTTLE_CONTROLS) :].astype(bool).tolist())


def on_breakpoints(y: ArrayLike, airframe: Airframe = STUDY) -> np.ndarray:
    """Which unknowns of y (n, 9 or 10) lie on a breakpoint of an aerodynamic table (n, 9 or 10)."""
    y = airframe.rows(y, "y")
    is_on = np.empty(y.shape, dtype=np.uint8)
    count = ctypes.c_long(len(y))
    library().gtm_on_breakpoints(*airframe.arguments, count, address(y), address(is_on))
    return is_on.astype(bool)


def trims(
    altitude: ArrayLike, gamma: ArrayLike, lower: ArrayLike, upper: ArrayLike, airframe: Airframe = STUDY
) -> Solutions:
    """Trims with the least sideslip: altitude (n) in ft, gamma (n) in rad.

    Bounds (n, 9 or 10) hold two or three of V, psi_dot, phi, alpha and beta.
    """
    altitude, gamma = np.ascontiguousarray(altitude, dtype=float), np.ascontiguousarray(gamma, dtype=float)
    lower, upper = airframe.rows(lower, "lower"), airframe.rows(upper, "upper")
    n, unknowns = len(altitude), len(airframe.unknowns)
    if not gamma.shape == (n,) or not lower.shape == upper.shape == (n, unknowns):
        raise ValueError("altitude, gamma, lower and upper must agree in their number of rows.")
    found = Solutions(np.empty((n, unknowns)), np.empty(n), np.empty(n), np.empty(n, dtype=np.int32))
    arguments = (altitude, gamma, lower, upper, *found)
    library().gtm_trims(*airframe.arguments, ctypes.c_long(n), *(address(array) for array in arguments))
    return found


def cold_starts(altitude: float, gamma: float, held: ArrayLike, airframe: Airframe = STUDY) -> np.ndarray:
    """Points of the trim manifold (m <= n, 9 or 10) at rows (V, phi, rudder) of ``held`` (n, 3), without bounds."""
    held = rows(held, 3, "held")
    y = np.empty((len(held), len(airframe.unknowns)))
    solve = library().gtm_cold_starts
    solve.restype = ctypes.c_long
    at = ctypes.c_double(altitude), ctypes.c_double(gamma), ctypes.c_long(len(held))
    found = solve(*airframe.arguments, *at, address(held), address(y))
    return y[:found]


class Extreme(NamedTuple):
    """Best point y (9 or 10), its excess over the bounds in scale units and its status."""

    y: np.ndarray
    violation: float
    status: int


def _search(
    name: str,
    airframe: Airframe,
    altitude: float,
    gamma: float,
    lower: ArrayLike,
    upper: ArrayLike,
    objective: ArrayLike,
    *starts: ArrayLike,
) -> Extreme:
    lower, upper = airframe.rows(lower, "lower"), airframe.rows(upper, "upper")
    objective = airframe.rows(objective, "objective")
    y, violation = np.full(len(airframe.unknowns), np.nan), ctypes.c_double(np.inf)
    status = getattr(library(), name)(
        *airframe.arguments,
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
    altitude: float,
    gamma: float,
    lower: ArrayLike,
    upper: ArrayLike,
    objective: ArrayLike,
    starts: ArrayLike,
    airframe: Airframe = STUDY,
) -> Extreme:
    """Least objective.y on the trim manifold inside the bounds, the best of all ``starts`` (n, 9 or 10).

    Without a point inside the bounds, the one that exceeds them least.
    """
    starts = airframe.rows(starts, "starts")
    at = airframe, altitude, gamma, lower, upper, objective
    return _search("gtm_extreme", *at, ctypes.c_long(len(starts)), address(starts))


def envelope_end(
    altitude: float,
    gamma: float,
    lower: ArrayLike,
    upper: ArrayLike,
    objective: ArrayLike,
    airframe: Airframe = STUDY,
    is_thorough: bool = False,
) -> Extreme:
    """The same from starts of its own.

    ``is_thorough``: from many starts in each of the `rudder_pieces`; it takes six times as long and serves as a check.
    """
    name = "gtm_thorough_end" if is_thorough else "gtm_envelope_end"
    return _search(name, airframe, altitude, gamma, lower, upper, objective)


def rudder_pieces(lower: float, upper: float) -> list[tuple[float, float]]:
    """The pieces of a range of the rudder in deg between its breakpoints; the best of their ends is the range's."""
    most = 64
    border = (ctypes.c_double * (most + 1))()
    count = library().gtm_rudder_pieces(ctypes.c_double(lower), ctypes.c_double(upper), ctypes.c_int(most), border)
    return list(pairwise(border[: count + 1]))


def trim_states(
    altitude: float, gamma: float, y: ArrayLike, airframe: Airframe = STUDY
) -> tuple[np.ndarray, np.ndarray]:
    """States x (.., 12) and controls u (.., 4) of steady manoeuvres y (.., 9 or 10) at altitude in ft, gamma in rad.

    With a configuration u (.., 5) follows `names.TWO_THROTTLE_CONTROLS`, and x moves with its wind.
    """
    y = airframe.rows(y, "y")
    is_study = airframe == STUDY
    leading = y.shape[:-1]
    x = np.empty((*leading, len(STATES)))
    u = np.empty((*leading, len(CONTROLS if is_study else TWO_THROTTLE_CONTROLS)))
    at = ctypes.c_double(altitude), ctypes.c_double(gamma), ctypes.c_long(int(np.prod(leading)))
    arrays = address(y), address(x), address(u)
    if is_study:
        library().gtm_trim_states(*at, *arrays)
    else:
        library().gtm_configured_trim_states(*airframe.arguments, *at, *arrays)
    return x, u


class Grid(NamedTuple):
    """Which cells (n, m) of speed and turn rate have a trim, and their unknowns (n, m, 9 or 10), NaN elsewhere."""

    feasible: np.ndarray
    y: np.ndarray


def grid(
    altitude: float,
    gamma: float,
    lower: ArrayLike,
    upper: ArrayLike,
    speed: ArrayLike,
    rate: ArrayLike,
    seeds: ArrayLike,
    airframe: Airframe = STUDY,
) -> Grid:
    """Trims with the least sideslip at speeds (n) in ft/s and turn rates (m) in rad/s, both rising.

    Cells are reached from the ``seeds`` (k, 9 or 10), trims inside the bounds, through neighbours that have a trim.
    """
    lower, upper = airframe.rows(lower, "lower"), airframe.rows(upper, "upper")
    speed, rate = (np.ascontiguousarray(axis, dtype=float) for axis in (speed, rate))
    seeds = airframe.rows(seeds, "seeds")
    feasible = np.zeros((len(speed), len(rate)), dtype=np.uint8)
    y = np.full((len(speed), len(rate), len(airframe.unknowns)), np.nan)
    solve = library().gtm_grid
    solve.restype = ctypes.c_long
    found = solve(
        *airframe.arguments,
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
