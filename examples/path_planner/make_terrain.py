"""Make the terrain that ships: `python examples/path_planner/make_terrain.py` writes terrain/ridge.npz anew.

A valley at 4000 ft, in the north a ridge of 3200 ft that runs from the west to its end at 2.5 km east, with a pass
in it, and two hills. No real place.
"""

import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from gtm_fmu.files import write_whole  # noqa: E402

SPACING_M, SIZE_M = 200.0, 14_000.0
VALLEY_FT, RIDGE_FT, RIDGE_NORTH_M, RIDGE_END_M, WIDTH_M = 4000.0, 3200.0, 5500.0, 2500.0, 1100.0
PASS_EAST_M, PASS_WIDTH_M, PASS_PART = -6500.0, 1400.0, 0.35
HILLS = ((1500.0, -6000.0, 1800.0, 1300.0), (-4500.0, 5000.0, 2200.0, 1600.0))
"""North and east in m, height in ft, width in m."""


def heights_ft(north_m: np.ndarray, east_m: np.ndarray) -> np.ndarray:
    """Of the ground: Gaussian across the ridge, a logistic end, a Gaussian pass, Gaussian hills."""
    across = np.exp(-(((north_m - RIDGE_NORTH_M) / WIDTH_M) ** 2))
    ends = 1.0 / (1.0 + np.exp((east_m - RIDGE_END_M) / 400.0))
    gap = 1.0 - PASS_PART * np.exp(-(((east_m - PASS_EAST_M) / PASS_WIDTH_M) ** 2))
    hills = sum(h * np.exp(-((north_m - n) ** 2 + (east_m - e) ** 2) / w**2) for n, e, h, w in HILLS)
    return VALLEY_FT + RIDGE_FT * across * ends * gap + hills


def main() -> None:
    """Write the grid."""
    axis = np.arange(-SIZE_M, SIZE_M + 1.0, SPACING_M)
    grid = np.rint(heights_ft(*np.meshgrid(axis, axis, indexing="ij"))).astype(np.int16)

    def write(path: Path) -> None:
        with path.open("wb") as file:
            np.savez_compressed(file, north_m=axis, east_m=axis, height_ft=grid)

    write_whole(Path(__file__).with_name("terrain") / "ridge.npz", write)


if __name__ == "__main__":
    main()
