"""Envelopes of every failure of the rudder over a grid of cells: altitude, flight path, lower and upper limit.

A restricted rudder may be held anywhere in its range, so its envelope is the union of those of its jams: V_min the
lowest, V_max the highest, t_min the least of them. The jams of 15 360 cells give the envelopes of half a million cases.
Exact jams come with the package; ``python -m gtm_study.paper.rudder_grid FOLDER`` computes them anew in a minute of
processor time, and goes on where it was stopped.
"""

import argparse
import sys
from collections.abc import Callable
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from rich.console import Console

from gtm_fmu.aircraft.ranges import WIDEST, Range
from gtm_fmu.datasets.axes import levels, limit_levels
from gtm_fmu.datasets.cases import CaseTable
from gtm_fmu.datasets.paper import ALTITUDE_FT, GAMMA_DEG
from gtm_fmu.envelopes.thrust_map import ThrustMap
from gtm_fmu.errors import script
from gtm_fmu.files import write_whole
from gtm_study.progress import stages

FILE = Path(str(files("gtm_study.paper") / "data" / "rudder_jams.npz"))
RESULTS = ("v_min", "v_max", "t_min")


def middles(bounds: Range, cells: int) -> np.ndarray:
    """Middles of even cells between two bounds."""
    lower, upper = bounds
    return lower + (upper - lower) * (np.arange(cells) + 0.5) / cells


class Cells(NamedTuple):
    """Number of cells of each axis."""

    altitude: int
    gamma: int
    rudder: int

    @property
    def axes(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Middles of the cells in ft and deg."""
        ranges = ALTITUDE_FT, GAMMA_DEG, WIDEST["rudder_deg"]
        altitude, gamma, rudder = (middles(bounds, cells) for bounds, cells in zip(ranges, self, strict=True))
        return altitude, gamma, rudder

    @property
    def jams(self) -> np.ndarray:
        """Cases (cells, 4) of a rudder jammed at the middles: altitude, flight path, lower and upper limit."""
        altitude, gamma, rudder = np.meshgrid(*self.axes, indexing="ij")
        return np.stack([altitude, gamma, rudder, rudder], axis=-1).reshape(-1, 4)

    @property
    def cases(self) -> np.ndarray:
        """Every case (altitude, gamma, rudder, rudder, 4); those with the lower limit above the upper one are none."""
        altitude, gamma, rudder = self.axes
        return np.stack(np.meshgrid(altitude, gamma, rudder, rudder, indexing="ij"), axis=-1)

    @property
    def weights(self) -> np.ndarray:
        """Share of each case's cell (altitude, gamma, rudder, rudder) that lies in the triangle of limits in order."""
        inside = np.triu(np.ones((self.rudder, self.rudder)), 1) + 0.5 * np.eye(self.rudder)
        return np.broadcast_to(inside, (self.altitude, self.gamma, *inside.shape))


EXACT_CELLS = Cells(16, 16, 60)


@dataclass(frozen=True, eq=False)
class RudderGrid:
    """Envelopes (altitude, gamma, lower limit, upper limit) over cells; NaN where there is none.

    Attributes:
        speeds_kt: (.., 2) V_min and V_max.
        t_min_pct: least throttle; None of a grid that was not asked for it.
    """

    cells: Cells
    speeds_kt: np.ndarray
    t_min_pct: np.ndarray | None = None

    @property
    def has_envelope(self) -> np.ndarray:
        """Whether each case has an envelope."""
        return np.isfinite(self.speeds_kt).all(axis=-1)

    @classmethod
    def of_jams(
        cls, cells: Cells, v_min_kt: ArrayLike, v_max_kt: ArrayLike, t_min_pct: ArrayLike | None = None
    ) -> "RudderGrid":
        """The grid of the jams (cells); NaN where there is no envelope."""
        lowest, highest = _over_ranges(cells, v_min_kt, np.fmin), _over_ranges(cells, v_max_kt, np.fmax)
        t_min = None if t_min_pct is None else _over_ranges(cells, t_min_pct, np.fmin)
        return cls(cells, np.stack([lowest, highest], axis=-1), t_min)


def _over_ranges(cells: Cells, jams: ArrayLike, best: np.ufunc) -> np.ndarray:
    """The best of the jams (cells) of every range (altitude, gamma, lower limit, upper limit)."""
    jams = np.reshape(jams, cells)
    found = np.full((*jams.shape, cells.rudder), np.nan)
    for k in range(cells.rudder):
        found[:, :, k, k:] = best.accumulate(jams[:, :, k:], axis=2)
    return found


def mapped(cells: Cells, thrust_map: ThrustMap) -> RudderGrid:
    """By a thrust map."""
    found = thrust_map.predict(cells.jams)
    return RudderGrid.of_jams(cells, found.v_min_kt, found.v_max_kt)


def exact() -> RudderGrid:
    """The exact one that comes with the package."""
    with np.load(FILE) as content:
        return RudderGrid.of_jams(EXACT_CELLS, *(content[name].astype(float) for name in RESULTS))


def solve(
    folder: Path, cells: Cells = EXACT_CELLS, workers: int | None = None, progress: Callable | None = None
) -> dict[str, np.ndarray]:
    """Exact V_min, V_max and t_min (cells) of the jams.

    Raises:
        InputError: as `distribution.compute`.
    """
    from gtm_fmu.datasets.distribution import compute
    from gtm_fmu.datasets.store import open_cases

    altitude, gamma, rudder = (axis.tolist() for axis in cells.axes)
    jams = limit_levels("rudder", [(jam, jam) for jam in rudder])
    table = CaseTable.lattice([levels("altitude", altitude), levels("gamma", gamma), jams])
    store = folder / FILE.with_suffix(".zarr").name
    compute(store, table, workers=workers, progress=progress)
    data = open_cases(store)
    return {name: data[name].values for name in RESULTS}


@script
def main() -> None:
    """Compute the jams and write the file of the package into a folder; 2 where that cannot be done."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="where the data set goes, and the file made of it")
    parser.add_argument("--workers", type=int, help="processes; default one a core")
    given = parser.parse_args()
    with stages(Console(stderr=True)) as stage, stage("Envelopes of jammed rudders") as advance:
        found = solve(given.folder, workers=given.workers, progress=advance)
    write_arrays(given.folder / FILE.name, found)


def write_arrays(path: Path, arrays: dict[str, np.ndarray]) -> None:
    """Write arrays in single precision, in one piece.

    Raises:
        InputError: it cannot be written.
    """

    def write(draft: Path) -> None:
        with draft.open("wb") as file:
            rounded = {name: values.astype("f4") for name, values in arrays.items()}
            np.savez_compressed(file, allow_pickle=False, **rounded)

    write_whole(path, write)


if __name__ == "__main__":
    sys.exit(main())
