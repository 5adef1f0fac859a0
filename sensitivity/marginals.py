"""Single inputs of any law that SciPy knows."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .distributions import Array, Density

_LEAST = 2.0**-53
"""Numbers in [0, 1) are kept this far from 0 and 1, where an unbounded law would give infinity."""


def inner(u: Array) -> Array:
    """Numbers in [0, 1) moved into the open interval."""
    return np.clip(u, _LEAST, 1.0 - _LEAST)


@dataclass(frozen=True)
class Marginal:
    """One input of a frozen distribution of `scipy.stats`, such as ``stats.norm(2, 0.5)``.

    Continuous and discrete laws serve alike: draws are quantiles.
    """

    name: str
    law: Any
    unit: str = ""

    def __post_init__(self) -> None:
        """Refuse what is no frozen distribution of numbers."""
        if not all(callable(getattr(self.law, method, None)) for method in ("ppf", "cdf", "support")):
            raise ValueError(
                f"The law of {self.name} is {self.law!r}: give a frozen distribution as scipy.stats.norm(0, 1)."
            )
        middle = np.asarray(self.law.ppf(0.5))
        if middle.ndim or not np.isfinite(middle):
            raise ValueError(f"The law of {self.name} has no finite median: give one number for each parameter.")

    def __repr__(self) -> str:
        """As it can be typed in, the law too; SciPy's own text of that is an address in memory."""
        family, law = getattr(self.law, "dist", None), repr(self.law)
        if family is not None and hasattr(self.law, "args"):
            given = [*map(str, self.law.args), *(f"{name}={value}" for name, value in self.law.kwds.items())]
            law = f"stats.{family.name}({', '.join(given)})"
        return f"Marginal({self.name!r}, {law}, {self.unit!r})"

    @property
    def names(self) -> tuple[str, ...]:
        """The input's name."""
        return (self.name,)

    @property
    def units(self) -> tuple[str, ...]:
        """The input's unit."""
        return (self.unit,)

    @property
    def bounds(self) -> tuple[tuple[float, float], ...]:
        """Ends of the support, infinite for an unbounded law."""
        lower, upper = self.law.support()
        return ((float(lower), float(upper)),)

    def sample(self, u: Array) -> Array:
        """Draws (n, 1) from u (n, 1) in [0, 1)."""
        return np.asarray(self.law.ppf(inner(u)), dtype=float)

    def conditional(self, x: Array, redrawn: Sequence[bool], u: Array) -> Array:
        """A single input has no others to depend on: the same as a draw."""
        return self.sample(u)

    def contains(self, x: Array) -> NDArray[np.bool_]:
        """Whether each row of x (n, 1) lies between the ends of the support, shape (n,)."""
        ((lower, upper),) = self.bounds
        return (lower <= x[:, 0]) & (x[:, 0] <= upper)

    def density(self, x: Array, kept: Sequence[bool]) -> Density:
        """Density of the kept columns of x (n, 1); of a discrete law its probability, on a set of dimension 0."""
        if not kept[0]:
            return Density.of_nothing(len(x))
        if hasattr(self.law, "pmf"):
            return Density(np.asarray(self.law.pmf(x[:, 0])), 0)
        return Density(np.asarray(self.law.pdf(x[:, 0])), 1)


@dataclass(frozen=True)
class PointMass:
    """Inputs that stand at one point; a part of a `Mixture`."""

    names: tuple[str, ...]
    at: tuple[float, ...]
    units: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Refuse a point of another length."""
        if isinstance(self.names, str) or len(self.names) != len(self.at) or not np.isfinite(self.at).all():
            raise ValueError(f"A point mass of {self.names!r} is at {self.at!r}: give one finite number for each name.")
        object.__setattr__(self, "units", self.units or ("",) * len(self.names))

    @property
    def bounds(self) -> tuple[tuple[float, float], ...]:
        """The point, as lower and upper end of each input."""
        return tuple((value, value) for value in self.at)

    def sample(self, u: Array) -> Array:
        """The point, once for each row of u (n, len(names))."""
        return np.tile(np.asarray(self.at, dtype=float), (len(u), 1))

    def conditional(self, x: Array, redrawn: Sequence[bool], u: Array) -> Array:
        """The redrawn columns of x (n, len(names)) put to the point."""
        return np.where(redrawn, self.at, x)

    def contains(self, x: Array) -> NDArray[np.bool_]:
        """Whether each row of x (n, len(names)) is the point."""
        return (x == self.at).all(axis=1)

    def density(self, x: Array, kept: Sequence[bool]) -> Density:
        """1 where the kept columns of x (n, len(names)) are at the point, else 0; on a set of dimension 0."""
        return Density(((x == self.at) | ~np.asarray(kept)).all(axis=1).astype(float), 0)
