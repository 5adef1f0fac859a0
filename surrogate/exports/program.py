"""A short list of vector operations, from which every export of a fitted model is written.

A program computes one vector after the other. Vector 0 holds the inputs, vector k + 1 is the result of step k, and the
last one is the result. There are few kinds of steps, so that each export says in a few lines what becomes of each.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from surrogate.exports import steps
from surrogate.exports.steps import Step
from surrogate.scaling import Array


@dataclass(eq=False)
class Program:
    """Steps from `n_inputs` inputs to a result. Each method that adds a step gives the number of its vector."""

    n_inputs: int
    steps: list[Step] = field(default_factory=list)
    sizes: list[int] = field(init=False)
    """Length of each vector."""

    def __post_init__(self) -> None:
        """Find the sizes."""
        given, self.steps, self.sizes = self.steps, [], [self.n_inputs]
        for step in given:
            self.add(step)

    def add(self, step: Step) -> int:
        """Add a step."""
        self.sizes.append(_size(step, self.sizes))
        self.steps.append(step)
        return len(self.steps)

    def scale(self, x: int, shift: ArrayLike = 0.0, factor: ArrayLike = 1.0, offset: ArrayLike = 0.0) -> int:
        """(x - shift) factor + offset, of numbers or vectors."""
        constants = (np.full(self.sizes[x], c, dtype=float) for c in (shift, factor, offset))
        return self.add(steps.Scale(x, *constants))

    def evaluate(self, X: ArrayLike) -> Array:
        """The result (..., m) at the inputs X (..., n_inputs), by NumPy."""
        values = [np.asarray(X, dtype=float)]
        for step in self.steps:
            values.append(_evaluate(step, values))
        return values[-1]

    def to_list(self) -> list[dict[str, Any]]:
        """The steps as names, lists and numbers."""

        def plain(value: Any) -> Any:
            return value.tolist() if isinstance(value, np.ndarray) else value

        return [
            {"step": type(step).__name__} | {f.name: plain(getattr(step, f.name)) for f in fields(step)}
            for step in self.steps
        ]


def _size(step: Step, sizes: list[int]) -> int:
    match step:
        case steps.Constant(values):
            return len(values)
        case steps.Affine(W=W):
            return len(W)
        case steps.Take(i=i) | steps.Products(i=i):
            return len(i)
        case steps.GroupSum(x, size):
            return sizes[x] // size
        case steps.Join(parts):
            return sum(sizes[x] for x in parts)
        case _:
            return sizes[step.x]


def _evaluate(step: Step, values: list[Array]) -> Array:
    match step:
        case steps.Constant(constant):
            return np.broadcast_to(constant, (*values[0].shape[:-1], len(constant)))
        case steps.Scale(x, shift, factor, offset):
            return (values[x] - shift) * factor + offset
        case steps.Affine(x, W, b):
            return values[x] @ W.T + b
        case steps.Apply(x, "softplus"):
            return np.asarray(np.logaddexp(0.0, values[x]))
        case steps.Apply(x, function):
            return np.asarray(getattr(np, function)(values[x]))
        case steps.Take(x, i):
            return values[x][..., i]
        case steps.Products(x, y, i, j):
            return values[x][..., i] * values[y][..., j]
        case steps.GroupSum(x, size):
            return np.asarray(values[x].reshape(*values[x].shape[:-1], -1, size).sum(axis=-1))
        case steps.Softmax(x):
            shares = np.exp(values[x] - values[x].max(axis=-1, keepdims=True))
            return np.asarray(shares / shares.sum(axis=-1, keepdims=True))
        case steps.Join(parts):
            return np.concatenate([values[x] for x in parts], axis=-1)
