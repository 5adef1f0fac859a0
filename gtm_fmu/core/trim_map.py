"""Envelopes with limits of every control by a table of trims: the core's trim map on NumPy arrays."""

import ctypes

import numpy as np
from numpy.typing import ArrayLike

from gtm_fmu.core.library import address, library, rows

VALUES = ("loading", "drag", "elevator", "aileron")
"""Of a node: 1 / EAS^2 in 1/kn^2, gross thrust of both engines / EAS^2 in lbf/kn^2, deg, deg."""
LIMITED = ("alpha", "bank", "elevator", "aileron", "rudder", "thrust")
"""What a case has a lower and an upper limit of, after altitude in ft and gamma in deg: deg, and lbf at sea level."""
_AXES = ("density", "gamma", "alpha", "bank", "rudder")


class _CoreTrimMap(ctypes.Structure):
    """``gtm_trim_map`` of trim_map.h."""

    _fields_ = (
        *((f"{name}s", ctypes.c_long) for name in _AXES),
        *((name, ctypes.c_void_p) for name in (*_AXES, "table")),
    )


def envelopes(nodes: tuple[np.ndarray, ...], table: np.ndarray, cases: ArrayLike) -> np.ndarray:
    """V_min and V_max (n, 2) in kn true airspeed, zeros without an envelope, of cases (n, 2 + 2 x 6) as in `LIMITED`.

    Cases of equal altitude and flight path that follow each other share work.

    Args:
        nodes: density ratios, gamma, alpha, bank and rudder in deg, each an array that is C-contiguous.
        table: (density, gamma, alpha, bank, rudder, 4) of `VALUES` in single precision; NaN where there is no trim.
    """
    cases = rows(cases, 2 + 2 * len(LIMITED), "cases")
    core_map = _CoreTrimMap(*map(len, nodes), *(axis.ctypes.data for axis in nodes), table.ctypes.data)
    memory, speeds = np.empty(table[0, 0].size), np.empty((len(cases), 2))
    arrays = address(cases), address(memory), address(speeds)
    library().gtm_trim_map_envelopes(ctypes.byref(core_map), ctypes.c_long(len(cases)), *arrays)
    return speeds
