"""Envelopes over a lattice of rudder failures and flight conditions, as an xarray data set in memory and on disk.

`gtm_fmu.datasets.distribution` computes data sets of any size and axes into a store.
"""

import hashlib
import json
import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import xarray as xr

from gtm_fmu.aircraft.ranges import Range
from gtm_fmu.airframe.provenance import provenance
from gtm_fmu.datasets import results
from gtm_fmu.datasets.axes import failure_levels, levels, limit_levels
from gtm_fmu.datasets.cases import CaseTable
from gtm_fmu.errors import InputError
from gtm_fmu.files import real_path, writable_folder
from gtm_fmu.interrupt import held_interrupt

PAPER_ALTITUDES_FT = (0.0, 10000.0, 20000.0, 30000.0)
PAPER_GAMMAS_DEG = tuple(float(gamma) for gamma in range(-5, 6))
PAPER_RUDDERS_DEG = (-30.0, -20.0, -10.0, 0.0, 10.0, 20.0, 30.0)
"""Levels of the paper's lattice (paper Table 7)."""


def rudder_failures(levels_deg: Iterable[float]) -> list[Range]:
    """All jams and restrictions between the levels: pairs lower <= upper, 28 for the paper's seven."""
    return [(lower, upper) for lower, upper in failure_levels("rudder", levels_deg).values]


def lattice(
    altitudes_ft: Sequence[float] = PAPER_ALTITUDES_FT,
    gammas_deg: Sequence[float] = PAPER_GAMMAS_DEG,
    failures: Sequence[Range] | None = None,
    progress: Callable[[int, int], None] | None = None,
    workers: int | None = None,
) -> xr.Dataset:
    """Envelopes at every altitude, flight-path angle and rudder failure (default: the paper's 1232 cases).

    Args:
        failures: lower and upper rudder limits in deg; default `rudder_failures` of the paper's levels.
        progress: called with the number of finished flight conditions and of all.
        workers: threads; default one a core (the solver runs outside the interpreter's lock).

    Returns:
        Data set over (altitude, gamma, failure): the columns of `results.schema`, feasible, v_min, v_max, t_min and
        the trims at both ends (``alpha_at_v_min`` ...). NaN where no envelope exists. Units are attributes.

    Raises:
        InputError: an empty axis, or a level outside what is allowed.
    """
    failures = rudder_failures(PAPER_RUDDERS_DEG) if failures is None else list(failures)
    table = CaseTable.lattice(
        [levels("altitude", altitudes_ft), levels("gamma", gammas_deg), limit_levels("rudder", failures)]
    )
    conditions = len(altitudes_ft) * len(gammas_deg)

    def solve(condition: int) -> dict[str, np.ndarray]:
        start = condition * len(failures)
        return results.evaluate(table.rows(start, start + len(failures)))

    solved = []
    with ThreadPoolExecutor(workers or os.cpu_count()) as pool:
        for columns in pool.map(solve, range(conditions)):
            solved.append(columns)
            if progress:
                progress(len(solved), conditions)
    dims, shape = ("altitude", "gamma", "failure"), (len(altitudes_ft), len(gammas_deg), len(failures))
    rudder_lower, rudder_upper = np.array(failures, dtype=float).T
    return xr.Dataset(
        {
            name: (dims, np.concatenate([columns[name] for columns in solved]).reshape(shape), described)
            for name, (_, described) in results.schema().items()
        },
        coords={
            "altitude": ("altitude", np.asarray(altitudes_ft, dtype=float), {"units": "ft"}),
            "gamma": ("gamma", np.asarray(gammas_deg, dtype=float), {"units": "deg"}),
            "rudder_lower": ("failure", rudder_lower, {"units": "deg"}),
            "rudder_upper": ("failure", rudder_upper, {"units": "deg"}),
        },
        attrs={
            "title": "Lowest and highest speed of steady manoeuvres of the GTM-T2 with a failed rudder",
            **provenance(),
        },
    )


CHECKSUM = "sha256"
"""Attribute with the hash of all values, by which a lost chunk is noticed."""


def _checksum(data: xr.Dataset) -> str:
    digest = hashlib.sha256()
    for name in sorted(map(str, data.variables)):
        digest.update(name.encode())
        digest.update(np.ascontiguousarray(data[name].values).tobytes())
    return digest.hexdigest()


def save(data: xr.Dataset, path: str | Path) -> Path:
    """Write a zarr store at ``path``; an earlier one is replaced only when the new one is complete.

    Raises:
        InputError: it cannot be written, or something other than a store of this function is there.
    """
    path = Path(path)
    place = real_path(path)
    writable_folder(place.parent)
    try:
        if place.exists() and not _is_saved(place):
            raise InputError(f"{path} is no data set of the study and is left as it is; choose another name.")
        with TemporaryDirectory(prefix=f".{place.name[:30]}.", dir=place.parent, ignore_cleanup_errors=True) as folder:
            made, replaced = Path(folder, "made"), Path(folder, "replaced")
            data.assign_attrs({CHECKSUM: _checksum(data)}).to_zarr(made, mode="w", consolidated=False)
            with held_interrupt():
                if place.exists():
                    place.rename(replaced)
                made.rename(place)
    except OSError as error:
        raise InputError(
            f"Cannot write {path} ({error.strerror or error}); choose a folder you may write to."
        ) from None
    return path


def _is_saved(path: Path) -> bool:
    """Whether a folder holds an earlier store of `save`, and nothing besides; or nothing at all."""
    try:
        entries = list(path.iterdir())
        described = json.loads((path / "zarr.json").read_text(encoding="utf-8")) if entries else {}
        return not entries or (
            CHECKSUM in described["attributes"]
            and all(entry.name == "zarr.json" or (entry / "zarr.json").is_file() for entry in entries)
        )
    except (OSError, ValueError, LookupError, TypeError, RecursionError):
        return False


def load(path: str | Path) -> xr.Dataset:
    """Read a data set that `save` wrote.

    Raises:
        InputError: there is none, or it is damaged.
    """
    try:
        data = xr.open_zarr(path, consolidated=False).load()
        if data.attrs.pop(CHECKSUM, None) != _checksum(data):  # a lost chunk reads as NaN, without an error
            raise ValueError("its values are not those that were written")
    except Exception as error:
        raise InputError(f"{path} is no readable data set ({error}); make one with `gtm-fmu study`.") from None
    return data


def samples(data: xr.Dataset) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Inputs (n, 4) altitude ft, gamma deg, rudder lower and upper deg; V_min, V_max (n, 2) kn; t_min (n) %."""
    flat = data.stack(case=("altitude", "gamma", "failure"))
    inputs = [flat[name].values for name in ("altitude", "gamma", "rudder_lower", "rudder_upper")]
    speeds = [flat[name].values for name in ("v_min", "v_max")]
    return np.column_stack(inputs), np.column_stack(speeds), flat["t_min"].values
