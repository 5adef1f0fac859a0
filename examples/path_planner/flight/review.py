"""What came of a flight: whether it stayed inside what the failure leaves, how near it came to it, and the track.

Inside means at each second from the beginning of the plan on: alpha and bank inside their bounds, the speed between
V_min and V_max of the altitude and flight path that are flown, and the turn between the ends of those at that speed.
The envelope is that of steady flight, so speed, flight path and turn are means over 5 s.
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import uniform_filter1d

from examples.path_planner.flight.failure import bounds_of, failure_of
from examples.path_planner.flight.flight import Flight
from examples.path_planner.flight.pilot import ASKED_EVERY_S
from examples.path_planner.planner.scenario import Scenario
from gtm_fmu.envelopes.envelope import FlightCondition
from gtm_fmu.envelopes.sections import turn_rate_interval

EVERY_S = 1.0
TRACK_M, TRACK_FT = 100.0, 150.0
"""Farther from the track than this has left it."""
_AVERAGED = ("tas_kt", "gamma_deg", "turn_rate_deg_s")
_MEAN = round(5.0 / ASKED_EVERY_S)
_PATHS_DEG, _ALTITUDES_FT = 0.5, 250.0  # to which V_min and V_max are asked for


@dataclass(frozen=True)
class Review:
    """Of one flight, from the beginning of the plan on (n samples).

    Attributes:
        time_s: of the samples.
        v_min_kt, v_max_kt, turns_deg_s: (n), (n), (n, 2), NaN where no steady flight is left.
        margins: by name (n): distance to the nearer limit, negative outside: ``tas_kt``, ``turn_rate_deg_s``,
            ``alpha_deg``, ``bank_deg``, ``clearance_ft`` (of the ground).
        is_inside: (n) all but the clearance are positive.
        across_m, above_ft: the greatest distances from the track.
        left_track_s: when it was left first, None if never.
    """

    flight: Flight
    time_s: np.ndarray
    v_min_kt: np.ndarray
    v_max_kt: np.ndarray
    turns_deg_s: np.ndarray
    margins: dict[str, np.ndarray]
    is_inside: np.ndarray
    across_m: float
    above_ft: float
    left_track_s: float | None

    @property
    def left_envelope_s(self) -> float | None:
        """When the flight was outside first; None if never."""
        return None if self.is_inside.all() else float(self.time_s[np.argmin(self.is_inside)])

    @property
    def outside_s(self) -> float:
        """For how long it was outside."""
        return float(np.count_nonzero(~self.is_inside) * EVERY_S)

    @property
    def least(self) -> dict[str, float]:
        """The least of each margin; minus infinity where there was never steady flight."""
        return {
            name: float(np.fmin.reduce(values, initial=np.inf)) if np.isfinite(values).any() else -np.inf
            for name, values in self.margins.items()
        }

    @property
    def is_as_planned(self) -> bool:
        """Whether it came to the end of the plan, on the track and inside the envelope."""
        return self.flight.is_complete and self.left_track_s is None and self.left_envelope_s is None

    @property
    def summary(self) -> str:
        """In a sentence."""
        parts = [f"flown to {self.time_s[-1]:.0f} s: {self.flight.end}"]
        if self.left_envelope_s is None:
            parts.append(f"inside the envelope all the way, {self.least['tas_kt']:.0f} kn from its ends at least")
        else:
            parts.append(
                f"outside the envelope from {self.left_envelope_s:.0f} s on, for {self.outside_s:.0f} s in all"
            )
        parts.append(f"{self.across_m:.0f} m and {self.above_ft:.0f} ft off the track at most")
        if self.left_track_s is not None:
            parts[-1] = f"off the track from {self.left_track_s:.0f} s on, by {self.across_m:.0f} m at most"
        return "; ".join(parts) + "."


def review(flight: Flight, scenario: Scenario) -> Review:
    """Ask the exact envelope along a flight."""
    failure, (alpha, bank) = failure_of(scenario.failure), bounds_of(scenario.failure)
    columns = flight.columns
    time = columns["time_s"]
    after = np.flatnonzero(time >= -1e-9)
    rows = after[np.unique(np.searchsorted(time[after], np.arange(0.0, time[-1] + 1e-9, EVERY_S)))]
    steady = {name: uniform_filter1d(columns[name], _MEAN, mode="nearest") for name in _AVERAGED}
    c = {name: values[rows] for name, values in (columns | steady).items()}
    speeds: dict[tuple[float, float], tuple[float, float]] = {}
    ends, turns = np.full((2, len(rows)), np.nan), np.full((len(rows), 2), np.nan)
    for k, (altitude, tas, gamma, turn) in enumerate(
        zip(c["altitude_ft"], c["tas_kt"], c["gamma_deg"], c["turn_rate_deg_s"], strict=True)
    ):
        if abs(gamma) > 45 or altitude < 0:
            continue
        key = round(altitude / _ALTITUDES_FT) * _ALTITUDES_FT, round(gamma / _PATHS_DEG) * _PATHS_DEG
        if key not in speeds:
            found = FlightCondition(*key, failure, alpha, bank).envelope()
            speeds[key] = (found.v_min_kt or np.nan, found.v_max_kt or np.nan)
        ends[:, k] = speeds[key]
        left = turn_rate_interval(altitude, max(tas, 20.0), gamma, failure, alpha, bank).intervals
        if left:
            turns[k] = min(left, key=lambda pair: max(pair[0] - turn, turn - pair[1]))
    ground = scenario.terrain.height(c["north_m"], c["east_m"])
    margins = {
        "tas_kt": np.minimum(c["tas_kt"] - ends[0], ends[1] - c["tas_kt"]),
        "turn_rate_deg_s": np.minimum(c["turn_rate_deg_s"] - turns[:, 0], turns[:, 1] - c["turn_rate_deg_s"]),
        "alpha_deg": np.minimum(c["alpha_deg"] - alpha[0], alpha[1] - c["alpha_deg"]),
        "bank_deg": np.minimum(c["bank_deg"] - bank[0], bank[1] - c["bank_deg"]),
        "clearance_ft": c["altitude_ft"] - ground,
    }
    is_inside = np.all([values >= 0 for name, values in margins.items() if name != "clearance_ft"], axis=0)
    off = (np.abs(columns["across_m"]) > TRACK_M) | (np.abs(columns["above_ft"]) > TRACK_FT)
    return Review(
        flight=flight,
        time_s=c["time_s"],
        v_min_kt=ends[0],
        v_max_kt=ends[1],
        turns_deg_s=turns,
        margins=margins,
        is_inside=is_inside,
        across_m=float(np.abs(columns["across_m"]).max()),
        above_ft=float(np.abs(columns["above_ft"]).max()),
        left_track_s=float(time[np.argmax(off)]) if off.any() else None,
    )
