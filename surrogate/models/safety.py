"""Values of a model that are safe to use: one-sided bounds of its outputs, with a promise (`gtm_fmu.conformal`).

An output that must never be too low, as a least speed, is moved up by a constant margin; one that must never be too
high is moved down. The margin is a split-conformal quantile of the errors in rows that no training saw, never below
zero. For one new row of the same distribution, and the draw of those rows,

    P(y_safe >= y) >= 1 - epsilon    or    P(y_safe <= y) >= 1 - epsilon,    each output by itself.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from gtm_fmu import conformal
from gtm_fmu.errors import InputError
from surrogate.models.evaluation import Variable, frozen_array
from surrogate.scaling import Array

Never = Literal["low", "high"]
"""What a safe value must never be."""
_SIGNS: dict[str, float] = {"low": 1.0, "high": -1.0}


@dataclass(frozen=True, eq=False)
class Safety:
    """Margins of some outputs of a model."""

    outputs: tuple[str, ...]
    """Names of the outputs (s)."""
    never: tuple[Never, ...]
    """What the safe value of each must never be (s)."""
    margins: Array
    """How far each is moved (s), in its unit, zero or more."""
    epsilon: float
    """Probability with which each may be wrong, at most."""
    cases: int
    """Rows that set the margins."""

    def __post_init__(self) -> None:
        """Hold plain values unchangeable; ValueError where they do not fit together."""
        for name in ("outputs", "never"):
            object.__setattr__(self, name, tuple(getattr(self, name)))
        margins = frozen_array(self.margins, (len(self.outputs),), "margins of the safe outputs")
        object.__setattr__(self, "margins", margins)
        if not self.outputs or len(self.never) != len(self.outputs) or not set(self.never) <= _SIGNS.keys():
            raise ValueError("the safe outputs must be one or more, each never 'low' or never 'high'.")
        if (margins < 0).any() or self.cases < conformal.least_cases(self.epsilon):
            raise ValueError("the margins of the safe outputs must be zero or more, of enough cases for their epsilon.")

    @property
    def shifts(self) -> Array:
        """What is added to each output (s)."""
        return self.margins * np.array([_SIGNS[side] for side in self.never])

    def places(self, outputs: Sequence[Variable]) -> np.ndarray:
        """Numbers (s) of the safe outputs among those of their model; ValueError where one is missing."""
        return np.array([[variable.name for variable in outputs].index(name) for name in self.outputs])

    def about(self, output: str) -> str:
        """What the safe value of an output promises, in words."""
        side = self.never[self.outputs.index(output)]
        word = "below" if side == "low" else "above"
        return (
            f"not {word} the true one with a probability of at least {1 - self.epsilon:.5g}, over the {self.cases} "
            "rows that set its margin and one more of the same distribution"
        )


def safety(
    errors: Array, outputs: Sequence[Variable], never: Mapping[str, Never], epsilon: float = conformal.EPSILON
) -> Safety:
    """Margins by errors (n, m), what a model gives less the truth, in rows that it was not trained on.

    Args:
        errors: of every output.
        outputs: of the model (m).
        never: by the names of the outputs that become safe, what they must never be.
        epsilon: probability with which each may be wrong.

    Raises:
        InputError: an output that the model has not, none at all, or too few rows for epsilon.
    """
    names = [variable.name for variable in outputs]
    for name in never:
        if name not in names:
            raise InputError(f"'{name}' is no output of the model: give some of {', '.join(names)}.")
    if not never:
        raise InputError("Which outputs must be safe was not said: name those that must never be too low, or too high.")
    margins = [
        max(conformal.margin(-_SIGNS[side] * errors[:, names.index(name)], epsilon), 0.0)
        for name, side in never.items()
    ]
    return Safety(tuple(never), tuple(never.values()), np.array(margins), epsilon, len(errors))


def safe_values(safe: Safety | None, Y: Array, outputs: Sequence[Variable]) -> Array:
    """Safe values (..., s) by all outputs Y (..., m) of a model; ValueError where it was not calibrated."""
    if safe is None:
        raise ValueError("the model was not calibrated: train it with rows that are held back for that.")
    return Y[..., safe.places(outputs)] + safe.shifts


def safety_from_plain(content: dict[str, Any] | None) -> Safety | None:
    """The margins of these fields, as JSON has them; None of a model without."""
    return None if content is None else Safety(**content)
