"""A closed form number by number, as equations: plain text, LaTeX, sympy."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Generic, Protocol, TypeVar

from surrogate.exports import steps
from surrogate.exports.program import Program
from surrogate.exports.steps import Step

E = TypeVar("E")
"""An expression: a string, or one of sympy's."""


class Algebra(Protocol, Generic[E]):
    """How expressions are made."""

    def number(self, value: float) -> E:
        """A number."""

    def total(self, terms: Sequence[tuple[float, E]], constant: float) -> E:
        """Constant and sum of coefficients times expressions."""

    def scaled(self, x: E, shift: float, factor: float, offset: float) -> E:
        """(x - shift) factor + offset."""

    def product(self, x: E, y: E) -> E:
        """X y."""

    def quotient(self, x: E, y: E) -> E:
        """X / y."""

    def call(self, function: str, x: E) -> E:
        """A function of `surrogate.exports.program`."""

    def define(self, k: int, i: int, expression: E) -> E:
        """What element i of vector k is referred to by from now on."""


def run(program: Program, inputs: Sequence[E], algebra: Algebra[E]) -> list[E]:
    """The elements of the result."""
    values = [list(inputs)]
    for k, step in enumerate(program.steps, start=1):
        elements = _elements(step, values, algebra)
        is_new = not isinstance(step, steps.Constant | steps.Take | steps.Join)
        values.append([algebra.define(k, i, e) if is_new else e for i, e in enumerate(elements)])
    return values[-1]


def _elements(step: Step, values: list[list[E]], algebra: Algebra[E]) -> list[E]:
    match step:
        case steps.Constant(constants):
            return [algebra.number(value) for value in constants.tolist()]
        case steps.Scale(x, shift, factor, offset):
            numbers = zip(values[x], shift.tolist(), factor.tolist(), offset.tolist(), strict=True)
            return [algebra.scaled(*each) for each in numbers]
        case steps.Affine(x, W, b):
            rows = zip(W.tolist(), b.tolist(), strict=True)
            return [
                algebra.total([(w, e) for w, e in zip(row, values[x], strict=True) if w], constant)
                for row, constant in rows
            ]
        case steps.Apply(x, function):
            return [algebra.call(function, e) for e in values[x]]
        case steps.Take(x, i):
            return [values[x][place] for place in i.tolist()]
        case steps.Products(x, y, i, j):
            return [algebra.product(values[x][a], values[y][b]) for a, b in zip(i.tolist(), j.tolist(), strict=True)]
        case steps.GroupSum(x, size):
            groups = [values[x][start : start + size] for start in range(0, len(values[x]), size)]
            return [algebra.total([(1.0, e) for e in group], 0.0) for group in groups]
        case steps.Softmax(x):
            powers = [algebra.call("exp", e) for e in values[x]]
            total = algebra.total([(1.0, power) for power in powers], 0.0)
            return [algebra.quotient(power, total) for power in powers]
        case steps.Join(parts):
            return [e for x in parts for e in values[x]]
