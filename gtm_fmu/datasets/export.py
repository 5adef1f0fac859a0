"""A data set as one flat table for other tools: CSV or Parquet."""

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from gtm_fmu.aircraft.inputs import Column
from gtm_fmu.datasets import results
from gtm_fmu.datasets.store import FINISHED, slices
from gtm_fmu.errors import InputError
from gtm_fmu.files import check_writable, real_path, write_whole


def frame(data: xr.Dataset) -> pd.DataFrame:
    """A row a finished case; units are in the names (``alpha_at_v_min_deg``), limits and choices are spelled out."""
    finished = data.isel(case=data[FINISHED].values)
    columns = {}
    for name in (*data.coords, *(name for name in data.data_vars if name != FINISHED)):
        values = finished[name]
        if "flag_masks" in values.attrs:
            names = [" ".join(results.limit_names(int(bits))) for bits in values.values]
            columns[name] = pd.array(names, dtype="string")
        elif "flag_values" in values.attrs:
            names = np.array(values.attrs["flag_meanings"].split())[values.values]
            columns[name] = pd.array(names, dtype="string")
        else:
            columns[Column(str(name), values.attrs.get("units", "")).label] = values.values
    return pd.DataFrame(columns)


def _write_csv(frames: Iterator[pd.DataFrame], path: Path) -> None:
    with path.open("w", encoding="utf-8", newline="") as file:
        for k, part in enumerate(frames):
            part.to_csv(file, index=False, header=k == 0)


def _write_parquet(frames: Iterator[pd.DataFrame], path: Path) -> None:
    import pyarrow
    import pyarrow.parquet

    tables = (pyarrow.Table.from_pandas(part, preserve_index=False) for part in frames)
    first = next(tables)
    with pyarrow.parquet.ParquetWriter(path, first.schema) as writer:
        writer.write_table(first)
        for table in tables:
            writer.write_table(table)


_WRITERS: dict[str, Callable[[Iterator[pd.DataFrame], Path], None]] = {".csv": _write_csv, ".parquet": _write_parquet}


def check_export(path: str | Path, store: str | Path) -> Path:
    """The path, if the table of a store can be written there.

    Raises:
        InputError: the ending is another, what it needs is not installed, it lies in the store, or cannot be written.
    """
    path = Path(path)
    if path.suffix not in _WRITERS:
        raise InputError(f"{path} is neither .csv nor .parquet; choose one of these endings.")
    if path.suffix == ".parquet":
        try:
            import pyarrow  # noqa: F401
        except ImportError:
            raise InputError("Parquet needs pyarrow: `pip install 'gtm-fmu[parquet]'`, or export to .csv.") from None
    if real_path(path).is_relative_to(real_path(Path(store))):
        raise InputError(f"{path} lies in the data set {store}, which holds nothing else; choose another folder.")
    return check_writable(path)


def export(store: str | Path, path: str | Path) -> Path:
    """Write the finished cases of a store as a table, chunk by chunk and in one piece.

    Raises:
        InputError: the ending is neither .csv nor .parquet, the store cannot be read, or the file not be written.
    """
    path = check_export(path, store)
    write_whole(path, lambda partial: _WRITERS[path.suffix]((frame(data) for data in slices(store)), partial))
    return path
