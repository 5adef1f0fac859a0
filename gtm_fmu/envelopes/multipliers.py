"""Slopes of V_min and V_max by the multipliers of the optimum: at once, and exact where the speed has a slope.

An end is the optimum of a program: least (or greatest) V with F(y) = 0 under bounds. The derivative of its value with
respect to anything is that of the Lagrangian. `slopes.envelope_slopes` solves the neighbours instead. That takes a
hundred solutions. It sees what multipliers can not: another local optimum that takes over, as at a jump of V_max.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.inputs import CONDITION, LIMITED, QUANTITIES
from gtm_fmu.aircraft.ranges import WIDEST_ALPHA_DEG, WIDEST_PHI_DEG, Range
from gtm_fmu.airframe.names import TWO_THROTTLE_CONTROLS
from gtm_fmu.core.slopes import end_slopes
from gtm_fmu.core.solver import dead_controls
from gtm_fmu.units import KT_PER_FT_S, RAD_PER_DEG

_AIRFRAME = ("stabilizer", "flaps", "spoilers", "fuel_used")
_ANYWHERE = (-math.inf, math.inf)
"""The core knows where these may go."""
_ALTITUDE_STEP_FT = 1000.0
_ONE = 1e-5
"""Relative difference of both sides that is none: of second differences of the accelerations, and of rounding."""


class Sides(NamedTuple):
    """The slope of an end towards smaller and larger values of a quantity.

    None where the quantity may not move that way, or no envelope is left there, or the speed jumps.
    """

    below: float | None
    above: float | None

    @property
    def has_kink(self) -> bool:
        """Whether the two sides differ."""
        if self.below is None or self.above is None:
            return False
        return abs(self.above - self.below) > _ONE * max(abs(self.above), abs(self.below), 1e-3)


@dataclass(frozen=True)
class Slope:
    """What moves both ends of an envelope.

    Attributes:
        name: ``altitude``, ``gamma``, a limit as ``rudder.lower`` or ``alpha.upper``, a control that is jammed as
            ``rudder``, or of the airframe ``stabilizer``, ``flaps``, ``spoilers`` (all panels alike) and ``fuel_used``.
        units: of the slopes: ``kn/1000 ft``, ``kn/deg``, ``kn/%``, ``kn/lb``.
        v_min, v_max: slopes.
    """

    name: str
    units: str
    v_min: Sides
    v_max: Sides

    @property
    def kinks(self) -> tuple[str, ...]:
        """Ends whose slopes to both sides differ."""
        return tuple(name for name in ("v_min", "v_max") if getattr(self, name).has_kink)

    def to_dict(self) -> dict[str, Any]:
        """All but the name, ready for JSON."""
        sides = {"v_min": self.v_min._asdict(), "v_max": self.v_max._asdict()}
        return {"units": self.units, **sides, "kinks": list(self.kinks)}


class _Quantity(NamedTuple):
    """Where a slope lies in the core's answer, its value, what is allowed, and the core's units in one of its."""

    name: str
    units: str
    place: tuple
    value: float
    allowed: Range
    scale: float = 1.0


def slopes(
    altitude_ft: float,
    gamma_deg: float,
    failure: Failure,
    bounds: tuple[np.ndarray, np.ndarray],
    ends: tuple[np.ndarray, np.ndarray],
) -> tuple[Slope, ...]:
    """Of the envelope whose trims are ``ends`` (V_min, V_max; 9 or 10 each) under the bounds (9 or 10 each)."""
    at = altitude_ft, gamma_deg * RAD_PER_DEG
    objective = np.zeros(len(bounds[0]))
    found = []
    for y, sign in zip(ends, (1.0, -1.0), strict=True):
        objective[0] = sign
        found.append((sign, end_slopes(*at, *bounds, objective, y, failure.airframe)))
    return tuple(
        Slope(
            each.name,
            each.units,
            *(_sides(each, sign * answer[each.place[0]][each.place[1:]]) for sign, answer in found),
        )
        for each in _quantities(altitude_ft, gamma_deg, failure, bounds)
    )


def _sides(quantity: _Quantity, slope: np.ndarray) -> Sides:
    can_move = quantity.value > quantity.allowed[0], quantity.value < quantity.allowed[1]
    return Sides(
        *(
            float(value) * quantity.scale * KT_PER_FT_S + 0.0 if can and math.isfinite(value) else None
            for can, value in zip(can_move, slope, strict=True)
        )
    )


def _quantities(
    altitude_ft: float, gamma_deg: float, failure: Failure, bounds: tuple[np.ndarray, np.ndarray]
) -> Iterator[_Quantity]:
    altitude, gamma = CONDITION.values()
    yield _Quantity("altitude", "kn/1000 ft", ("altitude",), altitude_ft, altitude, _ALTITUDE_STEP_FT)
    yield _Quantity("gamma", "kn/deg", ("gamma",), gamma_deg, gamma, RAD_PER_DEG)
    yield from _bounds("alpha", "deg", WIDEST_ALPHA_DEG, failure, bounds, RAD_PER_DEG)
    yield from _bounds("phi", "deg", WIDEST_PHI_DEG, failure, bounds, RAD_PER_DEG)
    dead = dict(zip(TWO_THROTTLE_CONTROLS, dead_controls(failure.configuration), strict=True))
    dead["throttle"] = dead["throttle_left"] and dead["throttle_right"]
    for control in failure.controls:
        if not dead[control]:
            column, allowed = LIMITED[control]
            yield from _bounds(control, column.units, allowed, failure, bounds)
    for name in _AIRFRAME:
        column, _ = QUANTITIES[name]
        yield _Quantity(name, f"kn/{column.units}", (name,), 0.0, _ANYWHERE)


def _bounds(
    unknown: str,
    units: str,
    allowed: Range,
    failure: Failure,
    bounds: tuple[np.ndarray, np.ndarray],
    scale: float = 1.0,
) -> Iterator[_Quantity]:
    k = failure.airframe.unknowns.index(unknown)
    low, high = (float(bound[k]) / scale for bound in bounds)
    if low == high:
        yield _Quantity(unknown, f"kn/{units}", ("held", k), low, allowed, scale)
    else:
        for end, value in (("lower", low), ("upper", high)):
            yield _Quantity(f"{unknown}.{end}", f"kn/{units}", (end, k), value, allowed, scale)
