"""Shares that sum to one: mixtures of substances, probabilities, allocations."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from .distributions import Array
from .marginals import inner


@dataclass(frozen=True)
class Simplex:
    """Shares of a total with Dirichlet's law; the default concentrations, all 1, are uniform on the simplex.

    Given the kept shares, the redrawn ones share out the rest by the same law. A single redrawn share is what is left,
    so its total index is 0.

    Raises:
        ValueError: fewer than two names, a concentration or total that is not above 0.
    """

    names: tuple[str, ...]
    concentration: tuple[float, ...] = ()
    total: float = 1.0
    unit: str = ""

    def __post_init__(self) -> None:
        """Check the numbers."""
        weights = tuple(self.concentration) or (1.0,) * len(self.names)
        if isinstance(self.names, str) or len(self.names) < 2 or len(weights) != len(self.names):
            raise ValueError(f"Shares {self.names!r} have {len(weights)} concentrations: give two or more, one each.")
        if not all(np.isfinite(w) and w > 0.0 for w in (*weights, self.total)):
            raise ValueError(f"Concentrations {weights} and the total {self.total:g} must be above 0.")
        object.__setattr__(self, "concentration", weights)

    @property
    def units(self) -> tuple[str, ...]:
        """The unit, once for each share."""
        return (self.unit,) * len(self.names)

    @property
    def bounds(self) -> tuple[tuple[float, float], ...]:
        """Nothing to everything."""
        return ((0.0, self.total),) * len(self.names)

    def sample(self, u: Array) -> Array:
        """Draws (n, M) from u (n, M) in [0, 1)."""
        return self.total * self._shares(u, np.arange(len(self.names)))

    def conditional(self, x: Array, redrawn: Sequence[bool], u: Array) -> Array:
        """Share out what the kept columns of x (n, M) leave."""
        y = np.flatnonzero(redrawn)
        left = self.total - x[:, ~np.asarray(redrawn)].sum(axis=1, keepdims=True)
        drawn = x.copy()
        drawn[:, y] = np.maximum(left, 0.0) * self._shares(u, y)
        return drawn

    def contains(self, x: Array) -> NDArray[np.bool_]:
        """Whether each row of x (n, M) has no negative share and sums to the total but for rounding, shape (n,)."""
        rounding = 8 * len(self.names) * np.finfo(float).eps * self.total
        return (x >= 0.0).all(axis=1) & (np.abs(x.sum(axis=1) - self.total) <= rounding)

    def _shares(self, u: Array, columns: NDArray[np.intp]) -> Array:
        """Gamma draws over their sum (n, len(columns))."""
        parts = stats.gamma.ppf(inner(u[:, columns]), np.asarray(self.concentration)[columns])
        return parts / parts.sum(axis=1, keepdims=True)
