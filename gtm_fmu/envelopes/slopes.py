"""How an envelope changes with what it depends on: altitude, flight path, and every limit that a failure leaves.

Slopes are differences of the exact solver, to either side by itself: at a kink, as where a limit begins to hold an end
or on a breakpoint of the tables, the two sides differ. With D(s) the difference quotient over a step s the slope is
2 D(s/2) - D(s), which leaves an error of the second order. Where the speed jumps, as V_max does at a fold of the thrust
required, the quotients grow as the step shrinks, and there is no slope.

`Envelope.slopes` are the same derivatives by the multipliers of the optimum, a thousand times faster. These differences
prove them, and see in addition what multipliers can not: jumps, and what a larger step costs.

A limit that neither end touches is free: an envelope that shrinks, but keeps both of its ends, has the same ends.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.inputs import CONDITION, LIMITED
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.aircraft.ranges import ALPHA_DEG, PHI_DEG, WIDEST, Range
from gtm_fmu.airframe.names import CONTROLS, TWO_THROTTLE_CONTROLS, V
from gtm_fmu.core.solver import dead_controls
from gtm_fmu.envelopes.envelope import Envelope, FlightCondition
from gtm_fmu.envelopes.multipliers import Sides
from gtm_fmu.trims.manoeuvre import Trim
from gtm_fmu.units import KT_PER_FT_S

STEPS = {"ft": 4.0, "deg": 0.01, "%": 0.02}
"""Of the difference quotients, by unit."""
LARGER_STEPS = {"ft": 1000.0, "deg": 1.0, "%": 1.0}
"""By which each quantity is moved for its cost, by unit."""
_NOISE_KT = 2e-4
"""How far two solutions of one end may lie apart."""
_JUMP = 0.3
"""Part of a quotient by which that of half the step may differ; a kink inside the step changes it by less."""
_KINK_KT = 0.02
"""Least difference of both sides' slopes, times `LARGER_STEPS`, that is a kink."""
REMEDY_TOLERANCE = {"ft": 10.0, "deg": 0.01, "%": 0.01}
"""To which the nearest value with an envelope is found, by unit."""


@dataclass(frozen=True)
class Quantity:
    """Something that an envelope depends on.

    Attributes:
        name: ``altitude``, ``gamma``, a limit as ``rudder.lower``, or a control that is jammed as ``rudder``.
        label: field that holds it, as ``rudder_deg``.
        units: ft, deg or %.
        value: where it is.
        allowed: where it may be moved to, other quantities staying.
        narrowing: sign of the direction in which a limit takes range away; 0 where that is neither.
    """

    name: str
    label: str
    units: str
    value: float
    allowed: Range
    narrowing: int = 0

    def moved(self, condition: FlightCondition, value: float) -> FlightCondition:
        """The condition with this quantity at another value."""
        if self.label in (column.label for column in CONDITION):
            at: dict[str, Any] = {self.label: value}
            return condition.changed(**at)
        low, high = _limits(condition.failure, self.label)
        pair = {1: (value, high), -1: (low, value), 0: (value, value)}[self.narrowing]
        return condition.changed(failure=condition.failure.with_limits(self.label, pair))

    def toward(self, amount: float) -> float:
        """The value moved by an amount as far as is allowed."""
        return float(np.clip(self.value + amount, *self.allowed))


@dataclass(frozen=True)
class Change:
    """A quantity moved by a larger step, and the exact ends then; None without an envelope."""

    to: float
    v_min_kt: float | None
    v_max_kt: float | None


@dataclass(frozen=True)
class QuantitySlopes:
    """What a quantity does to both ends.

    Attributes:
        v_min, v_max: slopes in kn per ft, deg or %.
        kinks: ends, of ``v_min`` and ``v_max``, whose slopes to both sides differ.
        jumps: ends that jump within the step to one side, as ``v_max.above``.
        changes: the quantity moved by one of `LARGER_STEPS`: a limit inwards only, what is no limit both ways.
    """

    quantity: Quantity
    v_min: Sides
    v_max: Sides
    kinks: tuple[str, ...]
    jumps: tuple[str, ...]
    changes: tuple[Change, ...]


