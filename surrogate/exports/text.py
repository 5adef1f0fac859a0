"""A closed form as equations to read: plain text, LaTeX."""

from __future__ import annotations

import re
from collections.abc import Sequence

from surrogate.exports.closed_form import ClosedForm
from surrogate.exports.scalars import run
from surrogate.models.evaluation import Variable

WRITTEN_BY = "Written by gtm-fmu from a fitted model."
"""First line of every file."""


def comment_lines(form: ClosedForm) -> list[str]:
    """What a file says first: inputs with their ranges, and outputs."""
    ranges = zip(form.inputs, form.input_ranges.tolist(), strict=True)
    return [
        WRITTEN_BY,
        "Inputs, and their ranges in the training data:",
        *(f"    {k}  {_named(v)}  {low:.10g} .. {high:.10g}" for k, (v, (low, high)) in enumerate(ranges)),
        "Outputs:",
        *(f"    {k}  {_named(v)}" for k, v in enumerate(form.outputs)),
        *_safe_lines(form),
    ]


def _safe_lines(form: ClosedForm) -> list[str]:
    """The safe values by the outputs, and what they promise."""
    if form.safe is None:
        return []
    values = zip(form.safe_outputs, form.safe_places, form.safe.shifts.tolist(), form.safe.outputs, strict=True)
    return [
        "Safe values:",
        *(
            f"    {k}  {_named(v)} = output {place} {shift:+.10g}, {form.safe.about(output)}"
            for k, (v, place, shift, output) in enumerate(values)
        ),
    ]


def _named(variable: Variable) -> str:
    """Name and unit on one line, without what could begin or end a comment of C, or a trigraph."""
    text = f"{variable.name} [{variable.unit}]"
    line = re.sub(r"\s+", " ", "".join(c if c.isprintable() else " " for c in text))
    return re.sub(r"(?<=\*)(?=/)|(?<=/)(?=[*/])|(?<=\?)(?=\?)", " ", line)


class _Text:
    """Expressions in the notation of most programming languages, in lines `v3_2 = ...`."""

    equals = " = "

    def __init__(self) -> None:
        self.lines: list[str] = []

    def number(self, value: float) -> str:
        return repr(value)

    def total(self, terms: Sequence[tuple[float, str]], constant: float) -> str:
        text = "" if constant == 0 and terms else self.number(constant)
        for factor, x in terms:
            sign = ("-" if factor < 0 else "") if not text else " - " if factor < 0 else " + "
            text += f"{sign}{x}" if abs(factor) == 1 else f"{sign}{self.product(self.number(abs(factor)), x)}"
        return text

    def scaled(self, x: str, shift: float, factor: float, offset: float) -> str:
        moved = self.brackets(self.total([(1.0, x)], -shift)) if shift else x
        return self.total([(factor, moved)], offset)

    def brackets(self, x: str) -> str:
        return f"({x})"

    def product(self, x: str, y: str) -> str:
        return f"{x}*{y}"

    def quotient(self, x: str, y: str) -> str:
        return f"{x}/({y})"

    def call(self, function: str, x: str) -> str:
        forms = {"square": f"{x}**2", "softplus": f"log1p(exp({x}))"}
        return forms.get(function, f"{function}({x})")

    def name(self, k: int, i: int) -> str:
        return f"v{k}_{i + 1}"

    def define(self, k: int, i: int, expression: str) -> str:
        name = self.name(k, i)
        self.lines.append(f"{name}{self.equals}{expression}")
        return name


class _Latex(_Text):
    """Expressions in LaTeX."""

    equals = " &= "

    def number(self, value: float) -> str:
        digits, _, exponent = repr(value).partition("e")
        return rf"{digits} \cdot 10^{{{int(exponent)}}}" if exponent else digits

    def brackets(self, x: str) -> str:
        return rf"\left({x}\right)"

    def product(self, x: str, y: str) -> str:
        return rf"{x} \, {y}"

    def quotient(self, x: str, y: str) -> str:
        return rf"\frac{{{x}}}{{{y}}}"

    def call(self, function: str, x: str) -> str:
        forms = {
            "square": rf"{x}^{{2}}",
            "sqrt": rf"\sqrt{{{x}}}",
            "exp": rf"e^{{{x}}}",
            "softplus": rf"\ln\left(1 + e^{{{x}}}\right)",
        }
        return forms.get(function, rf"\{function}\left({x}\right)")

    def name(self, k: int, i: int) -> str:
        return rf"v_{{{k},{i + 1}}}"


def text(form: ClosedForm) -> str:
    """The outputs as equations, one a line; x1, x2, ... are the inputs and y1, y2, ... the outputs."""
    algebra = _Text()
    results = run(form.predict, [f"x{i + 1}" for i in range(len(form.inputs))], algebra)
    names = [f"x{i + 1} = {_named(v)}" for i, v in enumerate(form.inputs)]
    outputs = [f"y{i + 1} = {result}" for i, result in enumerate(results)]
    named = [f"{_named(v)} = y{i + 1}" for i, v in enumerate(form.outputs)]
    head = [f"# {line}" for line in [*comment_lines(form), "", *names, *named]]
    return "\n".join([*head, "", *algebra.lines, *outputs]) + "\n"


def latex(form: ClosedForm) -> str:
    """The outputs as equations, for amsmath; x_1, x_2, ... are the inputs and y_1, y_2, ... the outputs."""
    algebra = _Latex()
    results = run(form.predict, [f"x_{{{i + 1}}}" for i in range(len(form.inputs))], algebra)
    outputs = [f"y_{{{i + 1}}} &= {result}" for i, result in enumerate(results)]
    variables = [
        (letter, i + 1, variable)
        for letter, group in (("x", form.inputs), ("y", form.outputs))
        for i, variable in enumerate(group)
    ]
    where = [rf"${letter}_{{{i}}}$: {_escaped(v.name)} ({_escaped(v.unit)})" for letter, i, v in variables]
    lines = " \\\\\n".join([*algebra.lines, *outputs])
    return f"\\begin{{align*}}\n{lines}\n\\end{{align*}}\n" + ", ".join(where) + ".\n"


def _escaped(name: str) -> str:
    """Text in LaTeX."""
    special = {"\\": r"\textbackslash{}", "^": r"\textasciicircum{}", "~": r"\textasciitilde{}"}
    return "".join(special.get(c, f"\\{c}" if c in "&%$#_{}" else c) for c in name)
