"""Tables of anybody's: .csv, .parquet, data sets of the aircraft, and any other zarr store."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gtm_fmu.errors import InputError
from gtm_fmu.extras import advice
from gtm_fmu.files import check_writable, write_whole

if TYPE_CHECKING:
    import pandas as pd  # slow to import
    import xarray as xr

WRITTEN_ENDINGS = (".csv", ".parquet")
ENDINGS = (*WRITTEN_ENDINGS, ".zarr")
KINDS = {"M": "dates", "m": "time spans", "c": "complex numbers"}
"""What a column can hold that is no number, by the kind of its type."""


@dataclass(frozen=True)
class Table:
    """A table of rows.

    Attributes:
        units: of columns, as far as the file tells them.
    """

    path: Path
    whole: pd.DataFrame
    units: dict[str, str]

    @property
    def names(self) -> list[str]:
        """Of all columns."""
        return [str(name) for name in self.whole.columns]

    def rows(self, names: Sequence[str]) -> pd.DataFrame:
        """The columns `names`."""
        return self.whole[list(names)]

    def rows_with_all(self, names: Sequence[str]) -> pd.DataFrame:
        """The columns `names`, and all others that have one value a row."""
        return self.whole


@dataclass(frozen=True)
class Lattice:
    """The same of arrays over several dimensions: a row a point of those of the columns that are read."""

    path: Path
    variables: dict[str, xr.Variable]
    units: dict[str, str]

    @property
    def names(self) -> list[str]:
        """Of all arrays, and of the dimensions."""
        return list(self.variables)

    def rows(self, names: Sequence[str]) -> pd.DataFrame:
        """The columns `names`, over the dimensions of that one which has most.

        Raises:
            InputError: another one lies over a further dimension, so that each of its values would belong to each of
                those, or an array cannot be read.
        """
        import pandas as pd

        chosen = {name: self.variables[name] for name in names}
        widest = max(names, key=lambda name: chosen[name].ndim)
        sizes = dict(chosen[widest].sizes)
        for name, values in chosen.items():
            if not sizes.keys() >= set(values.dims):
                ours, theirs = (", ".join(map(str, dims)) or "none" for dims in (values.dims, sizes))
                shared = "no dimension" if sizes.keys().isdisjoint(values.dims) else "not all dimensions"
                raise InputError(
                    f"'{name}' and '{widest}' of '{self.path}' share {shared} ({ours}; {theirs}): name columns of one "
                    "lattice, one of which lies over all its dimensions."
                )
        with _readable(self.path):
            return pd.DataFrame({name: values.set_dims(sizes).values.ravel() for name, values in chosen.items()})

    def rows_with_all(self, names: Sequence[str]) -> pd.DataFrame:
        """The columns `names`, and all others that have one value a row.

        The rows are the points of the smallest array that lies over all dimensions of `names`.
        """
        needed = {dim for name in names for dim in self.variables[name].dims}
        wide = [name for name, values in self.variables.items() if needed <= set(values.dims)]
        if not wide:
            return self.rows(names)  # which says so
        dims = set(min((self.variables[name] for name in wide), key=lambda values: values.ndim).dims)
        others = [name for name, values in self.variables.items() if dims >= set(values.dims) and name not in names]
        return self.rows([*names, *others])


def read_table(path: str | Path) -> Table | Lattice:
    """The table in a file, or in the folder of a store.

    Raises:
        InputError: it cannot be read, or is a data set that is not finished.
    """
    path = Path(path)
    is_store = path.suffix == ".zarr" or any((path / name).is_file() for name in ("zarr.json", ".zgroup"))
    if not is_store and path.suffix not in ENDINGS:
        raise InputError(f"'{path}' is no table that can be read: give one ending in {', '.join(ENDINGS)}.")
    with _readable(path):
        if is_store:
            return _read_zarr(path)
        import pandas as pd

        return Table(path, pd.read_csv(path) if path.suffix == ".csv" else pd.read_parquet(path), {})


@contextmanager
def _readable(path: Path) -> Iterator[None]:
    """An error of a reader as one sentence."""
    try:
        yield
    except InputError:
        raise
    except ImportError as error:
        module = error.name or "pyarrow"
        raise InputError(f"'{path}' needs {module}: {advice(module)}.") from None
    except Exception as error:  # readers raise all kinds of errors for damaged files
        reason = getattr(error, "strerror", None) or " ".join(str(error).split())[:120] or "too little memory"
        raise InputError(f"Cannot read '{path}' ({reason}): give another table.") from None


def _read_zarr(path: Path) -> Table | Lattice:
    """A store of `gtm-fmu dataset`, a lattice of the study, or any other data set."""
    import pandas as pd
    import xarray as xr

    from gtm_fmu.datasets.export import frame
    from gtm_fmu.datasets.store import FINISHED, slices

    data = xr.open_zarr(path, consolidated=False, chunks=None, decode_timedelta=False)
    if not data.variables:
        raise InputError(f"'{path}' holds no arrays at its top: give the folder of a group that does.")
    labels = {str(name): _label(str(name), values) for name, values in data.variables.items()}
    units = {labels[str(name)]: values.attrs.get("units", "") for name, values in data.variables.items()}
    if FINISHED in data:
        whole = pd.concat(map(frame, slices(path)), ignore_index=True)
        if len(whole) < (cases := data.sizes["case"]):
            raise InputError(
                f"'{path}' is not finished: {len(whole)} of {cases} cases are there; give the command that made it "
                "once more, which computes the rest."
            )
        return Table(path, whole, units)
    counted = {str(d): xr.Variable((d,), np.arange(n)) for d, n in data.sizes.items() if d not in data.variables}
    variables = {labels[str(name)]: values.to_base_variable() for name, values in data.variables.items()}
    return Lattice(path, counted | variables, units)


def _label(name: str, values: xr.Variable) -> str:
    """The name with the unit where that is one of the aircraft's."""
    from gtm_fmu.aircraft.inputs import Column

    try:
        return Column(name, values.attrs.get("units", "")).label
    except KeyError:
        return name


def numbers(column: pd.Series) -> np.ndarray | None:
    """The numbers of a column (n,), NaN where one is missing; None if it holds words.

    Raises:
        InputError: it holds dates, time spans or complex numbers.
    """
    if kind := KINDS.get(column.dtype.kind):
        raise InputError(f"The column '{column.name}' holds {kind}: store it as numbers, or choose another.")
    try:
        return column.to_numpy(dtype=float, na_value=np.nan)
    except (TypeError, ValueError):
        return None


def with_results(rows: pd.DataFrame, results: Mapping[str, np.ndarray], path: Path) -> pd.DataFrame:
    """Rows of the table at `path` with results (n,) beside them; one whose name is taken is called NAME_predicted.

    Raises:
        InputError: that name is taken as well.
    """
    named = {f"{name}_predicted" if name in rows else name: values for name, values in results.items()}
    if (taken := next((name for name in named if name in rows), None)) or len(named) < len(results):
        raise InputError(
            f"'{path}' has the columns of an earlier prediction{f' ({taken})' if taken else ''}: rename or remove them."
        )
    return rows.assign(**named)


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
