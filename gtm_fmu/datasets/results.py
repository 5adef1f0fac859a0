"""Results of a data set: what is kept of each case's envelope, as columns."""

from collections.abc import Collection, Mapping, Sequence
from itertools import chain, product

import numpy as np

from gtm_fmu.aircraft.inputs import EVERYWHERE, Column, failure, has_throttles_apart
from gtm_fmu.aircraft.ranges import ALPHA_DEG, PHI_DEG, Range
from gtm_fmu.airframe.names import TRIM_UNKNOWNS, TWO_THROTTLE_UNKNOWNS
from gtm_fmu.airframe.provenance import provenance
from gtm_fmu.envelopes.envelope import Envelope, FlightCondition
from gtm_fmu.envelopes.tolerances import Tolerances
from gtm_fmu.envelopes.tolerant_envelope import tolerant_envelope_of
from gtm_fmu.errors import InputError
from gtm_fmu.trims.manoeuvre import Trim

SPEEDS = (Column("v_min", "kt"), Column("v_max", "kt"), Column("t_min", "%"))
ENDS = ("v_min", "v_max")
TRIM = (
    *(Column(name, "deg") for name in ("alpha", "beta", "phi", "theta")),
    Column("turn_rate", "deg/s"),
    *(Column(name, "deg") for name in ("elevator", "aileron", "rudder")),
    Column("throttle", "%"),
)
"""What is kept of the trim at each end, as ``alpha_at_v_min``."""

THROTTLES = (Column("throttle_left", "%"), Column("throttle_right", "%"))
"""Kept too where each engine has a throttle of its own: ``throttle`` is then that of a single engine that runs."""

LIMITS = tuple(
    f"{name}.{side}" for name in dict.fromkeys((*TRIM_UNKNOWNS, *TWO_THROTTLE_UNKNOWNS)) for side in ("lower", "upper")
)
"""Limits that may hold an end, each a bit of ``limits_at_v_min`` and ``limits_at_v_max``, the first the lowest."""


def at(name: str, end: str) -> str:
    """Name of a column at an end."""
    return f"{name}_at_{end}"


def trim_columns(inputs: Collection[str]) -> tuple[Column, ...]:
    """What is kept of a trim, for these columns of inputs."""
    return TRIM + THROTTLES if has_throttles_apart(inputs) else TRIM


TOLERANT = tuple(f"{end}_{kind}" for kind in ("guaranteed", "possible") for end in ENDS)
"""Kept too where tolerances are given: speeds in kn, NaN where there are none."""


def schema(inputs: Collection[str] = EVERYWHERE, has_tolerances: bool = False) -> dict[str, tuple[np.dtype, dict]]:
    """Type and attributes (units, legend of the bits in the CF conventions' words) of every result, by name."""
    number, bits = np.dtype(float), np.dtype(np.uint32)
    legend = {"flag_masks": [1 << k for k in range(len(LIMITS))], "flag_meanings": " ".join(LIMITS)}
    columns: dict[str, tuple[np.dtype, dict]] = {"feasible": (np.dtype(bool), {})}
    columns |= {column.name: (number, {"units": column.units}) for column in SPEEDS}
    for end in ENDS:
        columns |= {at(column.name, end): (number, {"units": column.units}) for column in trim_columns(inputs)}
        columns[at("limits", end)] = bits, legend
    return columns | (dict.fromkeys(TOLERANT, (number, {"units": SPEEDS[0].units})) if has_tolerances else {})


def evaluate(
    cases: np.ndarray,
    alpha_deg: Range = ALPHA_DEG,
    phi_deg: Range = PHI_DEG,
    inputs: Sequence[str] = EVERYWHERE,
    asked_by: Mapping[str, str] | None = None,
    tolerances: Mapping[str, float] | None = None,
) -> dict[str, np.ndarray]:
    """Envelopes of cases (n, inputs) as the columns of `schema` (n each).

    Without an envelope the numbers are NaN and no limit is named.

    Args:
        inputs: names of the columns of the cases (`CaseTable.columns`).
        asked_by: `provenance` of the process that asks, where it is another.

    Raises:
        InputError: a case outside what is allowed, or ``asked_by`` is another version than this process.
    """
    if asked_by is not None and dict(asked_by) != provenance():
        raise InputError(
            f"A worker has gtm-fmu {provenance()['gtm_fmu_version']} or aerodynamic data that differ from those of "
            f"{asked_by['gtm_fmu_version']} here; install the same on every worker."
        )
    described = schema(inputs, tolerances is not None)
    columns = {name: np.zeros(len(cases), dtype) for name, (dtype, _) in described.items()}
    for name, column in columns.items():
        if column.dtype == float:
            columns[name][:] = np.nan
    for k, case in enumerate(cases.tolist()):
        value = dict(zip(inputs, case, strict=True))
        condition = FlightCondition(value["altitude"], value["gamma"], failure(value), alpha_deg, phi_deg)
        _keep(columns, k, condition.envelope(), trim_columns(inputs))
        if tolerances is not None:
            tolerant = tolerant_envelope_of(condition, Tolerances(**tolerances))
            kinds = (tolerant.speeds_kt(kind) or (np.nan, np.nan) for kind in ("guaranteed", "possible"))
            for name, speed in zip(TOLERANT, chain.from_iterable(kinds), strict=True):
                columns[name][k] = speed
    return columns


def _keep(columns: dict[str, np.ndarray], k: int, found: Envelope, kept: Sequence[Column]) -> None:
    if found.t_min_pct is not None:
        columns["t_min"][k] = found.t_min_pct
    if not (found.feasible and found.at_v_min and found.at_v_max):
        return
    columns["feasible"][k] = True
    columns["v_min"][k], columns["v_max"][k] = found.v_min_kt, found.v_max_kt
    for (end, trim), column in product(zip(ENDS, (found.at_v_min, found.at_v_max), strict=True), kept):
        if (number := getattr(trim, column.label)) is not None:
            columns[at(column.name, end)][k] = number
    columns["limits_at_v_min"][k], columns["limits_at_v_max"][k] = _bits(found.at_v_min), _bits(found.at_v_max)


def _bits(trim: Trim) -> int:
    return sum(1 << LIMITS.index(name) for name in trim.limits_hit)


def limit_names(bits: int) -> tuple[str, ...]:
    """Names of the limits of a mask."""
    return tuple(name for k, name in enumerate(LIMITS) if bits >> k & 1)
