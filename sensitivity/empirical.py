"""Inputs known by a sample of theirs only: the rows of a table."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from .distributions import Array

LEAST_ROWS = 20


@dataclass(frozen=True, eq=False)
class Empirical:
    """Draws are rows of a table (n, M); conditional draws come from rows whose kept inputs are nearest.

    Distances are of columns scaled by their standard deviation. With k neighbours the conditional law is that of a
    neighbourhood, not of a point: indices have a bias that falls as the table grows.

    Args:
        names: one for each column.
        rows: finite numbers (n, M), n at least `LEAST_ROWS`.
        neighbours: k; 0, the default: the square root of n.

    Raises:
        ValueError: another shape, too few rows, or numbers that are not finite (the first such row is named).
    """

    names: tuple[str, ...]
    rows: ArrayLike
    units: tuple[str, ...] = ()
    neighbours: int = 0
    _table: Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Check the table."""
        table = np.array(self.rows, dtype=float)
        if isinstance(self.names, str) or table.ndim != 2 or table.shape[1] != len(self.names):
            raise ValueError(f"A table of shape {table.shape} has the names {self.names!r}: give one for each column.")
        if len(table) < LEAST_ROWS:
            raise ValueError(f"A table of {len(table)} rows tells too little: give at least {LEAST_ROWS}.")
        bad = np.flatnonzero(~np.isfinite(table).all(axis=1))
        if bad.size:
            raise ValueError(f"{bad.size} rows of the table are not finite, first row {bad[0]}: leave them out.")
        k = self.neighbours or round(np.sqrt(len(table)))
        if not (isinstance(k, int | np.integer) and 1 <= k <= len(table)):
            raise ValueError(f"Neighbours are {k!r}: give a whole number from 1 to {len(table)}.")
        table.flags.writeable = False
        object.__setattr__(self, "_table", table)
        object.__setattr__(self, "neighbours", int(k))
        object.__setattr__(self, "units", tuple(self.units) or ("",) * len(self.names))

    @property
    def bounds(self) -> tuple[tuple[float, float], ...]:
        """Least and greatest value of each column."""
        return tuple(zip(self._table.min(axis=0).tolist(), self._table.max(axis=0).tolist(), strict=True))

    def sample(self, u: Array) -> Array:
        """Rows (n, M) that the first column of u (n, M) in [0, 1) chooses."""
        return self._table[(u[:, 0] * len(self._table)).astype(int)]

    def conditional(self, x: Array, redrawn: Sequence[bool], u: Array) -> Array:
        """Take the redrawn columns of x (n, M) from one of the rows nearest in the others."""
        kept = ~np.asarray(redrawn)
        spread = self._table[:, kept].std(axis=0)
        scale = np.where(spread > 0.0, spread, 1.0)
        _, near = cKDTree(self._table[:, kept] / scale).query(x[:, kept] / scale, k=np.arange(1, self.neighbours + 1))
        choice = (u[:, list(redrawn).index(True)] * self.neighbours).astype(int)
        return np.where(redrawn, self._table[near[np.arange(len(x)), choice]], x)

    def contains(self, x: Array) -> NDArray[np.bool_]:
        """Whether each row of x (n, M) lies inside the least and greatest values, shape (n,)."""
        return ((self._table.min(axis=0) <= x) & (x <= self._table.max(axis=0))).all(axis=1)
