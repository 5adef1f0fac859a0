"""What a planner answers: a path of steady manoeuvres, with the limits that surround each."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class Segment:
    """A steady manoeuvre that is held for a while; trim and limits are those at its start.

    Attributes:
        start_s, duration_s: since the path's start, and for how long.
        north_m, east_m, altitude_ft, heading_deg: where it begins. Headings are of the path through the air, from north
            to the east; the nose points beside it by the sideslip.
        tas_kt, gamma_deg, turn_rate_deg_s: the manoeuvre; turns to the right are positive.
        bank_deg: of its trim.
        controls: its trim by the FMU's names, as ``elevator_deg``, ``throttle_left_pct``, ``alpha_deg``; empty where
            the source knows no trims.
        v_min_kt, v_max_kt: speeds that the failure leaves on this flight path, turns of any rate included.
        turn_rates_deg_s: turns that it leaves at this speed and flight path, from left to right.
        margins: distance to the lower and the upper limit, in the unit in the name, as ``aileron_deg``.
        binding: the limit with the least margin for its size, as ``bank.upper``.
        second_failures_kt: by the name of a second failure: how far the speed would be inside the speeds that are left
            then, negative outside, None where no steady flight is left on this flight path.
    """

    start_s: float
    duration_s: float
    north_m: float
    east_m: float
    altitude_ft: float
    heading_deg: float
    tas_kt: float
    gamma_deg: float
    turn_rate_deg_s: float
    bank_deg: float
    controls: Mapping[str, float]
    v_min_kt: float
    v_max_kt: float
    turn_rates_deg_s: tuple[float, float]
    margins: Mapping[str, tuple[float, float]]
    binding: str
    second_failures_kt: Mapping[str, float | None]

    @property
    def margin_kt(self) -> float:
        """How far the speed is from the nearer end of those that are left."""
        return min(self.tas_kt - self.v_min_kt, self.v_max_kt - self.tas_kt)


@dataclass(frozen=True)
class Measures:
    """What a path costs in every respect.

    Attributes:
        time_s, distance_m: over ground.
        margin_kt: the least margin of the speed on the way.
        second_failure_kt: the least that the worst second failure leaves on the way; None where it would leave nothing.
        exposed_s: for how long the worst second failure would leave no steady flight, or none at this speed.
        clearance_ft: least height above ground.
    """

    time_s: float
    distance_m: float
    margin_kt: float
    second_failure_kt: float | None
    exposed_s: float
    clearance_ft: float


@dataclass(frozen=True)
class Plan:
    """A path, sampled (n points) and as segments.

    Attributes:
        name: what it was made for.
        time_s, north_m, east_m, altitude_ft, heading_deg: the track (n each).
        cost: of what was made least.
        measures: of the path in every respect.
        source: who was asked about the aircraft.
        seconds, queries: what the search took.
        alternatives: paths that are least in another respect.
    """

    name: str
    segments: tuple[Segment, ...]
    time_s: np.ndarray
    north_m: np.ndarray
    east_m: np.ndarray
    altitude_ft: np.ndarray
    heading_deg: np.ndarray
    cost: float
    measures: Measures
    source: str
    seconds: float = 0.0
    queries: int = 0
    alternatives: "tuple[Plan, ...]" = field(default=())


class NoPathError(RuntimeError):
    """What is asked cannot be flown; the message is one sentence that says what the nearest possible thing is."""
