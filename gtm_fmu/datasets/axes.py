"""Axes of a data set: what varies between its cases, at given levels or over a range.

An axis turns points of the unit cube into values, so that any sampling of the cube samples the cases. The inputs that
may vary are those of `inputs.NAMES`.
"""

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement
from typing import Protocol, TypeVar

import numpy as np

from gtm_fmu.aircraft.inputs import CHOICES, LIMITED, QUANTITIES, Column, limit_columns
from gtm_fmu.aircraft.ranges import Range, check_pair, check_range
from gtm_fmu.errors import InputError

T = TypeVar("T")
MOST_LEVELS = 250_000
"""Values of an axis, or pairs of limits, as of some 700 positions; all of them are in memory and in a store."""


class Axis(Protocol):
    """One or two columns that vary together."""

    @property
    def name(self) -> str:
        """The quantity or the control."""

    @property
    def columns(self) -> tuple[Column, ...]:
        """What varies."""

    @property
    def dimensions(self) -> int:
        """Coordinates of the unit cube that the axis takes; none if it is held."""

    def at(self, unit: np.ndarray) -> np.ndarray:
        """Values (n, columns) at points (n, dimensions) of the unit cube."""

    def __str__(self) -> str:
        """What is sampled, in words."""


@dataclass(frozen=True)
class Levels:
    """Given values, each a row with a number for every column; a single one is held."""

    name: str
    columns: tuple[Column, ...]
    values: tuple[tuple[float, ...], ...]

    def __post_init__(self) -> None:
        if not self.values:
            raise InputError(f"The lattice is empty: no level of {self.name}; give at least one.")
        check_count(self.name, len(self.values))

    def __len__(self) -> int:
        return len(self.values)

    @property
    def dimensions(self) -> int:
        """1, or 0 where there is one value only and nothing varies."""
        return int(len(self) > 1)

    def rows(self, index: np.ndarray) -> np.ndarray:
        """Values (n, columns) by their number (n)."""
        return np.array(self.values)[index]

    def at(self, unit: np.ndarray) -> np.ndarray:
        """All values with the same probability."""
        share = unit[:, 0] if self.dimensions else np.zeros(len(unit))
        return self.rows((share * len(self)).astype(int))

    def __str__(self) -> str:
        values = json.dumps([value[0] if len(value) == 1 else value for value in self.values])
        return ("one of " if self.dimensions else "held at ") + values


@dataclass(frozen=True)
class Span:
    """A quantity uniform between two bounds."""

    column: Column
    lower: float
    upper: float

    dimensions = 1

    @property
    def name(self) -> str:
        """The quantity."""
        return self.column.name

    @property
    def columns(self) -> tuple[Column, ...]:
        """The one."""
        return (self.column,)

    def at(self, unit: np.ndarray) -> np.ndarray:
        """From the lower to the upper bound."""
        return np.minimum(self.lower + unit * (self.upper - self.lower), self.upper)

    def __str__(self) -> str:
        return f"uniform in {json.dumps([self.lower, self.upper])}"


@dataclass(frozen=True)
class LimitsSpan:
    """Limits of a control, uniform over the triangle of all pairs in order, and a share of jams among them."""

    name: str
    lower: float
    upper: float
    jam_share: float

    dimensions = 2

    @property
    def columns(self) -> tuple[Column, ...]:
        """Lower and upper limit."""
        return limit_columns(self.name)

    def at(self, unit: np.ndarray) -> np.ndarray:
        """Jams where the first coordinate is below their share; the rest of it is the lower limit by its distribution.

        The lower limit a of a uniform pair on [0, 1] is distributed as 1 - (1 - a)^2, the upper one uniformly above it.
        """
        first, second = unit.T
        jam = first < self.jam_share
        rest = np.divide(first - self.jam_share, 1 - self.jam_share, out=np.zeros_like(first), where=~jam)
        low = 1 - np.sqrt(1 - rest)
        pair = np.where(jam, second, [low, low + second * (1 - low)])
        return np.minimum(self.lower + pair.T * (self.upper - self.lower), self.upper)

    def __str__(self) -> str:
        return f"pairs uniform in {json.dumps([self.lower, self.upper])}, share of jams {self.jam_share}"


