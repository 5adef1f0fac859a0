"""Refits the aerodynamic data file from NASA's polynomial database and prints how far it is from it.

    python -m gtm_fmu.airframe.refit T2_polynomial_aerodatabase.mat

Least squares over all breakpoints of the fitted axis, c = (V^T V)^-1 V^T values with V_ik = T_k(x_i / x_max). The
operator is computed in rational arithmetic and applied in a fixed order, so the file has the same bytes on every
machine.
"""

import argparse
import io
import zipfile
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.io import loadmat

from gtm_fmu.airframe.tables import DATA_FILE, LAYOUTS, Layout, load_tables
from gtm_fmu.errors import InputError
from gtm_fmu.files import write_whole

TOLERANCE = 1e-12
"""Largest residual allowed at a breakpoint."""

NOISE = 1e-13
"""Smaller coefficients are rounding and not stored: it stays below 3e-16, the smallest real one is 1.5e-7."""


def read_database(path: Path | str) -> dict[str, tuple[dict[str, np.ndarray], np.ndarray]]:
    """Breakpoints by axis name and values of every table of `LAYOUTS`, straight from the database."""
    try:
        database = loadmat(path, simplify_cells=True)
        if np.any(database["dC3_sym"]["data"]):
            raise InputError(f"{path} has entries in dC3_sym, which the specification says is identically zero.")
        return {name: _read_table(database, name, layout) for name, layout in LAYOUTS.items()}
    except InputError:
        raise
    except OSError as error:
        raise InputError(f"The database {path} cannot be read: {error.strerror or error}.") from error
    except Exception as error:  # loadmat raises anything from IndexError to NotImplementedError on a damaged file
        raise InputError(
            f"{path} is not the aerodynamic database: {error!r}; give T2_polynomial_aerodatabase.mat."
        ) from error


def _read_table(database: dict[str, Any], name: str, layout: Layout) -> tuple[dict[str, np.ndarray], np.ndarray]:
    entry = database
    for part in name.split("."):
        entry = entry[part]
    if "panel" in layout.axes:
        return {}, np.array([entry[panel] for panel in layout.labels["panel"]], dtype=float)
    breakpoints = {axis: np.asarray(entry[axis], dtype=float) for axis in layout.axes if axis not in layout.labels}
    values = np.asarray(entry["data"], dtype=float)
    sizes = {axis: len(points) for axis, points in {**layout.labels, **breakpoints}.items()}
    shape = (*(sizes[axis] for axis in layout.axes), len(layout.components))
    if values.shape != shape:
        raise ValueError(f"{name} has shape {values.shape} instead of {shape}")
    return breakpoints, values


def least_squares_operator(points: np.ndarray, degree: int) -> np.ndarray:
    """(V^T V)^-1 V^T of the Chebyshev polynomials up to `degree` at `points`, exact until its rounding to float.

    Shape (degree + 1, len(points)).
    """
    x = np.array([Fraction(float(point)) for point in points])
    columns = [x * 0 + 1, x]
    while len(columns) <= degree:
        columns.append(2 * x * columns[-1] - columns[-2])
    transposed = np.array(columns)
    normal = transposed @ transposed.T
    for pivot in range(degree + 1):  # Gauss-Jordan; exact on a positive definite matrix, so no pivoting
        transposed[pivot] /= normal[pivot, pivot]
        normal[pivot] /= normal[pivot, pivot]
        for row in set(range(degree + 1)) - {pivot}:
            transposed[row] -= normal[row, pivot] * transposed[pivot]
            normal[row] -= normal[row, pivot] * normal[pivot]
    return transposed.astype(float)


def encode(name: str, layout: Layout, breakpoints: dict[str, np.ndarray], values: np.ndarray) -> dict[str, np.ndarray]:
    """Members of the data file for one table (the inverse of what `load_tables` does)."""
    members = {f"{name}/{axis}": points for axis, points in breakpoints.items()}
    if layout.fitted is None:
        return members | {f"{name}/values": values}
    lines = np.moveaxis(values, layout.axes.index(layout.fitted), 0)
    points = breakpoints[layout.fitted] / np.abs(breakpoints[layout.fitted]).max()
    coefficients = _apply(least_squares_operator(points, layout.degree), lines)
    if layout.has_tabulated_entries:
        residual = np.abs(np.moveaxis(np.polynomial.chebyshev.chebval(points, coefficients), -1, 0) - lines).max(axis=0)
        tabulated = residual > NOISE
        coefficients[:, tabulated] = 0.0
        members[f"{name}/tabulated"] = np.packbits(tabulated)
        members[f"{name}/tabulated_values"] = np.moveaxis(lines, 0, -1)[tabulated]
    present = np.abs(coefficients) > NOISE
    return members | {f"{name}/present": np.packbits(present), f"{name}/coefficients": coefficients[present]}


