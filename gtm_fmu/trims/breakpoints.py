"""Slopes on both sides of the breakpoints of the aerodynamic tables that trims lie on.

The tables are multilinear, so that at a breakpoint the slope with respect to its own variable jumps, and no other one
does: the slopes on any sides of several breakpoints are those of one plus a jump for each. Most straight trims with a
free rudder lie on one (beta = 0), and every straight trim on those of the three rates.

Which unknowns lie on a breakpoint the core tells, of the rates only zero is looked at; a breakpoint counts where the
slopes do jump.
"""

from collections.abc import Callable, Iterator, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np

from gtm_fmu.airframe.names import ALPHA, BETA, LINEAR_STATES, PSI_DOT, STATES, TRIM_UNKNOWNS
from gtm_fmu.core import solver
from gtm_fmu.core.solver import Airframe
from gtm_fmu.units import DEG_PER_RAD

BELOW, ABOVE = 0, 1

_SURFACES = tuple(TRIM_UNKNOWNS.index(name) for name in ("elevator", "aileron", "rudder"))
_RATES = ("p", "q", "r")
_STANDS_STILL = 1e-9  # of a typical rate: rounding


class Reach(NamedTuple):
    """How far to each side slopes are taken, in typical sizes; the least jump that counts, of the largest slope."""

    step: float
    jump: float


EXACT = Reach(1e-8, 1e-7)
DIFFERENCES = Reach(2e-5, 2e-4)
"""For first-order differences over an FMU, whose own steps must not cross the breakpoint."""


class Breakpoint(NamedTuple):
    """A breakpoint that some of the trims lie on.

    Attributes:
        name: of the variable, with its unit.
        value: where the breakpoint is; of many trims that of the first.
        rows: (k) the trims.
        jumps: (2, k, ..) what the slopes below and above are more than those at the trims.
    """

    name: str
    value: float
    rows: np.ndarray
    jumps: np.ndarray

    def __str__(self) -> str:
        """As ``beta_deg = 0``."""
        return f"{self.name} = {self.value:.6g}"


def breakpoints(
    slopes: Callable[[np.ndarray, np.ndarray], np.ndarray],
    at: tuple[float, float],
    y: np.ndarray,
    airframe: Airframe,
    inputs: tuple[str, ...],
    weights: np.ndarray,
    reach: Reach = EXACT,
) -> list[Breakpoint]:
    """The breakpoints that trims y (n, 9 or 10, core units) at altitude in ft and gamma in rad lie on.

    Args:
        slopes: of states x (k, 12) and controls u (k, ..), an array (k, 8, m) with columns `LINEAR_STATES` and inputs.
        weights: (8, m) that make the slopes comparable.
    """
    x, u = solver.trim_states(*at, y, airframe)
    here, found = slopes(x, u), []
    for name, moving, is_on, values, move in _candidates(at, y, x, u, airframe):
        rows, is_moving = np.flatnonzero(is_on), np.isin((*LINEAR_STATES, *inputs), moving)
        if not (len(rows) and is_moving.any()):
            continue
        sides = (move(rows, side * reach.step) for side in (-1, 1))
        jumps = np.stack([slopes(*side) - here[rows] for side in sides]) * is_moving
        size = np.abs(jumps * weights).max(axis=(2, 3))  # (2, k)
        jumps[size == size.min(axis=0)] = 0.0  # the trim itself has the slopes of this side, but for rounding
        counts = size.max(axis=0) > reach.jump * np.abs(here[rows] * weights).max(axis=(1, 2))
        if counts.any():
            found.append(Breakpoint(name, float(values[rows[counts][0]]), rows[counts], jumps[:, counts]))
    return found


def on_each_side(
    slopes: np.ndarray, found: Sequence[Breakpoint]
) -> Iterator[tuple[np.ndarray, dict[int, int], np.ndarray]]:
    """Slopes (n, ..) on every combination of sides: which trims (k), the side of each breakpoint, their slopes (k, ..).

    A trim on no breakpoint comes once. The last combination of each has all sides above.
    """
    lies_on = np.zeros((len(slopes), len(found)), dtype=bool)
    for number, breakpoint in enumerate(found):
        lies_on[breakpoint.rows, number] = True
    patterns = lies_on @ (1 << np.arange(len(found))[::-1])
    for pattern in sorted(set(patterns.tolist())):
        rows = np.flatnonzero(patterns == pattern)
        numbers = np.flatnonzero(lies_on[rows[0]]).tolist()
        for sides in product((BELOW, ABOVE), repeat=len(numbers)):
            there = slopes[rows].copy()
            for number, side in zip(numbers, sides, strict=True):
                places = np.searchsorted(found[number].rows, rows)
                there += found[number].jumps[side, places]
            yield rows, dict(zip(numbers, sides, strict=True)), there


def _candidates(
    at: tuple[float, float], y: np.ndarray, x: np.ndarray, u: np.ndarray, airframe: Airframe
) -> Iterator[tuple]:
    """Variables whose tables may have a breakpoint at a trim.

    The name with its unit, the states and inputs that move it, which trims (n) lie there, where that is (n), and a
    function that gives states and controls beside it.
    """
    altitude_ft, gamma = at
    scale, is_on = solver.scale(airframe), solver.on_breakpoints(y, airframe)

    def along_unknown(k: int) -> Callable:
        def move(rows: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray]:
            moved = y[rows].copy()
            moved[:, k] += step * scale[k]
            return solver.trim_states(altitude_ft, gamma, moved, airframe)

        return move

    def along_rate(column: int) -> Callable:
        def move(rows: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray]:
            moved = x[rows].copy()
            moved[:, column] = step * scale[PSI_DOT]
            return moved, u[rows]

        return move

    for k in (ALPHA, BETA, *_SURFACES):
        name, is_flow = TRIM_UNKNOWNS[k], k in (ALPHA, BETA)
        moving, factor = (("u", "v", "w"), DEG_PER_RAD) if is_flow else ((name,), 1.0)
        yield f"{name}_deg", moving, is_on[:, k], y[:, k] * factor, along_unknown(k)
    for name in _RATES:
        column = STATES.index(name)
        stands_still = np.abs(x[:, column]) <= _STANDS_STILL * scale[PSI_DOT]
        yield f"{name}_deg_s", (name,), stands_still, np.zeros(len(x)), along_rate(column)
