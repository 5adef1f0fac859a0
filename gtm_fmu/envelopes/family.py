"""Envelopes along an axis: over flight path or altitude, the paper's three-dimensional envelope, or over jams."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from gtm_fmu.aircraft.inputs import CONDITION, LIMITED, Column
from gtm_fmu.envelopes.boundary import Boundary, envelope_boundary
from gtm_fmu.envelopes.envelope import Envelope, FlightCondition
from gtm_fmu.envelopes.grid import EnvelopeGrid, envelope_grid
from gtm_fmu.errors import InputError

AXES: dict[str, Column] = {
    **{column.name: column for column in CONDITION},
    **{control: column for control, (column, _) in LIMITED.items()},
}
"""What a family may vary: altitude, flight-path angle, or the position that a control is jammed at."""


class Member(NamedTuple):
    """One envelope of a family."""

    value: float
    envelope: Envelope
    boundary: Boundary
    grid: EnvelopeGrid

    def to_dict(self) -> dict[str, Any]:
        """Ends, polygons with the limits of their pieces, and the number of manoeuvres, ready for JSON."""
        return self.envelope.to_dict() | {
            "polygons": [[piece.to_dict() for piece in around] for around in self.boundary.polygons],
            "manoeuvres": {name: int(getattr(self.grid, name).sum()) for name in ("feasible", "stable", "accepted")},
        }


@dataclass(frozen=True)
class EnvelopeFamily:
    """Envelopes along one axis of `AXES`, in the order of its values."""

    axis: Column
    members: tuple[Member, ...]

    @property
    def values(self) -> np.ndarray:
        """Of the axis (n), in its unit."""
        return np.array([member.value for member in self.members])

    def to_dataset(self) -> xr.Dataset:
        """All trims over (axis, tas, turn_rate), with units; no trim at the speeds that a member does not reach.

        The axis of a control's jams is called after it, as ``rudder_jam``.
        """
        grids = [member.grid.to_dataset() for member in self.members]
        names = [column.label for column in CONDITION if column != self.axis]
        name = self.axis.name if self.axis in CONDITION else f"{self.axis.name}_jam"
        empty = {name: False if values.dtype == bool else np.nan for name, values in grids[0].items()}
        along = xr.Variable(name, self.values, {"units": self.axis.units})
        joined = xr.concat(grids, along, join="outer", fill_value=empty, combine_attrs="drop")
        return joined.assign_attrs({name: grids[0].attrs[name] for name in names})

    def to_dict(self) -> dict[str, Any]:
        """The members, ready for JSON."""
        return {
            "over": self.axis.label,
            "values": self.values.tolist(),
            "envelopes": [m.to_dict() for m in self.members],
        }


def envelope_family(
    condition: FlightCondition,
    over: str,
    values: Sequence[float],
    tas_step_kt: float = 1.0,
    turn_rate_step_deg_s: float = 1.0,
    progress: Callable[[int, int], None] | None = None,
) -> EnvelopeFamily:
    """Envelopes of a flight condition with another altitude in ft, flight-path angle in deg, or jam at each value.

    Args:
        over: a name of `AXES`; for a control each value is a jam at it, in deg or %, instead of its limits.
        progress: called with the number of finished envelopes and of all.

    Raises:
        InputError: no such axis, no value, or a value or step outside what is allowed.
    """
    conditions = varied_conditions(condition, over, values)
    members = []
    for value, varied in zip(values, conditions, strict=True):
        grid = envelope_grid(varied, tas_step_kt, turn_rate_step_deg_s)
        members.append(Member(float(value), varied.envelope(), envelope_boundary(varied), grid))
        if progress:
            progress(len(members), len(conditions))
    return EnvelopeFamily(AXES[over], tuple(members))


def varied_conditions(condition: FlightCondition, over: str, values: Sequence[float]) -> list[FlightCondition]:
    """The conditions of a family.

    Args:
        condition: what all have in common.
        over: a name of `AXES`.
        values: of the axis, in ft, deg or %.

    Raises:
        InputError: no such axis, no value, or a value outside what is allowed.
    """
    if over not in AXES:
        raise InputError(f"Envelopes do not vary over '{over}'; choose one of {', '.join(AXES)}.")
    if not len(values):
        raise InputError(f"There is no value of {over}; give at least one.")
    return [_varied(condition, AXES[over], float(value)) for value in values]


def _varied(condition: FlightCondition, axis: Column, value: float) -> FlightCondition:
    if axis in CONDITION:
        place: dict[str, Any] = {axis.label: value}
        return condition.changed(**place)
    return condition.changed(failure=condition.failure.with_limits(axis.label, (value, value)))