def _apply(operator: np.ndarray, lines: np.ndarray) -> np.ndarray:
    # Not a matrix product: its order of summation, and so the last bit, depends on the processor.
    result = np.zeros((len(operator), *lines.shape[1:]))
    for column, line in zip(operator.T, lines, strict=True):
        result += column.reshape(-1, *(1,) * line.ndim) * line
    return result


def write_members(path: Path, members: dict[str, np.ndarray]) -> None:
    """Writes an .npz file whose bytes depend on nothing but the arrays (no clock, no compression library)."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED) as archive:
        for name, array in members.items():
            buffer = io.BytesIO()
            little_endian = array.astype(array.dtype.newbyteorder("<"))
            np.lib.format.write_array(buffer, np.ascontiguousarray(little_endian), version=(1, 0), allow_pickle=False)
            info = zipfile.ZipInfo(f"{name}.npy", date_time=(1980, 1, 1, 0, 0, 0))
            info.create_system = 3
            info.external_attr = 0o644 << 16
            archive.writestr(info, buffer.getvalue())


class Refit(NamedTuple):
    """One table of the data file: how it is stored, in how many numbers, and how far it is from the database."""

    table: str
    form: str
    numbers: int
    residual: float


def refit(database: Path | str, output: Path | str = DATA_FILE) -> list[Refit]:
    """Writes the data file and returns its account, table by table.

    The residuals are those of the written file, read back by `load_tables`, at every breakpoint. Nothing replaces
    `output` unless all of them are within `TOLERANCE`.
    """
    source, output = read_database(database), Path(output)
    members = {name: encode(name, LAYOUTS[name], *entry) for name, entry in source.items()}
    account: list[Refit] = []

    def write(draft: Path) -> None:
        write_members(draft, {key: array for table in members.values() for key, array in table.items()})
        written = load_tables(draft)
        for name, (_, values) in source.items():
            account.append(_account(name, members[name], float(np.abs(written[name].values - values).max())))
        failed = [entry.table for entry in account if not entry.residual <= TOLERANCE]
        if failed:
            raise InputError(
                f"The stored form misses {database} by more than {TOLERANCE:g} in {', '.join(failed)}; "
                "give the polynomial-fit database, version 0.2."
            )

    write_whole(output, write)
    return account


def _account(name: str, members: dict[str, np.ndarray], residual: float) -> Refit:
    layout = LAYOUTS[name]
    if layout.fitted is None:
        return Refit(name, "values", members[f"{name}/values"].size, residual)
    form, numbers = f"degree <= {layout.degree} in {layout.fitted}", members[f"{name}/coefficients"].size
    if layout.has_tabulated_entries:
        tabulated = members[f"{name}/tabulated_values"]
        form, numbers = f"{form}; {len(tabulated)} lines as values", numbers + tabulated.size
    return Refit(name, form, numbers, residual)


def main() -> None:
    """Command line of the refit."""
    parser = argparse.ArgumentParser(prog="python -m gtm_fmu.airframe.refit", description=__doc__.splitlines()[0])
    parser.add_argument("database", metavar="DATABASE.mat", help="T2_polynomial_aerodatabase.mat of GTM_DesignSim")
    parser.add_argument("--output", default=DATA_FILE, help="data file to write (default: the one the package carries)")
    arguments = parser.parse_args()
    try:
        account = refit(arguments.database, arguments.output)
    except InputError as error:
        parser.exit(2, f"{error}\n")
    print(f"{'table':<20}{'form':<42}{'numbers':>8}{'residual':>11}")
    for table, form, numbers, residual in [*account, Refit("dC3_sym", "identically zero, not stored", 0, 0.0)]:
        print(f"{table:<20}{form:<42}{numbers:>8}{residual:>11.1e}")
    print(f"{Path(arguments.output).stat().st_size} bytes in {arguments.output}")


if __name__ == "__main__":
    main()