@dataclass(frozen=True)
class EnvelopeSlopes:
    """An envelope with what moves its ends; without an envelope there are no slopes, but `remedies`.

    Attributes:
        remedies: for each quantity that alone could bring an envelope back, the value nearest to its own that does.
    """

    envelope: Envelope
    slopes: tuple[QuantitySlopes, ...]
    remedies: tuple[tuple[Quantity, float], ...] = ()


def envelope_slopes(
    altitude_ft: float,
    gamma_deg: float,
    limits: ControlLimits | Failure | None = None,
    alpha_deg: Range = ALPHA_DEG,
    phi_deg: Range = PHI_DEG,
) -> EnvelopeSlopes:
    """Exact envelope of a flight condition under the limits a failure leaves, and its slopes.

    Args:
        altitude_ft: geometric altitude in ft.
        gamma_deg: flight-path angle in deg, positive in a climb.
        limits: what the failure leaves of the controls, or a whole `Failure`; None: nothing has failed.
        alpha_deg: least and greatest angle of attack in deg.
        phi_deg: least and greatest bank in deg.

    Raises:
        InputError: altitude, flight path or bounds outside what is allowed.
    """
    condition = FlightCondition(altitude_ft, gamma_deg, limits, alpha_deg, phi_deg)
    envelope = condition.envelope()
    every = tuple(quantities(condition))
    if not (envelope.feasible and envelope.at_v_min and envelope.at_v_max):
        return EnvelopeSlopes(envelope, (), tuple(_remedies(condition, every)))
    ends = _Ends(condition, (envelope.at_v_min, envelope.at_v_max))
    return EnvelopeSlopes(envelope, tuple(_slopes(ends, quantity) for quantity in every))


def quantities(condition: FlightCondition) -> Iterator[Quantity]:
    """Altitude, flight path, and the limits of every control that moves something."""
    for column, allowed in CONDITION.items():
        yield Quantity(column.name, column.label, column.units, getattr(condition, column.label), allowed)
    failure = condition.failure
    for control in failure.controls:
        label = _label(failure, control)
        if label is None:
            continue
        column, (lowest, highest) = LIMITED[control]
        low, high = _limits(failure, label)
        if low == high:
            yield Quantity(control, label, column.units, low, (lowest, highest))
        else:
            yield Quantity(f"{control}.lower", label, column.units, low, (lowest, high), 1)
            yield Quantity(f"{control}.upper", label, column.units, high, (low, highest), -1)


def _label(failure: Failure, control: str) -> str | None:
    """The field that holds a control's limits; None if it moves nothing."""
    moving = [not dead for dead in dead_controls(failure.configuration)]
    alive = dict(zip(TWO_THROTTLE_CONTROLS, moving, strict=True))
    engines = [name for name in TWO_THROTTLE_CONTROLS if name not in CONTROLS and alive[name]]
    if control == "throttle" and engines:  # it drives the first engine that runs by that one's limits, if it has some
        own = LIMITED[engines[0]][0].label
        return own if getattr(failure, own) is not None else LIMITED[control][0].label
    return LIMITED[control][0].label if alive.get(control, False) else None


def _limits(failure: Failure, label: str) -> Range:
    if label in WIDEST:
        return getattr(failure.limits, label)
    return getattr(failure, label) or failure.limits.throttle_pct


