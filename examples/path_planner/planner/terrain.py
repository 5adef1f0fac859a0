"""Heights of the ground on a grid of north and east."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gtm_fmu.errors import InputError


@dataclass(frozen=True)
class Terrain:
    """A grid of heights, bilinear between its points.

    Attributes:
        north_m, east_m: of the rows and the columns, evenly spaced and increasing.
        height_ft: above sea level (rows, columns).
    """

    north_m: np.ndarray
    east_m: np.ndarray
    height_ft: np.ndarray

    def height(self, north_m: np.ndarray, east_m: np.ndarray) -> np.ndarray:
        """Of the ground in ft, infinite outside the grid."""
        row = (north_m - self.north_m[0]) / (self.north_m[1] - self.north_m[0])
        column = (east_m - self.east_m[0]) / (self.east_m[1] - self.east_m[0])
        rows, columns = self.height_ft.shape
        inside = (row >= 0) & (row <= rows - 1) & (column >= 0) & (column <= columns - 1)
        i = np.clip(row.astype(int), 0, rows - 2)
        j = np.clip(column.astype(int), 0, columns - 2)
        u, v = row - i, column - j
        z = self.height_ft
        height = (1 - u) * ((1 - v) * z[i, j] + v * z[i, j + 1]) + u * ((1 - v) * z[i + 1, j] + v * z[i + 1, j + 1])
        return np.where(inside, height, np.inf)


def flat(height_ft: float = 0.0, size_m: float = 30_000.0) -> Terrain:
    """A plain about the origin."""
    axis = np.array([-size_m, size_m])
    return Terrain(axis, axis, np.full((2, 2), height_ft))


def read(path: Path) -> Terrain:
    """A grid from a file of this package (``.npz`` with the names of `Terrain`).

    Raises:
        InputError: no such file, or none of this kind.
    """
    try:
        with np.load(path) as arrays:
            return Terrain(arrays["north_m"], arrays["east_m"], arrays["height_ft"].astype(float))
    except (OSError, KeyError, ValueError) as error:
        raise InputError(
            f"'{path}' is no terrain grid ({error}): give a .npz of north_m, east_m, height_ft."
        ) from error
