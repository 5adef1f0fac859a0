"""A closed form as sympy expressions. Needs sympy."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from surrogate.exports.closed_form import ClosedForm
from surrogate.exports.scalars import run

if TYPE_CHECKING:
    from sympy import Expr


class _Sympy:
    def number(self, value: float) -> Expr:
        import sympy

        return sympy.Float(value)

    def total(self, terms: Sequence[tuple[float, Expr]], constant: float) -> Expr:
        import sympy

        return sympy.Add(self.number(constant) if constant else 0, *(self.number(w) * x for w, x in terms))

    def scaled(self, x: Expr, shift: float, factor: float, offset: float) -> Expr:
        return (x - self.number(shift)) * self.number(factor) + self.number(offset)

    def product(self, x: Expr, y: Expr) -> Expr:
        return x * y

    def quotient(self, x: Expr, y: Expr) -> Expr:
        return x / y

    def call(self, function: str, x: Expr) -> Expr:
        import sympy

        if function == "square":
            return x**2
        return sympy.log(1 + sympy.exp(x)) if function == "softplus" else getattr(sympy, function)(x)

    def define(self, k: int, i: int, expression: Expr) -> Expr:
        return expression


def sympy_expressions(form: ClosedForm) -> dict[str, Expr]:
    """Each output by its name, as an expression of real symbols with the names of the inputs."""
    import sympy

    symbols = [sympy.Symbol(variable.name, real=True) for variable in form.inputs]
    with sympy.evaluate(False):  # which would multiply brackets out, and lose digits by it
        results = run(form.predict, symbols, _Sympy())
    return {variable.name: result for variable, result in zip(form.outputs, results, strict=True)}
