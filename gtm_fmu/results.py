"""Results of a data set: what is kept of each case's envelope, as columns."""

import hashlib
from collections.abc import Mapping
from functools import cache
from importlib.metadata import version
from itertools import product

import numpy as np

from gtm_fmu.airframe.names import CONTROLS, TRIM_UNKNOWNS
from gtm_fmu.airframe.tables import DATA_FILE
from gtm_fmu.axes import INPUTS, Column, limit_columns
from gtm_fmu.envelope import Envelope, envelope
from gtm_fmu.errors import InputError
from gtm_fmu.failures import ControlLimits, Range
from gtm_fmu.manoeuvre import ALPHA_DEG, PHI_DEG, Trim

SPEEDS = (Column("v_min", "kt"), Column("v_max", "kt"), Column("t_min", "%"))
ENDS = ("v_min", "v_max")
TRIM = (
    *(Column(name, "deg") for name in ("alpha", "beta", "phi", "theta")),
    Column("turn_rate", "deg/s"),
    *(Column(name, "deg") for name in ("elevator", "aileron", "rudder")),
    Column("throttle", "%"),
)
"""What is kept of the trim at each end, as ``alpha_at_v_min``."""

LIMITS = tuple(f"{name}.{side}" for name in TRIM_UNKNOWNS for side in ("lower", "upper"))
"""Limits that may hold an end, each a bit of ``limits_at_v_min`` and ``limits_at_v_max``, the first the lowest."""


def at(name: str, end: str) -> str:
    """Name of a column at an end."""
    return f"{name}_at_{end}"


def schema() -> dict[str, tuple[np.dtype, dict]]:
    """Type and attributes (units, legend of the bits in the CF conventions' words) of every result, by name."""
    number, bits = np.dtype(float), np.dtype(np.uint32)
    legend = {"flag_masks": [1 << k for k in range(len(LIMITS))], "flag_meanings": " ".join(LIMITS)}
    columns: dict[str, tuple[np.dtype, dict]] = {"feasible": (np.dtype(bool), {})}
    columns |= {column.name: (number, {"units": column.units}) for column in SPEEDS}
    for end in ENDS:
        columns |= {at(column.name, end): (number, {"units": column.units}) for column in TRIM}
        columns[at("limits", end)] = bits, legend
    return columns


@cache
def provenance() -> dict[str, str]:
    """Version of the package and hash of its aerodynamic data, as attributes of a data set."""
    data_hash = hashlib.sha256(DATA_FILE.read_bytes()).hexdigest()
    return {"gtm_fmu_version": version("gtm-fmu"), "aerodynamic_data_sha256": data_hash}


def evaluate(
    cases: np.ndarray,
    alpha_deg: Range = ALPHA_DEG,
    phi_deg: Range = PHI_DEG,
    asked_by: Mapping[str, str] | None = None,
) -> dict[str, np.ndarray]:
    """Envelopes of cases (n, columns of `axes.INPUTS`) as the columns of `schema` (n each).

    Without an envelope the numbers are NaN and no limit is named.

    Args:
        asked_by: `provenance` of the process that asks, where it is another.

    Raises:
        InputError: a case outside what is allowed, or ``asked_by`` is another version than this process.
    """
    if asked_by is not None and dict(asked_by) != provenance():
        raise InputError(
            f"A worker has gtm-fmu {provenance()['gtm_fmu_version']} or aerodynamic data that differ from those of "
            f"{asked_by['gtm_fmu_version']} here; install the same on every worker."
        )
    columns = {name: np.zeros(len(cases), dtype) for name, (dtype, _) in schema().items()}
    for name, column in columns.items():
        if column.dtype == float:
            columns[name][:] = np.nan
    for k, case in enumerate(cases.tolist()):
        _keep(columns, k, _solve(case, alpha_deg, phi_deg))
    return columns


def _solve(case: list[float], alpha_deg: Range, phi_deg: Range) -> Envelope:
    value = dict(zip(INPUTS, case, strict=True))
    (altitude_ft, gamma_deg), controls = case[:2], (limit_columns(control) for control in CONTROLS)
    limits = ControlLimits(*((value[lower], value[upper]) for lower, upper in controls))
    return envelope(altitude_ft, gamma_deg, limits, alpha_deg, phi_deg)


def _keep(columns: dict[str, np.ndarray], k: int, found: Envelope) -> None:
    if found.t_min_pct is not None:
        columns["t_min"][k] = found.t_min_pct
    if not (found.feasible and found.at_v_min and found.at_v_max):
        return
    columns["feasible"][k] = True
    columns["v_min"][k], columns["v_max"][k] = found.v_min_kt, found.v_max_kt
    for (end, trim), column in product(zip(ENDS, (found.at_v_min, found.at_v_max), strict=True), TRIM):
        columns[at(column.name, end)][k] = getattr(trim, column.label)
    columns["limits_at_v_min"][k], columns["limits_at_v_max"][k] = _bits(found.at_v_min), _bits(found.at_v_max)


def _bits(trim: Trim) -> int:
    return sum(1 << LIMITS.index(name) for name in trim.limits_hit)


def limit_names(bits: int) -> tuple[str, ...]:
    """Names of the limits of a mask."""
    return tuple(name for k, name in enumerate(LIMITS) if bits >> k & 1)
