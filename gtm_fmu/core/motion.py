"""State derivatives, outputs and their exact Jacobians (SPEC 2-8) in the specification's units.

Arrays of any leading shape: x (.., 12) in the order of `names.STATES`, u (.., 4) in that of `names.CONTROLS`.
At a table breakpoint a Jacobian is the one-sided slope of the interval above.
"""

import ctypes

import numpy as np
from numpy.typing import ArrayLike

from gtm_fmu.airframe.names import CONTROLS, OUTPUTS, STATES
from gtm_fmu.core.library import address, library, rows

NX, NU, NY = len(STATES), len(CONTROLS), len(OUTPUTS)
BAD_STEP = 6  # enum gtm_fault
MOST_SUBSTEPS = 1_000_000  # GTM_SUBSTEPS of gtm_core.h


def _rows(x: ArrayLike, u: ArrayLike) -> tuple[np.ndarray, np.ndarray, tuple[int, ...]]:
    x, u = rows(x, NX, "x"), rows(u, NU, "u")
    if x.shape[:-1] != u.shape[:-1]:
        leading = np.broadcast_shapes(x.shape[:-1], u.shape[:-1])
        x = np.ascontiguousarray(np.broadcast_to(x, (*leading, NX)))
        u = np.ascontiguousarray(np.broadcast_to(u, (*leading, NU)))
    return x, u, x.shape[:-1]


def _call(name: str, x: ArrayLike, u: ArrayLike, *widths: tuple[int, ...]) -> list[np.ndarray]:
    x, u, leading = _rows(x, u)
    results = [np.empty((*leading, *width)) for width in widths]
    count = ctypes.c_long(int(np.prod(leading)))
    getattr(library(), name)(count, address(x), address(u), *(address(result) for result in results))
    return results


def derivatives(x: ArrayLike, u: ArrayLike) -> np.ndarray:
    """State derivatives (.., 12) per second."""
    return _call("gtm_derivatives_batch", x, u, (NX,))[0]


def outputs(x: ArrayLike, u: ArrayLike) -> np.ndarray:
    """Outputs (.., 15) in the order and units of `names.OUTPUTS`."""
    return _call("gtm_outputs_batch", x, u, (NY,))[0]


def jacobian(x: ArrayLike, u: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """State derivatives (.., 12) and their derivatives (.., 12, 16) with respect to (x, u)."""
    dx, slopes = _call("gtm_jacobian_batch", x, u, (NX,), (NX, NX + NU))
    return dx, slopes


def outputs_jacobian(x: ArrayLike, u: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Outputs (.., 15) and their derivatives (.., 15, 16) with respect to (x, u)."""
    y, slopes = _call("gtm_outputs_jacobian_batch", x, u, (NY,), (NY, NX + NU))
    return y, slopes


def state_fault(x: ArrayLike) -> int:
    """Why a state (12) has no derivatives: 0 none, else a code of ``enum gtm_fault`` in gtm_core.h."""
    state = rows(x, NX, "x")
    if state.ndim != 1:
        raise ValueError(f"x has shape {state.shape}; give one state of length {NX}.")
    return library().gtm_state_fault(address(state))


def advance(x: ArrayLike, u: ArrayLike, duration_s: float, substep_s: float) -> np.ndarray:
    """State (12) after ``duration_s`` with constant controls u (4), by Runge-Kutta steps of ``substep_s``.

    Raises:
        ValueError: a substep that is not positive, a negative duration, or more than `MOST_SUBSTEPS`.
        FloatingPointError: a state on the way has no derivatives (see `state_fault`).
    """
    moved, u = rows(x, NX, "x").copy(), rows(u, NU, "u")
    duration, substep = ctypes.c_double(duration_s), ctypes.c_double(substep_s)
    fault = library().gtm_advance(address(moved), address(u), duration, substep)
    if fault == BAD_STEP:
        raise ValueError(
            f"Cannot advance by {duration_s} s in steps of {substep_s} s; give positive numbers, and {MOST_SUBSTEPS} "
            "steps at most in one call."
        )
    if fault:
        raise FloatingPointError(f"A state without derivatives is met on the way (fault {fault}, see gtm_core.h).")
    return moved
