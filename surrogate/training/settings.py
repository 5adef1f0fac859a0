"""Allowed values of settings as data, read by one validator, so that every setting is refused in the same words."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf
from numbers import Integral, Real
from typing import Any, Protocol, cast

_SHOWN = 40
"""Characters of a value in a sentence: somebody may give a number of 400 digits."""


class Allowed(Protocol):
    """What a setting may be; its text completes the sentence "but must be ..."."""

    def admits(self, value: Any) -> bool:
        """Whether the value is one of them."""


@dataclass(frozen=True)
class Whole:
    """Whole numbers; True and False are none."""

    least: int
    most: int

    def admits(self, value: Any) -> bool:
        """Whether the value is one of them."""
        return isinstance(value, Integral) and not isinstance(value, bool) and self.least <= int(value) <= self.most

    def __str__(self) -> str:
        return f"a whole number from {self.least} to {self.most}"


@dataclass(frozen=True)
class Number:
    """Finite numbers from `least`, or above it, to `most`."""

    least: float = 0.0
    most: float = inf
    above: bool = False

    def admits(self, value: Any) -> bool:
        """Whether the value is one of them."""
        if not isinstance(value, Real) or isinstance(value, bool):
            return False
        number = cast(float, value)
        return (self.least < number if self.above else self.least <= number) and number <= self.most and number < inf

    def __str__(self) -> str:
        start = f"a finite number {'above' if self.above else 'from'} {self.least:g}"
        return start if self.most == inf else f"{start} to {self.most:g}"


@dataclass(frozen=True)
class Choice:
    """Some values."""

    values: tuple[Any, ...]

    def admits(self, value: Any) -> bool:
        """Whether the value is one of them."""
        return isinstance(value, type(self.values[0])) and value in self.values

    def __str__(self) -> str:
        return f"one of {', '.join(map(str, self.values))}"


@dataclass(frozen=True)
class Layers:
    """A number of neurons, or one for each hidden layer."""

    neurons: Whole
    most: int

    def admits(self, value: Any) -> bool:
        """Whether the value is one of them."""
        if self.neurons.admits(value):
            return True
        is_row = isinstance(value, Sequence) and not isinstance(value, str) and 1 <= len(value) <= self.most
        return is_row and all(map(self.neurons.admits, value))

    def __str__(self) -> str:
        return f"{self.neurons} of neurons, or one for each of at most {self.most} hidden layers"


def check(settings: Mapping[str, Any], allowed: Mapping[str, Allowed]) -> None:
    """Refuse the first of the settings that is not allowed.

    Raises:
        ValueError: what was given, and what is allowed.
    """
    for name, admitted in allowed.items():
        if name in settings and not admitted.admits(settings[name]):
            try:
                given = repr(settings[name])
            except ValueError:  # Python does not print a number of over 4300 digits
                given = "a number of thousands of digits"
            shown = given if len(given) <= _SHOWN else f"{given[:_SHOWN]} ..."
            raise ValueError(f"{name} is {shown}, but must be {admitted}.")
