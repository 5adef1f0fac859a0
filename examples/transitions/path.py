"""The reference of a transition: steady manoeuvres on a straight line in speed, flight path and turn rate."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gtm_fmu.aircraft import ranges
from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.ranges import Range
from gtm_fmu.envelopes.manoeuvres import Manoeuvres, manoeuvres
from gtm_fmu.errors import InputError
from gtm_fmu.units import FT_S_PER_KT, RAD_PER_DEG

CHECKED_S = 0.05
"""Between points of the path that are asked for their trim."""
SETTLE_S = 10.0
"""At the target, after the reference has stopped."""
_PEAK = 15 / 8  # greatest over mean slope of `_smooth_step`


class Manoeuvre(NamedTuple):
    """A steady manoeuvre: kn true airspeed, deg, deg/s positive to the right."""

    tas_kt: float
    gamma_deg: float = 0.0
    turn_rate_deg_s: float = 0.0

    def __str__(self) -> str:
        """In words."""
        return (
            f"{self.tas_kt:.1f} kn, flight path {self.gamma_deg:.1f} deg and {self.turn_rate_deg_s:.1f} deg/s of turn"
        )


class Rates(NamedTuple):
    """Fastest motion of the reference: kn/s, deg/s, deg/s^2."""

    tas: float = 1.0
    gamma: float = 1.0
    turn_rate: float = 0.5


DEFAULT_RATES = Rates()


def _smooth_step(part: np.ndarray) -> np.ndarray:
    """From 0 to 1 without a jump of speed or acceleration: least jerk."""
    return part**3 * (10 - 15 * part + 6 * part**2)


@dataclass(frozen=True)
class Path:
    """The trims of a reference (n) and when they are asked for, every `CHECKED_S` about.

    Attributes:
        time_s: (n); it moves until ``moving_s`` and stays at the target for `SETTLE_S`.
        altitude_ft: (n), where steady climbs and descents lead to.
        trims: some may be infeasible. Beyond the altitudes that may be asked for they are those at the nearest one.
    """

    time_s: np.ndarray
    moving_s: float
    altitude_ft: np.ndarray
    trims: Manoeuvres

    @property
    def refusal(self) -> int | None:
        """The first manoeuvre that the limits do not leave; None if all exist."""
        return None if self.trims.feasible.all() else int(np.argmin(self.trims.feasible))

    def manoeuvre(self, k: int) -> Manoeuvre:
        """The ``k``-th one."""
        return Manoeuvre(*(float(column[k]) for column in self.trims.asked[1:]))


def straight_path(
    altitude_ft: float,
    start: Manoeuvre,
    target: Manoeuvre,
    failure: Failure,
    rates: Rates,
    alpha_deg: Range,
    phi_deg: Range,
) -> Path:
    """The path from ``start`` to ``target``.

    Raises:
        InputError: an altitude, a manoeuvre or bounds outside what is allowed, or rates that are not positive.
    """
    ranges.check_range("altitude in ft", altitude_ft, ranges.ALTITUDE_FT)
    if not min(rates) > 0:
        raise InputError(f"The reference moves by {', '.join(map(str, rates))}; give positive kn/s, deg/s and deg/s^2.")
    for manoeuvre in (start, target):
        ranges.check_range("tas in kn", manoeuvre.tas_kt, ranges.TAS_KT)
        ranges.check_range("gamma in deg", manoeuvre.gamma_deg, ranges.GAMMA_DEG)
        ranges.check_range("turn rate in deg/s", manoeuvre.turn_rate_deg_s, ranges.TURN_RATE_DEG_S)
    changes = np.subtract(target, start)
    moving_s = _PEAK * float(np.max(np.abs(changes) / rates))
    time_s = np.linspace(0.0, moving_s + SETTLE_S, 1 + int(np.ceil((moving_s + SETTLE_S) / CHECKED_S)))
    part = np.clip(time_s / moving_s, 0, 1) if moving_s else np.ones_like(time_s)
    tas, gamma, turn_rate = (np.array(start) + np.outer(_smooth_step(part), changes)).T
    climb = tas * FT_S_PER_KT * np.sin(gamma * RAD_PER_DEG)
    altitude = altitude_ft + np.append(0.0, np.cumsum(np.diff(time_s) * (climb[1:] + climb[:-1]) / 2))
    trims = manoeuvres(np.clip(altitude, *ranges.ALTITUDE_FT), tas, gamma, turn_rate, failure, alpha_deg, phi_deg)
    return Path(time_s, moving_s, altitude, trims)
