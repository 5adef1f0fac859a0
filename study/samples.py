"""Samples to train on or to predict: columns of a table in a file, with their units."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gtm_fmu.errors import InputError
from gtm_fmu.files import check_writable, write_whole
from surrogate import Variable

if TYPE_CHECKING:
    import pandas as pd  # slow to import
    import xarray as xr

WRITTEN_ENDINGS = (".csv", ".parquet")
ENDINGS = (*WRITTEN_ENDINGS, ".zarr")
UNITS = ("ft", "m", "mm", "kt", "kn", "m_s", "deg", "rad", "deg_s", "rad_s", "pct", "s", "N", "Pa")
"""Units that the end of a column's name may tell, as in ``altitude_ft``."""
SPELLED = {"pct": "%", "m_s": "m/s", "deg_s": "deg/s", "rad_s": "rad/s"}


@dataclass(frozen=True)
class Samples:
    """Rows of a table that have all their values.

    Attributes:
        X: inputs (n, d).
        Y: outputs (n, m).
        left_out: rows in which a value is missing, as outputs are where nothing exists.
    """

    inputs: tuple[Variable, ...]
    outputs: tuple[Variable, ...]
    X: np.ndarray
    Y: np.ndarray
    left_out: int

    def sha256(self) -> str:
        """Hash of names, units and numbers."""
        digest = hashlib.sha256(repr((self.inputs, self.outputs)).encode())
        for values in (self.X, self.Y):
            digest.update(np.ascontiguousarray(values).tobytes())
        return digest.hexdigest()


def read_samples(path: str | Path, inputs: Sequence[str], outputs: Sequence[str]) -> Samples:
    """Columns of a .csv or .parquet table, or of a .zarr data set.

    Args:
        path: file, or folder of a store.
        inputs: columns as ``name`` or ``name:unit``. Without a unit it is that of the data set or the one at the end of
            the name (``span_mm``), else none.
        outputs: the same.

    Raises:
        InputError: the file cannot be read, or a column is missing, given twice or holds no numbers.
    """
    table, units = read_table(path)
    variables = [[_variable(spelling, units) for spelling in group] for group in (inputs, outputs)]
    names = [variable.name for group in variables for variable in group]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise InputError(f"The column '{twice}' was given twice: each can be one input or one output.")
    X, Y = (columns(table, [variable.name for variable in group], path) for group in variables)
    whole = np.isfinite(X).all(axis=1) & np.isfinite(Y).all(axis=1)
    if not whole.any():
        raise InputError(f"'{path}' has no row with all of {', '.join(names)}: give other columns.")
    return Samples(tuple(variables[0]), tuple(variables[1]), X[whole], Y[whole], int((~whole).sum()))


def columns(table: pd.DataFrame, names: Sequence[str], path: str | Path) -> np.ndarray:
    """Numbers (n, columns) of a table that was read from `path`.

    Raises:
        InputError: a column is missing or holds no numbers.
    """
    for name in names:
        if name not in table:
            raise InputError(f"'{path}' has no column '{name}': it has {', '.join(map(str, table.columns))}.")
    try:
        return table[list(names)].to_numpy(dtype=float, na_value=np.nan)
    except (TypeError, ValueError):
        wrong = next(name for name in names if table[name].dtype.kind not in "fiub")
        raise InputError(f"The column '{wrong}' of '{path}' holds more than numbers: choose another.") from None


def read_table(path: str | Path) -> tuple[pd.DataFrame, dict[str, str]]:
    """The whole table, and the units of columns as far as the file tells them.

    Raises:
        InputError: the file cannot be read.
    """
    path = Path(path)
    if path.suffix not in ENDINGS:
        raise InputError(f"'{path}' is no table that can be read: give one ending in {', '.join(ENDINGS)}.")
    try:
        if path.suffix == ".zarr":
            return _read_zarr(path)
        import pandas as pd

        return (pd.read_csv(path) if path.suffix == ".csv" else pd.read_parquet(path)), {}
    except InputError:
        raise
    except ImportError as error:
        raise InputError(f"'{path}' needs {error.name or 'pyarrow'}: pip install 'gtm-fmu[parquet]'.") from None
    except Exception as error:  # readers raise all kinds of errors for damaged files
        reason = getattr(error, "strerror", None) or " ".join(str(error).split())[:120]
        raise InputError(f"Cannot read '{path}' ({reason}): give another table.") from None


def _read_zarr(path: Path) -> tuple[pd.DataFrame, dict[str, str]]:
    """A store of `gtm-fmu dataset`, a lattice of the study, or any other data set: one column a variable."""
    import pandas as pd
    import xarray as xr

    from gtm_fmu import dataset as lattice
    from gtm_fmu.export import frame
    from gtm_fmu.store import FINISHED, slices

    data = xr.open_zarr(path, consolidated=False)
    units = {_label(str(name), values): values.attrs.get("units", "") for name, values in data.variables.items()}
    if FINISHED in data:
        return pd.concat(map(frame, slices(path)), ignore_index=True), units
    labels = {name: _label(str(name), values) for name, values in data.variables.items()}
    whole = lattice.load(path) if lattice.CHECKSUM in data.attrs else data.load()
    return whole.to_dataframe().reset_index().rename(columns=labels), units


def _label(name: str, values: xr.Variable) -> str:
    """The name with the unit where that is one of the aircraft's."""
    from gtm_fmu.inputs import Column

    try:
        return Column(name, values.attrs.get("units", "")).label
    except KeyError:
        return name


def check_table(path: Path) -> None:
    """Refuse a table that `write_table` could not write, before anything is computed for it.

    Raises:
        InputError: another ending, or a place that cannot be written.
    """
    if path.suffix not in WRITTEN_ENDINGS:
        endings = " or ".join(WRITTEN_ENDINGS)
        raise InputError(f"'{path}' is no table that can be written: give one ending in {endings}.")
    check_writable(path)


def write_table(table: pd.DataFrame, path: Path) -> Path:
    """Write a .csv or .parquet table in one piece.

    Raises:
        InputError: another ending, or a place that cannot be written.
    """
    check_table(path)
    write = table.to_csv if path.suffix == ".csv" else table.to_parquet
    write_whole(path, lambda draft: write(draft, index=False))
    return path


def _variable(spelling: str, units: dict[str, str]) -> Variable:
    """Name and unit of ``name`` or ``name:unit``."""
    name, colon, unit = spelling.rpartition(":")
    if colon:
        return Variable(name, unit)
    if spelling in units:
        return Variable(spelling, units[spelling])
    found = re.search(rf"_({'|'.join(UNITS)})$", spelling)
    return Variable(spelling, SPELLED.get(found[1], found[1]) if found else "")
