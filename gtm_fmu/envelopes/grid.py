"""Every steady manoeuvre left at a flight condition, on a grid of speed and turn rate, with its stability.

Each cell holds the trim with the least sideslip. A trim is accepted when it is stable, or unstable but controllable
(paper Fig. 8).
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.airframe.names import AILERON, ALPHA, BETA, ELEVATOR, PHI, RUDDER, THROTTLE, V
from gtm_fmu.core import query, solver
from gtm_fmu.envelopes.envelope import FlightCondition
from gtm_fmu.errors import InputError
from gtm_fmu.trims import manoeuvre
from gtm_fmu.units import DEG_PER_RAD, FT_S_PER_KT, RAD_PER_DEG

WIDEST_TURN_RATE_DEG_S = 40.0
"""Beyond any turn of the model inside the study's bank angles."""

_TRIM_VARIABLES = {
    "alpha": (ALPHA, DEG_PER_RAD, "deg"),
    "beta": (BETA, DEG_PER_RAD, "deg"),
    "phi": (PHI, DEG_PER_RAD, "deg"),
    "elevator": (ELEVATOR, 1.0, "deg"),
    "aileron": (AILERON, 1.0, "deg"),
    "rudder": (RUDDER, 1.0, "deg"),
    "throttle": (THROTTLE, 1.0, "%"),
}
_SEPARATE_THROTTLES = {
    "throttle_left": (THROTTLE, 1.0, "%"),
    "throttle_right": (THROTTLE + 1, 1.0, "%"),
}


class Assessment(NamedTuple):
    """Stability and controllability (n) of trims."""

    stable: np.ndarray
    controllable: np.ndarray


def assess(altitude_ft: float, gamma_deg: float, y: ArrayLike, limits: ControlLimits | Failure) -> Assessment:
    """Stability and controllability of trims y (n, 9 or 10, core units), without the jammed controls as inputs.

    Of a trim on breakpoints of the tables those of all their sides together, as of a `linearization.LinearModel`.
    """
    failure = Failure.of(limits)
    lower, upper = manoeuvre.bounds(failure)
    at = altitude_ft, gamma_deg * RAD_PER_DEG, lower, upper
    stable, controllable = query.assess(*at, np.asarray(y, dtype=float), failure.airframe)
    return Assessment(stable, controllable)


@dataclass(frozen=True)
class EnvelopeGrid:
    """Steady manoeuvres over true airspeed (n) in kn and turn rate (m) in deg/s.

    Attributes:
        feasible, stable, controllable: (n, m); the last two are false where no trim exists.
        y: trim unknowns (n, m, 9 or 10) in the core's units, NaN where no trim exists.
    """

    altitude_ft: float
    gamma_deg: float
    failure: Failure
    tas_kt: np.ndarray
    turn_rate_deg_s: np.ndarray
    feasible: np.ndarray
    stable: np.ndarray
    controllable: np.ndarray
    y: np.ndarray

    @property
    def limits(self) -> ControlLimits:
        """Of the controls."""
        return self.failure.limits

    @property
    def accepted(self) -> np.ndarray:
        """Trims (n, m) of the envelope by the paper's rule: stable, or else controllable."""
        return self.feasible & (self.stable | self.controllable)

    def to_dataset(self) -> xr.Dataset:
        """All of it over (tas, turn_rate), with units."""
        dims = ("tas", "turn_rate")
        names = ("feasible", "stable", "controllable", "accepted")
        variables: dict[str, tuple] = {name: (dims, getattr(self, name)) for name in names}
        columns = dict(_TRIM_VARIABLES)
        if self.failure.airframe.throttles == solver.TWO_THROTTLES:
            del columns["throttle"]
            columns |= _SEPARATE_THROTTLES
        for name, (column, factor, unit) in columns.items():
            variables[name] = (dims, self.y[..., column] * factor, {"units": unit})
        coords = {
            "tas": ("tas", self.tas_kt, {"units": "kt"}),
            "turn_rate": ("turn_rate", self.turn_rate_deg_s, {"units": "deg/s"}),
        }
        return xr.Dataset(variables, coords, {"altitude_ft": self.altitude_ft, "gamma_deg": self.gamma_deg})


def envelope_grid(
    condition: FlightCondition, tas_step_kt: float = 1.0, turn_rate_step_deg_s: float = 1.0
) -> EnvelopeGrid:
    """Every steady manoeuvre of a flight condition at multiples of the two steps.

    With two jams the manoeuvres are a curve in this plane, which meets no cell.

    Raises:
        InputError: a step that is not positive.
    """
    for name, step in (("speed step in kn", tas_step_kt), ("turn-rate step in deg/s", turn_rate_step_deg_s)):
        if not 0.01 <= step <= 50.0:
            raise InputError(f"{name} {step:g} is outside 0.01 .. 50; give a value inside.")
    seeds = condition.extremes()
    if len(seeds):
        ends_kt = seeds[:, V].min() / FT_S_PER_KT, seeds[:, V].max() / FT_S_PER_KT
        tas_kt = tas_step_kt * np.arange(np.ceil(ends_kt[0] / tas_step_kt), np.floor(ends_kt[1] / tas_step_kt) + 1)
    else:
        tas_kt = np.empty(0)
    half = np.floor(WIDEST_TURN_RATE_DEG_S / turn_rate_step_deg_s)
    turn_rate_deg_s = turn_rate_step_deg_s * np.arange(-half, half + 1)
    lower, upper = condition.bounds
    at = condition.altitude_ft, condition.gamma_deg * RAD_PER_DEG
    of_failure = seeds, condition.failure.airframe
    found = solver.grid(*at, lower, upper, tas_kt * FT_S_PER_KT, turn_rate_deg_s * RAD_PER_DEG, *of_failure)
    stable, controllable = np.zeros_like(found.feasible), np.zeros_like(found.feasible)
    if found.feasible.any():
        trims = found.y[found.feasible]
        assessment = assess(condition.altitude_ft, condition.gamma_deg, trims, condition.failure)
        stable[found.feasible], controllable[found.feasible] = assessment
    return EnvelopeGrid(
        condition.altitude_ft,
        condition.gamma_deg,
        condition.failure,
        tas_kt,
        turn_rate_deg_s,
        found.feasible,
        stable,
        controllable,
        found.y,
    )
