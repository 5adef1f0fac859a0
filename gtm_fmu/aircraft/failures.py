"""What a failure leaves of the aircraft: jams and restrictions of controls, lost surfaces, engines that are out."""

from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

import numpy as np

from gtm_fmu.aircraft.limits import ControlLimits, RateLimits, checked_limits
from gtm_fmu.aircraft.ranges import WIDEST, Range
from gtm_fmu.airframe.names import CONTROLS, TWO_THROTTLE_CONTROLS
from gtm_fmu.core.configuration import Configuration
from gtm_fmu.core.solver import ONE_THROTTLE, TWO_THROTTLES, Airframe, dead_controls
from gtm_fmu.errors import InputError


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

    limits: ControlLimits = field(default_factory=ControlLimits)
    configuration: Configuration = field(default_factory=_study)
    throttle_left_pct: Range | None = None
    throttle_right_pct: Range | None = None
    rate_limits: RateLimits = field(default_factory=RateLimits)

    def __post_init__(self) -> None:
        """Check the parts."""
        for name, kind in (("limits", ControlLimits), ("configuration", Configuration), ("rate_limits", RateLimits)):
            if not isinstance(getattr(self, name), kind):
                raise InputError(f"{name} of a failure is {getattr(self, name)!r}; give a {kind.__name__}.")
        for name in ("throttle_left_pct", "throttle_right_pct"):
            if (limits := getattr(self, name)) is not None:
                object.__setattr__(self, name, checked_limits(name, limits, WIDEST["throttle_pct"]))

    @classmethod
    def of(cls, what: "ControlLimits | Failure | None") -> "Failure":
        """The failure that ``what`` is: limits of controls, None for no failure, or a failure already."""
        return what if isinstance(what, Failure) else cls(what if what is not None else ControlLimits())

    def with_limits(self, label: str, limits: Range) -> "Failure":
        """The same with other ``limits`` of one control, in deg or %; ``label`` names their field, as ``rudder_deg``.

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
        """Lower limits of the `controls`. One that moves nothing any more is held at one position."""
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