class _Ends:
    """V_min and V_max in kn about a condition whose trims at both ends are known."""

    def __init__(self, condition: FlightCondition, trims: tuple[Trim, Trim]):
        self.condition, self.trims = condition, trims
        self.here = np.array([trim.tas_kt for trim in trims])

    def at(self, quantity: Quantity, value: float) -> np.ndarray:
        """Both ends (2) with the quantity at a value; NaN without an envelope."""
        if value == quantity.value or self._are_kept(quantity, value):
            return self.here
        found = quantity.moved(self.condition, value).extremes()[:, V] * KT_PER_FT_S
        return found if len(found) == len(self.here) else np.full(len(self.here), np.nan)

    def _are_kept(self, quantity: Quantity, value: float) -> bool:
        """Whether a limit that moves inwards leaves the trims at both ends."""
        if not quantity.narrowing or (value - quantity.value) * quantity.narrowing < 0:
            return False
        where = self.condition.failure.airframe.unknowns.index(quantity.name.partition(".")[0])
        return all((trim.unknowns[where] - value) * quantity.narrowing >= 0 for trim in self.trims)


def _slopes(ends: _Ends, quantity: Quantity) -> QuantitySlopes:
    step, larger = STEPS[quantity.units], LARGER_STEPS[quantity.units]
    below, above = (_one_sided(ends, quantity, way * step) for way in (-1, 1))
    sides = [
        Sides(*(None if np.isnan(value) else float(value) for value in pair))
        for pair in zip(below[0], above[0], strict=True)
    ]
    names = ("v_min", "v_max")
    kinks = tuple(
        name
        for name, (left, right) in zip(names, sides, strict=True)
        if left is not None and right is not None and abs(left - right) * larger > _KINK_KT
    )
    jumps = tuple(
        f"{name}.{side}"
        for k, name in enumerate(names)
        for side, (_, jumped) in (("below", below), ("above", above))
        if jumped[k]
    )
    ways = (quantity.narrowing,) if quantity.narrowing else (-1, 1)
    changes = []
    for to in dict.fromkeys(quantity.toward(way * larger) for way in ways):
        if to != quantity.value:
            low, high = (None if np.isnan(value) else float(value) for value in ends.at(quantity, to))
            changes.append(Change(to, low, high))
    return QuantitySlopes(quantity, sides[0], sides[1], kinks, jumps, tuple(changes))


def _one_sided(ends: _Ends, quantity: Quantity, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Slopes (2) of both ends to one side, NaN where there is none, and whether they jump (2)."""
    if quantity.toward(step) != quantity.value + step:
        return np.full(2, np.nan), np.zeros(2, dtype=bool)
    whole, half = ((ends.at(quantity, quantity.value + part * step) - ends.here) / (part * step) for part in (1.0, 0.5))
    apart = np.abs(half - whole)
    jumps = (apart > _JUMP * np.abs(whole)) & (apart > 4 * _NOISE_KT / abs(step))
    return np.where(jumps, np.nan, 2.0 * half - whole), jumps


def _remedies(condition: FlightCondition, every: tuple[Quantity, ...]) -> Iterator[tuple[Quantity, float]]:
    """Each quantity that alone brings an envelope back, with the nearest value found that does."""
    for quantity in every:
        for way in (-quantity.narrowing,) if quantity.narrowing else (-1, 1):
            without, with_one = quantity.value, None
            amount = way * LARGER_STEPS[quantity.units]
            while with_one is None and without != (to := quantity.toward(amount)):
                without, with_one = (without, to) if _exists(quantity.moved(condition, to)) else (to, None)
                amount *= 2.0
            if with_one is not None:
                yield quantity, _border(condition, quantity, without, with_one)


def _border(condition: FlightCondition, quantity: Quantity, without: float, with_one: float) -> float:
    """The value with an envelope nearest to one without, by bisection."""
    while abs(with_one - without) > REMEDY_TOLERANCE[quantity.units]:
        middle = 0.5 * (without + with_one)
        if _exists(quantity.moved(condition, middle)):
            with_one = middle
        else:
            without = middle
    return with_one


def _exists(condition: FlightCondition) -> bool:
    return len(condition.extremes()) == 2
