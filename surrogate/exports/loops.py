"""A closed form as loops over flat arrays, in what C and JavaScript have in common.

Slopes are carried forward: beside each vector v (n,) stands its derivative (n, d) with respect to the d inputs. A
linear step does to the rows of the derivative what it does to the vector, without its constants.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from surrogate.exports import steps
from surrogate.exports.program import Program
from surrogate.exports.steps import Step

VALUES = {
    "tanh": "{tanh}({x})",
    "exp": "{exp}({x})",
    "softplus": "{softplus}({x})",
    "square": "{x} * {x}",
    "sqrt": "{sqrt}({x})",
}
"""Each function of x in the words of a language."""
SLOPES = {
    "tanh": "1 - {y} * {y}",
    "exp": "{y}",
    "softplus": "{exp}({x} - {y})",
    "square": "2 * {x}",
    "sqrt": "0.5 / {y}",
}
"""dy / dx, in terms of x and y."""


@dataclass(frozen=True)
class Language:
    """What differs between the languages: templates of declarations, and the names of functions."""

    counter: str
    """Type of a loop's counter."""
    number: str
    """Declaration of the number {name} = {value}."""
    array: str
    """Declaration of an array: {name}, {size}."""
    numbers: str
    """Declaration of constant numbers: {name}, {size}, {values}."""
    singles: str
    """The same in single precision."""
    indices: str
    """Declaration of constant indices."""
    words: dict[str, str]
    """Names of tanh, exp, softplus, sqrt and max."""


@dataclass
class Tables:
    """Constant arrays of a file; equal ones are written once."""

    language: Language
    prefix: str
    names: dict[tuple[str, bytes], str] = field(default_factory=dict)
    lines: list[str] = field(default_factory=list)

    def name(self, values: np.ndarray) -> str:
        """Name of the array with these values."""
        key = values.dtype.str, values.tobytes()
        if key not in self.names:
            self.names[key] = name = f"{self.prefix}{len(self.names) + 1}"
            language = self.language
            by_type = {"<f8": language.numbers, "<f4": language.singles, "<i8": language.indices}
            declaration = by_type[values.dtype.newbyteorder("<").str]
            listed = _wrapped(map(str, values.ravel() if values.dtype.itemsize == 4 else values.ravel().tolist()))
            self.lines.append(declaration.format(name=name, size=values.size, values=listed))
        return self.names[key]


def _wrapped(items: Iterator[str], width: int = 110) -> str:
    """Items with commas, in lines."""
    lines, line = [], ""
    for item in items:
        if len(line) + len(item) > width:
            lines.append(line.rstrip())
            line = ""
        line += f"{item}, "
    return "\n    ".join([*lines, line.rstrip(", ")])


