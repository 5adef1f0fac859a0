"""Mixtures: some cases of one law, others of another, point masses included."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .distributions import Array, BlockWithDensity, Density, OrderedUniform, UniformPair


@dataclass(frozen=True)
class Equal(UniformPair):
    """Two inputs that are always equal, uniform on [lower, upper): a jam, as limits. A part of a `Mixture`."""

    relation = " = "

    @property
    def bounds(self) -> tuple[tuple[float, float], ...]:
        """Least and greatest value of each input."""
        return ((self.lower, self.upper),) * 2

    def sample(self, u: Array) -> Array:
        """Draws (n, 2) from the first column of u (n, 2) in [0, 1)."""
        return np.repeat(self.lower + (self.upper - self.lower) * u[:, :1], 2, axis=1)

    def conditional(self, x: Array, redrawn: Sequence[bool], u: Array) -> Array:
        """The other input's value; x (n, 2)."""
        return np.repeat(x[:, 1:] if redrawn[0] else x[:, :1], 2, axis=1)

    def contains(self, x: Array) -> NDArray[np.bool_]:
        """Whether each row of x (n, 2) holds one value between the bounds twice, shape (n,)."""
        return (x[:, 0] == x[:, 1]) & (self.lower <= x[:, 0]) & (x[:, 0] <= self.upper)

    def density(self, x: Array, kept: Sequence[bool]) -> Density:
        """Density of the kept columns of x (n, 2), which lie on a line even if both are kept."""
        if not any(kept):
            return Density.of_nothing(len(x))
        column = x[:, list(kept).index(True)]
        inside = self.contains(x) if all(kept) else (self.lower <= column) & (column <= self.upper)
        return Density(inside / (self.upper - self.lower), 1)


@dataclass(frozen=True)
class Mixture:
    """Each case follows one of several laws of the same inputs, by chance.

    Given some inputs, a law keeps its weight times its density there; one that has a share of its probability on that
    very point or line outweighs those that have none.

    Args:
        parts: blocks with `density` and the same names.
        weights: share of the cases that follow each; they are scaled to sum to one.

    Raises:
        ValueError: parts of other names or without a density, or weights that are none.
    """

    parts: tuple[BlockWithDensity, ...]
    weights: tuple[float, ...]

    def __post_init__(self) -> None:
        """Check the parts and scale the weights."""
        if len(self.parts) < 2 or len(self.weights) != len(self.parts):
            raise ValueError(f"{len(self.parts)} parts have {len(self.weights)} weights: give two or more, one each.")
        for part in self.parts:
            if tuple(part.names) != tuple(self.parts[0].names):
                raise ValueError(f"Parts of a mixture have the names {self.parts[0].names} and {part.names}: give one.")
            if not hasattr(part, "density"):
                raise ValueError(f"{part!r} has no density, which a part of a mixture needs: choose another law.")
        weights = np.asarray(self.weights, dtype=float)
        if not (np.isfinite(weights).all() and (weights >= 0.0).all() and weights.sum() > 0.0):
            raise ValueError(f"Weights of a mixture are {tuple(self.weights)}: give numbers from 0 with a sum above 0.")
        object.__setattr__(self, "parts", tuple(self.parts))
        object.__setattr__(self, "weights", tuple((weights / weights.sum()).tolist()))

    @property
    def names(self) -> tuple[str, ...]:
        """Name of each input."""
        return tuple(self.parts[0].names)

    @property
    def units(self) -> tuple[str, ...]:
        """Unit of each input."""
        return tuple(self.parts[0].units)

    @property
    def bounds(self) -> tuple[tuple[float, float], ...]:
        """Least and greatest value of each input over the parts."""
        ends = np.array([part.bounds for part in self.parts])  # type: ignore[attr-defined]
        return tuple(zip(ends[..., 0].min(axis=0).tolist(), ends[..., 1].max(axis=0).tolist(), strict=True))

    def sample(self, u: Array) -> Array:
        """Draws (n, M) from u (n, M) in [0, 1); the first column also chooses the part."""
        weights = np.tile(self.weights, (len(u), 1))
        return self._each_by_its_part(weights, 0, u, lambda part, rows, v: part.sample(v))

    def conditional(self, x: Array, redrawn: Sequence[bool], u: Array) -> Array:
        """Redraw some columns of x (n, M): the part by its weight given the others, then by that part."""
        densities = [part.density(x, [not mark for mark in redrawn]) for part in self.parts]
        dimension = np.array([[d.dimension] for d in densities]) * np.ones(len(x))
        value = np.array([d.value for d in densities])
        lowest = np.where(value > 0.0, dimension, np.inf).min(axis=0)
        weights = np.where(dimension == lowest, value, 0.0).T * self.weights
        return self._each_by_its_part(
            weights / weights.sum(axis=1, keepdims=True),
            list(redrawn).index(True),
            u,
            lambda part, rows, v: part.conditional(x[rows], redrawn, v),
        )

    def contains(self, x: Array) -> NDArray[np.bool_]:
        """Whether each row of x (n, M) lies in the support of a part, shape (n,)."""
        return np.logical_or.reduce([part.contains(x) for part in self.parts])

    def _each_by_its_part(
        self, weights: Array, column: int, u: Array, draw: Callable[[BlockWithDensity, NDArray[np.intp], Array], Array]
    ) -> Array:
        """Rows drawn by the part that a column of u chooses by `weights` (n, parts).

        A number's place inside its part's stretch of [0, 1) is uniform too, so that place is what the part is drawn by.
        """
        ends = np.cumsum(weights, axis=1)
        chosen = (u[:, [column]] >= ends[:, :-1]).sum(axis=1)
        rows = np.arange(len(u))
        start = np.where(chosen > 0, ends[rows, chosen - 1], 0.0)
        v = u.copy()
        v[:, column] = np.clip((u[:, column] - start) / weights[rows, chosen], 0.0, 1.0 - 2.0**-53)
        drawn = np.empty((len(u), len(self.names)))
        for k, part in enumerate(self.parts):
            mine = np.flatnonzero(chosen == k)
            if mine.size:
                drawn[mine] = draw(part, mine, v[mine])
        return drawn


def ordered_with_jams(
    names: tuple[str, str], lower: float, upper: float, jam_share: float, unit: str = ""
) -> Mixture | OrderedUniform | Equal:
    """Limits of a control: a share of the cases are jams (both equal), the others uniform on LL <= UL.

    Args:
        names: of the lower and the upper limit.
        lower: least value of both.
        upper: greatest value of both.
        jam_share: share of the jams, 0 .. 1.
        unit: of both limits.

    Raises:
        ValueError: a share outside 0 .. 1, or bounds that `OrderedUniform` refuses.
    """
    if not 0.0 <= jam_share <= 1.0:
        raise ValueError(f"The share of jams is {jam_share:g}: give a number from 0 to 1.")
    pair, jam = OrderedUniform(names, lower, upper, unit), Equal(names, lower, upper, unit)
    if jam_share in (0.0, 1.0):
        return jam if jam_share else pair
    return Mixture((pair, jam), (1.0 - jam_share, jam_share))
