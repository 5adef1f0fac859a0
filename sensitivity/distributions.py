"""Input distributions: joint sampling, and sampling of any subset of the inputs given all the others.

A distribution is a product of independent blocks. Inputs of one block may depend on each other; variance-based indices
of dependent inputs then need draws from p(z | y) for every split of the inputs into y and z (Kucherenko, Tarantola,
Annoni 2012). All draws are transformations of numbers in [0, 1), so random and quasi-random points serve alike.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import ClassVar, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


class Density(NamedTuple):
    """Density (n,) of some inputs at n points, on a set of this dimension.

    A share of the probability may lie on a line or a point of the space. Where it does, it outweighs any density of a
    higher dimension.
    """

    value: Array
    dimension: int

    @classmethod
    def of_nothing(cls, n: int) -> "Density":
        """That of no inputs at all, at n points."""
        return cls(np.ones(n), 0)


class Block(Protocol):
    """Inputs that are independent of all other blocks; implement this to bring a distribution of your own."""

    @property
    def names(self) -> tuple[str, ...]:
        """Name of each input."""

    @property
    def units(self) -> tuple[str, ...]:
        """Unit of each input, "" where it has none."""

    def sample(self, u: Array) -> Array:
        """Map numbers u in [0, 1), shape (n, len(names)), to draws of the joint distribution, same shape."""

    def conditional(self, x: Array, redrawn: Sequence[bool], u: Array) -> Array:
        """Return x with the columns marked in `redrawn` drawn anew given the others; all shapes (n, len(names)).

        It is called only where some, but not all, columns are marked; each redrawn column uses its own column of u.
        """

    def contains(self, x: Array) -> NDArray[np.bool_]:
        """Whether each row of x (n, len(names)) lies in the support, shape (n,)."""


class BlockWithDensity(Block, Protocol):
    """A block that can be a part of a `Mixture`."""

    def density(self, x: Array, kept: Sequence[bool]) -> Density:
        """Density of the columns of x (n, len(names)) that are marked in `kept`, whatever the others are."""


@dataclass(frozen=True)
class Uniform:
    """One input, uniform on [lower, upper)."""

    name: str
    lower: float
    upper: float
    unit: str = ""

    def __post_init__(self) -> None:
        """Refuse bounds that are not finite and increasing."""
        check_bounds(self.name, self.lower, self.upper)

    @property
    def names(self) -> tuple[str, ...]:
        """The input's name."""
        return (self.name,)

    @property
    def units(self) -> tuple[str, ...]:
        """The input's unit."""
        return (self.unit,)

    def sample(self, u: Array) -> Array:
        """Draws (n, 1) from u (n, 1) in [0, 1)."""
        return _between(self.lower, self.upper, u)

    def conditional(self, x: Array, redrawn: Sequence[bool], u: Array) -> Array:
        """A single input has no others to depend on: the same as a draw."""
        return self.sample(u)

    def contains(self, x: Array) -> NDArray[np.bool_]:
        """Whether each row of x (n, 1) lies in [lower, upper], shape (n,)."""
        return (self.lower <= x[:, 0]) & (x[:, 0] <= self.upper)

    @property
    def bounds(self) -> tuple[tuple[float, float], ...]:
        """Least and greatest value."""
        return ((self.lower, self.upper),)

    def density(self, x: Array, kept: Sequence[bool]) -> Density:
        """Density of the kept columns of x (n, 1)."""
        if not kept[0]:
            return Density.of_nothing(len(x))
        return Density(self.contains(x).astype(float) / (self.upper - self.lower), 1)


@dataclass(frozen=True)
class UniformPair:
    """Two inputs of one unit on [lower, upper]; `relation` stands between their names in messages."""

    relation: ClassVar[str]
    names: tuple[str, str]
    lower: float
    upper: float
    unit: str = ""

    def __post_init__(self) -> None:
        """Refuse anything but two names and finite, increasing bounds."""
        if isinstance(self.names, str) or len(self.names) != 2:
            raise ValueError(f"{type(self).__name__} has exactly two names, got {self.names!r}: give (lower, upper).")
        check_bounds(self.relation.join(self.names), self.lower, self.upper)

    @property
    def units(self) -> tuple[str, str]:
        """The unit, once for each input."""
        return (self.unit, self.unit)


@dataclass(frozen=True)
class OrderedUniform(UniformPair):
    """A pair (LL, UL), uniform on the triangle lower <= LL <= UL <= upper.

    The density of LL falls linearly to zero at `upper`, that of UL rises linearly from zero at `lower`. Given LL, UL is
    uniform on [LL, upper]; given UL, LL is uniform on [lower, UL]. The paper's map of the unit square (eq. 63) gives
    the same joint distribution, but its p1 and p2 are not LL and UL: holding one of them is no conditional draw.
    """

    relation = " <= "

    def sample(self, u: Array) -> Array:
        """Draws (n, 2) from u (n, 2) in [0, 1): LL by inversion of its marginal distribution, then UL given LL."""
        lower_limit = _between(self.lower, self.upper, 1.0 - np.sqrt(1.0 - u[:, 0]))
        return np.column_stack([lower_limit, _between(lower_limit, self.upper, u[:, 1])])

    def conditional(self, x: Array, redrawn: Sequence[bool], u: Array) -> Array:
        """Redraw LL given UL, or UL given LL; shapes (n, 2)."""
        lower_limit, upper_limit = x[:, 0], x[:, 1]
        if redrawn[0]:
            return np.column_stack([_between(self.lower, upper_limit, u[:, 0]), upper_limit])
        return np.column_stack([lower_limit, _between(lower_limit, self.upper, u[:, 1])])

    def contains(self, x: Array) -> NDArray[np.bool_]:
        """Whether each row of x (n, 2) lies in the closed triangle, shape (n,)."""
        return (self.lower <= x[:, 0]) & (x[:, 0] <= x[:, 1]) & (x[:, 1] <= self.upper)

    @property
    def bounds(self) -> tuple[tuple[float, float], ...]:
        """Least and greatest value of each input."""
        return ((self.lower, self.upper),) * 2

    def density(self, x: Array, kept: Sequence[bool]) -> Density:
        """Density of the kept columns of x (n, 2)."""
        width = self.upper - self.lower
        if all(kept):
            return Density(self.contains(x).astype(float) * (2.0 / width**2), 2)
        if not any(kept):
            return Density.of_nothing(len(x))
        column = x[:, list(kept).index(True)]
        above = self.upper - column if kept[0] else column - self.lower
        inside = (self.lower <= column) & (column <= self.upper)
        return Density(2.0 * inside * above / width**2, 1)


