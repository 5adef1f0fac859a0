"""Which steady manoeuvre brings the aircraft back to the track: the plan's own, corrected by where the aircraft is.

Beside the planned manoeuvre, across the track and in altitude, with e the distance to its right, chi headings through
the air and h altitudes:

    turn rate = planned + (chi_planned - atan(e / L) - chi) / tau
    flight path = planned + (h_planned - h) / (V tau_h)

The planned manoeuvre is taken a little ahead, because a change takes its time.
"""

from typing import NamedTuple

import numpy as np

from examples.path_planner.planner.plan import Plan
from examples.path_planner.planner.tracks import Wind
from examples.transitions.path import Manoeuvre
from gtm_fmu.units import DEG_PER_RAD, FT_S_PER_KT, M_S_PER_KT, RAD_PER_DEG

RESAMPLED_S, WINDOW_S = 0.1, 8.0
AHEAD_S, AIM_S, HEADING_S, ALTITUDE_S = 1.2, 4.0, 3.0, 8.0
MOST_CLIMB_DEG = 1.5
"""Of flight path beside the planned one."""


class Place(NamedTuple):
    """Where the aircraft is: m, m, ft, heading through the air in deg, flight path through the air in deg."""

    north_m: float
    east_m: float
    altitude_ft: float
    heading_deg: float


def turned(angle_deg: float) -> float:
    """An angle in deg from -180 to 180."""
    return (angle_deg + 180.0) % 360.0 - 180.0


class Guide:
    """Follows one plan, and before it a straight and level line that leads to its start.

    Attributes:
        at_s: how far along the plan the aircraft is; negative before its start.
        across_m, above_ft: its distance to the right of the track and above it.
    """

    def __init__(self, plan: Plan, lead_s: float, wind: Wind) -> None:
        self.end_s, self._lead_s = float(plan.time_s[-1]), lead_s
        self._time = np.arange(-lead_s, self.end_s + RESAMPLED_S, RESAMPLED_S)
        heading = np.unwrap(plan.heading_deg, period=360.0)
        columns = (plan.north_m, plan.east_m, plan.altitude_ft, heading)
        self._track = np.array([np.interp(self._time, plan.time_s, column) for column in columns])
        course, speed = heading[0] * RAD_PER_DEG, plan.segments[0].tas_kt * M_S_PER_KT
        velocity = np.array([speed * np.cos(course) + wind.north_m_s, speed * np.sin(course) + wind.east_m_s])
        self._track[:2] += velocity[:, None] * np.minimum(self._time, 0.0)
        course = np.gradient(self._track[:2], axis=1)
        self._right = np.array([-course[1], course[0]]) / np.hypot(*course)
        self._begins = np.array([segment.start_s for segment in plan.segments])
        self._segments = plan.segments
        self.at_s, self.across_m, self.above_ft = -lead_s, 0.0, 0.0

    @property
    def is_over(self) -> bool:
        """Whether the plan has been flown to its end."""
        return self.at_s >= self.end_s - RESAMPLED_S

    def planned(self, time_s: float) -> Manoeuvre:
        """The manoeuvre of the plan."""
        k = int(np.clip(np.searchsorted(self._begins, time_s, side="right") - 1, 0, len(self._begins) - 1))
        segment = self._segments[k]
        if time_s < 0:
            return Manoeuvre(segment.tas_kt)
        return Manoeuvre(segment.tas_kt, segment.gamma_deg, segment.turn_rate_deg_s)

    def manoeuvre(self, place: Place) -> Manoeuvre:
        """The one to fly here."""
        k = self._nearest(place)
        self.at_s = float(self._time[k])
        north, east, altitude, heading = self._track[:, k]
        away = np.array([place.north_m - north, place.east_m - east])
        self.across_m, self.above_ft = float(away @ self._right[:, k]), place.altitude_ft - float(altitude)
        tas_kt, gamma_deg, rate = self.planned(self.at_s + AHEAD_S)
        aim = heading - np.arctan(self.across_m / (AIM_S * tas_kt * M_S_PER_KT)) * DEG_PER_RAD
        climb = -self.above_ft / (tas_kt * FT_S_PER_KT * ALTITUDE_S) * DEG_PER_RAD
        return Manoeuvre(
            tas_kt,
            gamma_deg + float(np.clip(climb, -MOST_CLIMB_DEG, MOST_CLIMB_DEG)),
            rate + turned(float(aim) - place.heading_deg) / HEADING_S,
        )

    def _nearest(self, place: Place) -> int:
        begin = round((self.at_s + self._lead_s) / RESAMPLED_S)
        window = self._track[:2, begin : begin + round(WINDOW_S / RESAMPLED_S)]
        return begin + int(np.argmin(np.hypot(window[0] - place.north_m, window[1] - place.east_m)))
