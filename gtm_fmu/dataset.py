"""Envelopes over a lattice of rudder failures and flight conditions, as an xarray data set on disk."""

import hashlib
import os
import shutil
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from importlib.metadata import version
from itertools import combinations_with_replacement, product
from pathlib import Path

import numpy as np
import xarray as xr

from gtm_fmu.airframe.tables import DATA_FILE
from gtm_fmu.envelope import Envelope, FlightCondition
from gtm_fmu.errors import InputError
from gtm_fmu.failures import Range

PAPER_ALTITUDES_FT = (0.0, 10000.0, 20000.0, 30000.0)
PAPER_GAMMAS_DEG = tuple(float(gamma) for gamma in range(-5, 6))
PAPER_RUDDERS_DEG = (-30.0, -20.0, -10.0, 0.0, 10.0, 20.0, 30.0)
"""Levels of the paper's lattice (paper Table 7)."""

_AT_THE_ENDS = {
    "alpha_deg": "deg",
    "beta_deg": "deg",
    "phi_deg": "deg",
    "theta_deg": "deg",
    "turn_rate_deg_s": "deg/s",
    "elevator_deg": "deg",
    "aileron_deg": "deg",
    "rudder_deg": "deg",
    "throttle_pct": "%",
}
"""What is kept of the trim at each end, with its unit."""
_SUFFIX = {"deg": "_deg", "deg/s": "_deg_s", "%": "_pct"}


def rudder_failures(levels_deg: Iterable[float]) -> list[Range]:
    """All jams and restrictions between the levels: pairs lower <= upper, 28 for the paper's seven."""
    return list(combinations_with_replacement(sorted(levels_deg), 2))


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
        Data set over (altitude, gamma, failure): feasible, v_min, v_max, t_min and the trims at both ends
        (``alpha_at_v_min`` ...). NaN where no envelope exists. Units are attributes of each variable.

    Raises:
        InputError: an empty axis, or a level outside what is allowed.
    """
    failures = rudder_failures(PAPER_RUDDERS_DEG) if failures is None else list(failures)
    if not (len(altitudes_ft) and len(gammas_deg) and failures):
        raise InputError("The lattice is empty; give at least one altitude, flight-path angle and failure.")
    conditions = [FlightCondition(*condition) for condition in product(altitudes_ft, gammas_deg)]

    def solve(condition: FlightCondition) -> list[Envelope]:
        return [condition.envelope(failure) for failure in failures]

    envelopes: list[Envelope] = []
    with ThreadPoolExecutor(workers or os.cpu_count()) as pool:
        for solved in pool.map(solve, conditions):
            envelopes += solved
            if progress:
                progress(len(envelopes) // len(failures), len(conditions))
    return _dataset(envelopes, altitudes_ft, gammas_deg, failures)


def _dataset(envelopes: list[Envelope], altitudes_ft, gammas_deg, failures) -> xr.Dataset:
    dims, shape = ("altitude", "gamma", "failure"), (len(altitudes_ft), len(gammas_deg), len(failures))

    def variable(values: Iterable[float | None], units: str) -> tuple:
        column = np.array([np.nan if value is None else value for value in values], dtype=float)
        return dims, column.reshape(shape), {"units": units}

    def at(end: str, name: str) -> list[float | None]:
        return [getattr(getattr(e, f"at_{end}"), name) if e.feasible else None for e in envelopes]

    variables: dict[str, tuple] = {"feasible": (dims, np.reshape([e.feasible for e in envelopes], shape))}
    variables["v_min"] = variable((e.v_min_kt for e in envelopes), "kt")
    variables["v_max"] = variable((e.v_max_kt for e in envelopes), "kt")
    variables["t_min"] = variable((e.t_min_pct for e in envelopes), "%")
    for end, (name, units) in product(("v_min", "v_max"), _AT_THE_ENDS.items()):
        variables[f"{name.removesuffix(_SUFFIX[units])}_at_{end}"] = variable(at(end, name), units)
    lower, upper = zip(*failures, strict=True)
    return xr.Dataset(
        variables,
        coords={
            "altitude": ("altitude", np.asarray(altitudes_ft, dtype=float), {"units": "ft"}),
            "gamma": ("gamma", np.asarray(gammas_deg, dtype=float), {"units": "deg"}),
            "rudder_lower": ("failure", np.asarray(lower, dtype=float), {"units": "deg"}),
            "rudder_upper": ("failure", np.asarray(upper, dtype=float), {"units": "deg"}),
        },
        attrs={
            "title": "Lowest and highest speed of steady manoeuvres of the GTM-T2 with a failed rudder",
            "gtm_fmu_version": version("gtm-fmu"),
            "aerodynamic_data_sha256": hashlib.sha256(DATA_FILE.read_bytes()).hexdigest(),
        },
    )


def save(data: xr.Dataset, path: str | Path) -> Path:
    """Write a zarr store at ``path``; an earlier one is replaced only when the new one is complete.

    Raises:
        InputError: the folder cannot be written.
    """
    path = Path(path)
    partial, replaced = (path.with_name(f".{path.name}.{suffix}") for suffix in ("partial", "replaced"))
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        for leftover in (partial, replaced):
            shutil.rmtree(leftover, ignore_errors=True)
        data.to_zarr(partial, mode="w", consolidated=False)
        if path.exists():
            path.rename(replaced)
        partial.rename(path)
        shutil.rmtree(replaced, ignore_errors=True)
    except OSError as error:
        raise InputError(f"Cannot write {path}: {error.strerror or error}; choose a folder you may write to.") from None
    return path


def load(path: str | Path) -> xr.Dataset:
    """Read a data set that `save` wrote.

    Raises:
        InputError: there is none, or it is damaged.
    """
    try:
        return xr.open_zarr(path, consolidated=False).load()
    except Exception as error:
        raise InputError(f"{path} is no readable data set ({error}); make one with `gtm-fmu study`.") from None


def samples(data: xr.Dataset) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Inputs (n, 4) altitude ft, gamma deg, rudder lower and upper deg; V_min, V_max (n, 2) kt; t_min (n) %."""
    flat = data.stack(case=("altitude", "gamma", "failure"))
    inputs = [flat[name].values for name in ("altitude", "gamma", "rudder_lower", "rudder_upper")]
    speeds = [flat[name].values for name in ("v_min", "v_max")]
    return np.column_stack(inputs), np.column_stack(speeds), flat["t_min"].values