class Body:
    """Statements that run a program from the array `x` into `y`, and if asked its slopes into `dy`, row by row."""

    def __init__(self, program: Program, tables: Tables, *, has_slopes: bool):
        """Take the program; its constants go to `tables`."""
        self.steps, self.sizes, self.d = program.steps, program.sizes, program.n_inputs
        self.tables, self.language, self.has_slopes = tables, tables.language, has_slopes
        self.values = ["x", *(f"v{k}" for k in range(1, len(self.steps))), "y"]
        self.slopes = [*(f"d{k}" for k in range(len(self.steps))), "dy"]

    def lines(self) -> Iterator[str]:
        """All statements."""
        for k in range(1, len(self.steps)):
            yield self.language.array.format(name=self.values[k], size=self.sizes[k])
        if self.has_slopes:
            for k in range(len(self.steps)):
                yield self.language.array.format(name=self.slopes[k], size=self.sizes[k] * self.d)
            yield self.loop("i", self.d * self.d, f"d0[i] = i % {self.d + 1} == 0 ? 1 : 0;")
        for k, step in enumerate(self.steps, start=1):
            match step:
                case steps.Apply() | steps.Products() | steps.Softmax():
                    yield from self.curved(step, k)
                case _:
                    yield from self.linear(step, k, self.values, 1)
                    if self.has_slopes:
                        yield from self.linear(step, k, self.slopes, self.d)

    def loop(self, counter: str, end: int | str, statement: str) -> str:
        """A loop over one statement."""
        return f"for ({self.language.counter} {counter} = 0; {counter} < {end}; {counter}++) {statement}"

    def linear(self, step: Step, k: int, names: list[str], width: int) -> Iterator[str]:
        """A linear step, on rows of one value or of slopes."""
        y, size, table = names[k], self.sizes[k], self.tables.name
        is_value = width == 1 and names is self.values

        def at(array: str, place: str) -> str:
            return f"{array}[{place}]" if width == 1 else f"{array}[{_factor(place)} * {width} + c]"

        def row(statement: str) -> str:
            return statement if width == 1 else self.loop("c", width, statement)

        match step:
            case steps.Constant(values):
                yield self.loop("i", size * width, f"{y}[i] = {f'{table(values)}[i]' if is_value else 0};")
            case steps.Scale(x, shift, factor, offset):
                moved = f"({at(names[x], 'i')} - {table(shift)}[i])" if is_value else at(names[x], "i")
                added = f" + {table(offset)}[i]" if is_value else ""
                yield self.loop("i", size, row(f"{at(y, 'i')} = {moved} * {table(factor)}[i]{added};"))
            case steps.Affine(x, W, b):
                yield self.loop("i", size * width, f"{y}[i] = {f'{table(b)}[i]' if is_value else 0};")
                columns, rows, place = _columns(W)
                entry = f"{table(columns)}[{place}]"
                term = row(f"{at(y, 'i')} += {entry} * {at(names[x], 'j')};")
                yield self.loop("j", W.shape[1], self.loop("i", rows, term))
            case steps.Take(x, i):
                yield self.loop("i", size, row(f"{at(y, 'i')} = {at(names[x], f'{table(i)}[i]')};"))
            case steps.GroupSum(x, n):
                yield self.loop("i", size * width, f"{y}[i] = 0;")
                term = row(f"{at(y, 'i')} += {at(names[x], f'i * {n} + j')};")
                yield self.loop("i", size, self.loop("j", n, term))
            case steps.Join(parts):
                start = 0
                for x in parts:
                    length = self.sizes[x] * width
                    yield self.loop("i", length, f"{y}[{start} + i] = {names[x]}[i];")
                    start += length

    def curved(self, step: Step, k: int) -> Iterator[str]:
        """A step that is not linear: its values, then its slopes."""
        size, d, table = self.sizes[k], self.d, self.tables.name
        y, dy = f"{self.values[k]}[i]", f"{self.slopes[k]}[i * {d} + c]"
        match step:
            case steps.Apply(x, function):
                words = self.language.words | {"x": f"{self.values[x]}[i]", "y": y}
                value, slope = (formulas[function].format(**words) for formulas in (VALUES, SLOPES))
                derivative = f"({slope}) * {self.slopes[x]}[i * {d} + c]"
            case steps.Products(u, v, i, j):
                left, right = f"{table(i)}[i]", f"{table(j)}[i]"
                a, b = f"{self.values[u]}[{left}]", f"{self.values[v]}[{right}]"
                value = f"{a} * {b}"
                du, dv = f"{self.slopes[u]}[{left} * {d} + c]", f"{self.slopes[v]}[{right} * {d} + c]"
                derivative = f"{du} * {b} + {a} * {dv}"
            case steps.Softmax(x):
                yield from self.shares(self.values[x], self.values[k], k)
                value, derivative = "", f"{y} * ({self.slopes[x]}[i * {d} + c] - m{k}[c])"
                if self.has_slopes:
                    yield self.language.array.format(name=f"m{k}", size=d)
                    yield self.loop("c", d, f"m{k}[c] = 0;")
                    mean = f"m{k}[c] += {y} * {self.slopes[x]}[i * {d} + c];"
                    yield self.loop("i", size, self.loop("c", d, mean))
        if value:
            yield self.loop("i", size, f"{y} = {value};")
        if self.has_slopes:
            yield self.loop("i", size, self.loop("c", d, f"{dy} = {derivative};"))

    def shares(self, x: str, y: str, k: int) -> Iterator[str]:
        """Softmax, with the largest argument taken out so that nothing overflows."""
        size, words = self.sizes[k], self.language.words
        yield self.language.number.format(name=f"top{k}", value=f"{x}[0]")
        yield self.language.number.format(name=f"sum{k}", value="0")
        yield self.loop("i", size, f"top{k} = {words['max']}(top{k}, {x}[i]);")
        yield self.loop("i", size, f"sum{k} += {y}[i] = {words['exp']}({x}[i] - top{k});")
        yield self.loop("i", size, f"{y}[i] /= sum{k};")


def _factor(place: str) -> str:
    return f"({place})" if " " in place else place


def _columns(W: np.ndarray) -> tuple[np.ndarray, str, str]:
    """The columns of W one after the other, rows in column j, place of entry i, j.

    Column by column a compiler can use its vector registers. The zeros of a triangle are left out.
    """
    m, n = W.shape
    if m == n > 1 and not np.tril(W, -1).any():
        return np.concatenate([W[: j + 1, j] for j in range(n)]), "j + 1", "j * (j + 1) / 2 + i"
    return np.ascontiguousarray(W.T), str(m), f"j * {m} + i"