class Distribution:
    """Joint distribution of all inputs: independent blocks side by side, one column an input.

    `names` and `units` follow the order of the blocks; `dependent` lists the names of each block with several inputs.
    """

    def __init__(self, blocks: Sequence[Block]) -> None:
        """Join the blocks; every input needs a name of its own."""
        self.blocks = tuple(blocks)
        self.names = tuple(name for block in self.blocks for name in block.names)
        self.units = tuple(unit for block in self.blocks for unit in block.units)
        self.dependent = tuple(tuple(block.names) for block in self.blocks if len(block.names) > 1)
        if not self.blocks:
            raise ValueError("A distribution needs at least one block, got none: give for instance Uniform('x', 0, 1).")
        repeated = sorted({name for name in self.names if self.names.count(name) > 1})
        if repeated:
            raise ValueError(f"Input names must differ, but {repeated} occur more than once: rename them.")
        ends = np.cumsum([len(block.names) for block in self.blocks])
        self._columns = [slice(end - len(block.names), end) for block, end in zip(self.blocks, ends, strict=True)]

    def __repr__(self) -> str:
        """The blocks as they can be typed in."""
        return f"Distribution([{', '.join(map(repr, self.blocks))}])"

    def sample(self, u: ArrayLike) -> Array:
        """Map numbers u in [0, 1), shape (n, inputs), to draws of the joint distribution, same shape."""
        u = self._unit_numbers(u)
        return np.hstack([block.sample(u[:, c]) for block, c in zip(self.blocks, self._columns, strict=True)])

    def conditional(self, x: ArrayLike, redrawn: Collection[str], u: ArrayLike) -> Array:
        """Draw the inputs named in `redrawn` anew from their distribution given all other inputs.

        x (n, inputs) holds the points, u (n, inputs) numbers in [0, 1) independent of x; only the columns of u of the
        redrawn inputs are used. Returns (n, inputs) with the other columns unchanged.
        """
        self.check_names(redrawn)
        x, u = np.array(x, dtype=float), self._unit_numbers(u)
        if x.shape != u.shape:
            raise ValueError(f"Points have shape {x.shape}, unit numbers {u.shape}: give one number for each input.")
        for block, c in zip(self.blocks, self._columns, strict=True):
            marks = [name in redrawn for name in block.names]
            if all(marks):
                x[:, c] = block.sample(u[:, c])
            elif any(marks):
                x[:, c] = block.conditional(x[:, c], marks, u[:, c])
        return x

    def contains(self, x: ArrayLike) -> NDArray[np.bool_]:
        """Whether each row of x (n, inputs) lies in the support, shape (n,)."""
        x = np.asarray(x, dtype=float)
        inside = [block.contains(x[:, c]) for block, c in zip(self.blocks, self._columns, strict=True)]
        return np.logical_and.reduce(inside)

    def complement(self, names: Collection[str]) -> tuple[str, ...]:
        """All inputs but ``names``, in order."""
        return tuple(name for name in self.names if name not in names)

    @property
    def bounds(self) -> tuple[tuple[float, float], ...]:
        """Least and greatest value of each input; infinite where it has none, or a block does not tell."""
        unknown = (-np.inf, np.inf)
        return tuple(pair for block in self.blocks for pair in getattr(block, "bounds", (unknown,) * len(block.names)))

    def check_names(self, names: Collection[str]) -> None:
        """Refuse ``names`` that are not inputs of this distribution by a ValueError."""
        unknown = sorted(set(names) - set(self.names))
        if isinstance(names, str) or unknown:
            raise ValueError(f"{names!r} is not a list of inputs: choose from {', '.join(self.names)}.")

    def _unit_numbers(self, u: ArrayLike) -> Array:
        u = np.asarray(u, dtype=float)
        if u.ndim != 2 or u.shape[1] != len(self.names):
            raise ValueError(
                f"Unit numbers have shape {u.shape}, expected (n, {len(self.names)}): one column an input."
            )
        if not np.all((u >= 0.0) & (u < 1.0)):
            raise ValueError("Unit numbers must lie in [0, 1): take them from a random generator or a Sobol sequence.")
        return u


def _between(lower: float | Array, upper: float | Array, u: Array) -> Array:
    """The point a fraction u < 1 of the way up; u <= 1 - 2^-53 outweighs the rounding, so it never passes `upper`."""
    return lower + (upper - lower) * u


def check_bounds(what: str, lower: float, upper: float) -> None:
    """Refuse bounds that are not finite and increasing."""
    if not (np.isfinite(lower) and np.isfinite(upper) and lower < upper):
        raise ValueError(f"Bounds of {what} are [{lower:g}, {upper:g}]: give finite bounds with lower < upper.")
