"""Sections of the envelope of steady manoeuvres: intervals of turn rate, speed or flight path; the core's units."""

import ctypes
from typing import NamedTuple

import numpy as np

from gtm_fmu.airframe.names import TWO_THROTTLE_UNKNOWNS
from gtm_fmu.core.library import address, library
from gtm_fmu.core.solver import STUDY, Airframe

TURN_RATES, SPEEDS, CLIMBS = 0, 1, 2
"""What varies (``enum gtm_section_kind``): psi_dot in rad/s, V in ft/s, gamma in rad."""

_MOST, _UNKNOWNS = 8, len(TWO_THROTTLE_UNKNOWNS)
INTERVALS = np.dtype([("count", np.int32), ("end", float, (_MOST, 2)), ("y", float, (_MOST, 2, _UNKNOWNS))], align=True)
"""``gtm_intervals`` of gtm_sections.h."""


class Intervals(NamedTuple):
    """Ends (n, 2) of n intervals in rising order, and the trims (n, 2, 9 or 10) there."""

    ends: np.ndarray
    y: np.ndarray


def section(
    kind: int,
    altitude: float,
    gamma: float,
    lower: np.ndarray,
    upper: np.ndarray,
    within: tuple[float, float],
    airframe: Airframe = STUDY,
) -> Intervals:
    """The intervals inside ``within`` of what varies; the bounds (9 or 10) hold V and psi_dot unless they vary.

    Altitude in ft, gamma in rad, which `CLIMBS` does not look at.
    """
    lower, upper = airframe.rows(lower, "lower"), airframe.rows(upper, "upper")
    found = np.zeros((), INTERVALS)
    library().gtm_section(
        *airframe.arguments,
        ctypes.c_int(kind),
        ctypes.c_double(altitude),
        ctypes.c_double(gamma),
        address(lower),
        address(upper),
        ctypes.c_double(within[0]),
        ctypes.c_double(within[1]),
        address(found),
    )
    count = int(found["count"])
    return Intervals(found["end"][:count].copy(), found["y"][:count, :, : len(airframe.unknowns)].copy())
