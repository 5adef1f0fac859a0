"""Linear maps between the range of each variable and the intervals [-1, 1] and [0, 1] (paper eq. 43)."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


ROUNDING = 8 * np.finfo(float).eps
"""A column that varies by less than this share of its size holds one value with rounding errors."""

LEAST_RANGE, MOST_RANGE = 1e-150, 1e150
"""Of a column: the squares of what lies between still are numbers."""


def column_ranges(X: Array, names: Iterable[str]) -> Array:
    """Least and greatest value of each column of X (n, d), as an array (d, 2).

    Raises:
        ValueError: a column that does not vary but for rounding, as it has no scale, or whose squares are no numbers.
    """
    ranges = np.column_stack([X.min(axis=0), X.max(axis=0)])
    for name, (least, greatest) in zip(names, ranges, strict=True):
        if greatest - least <= ROUNDING * max(abs(least), abs(greatest)):
            raise ValueError(
                f"'{name}' has the value {least:g} in every sample but for rounding, and must vary: leave it out."
            )
        if not LEAST_RANGE < greatest - least < MOST_RANGE:
            raise ValueError(
                f"'{name}' lies between {least:g} and {greatest:g}, where squares are no numbers: take another unit."
            )
    return ranges


def to_symmetric(X: ArrayLike, ranges: Array) -> Array:
    """Map values (..., d) so that their ranges (d, 2) become [-1, 1] (paper eq. 43)."""
    least, greatest = ranges.T
    return (X - least) * (2.0 / (greatest - least)) - 1.0


def from_symmetric(X_p: Array, ranges: Array) -> Array:
    """Inverse of `to_symmetric`."""
    least, greatest = ranges.T
    return (X_p + 1.0) * ((greatest - least) / 2.0) + least


def to_unit(X: ArrayLike, ranges: Array) -> Array:
    """Map values (..., d) so that their ranges (d, 2) become [0, 1], the scale of the paper's errors."""
    least, greatest = ranges.T
    return (X - least) / (greatest - least)
