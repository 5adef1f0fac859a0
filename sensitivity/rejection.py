"""Any inputs, restricted to where a condition holds."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .distributions import Array, Block, Distribution

MOST_TRIES = 10_000
"""Draws after which a row is given up."""
HOPELESS = 1000
"""Draws of which not one met the condition end the search."""


@dataclass(frozen=True, eq=False)
class Conditioned:
    """A distribution given that a condition holds, by rejection; all of its inputs then depend on each other.

    The first try of each row uses the numbers it is given, further ones a generator of their own. So a Sobol sequence
    keeps its evenness only in the rows that are accepted at once: `acceptance` tells how many.

    Args:
        distribution: what the inputs follow without the condition.
        condition: maps points (n, M) to whether it holds (n,), such as "this case has an envelope".
        seed: of the further tries.

    Raises:
        ValueError: when drawing, if the condition holds (almost) nowhere.
    """

    distribution: Distribution
    condition: Callable[[Array], ArrayLike]
    seed: int = 0
    _tried: list[int] = field(default_factory=lambda: [0, 0], init=False, repr=False)

    @property
    def names(self) -> tuple[str, ...]:
        """Name of each input."""
        return self.distribution.names

    @property
    def units(self) -> tuple[str, ...]:
        """Unit of each input."""
        return self.distribution.units

    @property
    def bounds(self) -> tuple[tuple[float, float], ...]:
        """Least and greatest value of each input without the condition."""
        return self.distribution.bounds

    @property
    def acceptance(self) -> float:
        """Share of all draws so far that met the condition; NaN before the first."""
        tried, met = self._tried
        return met / tried if tried else float("nan")

    def sample(self, u: Array) -> Array:
        """Draws (n, M) from u (n, M) in [0, 1)."""
        return self._until_it_holds(lambda rows, v: self.distribution.sample(v), u)

    def conditional(self, x: Array, redrawn: Sequence[bool], u: Array) -> Array:
        """Redraw some columns of x (n, M) given the others and the condition."""
        names = [name for name, mark in zip(self.names, redrawn, strict=True) if mark]
        return self._until_it_holds(lambda rows, v: self.distribution.conditional(x[rows], names, v), u)

    def contains(self, x: Array) -> NDArray[np.bool_]:
        """Whether each row of x (n, M) lies in the support and meets the condition, shape (n,)."""
        return self.distribution.contains(x) & self._holds(x)

    def _until_it_holds(self, draw: Callable[[NDArray[np.intp], Array], Array], u: Array) -> Array:
        rng = np.random.default_rng((self.seed, len(u)))
        drawn, open_rows, v = np.empty_like(u), np.arange(len(u)), u
        for _ in range(MOST_TRIES):
            found = draw(open_rows, v)
            met = self._holds(found)
            self._tried[0] += len(open_rows)
            self._tried[1] += int(met.sum())
            drawn[open_rows[met]] = found[met]
            open_rows = open_rows[~met]
            if not open_rows.size:
                return drawn
            tried, ever_met = self._tried
            if not ever_met and tried >= HOPELESS:
                raise ValueError(
                    f"The condition held in none of {tried} draws: choose a distribution closer to where it holds."
                )
            v = rng.random((len(open_rows), u.shape[1]))
        raise ValueError(
            f"The condition held in none of {MOST_TRIES} draws of {len(open_rows)} rows "
            f"({self.acceptance:.2g} of all draws met it): choose a distribution closer to where it holds."
        )

    def _holds(self, x: Array) -> NDArray[np.bool_]:
        met = np.asarray(self.condition(x))
        if met.shape != (len(x),):
            raise ValueError(f"The condition returned shape {met.shape} for {len(x)} points: return one truth a point.")
        return met.astype(bool)


def conditioned(distribution: Distribution | Sequence[Block], condition: Callable[[Array], ArrayLike]) -> Distribution:
    """The distribution given that a condition holds; see `Conditioned`, which is its only block.

    Args:
        distribution: of the inputs, or the blocks of one.
        condition: tells of points (n, M) whether it holds (n,).
    """
    whole = distribution if isinstance(distribution, Distribution) else Distribution(distribution)
    return Distribution([Conditioned(whole, condition)])
