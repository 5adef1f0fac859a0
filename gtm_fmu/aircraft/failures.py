"""What a failure leaves of the aircraft: jams and restrictions of controls, lost surfaces, engines that are out."""

import math
from dataclasses import dataclass, field, fields, replace
from functools import cache
from typing import Any

import numpy as np

from gtm_fmu.airframe.actuators import RATE_LIMIT_DEG_S
from gtm_fmu.airframe.names import CONTROLS, TWO_THROTTLE_CONTROLS
from gtm_fmu.core.configuration import Configuration
from gtm_fmu.core.solver import ONE_THROTTLE, TWO_THROTTLES, Airframe, dead_controls
from gtm_fmu.errors import InputError

Range = tuple[float, float]

WIDEST: dict[str, Range] = {
    "elevator_deg": (-30.0, 30.0),
    "aileron_deg": (-20.0, 20.0),
    "rudder_deg": (-30.0, 30.0),
    "throttle_pct": (0.0, 100.0),
}
"""Limits of the undamaged aircraft, in the order of `names.CONTROLS` (SPEC 9)."""

FASTEST_DEG_S = RATE_LIMIT_DEG_S
"""Rate limit of every aerodynamic surface of the undamaged aircraft (SPEC 10.1)."""


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
        for f in fields(self):
            object.__setattr__(self, f.name, _checked_limits(f.name, getattr(self, f.name), WIDEST[f.name]))

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


def _checked_limits(field_name: str, limits, widest: Range) -> Range:
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

    def __post_init__(self):
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


@cache
def _study() -> Configuration:
    return Configuration()


@dataclass(frozen=True)
class Failure:
    """Everything that a failure changes; without arguments the undamaged aircraft of the study.

    Attributes:
        limits: of the controls.
        configuration: the airframe: damage case, engines that run, surfaces that are fixed or follow in part,
            stabiliser, flaps, spoilers, gear, fuel.
        throttle_left_pct, throttle_right_pct: limits of each engine's throttle in %. If one is given the engines are
            controlled separately, and one that is not given keeps ``limits.throttle_pct``; that has no effect where
            both are given.
        rate_limits: of the surfaces.

    Raises:
        InputError: limits as for `ControlLimits`, or a part of another kind.
    """

    limits: ControlLimits = ControlLimits()
    configuration: Configuration = field(default_factory=_study)
    throttle_left_pct: Range | None = None
    throttle_right_pct: Range | None = None
    rate_limits: RateLimits = RateLimits()

    def __post_init__(self):
        """Check the parts."""
        for name, kind in (("limits", ControlLimits), ("configuration", Configuration), ("rate_limits", RateLimits)):
            if not isinstance(getattr(self, name), kind):
                raise InputError(f"{name} of a failure is {getattr(self, name)!r}; give a {kind.__name__}.")
        for name in ("throttle_left_pct", "throttle_right_pct"):
            if (limits := getattr(self, name)) is not None:
                object.__setattr__(self, name, _checked_limits(name, limits, WIDEST["throttle_pct"]))

    @classmethod
    def of(cls, what: "ControlLimits | Failure | None") -> "Failure":
        """The failure that limits of controls mean by themselves, or the failure that it already is."""
        return what if isinstance(what, Failure) else cls(what if what is not None else ControlLimits())

    def with_limits(self, label: str, limits: Range) -> "Failure":
        """The same with other limits of one control, by the name of their field, as ``rudder_deg``.

        Raises:
            InputError: limits as for `ControlLimits`.
        """
        changed: dict[str, Any] = {label: limits}
        return replace(self, limits=replace(self.limits, **changed)) if label in WIDEST else replace(self, **changed)

    @property
    def airframe(self) -> Airframe:
        """What the core's solvers take."""
        throttles = ONE_THROTTLE if self.controls == CONTROLS else TWO_THROTTLES
        is_study = self.configuration == _study() and throttles == ONE_THROTTLE
        return Airframe(None if is_study else self.configuration, throttles)

    @property
    def controls(self) -> tuple[str, ...]:
        """`names.CONTROLS`, or `names.TWO_THROTTLE_CONTROLS` if both engines run, each with a throttle of its own."""
        separate = self.throttle_left_pct is not None or self.throttle_right_pct is not None
        return TWO_THROTTLE_CONTROLS if separate and all(self.configuration.engine_running) else CONTROLS

    @property
    def lower(self) -> np.ndarray:
        """Lower limits of the `controls`, of those that nothing follows the one position they are held at."""
        return self._ranges[:, 0]

    @property
    def upper(self) -> np.ndarray:
        """Upper limits, likewise."""
        return self._ranges[:, 1]

    @property
    def jammed(self) -> tuple[bool, ...]:
        """Which of the `controls` cannot move or move nothing."""
        return tuple(bool(jam) for jam in self.lower == self.upper)

    @property
    def _ranges(self) -> np.ndarray:
        """Limits (controls, 2)."""
        throttles = [own or self.limits.throttle_pct for own in (self.throttle_left_pct, self.throttle_right_pct)]
        dead = np.array(dead_controls(self.configuration))
        if self.controls == CONTROLS:  # one throttle drives the engines that run
            running = self.configuration.engine_running
            throttles = [throttles[running.index(True)] if True in running else self.limits.throttle_pct]
            dead = np.append(dead[:-2], dead[-2:].all())
        ranges = np.array([self.limits.elevator_deg, self.limits.aileron_deg, self.limits.rudder_deg, *throttles])
        held = np.clip(0.0, ranges[:, 0], ranges[:, 1])
        return np.where(dead[:, None], held[:, None], ranges)