def _entry(inputs: Mapping[str, T], name: str) -> T:
    try:
        return inputs[name]
    except KeyError:
        raise InputError(f"There is no such input as {name!r} here; choose one of {', '.join(inputs)}.") from None


def check_count(name: str, count: int) -> None:
    """Refuse more levels than an axis may have, before they are made.

    Raises:
        InputError: more than `MOST_LEVELS`.
    """
    if count > MOST_LEVELS:
        raise InputError(
            f"{count} levels or pairs of levels of {name.replace('_', ' ')} are too many; take {MOST_LEVELS} at most."
        )


def _spelled(column: Column) -> str:
    return column.name.replace("_", " ") + (f" in {column.units}" if column.units != "1" else "")


def levels(name: str, values: Iterable[float]) -> Levels:
    """Values of one of `inputs.QUANTITIES`, in its unit.

    Args:
        name: of the quantity, as ``altitude``.
        values: in the unit of the quantity, as ft.

    Raises:
        InputError: none, or one outside what is allowed.
    """
    column, allowed = _entry(QUANTITIES, name)
    spelled = _spelled(column)
    return Levels(name, (column,), tuple((check_range(spelled, value, allowed),) for value in values))


def span(name: str, lower: float, upper: float) -> Axis:
    """One of `inputs.QUANTITIES` between two bounds in its unit; held if they are equal.

    Args:
        name: of the quantity, as ``altitude``.
        lower: least value, in the unit of the quantity.
        upper: greatest value, in the same unit.

    Raises:
        InputError: bounds reversed, not finite, or outside what is allowed.
    """
    column, allowed = _entry(QUANTITIES, name)
    lower, upper = check_pair(_spelled(column), (lower, upper), allowed)
    return Span(column, lower, upper) if lower < upper else levels(name, [lower])


def choices(name: str, numbers: Iterable[int]) -> Levels:
    """Numbers of one of `inputs.CHOICES`: damage cases, or engines that are out by their place in `EngineOut`.

    Args:
        name: of the choice, as ``damage_case``.
        numbers: those that occur.

    Raises:
        InputError: none, one given twice, or one that does not exist.
    """
    given, last = tuple(numbers), len(_entry(CHOICES, name)) - 1
    for number in given:
        if number not in range(last + 1):
            raise InputError(f"{name.replace('_', ' ')} {number} does not exist; give a whole number from 0 to {last}.")
        if given.count(number) > 1:
            raise InputError(f"{name.replace('_', ' ')} {number} was given twice; give each one once.")
    return Levels(name, (Column(name, ""),), tuple((int(number),) for number in given))


def _limits(control: str, pair: Sequence[float]) -> Range:
    column, widest = _entry(LIMITED, control)
    return check_pair(_spelled(column), pair, widest)


def limit_levels(control: str, pairs: Iterable[Sequence[float]]) -> Levels:
    """Given limits of a control in deg or %; equal ones are a jam, a single pair is held.

    Raises:
        InputError: no pair, or one reversed, not finite, or wider than the undamaged aircraft's.
    """
    return Levels(control, limit_columns(control), tuple(_limits(control, pair) for pair in pairs))


def failure_levels(control: str, positions: Iterable[float]) -> Levels:
    """All jams and restrictions of a control between the positions: 28 for the paper's seven of the rudder.

    Raises:
        InputError: as `limit_levels`, or too many.
    """
    ordered = sorted(positions)
    check_count(control, len(ordered) * (len(ordered) + 1) // 2)
    return limit_levels(control, combinations_with_replacement(ordered, 2))


def limits_span(control: str, lower: float, upper: float, jam_share: float = 0.0) -> Axis:
    """Limits of a control anywhere between two bounds in deg or %; a jam that is held if they are equal.

    Args:
        control: as ``rudder``.
        lower: least limit in deg or %.
        upper: greatest limit in deg or %.
        jam_share: share of the cases, 0 .. 1, in which both limits are equal.

    Raises:
        InputError: bounds reversed, not finite or too wide, or the share outside 0 .. 1.
    """
    lower, upper = _limits(control, (lower, upper))
    jam_share = check_range("Share of jams", jam_share, (0.0, 1.0))
    return LimitsSpan(control, lower, upper, jam_share) if lower < upper else limit_levels(control, [(lower, upper)])
