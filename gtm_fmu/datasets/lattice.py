"""Lattices of rudder failures and flight conditions, as the paper's: their cases, and a view of their stores.

`gtm_fmu.datasets.distribution` computes data sets of any size and axes into a store. That of a lattice is read here as
arrays over altitude, flight-path angle and failure.
"""

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from gtm_fmu.aircraft.ranges import Range
from gtm_fmu.datasets import paper
from gtm_fmu.datasets.axes import failure_levels, levels, limit_levels
from gtm_fmu.datasets.cases import CaseTable
from gtm_fmu.datasets.store import slices

DIMENSIONS = ("altitude", "gamma", "failure")


def rudder_failures(levels_deg: Iterable[float]) -> list[Range]:
    """All jams and restrictions between the levels: pairs lower <= upper, 28 for the paper's seven."""
    return [(lower, upper) for lower, upper in failure_levels("rudder", levels_deg).values]


def lattice(
    altitudes_ft: Sequence[float] = paper.ALTITUDES_FT,
    gammas_deg: Sequence[float] = paper.GAMMAS_DEG,
    failures: Sequence[Range] | None = None,
) -> CaseTable:
    """Every altitude, flight-path angle and rudder failure: by default the 1232 cases of the paper's Table 7.

    Args:
        failures: lower and upper rudder limits in deg; default `rudder_failures` of the paper's levels.

    Raises:
        InputError: an empty axis, or a level outside what is allowed.
    """
    failures = rudder_failures(paper.RUDDERS_DEG) if failures is None else list(failures)
    return CaseTable.lattice(
        [levels("altitude", altitudes_ft), levels("gamma", gammas_deg), limit_levels("rudder", failures)]
    )


def solved(
    store: str | Path,
    table: CaseTable,
    progress: Callable[[int, int], None] | None = None,
    workers: int | None = None,
) -> xr.Dataset:
    """The envelopes of a lattice, computed into a store as far as they are not there, as `view` gives them.

    A store that another version has made, or with another lattice, is replaced.

    Raises:
        InputError: as `distribution.compute`.
    """
    from gtm_fmu.datasets.distribution import compute

    compute(store, table, workers=workers, progress=progress, replace=True)
    return view(store)


def view(store: str | Path) -> xr.Dataset:
    """A finished store of a lattice over (altitude, gamma, failure).

    Returns:
        Data set with the columns of `results.schema`: feasible, v_min, v_max, t_min and the trims at both ends
        (``alpha_at_v_min`` ...). NaN where no envelope exists. Units are attributes.

    Raises:
        InputError: there is no such store, or it is damaged.
    """
    cases = xr.concat(list(slices(store)), dim="case", combine_attrs="override", data_vars="all", coords="all")
    cases = cases.drop_vars("finished")
    altitudes, gammas = (list(dict.fromkeys(cases[name].values.tolist())) for name in DIMENSIONS[:2])
    shape = (len(altitudes), len(gammas), cases.sizes["case"] // (len(altitudes) * len(gammas)))
    limits = {name: cases[name] for name in ("rudder_lower", "rudder_upper")}
    columns = {str(name): column for name, column in cases.data_vars.items()}
    return xr.Dataset(
        {name: (DIMENSIONS, column.values.reshape(shape), column.attrs) for name, column in columns.items()},
        coords={
            "altitude": ("altitude", altitudes, cases["altitude"].attrs),
            "gamma": ("gamma", gammas, cases["gamma"].attrs),
            **{name: ("failure", column.values[: shape[2]], column.attrs) for name, column in limits.items()},
        },
        attrs=cases.attrs,
    )


def samples(data: xr.Dataset) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Inputs (n, 4) altitude ft, gamma deg, rudder lower and upper deg; V_min, V_max (n, 2) kn; t_min (n) %."""
    flat = data.stack(case=("altitude", "gamma", "failure"))
    inputs = [flat[name].values for name in ("altitude", "gamma", "rudder_lower", "rudder_upper")]
    speeds = [flat[name].values for name in ("v_min", "v_max")]
    return np.column_stack(inputs), np.column_stack(speeds), flat["t_min"].values
