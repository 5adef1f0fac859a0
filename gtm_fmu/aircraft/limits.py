"""Limits of the controls and of their rates, as plain data."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, fields

import numpy as np

from gtm_fmu.aircraft.ranges import FASTEST_DEG_S, WIDEST, Range
from gtm_fmu.errors import InputError


@dataclass(frozen=True)
class ControlLimits:
    """Lowest and highest position of each control; equal values are a jam (SPEC 9, paper eq. 29).

    Elevator, aileron and rudder in deg, throttle in %. The defaults are the undamaged aircraft.

    Raises:
        InputError: limits reversed, not finite, or wider than the undamaged aircraft's.
    """

    elevator_deg: Range = WIDEST["elevator_deg"]
    aileron_deg: Range = WIDEST["aileron_deg"]
    rudder_deg: Range = WIDEST["rudder_deg"]
    throttle_pct: Range = WIDEST["throttle_pct"]

    def __post_init__(self) -> None:
        """Check each pair and store it as floats."""
        for f in fields(self):
            object.__setattr__(self, f.name, checked_limits(f.name, getattr(self, f.name), WIDEST[f.name]))

    @property
    def lower(self) -> np.ndarray:
        """Lower limits (4) in the order of `names.CONTROLS`."""
        return np.array([getattr(self, f.name)[0] for f in fields(self)])

    @property
    def upper(self) -> np.ndarray:
        """Upper limits (4) in the order of `names.CONTROLS`."""
        return np.array([getattr(self, f.name)[1] for f in fields(self)])

    @property
    def jammed(self) -> tuple[bool, ...]:
        """Which controls cannot move, in the order of `names.CONTROLS`."""
        return tuple(bool(jam) for jam in self.lower == self.upper)


def checked_limits(field_name: str, limits: Iterable[float], widest: Range) -> Range:
    """Lower and upper limit as floats, for a field named ``<control>_<unit>``."""
    control, unit = field_name.rsplit("_", 1)
    name = f"{control.replace('_', ' ')} in {unit.replace('pct', '%')}"
    try:
        if isinstance(limits, str | bytes):
            raise TypeError
        lower, upper = (float(value) for value in limits)
    except (TypeError, ValueError):
        raise InputError(f"{name}: give two numbers, lower and upper limit.") from None
    if not (math.isfinite(lower) and math.isfinite(upper)):
        raise InputError(f"{name}: limits {lower:g} {upper:g} are not finite; give two numbers.")
    if lower > upper:
        raise InputError(f"{name}: limits {lower:g} {upper:g} are reversed; give the lower one first.")
    if lower < widest[0] or upper > widest[1]:
        raise InputError(
            f"{name}: limits {lower:g} {upper:g} are outside {widest[0]:g} .. {widest[1]:g}; "
            "a failure can only take range away."
        )
    return lower, upper


@dataclass(frozen=True)
class RateLimits:
    """Fastest motion of each surface in deg/s; 0 is a jam where it stands. The defaults are the undamaged aircraft.

    Data for simulations: steady manoeuvres do not depend on them.

    Raises:
        InputError: not a number from 0 to `FASTEST_DEG_S`.
    """

    elevator_deg_s: float = FASTEST_DEG_S
    aileron_deg_s: float = FASTEST_DEG_S
    rudder_deg_s: float = FASTEST_DEG_S

    def __post_init__(self) -> None:
        """Check each rate and store it as a float."""
        for f in fields(self):
            given = getattr(self, f.name)
            try:
                rate = float(given)
            except (TypeError, ValueError):
                rate = math.nan
            if not 0.0 <= rate <= FASTEST_DEG_S:
                name = f.name.removesuffix("_deg_s")
                raise InputError(f"{name} rate in deg/s is {given!r}; give a number from 0 to {FASTEST_DEG_S:g}.")
            object.__setattr__(self, f.name, rate)
