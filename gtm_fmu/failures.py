"""What a failure leaves of each control: jam, restriction, full range."""

import math
from dataclasses import dataclass, fields

import numpy as np

from gtm_fmu.errors import InputError

Range = tuple[float, float]

WIDEST: dict[str, Range] = {
    "elevator_deg": (-30.0, 30.0),
    "aileron_deg": (-20.0, 20.0),
    "rudder_deg": (-30.0, 30.0),
    "throttle_pct": (0.0, 100.0),
}
"""Limits of the undamaged aircraft, in the order of `names.CONTROLS` (SPEC 9)."""


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

    def __post_init__(self):
        """Check each pair and store it as floats."""
        for field in fields(self):
            name = field.name.replace("_", " in ").replace("pct", "%")
            try:
                lower, upper = (float(value) for value in getattr(self, field.name))
            except (TypeError, ValueError):
                raise InputError(f"{name}: give two numbers, lower and upper limit.") from None
            widest = WIDEST[field.name]
            if not (math.isfinite(lower) and math.isfinite(upper)):
                raise InputError(f"{name}: limits {lower:g} {upper:g} are not finite; give two numbers.")
            if lower > upper:
                raise InputError(f"{name}: limits {lower:g} {upper:g} are reversed; give the lower one first.")
            if lower < widest[0] or upper > widest[1]:
                raise InputError(
                    f"{name}: limits {lower:g} {upper:g} are outside {widest[0]:g} .. {widest[1]:g}; "
                    "a failure can only take range away."
                )
            object.__setattr__(self, field.name, (lower, upper))

    @property
    def lower(self) -> np.ndarray:
        """Lower limits (4) in the order of `names.CONTROLS`."""
        return np.array([getattr(self, field.name)[0] for field in fields(self)])

    @property
    def upper(self) -> np.ndarray:
        """Upper limits (4) in the order of `names.CONTROLS`."""
        return np.array([getattr(self, field.name)[1] for field in fields(self)])

    @property
    def jammed(self) -> tuple[bool, ...]:
        """Which controls cannot move, in the order of `names.CONTROLS`."""
        return tuple(bool(jam) for jam in self.lower == self.upper)
