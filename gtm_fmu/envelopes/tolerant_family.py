"""Guaranteed, nominal and possible speeds along an axis: altitude, flight path, or the jams of a control."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from gtm_fmu.aircraft.inputs import Column
from gtm_fmu.envelopes.envelope import FlightCondition
from gtm_fmu.envelopes.family import AXES, varied_conditions
from gtm_fmu.envelopes.tolerances import Tolerances
from gtm_fmu.envelopes.tolerant_envelope import TolerantEnvelope, tolerant_envelope_of

KINDS = ("guaranteed", "nominal", "possible")
"""Of speeds, from the narrowest to the widest."""


@dataclass(frozen=True)
class TolerantFamily:
    """Envelopes with tolerances along one axis of `family.AXES`, in the order of its values."""

    axis: Column
    tolerances: Tolerances
    values: tuple[float, ...]
    members: tuple[TolerantEnvelope, ...]

    @property
    def speeds_kt(self) -> np.ndarray:
        """V_min and V_max (n, 3, 2) of each of `KINDS`; NaN where there is none."""
        return np.array([[member.speeds_kt(kind) or (np.nan, np.nan) for kind in KINDS] for member in self.members])

    def to_dict(self) -> dict[str, Any]:
        """The members, ready for JSON."""
        return {
            "over": self.axis.label,
            "values": list(self.values),
            "tolerances": asdict(self.tolerances),
            "envelopes": [member.nominal.to_dict() | member.to_dict() for member in self.members],
        }


def tolerant_family(
    condition: FlightCondition,
    over: str,
    values: Sequence[float],
    tolerances: Tolerances,
    progress: Callable[[int, int], None] | None = None,
) -> TolerantFamily:
    """Envelopes with tolerances of a flight condition with another altitude, flight path or jam at each value.

    Args:
        condition: what all have in common.
        over: a name of `family.AXES`; for a control each value is a jam at it.
        values: of the axis (n), in ft, deg or %.
        tolerances: of the aircraft, and the gust.
        progress: called with the number of finished envelopes and of all.

    Raises:
        InputError: no such axis, no value, or a value outside what is allowed.
    """
    conditions = varied_conditions(condition, over, values)
    members = []
    for varied in conditions:
        members.append(tolerant_envelope_of(varied, tolerances))
        if progress:
            progress(len(members), len(conditions))
    return TolerantFamily(AXES[over], tolerances, tuple(map(float, values)), tuple(members))
