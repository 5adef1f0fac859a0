"""Terrain from elevation files in metres: GeoTIFF and the .hgt tiles of SRTM, on a plane about an origin.

One degree of latitude is 111 132 m, one of longitude 111 320 m times the cosine of the origin's latitude: right to
0.5 % within 50 km.
"""

import math
import re
from pathlib import Path

import numpy as np

from examples.path_planner.planner.terrain import Terrain
from examples.path_planner.planner.tracks import FT_PER_M
from gtm_fmu.errors import InputError

M_PER_DEG_LATITUDE, M_PER_DEG_LONGITUDE = 111_132.0, 111_320.0
_VOID = -32768
_TILE = re.compile(r"([NS])(\d\d)([EW])(\d\d\d)")


def read_hgt(path: Path, origin: tuple[float, float] | None) -> Terrain:
    """A tile of one degree, whose name says its south-west corner, as ``N47E011.hgt``.

    Args:
        origin: latitude and longitude in deg of the scenario's zero; None for the tile's middle.

    Raises:
        InputError: another name, another size, or not a single height.
    """
    named = _TILE.match(path.stem.upper())
    if named is None:
        raise InputError(f"'{path.name}' does not say its corner; call the tile as in N47E011.hgt.")
    south = int(named[2]) * (1 if named[1] == "N" else -1)
    west = int(named[4]) * (1 if named[3] == "E" else -1)
    heights = np.fromfile(path, ">i2").astype(float)
    side = math.isqrt(len(heights))
    if side * side != len(heights) or side < 2:
        raise InputError(f"'{path.name}' has {len(heights)} heights, which is no square; give a whole tile.")
    heights = heights.reshape(side, side)
    heights[heights == _VOID] = np.nan
    axis = np.linspace(0.0, 1.0, side)
    return _on_a_plane(path, south + axis, west + axis, heights[::-1], origin)


def read_geotiff(path: Path, origin: tuple[float, float] | None) -> Terrain:
    """The first band of a GeoTIFF that is not rotated, in degrees or in metres.

    Args:
        origin: of the scenario's zero: latitude and longitude in deg, or northing and easting in m where the file is in
            metres; None for its middle.

    Raises:
        InputError: rasterio is missing, a file that it cannot read, or a rotated one.
    """
    try:
        import rasterio
    except ImportError as error:
        raise InputError("GeoTIFF needs rasterio: pip install 'gtm-fmu[planner]', or give a .hgt or .npz.") from error
    try:
        with rasterio.open(path) as file:
            band = file.read(1, masked=True).astype(float).filled(np.nan)
            transform, is_geographic = file.transform, file.crs is None or file.crs.is_geographic
    except rasterio.errors.RasterioError as error:
        raise InputError(f"'{path}' cannot be read as GeoTIFF: {error}") from error
    if transform.b or transform.d:
        raise InputError(f"'{path.name}' is rotated; warp it to north up first (gdalwarp).")
    rows, columns = band.shape
    east = transform.c + transform.a * (np.arange(columns) + 0.5)
    north = transform.f + transform.e * (np.arange(rows) + 0.5)
    if transform.e < 0:
        north, band = north[::-1], band[::-1]
    if is_geographic:
        return _on_a_plane(path, north, east, band, origin)
    centre = origin or (float(north.mean()), float(east.mean()))
    return _terrain(path, north - centre[0], east - centre[1], band)


def _on_a_plane(
    path: Path, latitude: np.ndarray, longitude: np.ndarray, heights_m: np.ndarray, origin: tuple[float, float] | None
) -> Terrain:
    zero = origin or (float(latitude.mean()), float(longitude.mean()))
    north = (latitude - zero[0]) * M_PER_DEG_LATITUDE
    east = (longitude - zero[1]) * M_PER_DEG_LONGITUDE * math.cos(math.radians(zero[0]))
    return _terrain(path, north, east, heights_m)


def _terrain(path: Path, north_m: np.ndarray, east_m: np.ndarray, heights_m: np.ndarray) -> Terrain:
    """Points without a height are as high as the highest, so that no path leads over them."""
    if np.isnan(heights_m).all():
        raise InputError(f"'{path.name}' has not a single height.")
    return Terrain(north_m, east_m, np.where(np.isnan(heights_m), np.nanmax(heights_m), heights_m) * FT_PER_M)
