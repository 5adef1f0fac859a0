"""Sections of the four-dimensional envelope of steady manoeuvres (paper eq. 10).

A section is where along one of speed, flight path and turn rate, the others given, a steady manoeuvre exists. Gaps are
kept: it may be several intervals.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from gtm_fmu.aircraft import ranges
from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.aircraft.ranges import ALPHA_DEG, PHI_DEG, Range
from gtm_fmu.core import sections
from gtm_fmu.trims import manoeuvre
from gtm_fmu.trims.manoeuvre import Trim
from gtm_fmu.units import DEG_PER_RAD, KT_PER_FT_S, RAD_PER_DEG

_END_TOLERANCE = 1e-4  # of an unknown's typical size: the core finds an end to 1e-5 of that of what varies

_FACTORS = {sections.TURN_RATES: DEG_PER_RAD, sections.SPEEDS: KT_PER_FT_S, sections.CLIMBS: DEG_PER_RAD}
_NAMES = {
    sections.TURN_RATES: "turn_rate_deg_s",
    sections.SPEEDS: "tas_kt",
    sections.CLIMBS: "gamma_deg",
}


@dataclass(frozen=True)
class Section:
    """Intervals of one variable, in rising order.

    Attributes:
        name: of the variable with its unit: ``turn_rate_deg_s``, ``tas_kt`` or ``gamma_deg``.
        intervals: lower and upper end of each; none where no manoeuvre exists.
        trims: those at both ends of each.
    """

    name: str
    intervals: tuple[Range, ...]
    trims: tuple[tuple[Trim, Trim], ...]

    def __contains__(self, value: float) -> bool:
        """Whether a manoeuvre exists at this value."""
        return any(low <= value <= high for low, high in self.intervals)

    def to_dict(self) -> dict[str, Any]:
        """All values, ready for JSON."""
        ends = [{"lower": low.to_dict(), "upper": high.to_dict()} for low, high in self.trims]
        return {"variable": self.name, "intervals": [list(interval) for interval in self.intervals], "trims": ends}


def turn_rate_interval(
    altitude_ft: float,
    tas_kt: float,
    gamma_deg: float = 0.0,
    limits: ControlLimits | Failure | None = None,
    alpha_deg: Range = ALPHA_DEG,
    phi_deg: Range = PHI_DEG,
) -> Section:
    """Turn rates in deg/s at a speed and a flight path.

    Args:
        altitude_ft: geometric altitude in ft.
        tas_kt: true airspeed in kn.
        gamma_deg: flight-path angle in deg, positive in a climb.
        limits: what the failure leaves of the controls, or a whole `Failure`; None: nothing has failed.
        alpha_deg: least and greatest angle of attack in deg.
        phi_deg: least and greatest bank in deg.

    Raises:
        InputError: a value outside what is allowed.
    """
    return _section(sections.TURN_RATES, altitude_ft, gamma_deg, tas_kt, None, limits, alpha_deg, phi_deg)


def speed_interval(
    altitude_ft: float,
    gamma_deg: float = 0.0,
    turn_rate_deg_s: float = 0.0,
    limits: ControlLimits | Failure | None = None,
    alpha_deg: Range = ALPHA_DEG,
    phi_deg: Range = PHI_DEG,
) -> Section:
    """True airspeeds in kn at a turn rate and a flight path.

    Args:
        altitude_ft: geometric altitude in ft.
        gamma_deg: flight-path angle in deg, positive in a climb.
        turn_rate_deg_s: turn rate in deg/s, positive to the right.
        limits: what the failure leaves of the controls, or a whole `Failure`; None: nothing has failed.
        alpha_deg: least and greatest angle of attack in deg.
        phi_deg: least and greatest bank in deg.

    Raises:
        InputError: a value outside what is allowed.
    """
    return _section(sections.SPEEDS, altitude_ft, gamma_deg, None, turn_rate_deg_s, limits, alpha_deg, phi_deg)


def climb_interval(
    altitude_ft: float,
    tas_kt: float,
    turn_rate_deg_s: float = 0.0,
    limits: ControlLimits | Failure | None = None,
    alpha_deg: Range = ALPHA_DEG,
    phi_deg: Range = PHI_DEG,
) -> Section:
    """Flight-path angles in deg at a speed and a turn rate.

    Args:
        altitude_ft: geometric altitude in ft.
        tas_kt: true airspeed in kn.
        turn_rate_deg_s: turn rate in deg/s, positive to the right.
        limits: what the failure leaves of the controls, or a whole `Failure`; None: nothing has failed.
        alpha_deg: least and greatest angle of attack in deg.
        phi_deg: least and greatest bank in deg.

    Raises:
        InputError: a value outside what is allowed.
    """
    return _section(sections.CLIMBS, altitude_ft, 0.0, tas_kt, turn_rate_deg_s, limits, alpha_deg, phi_deg)


def _section(
    kind: int,
    altitude_ft: float,
    gamma_deg: float,
    tas_kt: float | None,
    turn_rate_deg_s: float | None,
    limits: ControlLimits | Failure | None,
    alpha_deg: Range,
    phi_deg: Range,
) -> Section:
    altitude_ft = ranges.check_range("altitude in ft", altitude_ft, ranges.ALTITUDE_FT)
    gamma_deg = ranges.check_range("gamma in deg", gamma_deg, ranges.GAMMA_DEG)
    failure = Failure.of(limits)
    tas = ranges.TAS_KT if tas_kt is None else (tas_kt, tas_kt)
    rates = ranges.TURN_RATE_DEG_S if turn_rate_deg_s is None else (turn_rate_deg_s, turn_rate_deg_s)
    lower, upper = manoeuvre.bounds(failure, alpha_deg, phi_deg, tas, rates)
    within = {
        sections.TURN_RATES: ranges.TURN_RATE_DEG_S,
        sections.SPEEDS: ranges.TAS_KT,
        sections.CLIMBS: ranges.GAMMA_DEG,
    }[kind]
    factor, gamma = _FACTORS[kind], gamma_deg * RAD_PER_DEG
    least, most = (end / factor for end in within)
    found = sections.section(kind, altitude_ft, gamma, lower, upper, (least, most), failure.airframe)

    def trim(value: float, y: np.ndarray) -> Trim:
        hit = manoeuvre.limits_hit(y, lower, upper, failure.airframe, _END_TOLERANCE)
        at_gamma = value * DEG_PER_RAD if kind == sections.CLIMBS else gamma_deg
        return Trim.of_unknowns(y, altitude_ft, at_gamma, True, hit, failure)

    return Section(
        _NAMES[kind],
        tuple((float(low * factor), float(high * factor)) for low, high in found.ends),
        tuple((trim(low, y[0]), trim(high, y[1])) for (low, high), y in zip(found.ends.tolist(), found.y, strict=True)),
    )
