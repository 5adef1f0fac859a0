"""The autopilot of a flight along a plan: it moves from one steady manoeuvre towards another, inside what is left.

What it is to hold is a manoeuvre that the failure leaves, always, and where there is room a little inside. One that is
not left is replaced by one with the nearest flight path that is, else with the nearest turn rate, else by the one
before. Between the moments at which it is asked, what holds the manoeuvre (`examples.transitions.autopilot`) is
interpolated.
"""

from collections.abc import Iterator

import numpy as np
from threadpoolctl import threadpool_limits

from examples.transitions.autopilot import Hold, hold
from examples.transitions.path import Manoeuvre
from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.ranges import ALTITUDE_FT, Range
from gtm_fmu.envelopes.manoeuvres import Manoeuvres, manoeuvres
from gtm_fmu.envelopes.sections import Section, climb_interval, turn_rate_interval

ASKED_EVERY_S = 0.2
SETTLES_S = Manoeuvre(1.0, 1.0, 0.5)
"""Time in which the held speed, flight path and turn rate come near those that are wanted."""
FASTEST = Manoeuvre(2.0, 2.0, 4.0)
"""Of their motion: kn/s, deg/s, deg/s^2."""
NEAR_DEG, NEAR_DEG_S = 0.5, 0.5
"""Of flight path and of turn rate that is kept to the ends of those that are left."""


def _nearest(value: float, section: Section, kept: float) -> float | None:
    """The nearest value of a section that is so far inside, or in the middle; None where nothing is left."""
    inside = [
        float(np.clip(value, min(low + kept, 0.5 * (low + high)), max(high - kept, 0.5 * (low + high))))
        for low, high in section.intervals
    ]
    return min(inside, key=lambda each: abs(each - value), default=None)


class Pilot:
    """The autopilot, which knows the failure that it is told.

    Attributes:
        held: the manoeuvre that is held.
    """

    def __init__(self, held: Manoeuvre, altitude_ft: float, failure: Failure, bounds: tuple[Range, Range]) -> None:
        """Hold a manoeuvre, which must be feasible."""
        self.held, self.failure, self.bounds = held, failure, bounds
        self._before = self._next = self._hold(self._asked(altitude_ft, held))
        self._since_s = 0.0

    def fails(self, failure: Failure) -> None:
        """From now on this is what is left."""
        self.failure = failure

    def steer(self, altitude_ft: float, wanted: Manoeuvre, now_s: float) -> None:
        """Move towards a wanted manoeuvre; to be called every `ASKED_EVERY_S`."""
        self._before, self._since_s = self._next, now_s
        moved = []
        for held, goal, settles, fastest in zip(self.held, wanted, SETTLES_S, FASTEST, strict=True):
            change = float(np.clip((goal - held) / settles, -fastest, fastest)) * ASKED_EVERY_S
            moved.append(held + change)
        for manoeuvre in self._choices(altitude_ft, Manoeuvre(*moved)):
            found = self._asked(altitude_ft, manoeuvre)
            if found.feasible[0]:
                try:
                    self._next = self._hold(found)
                except (ValueError, np.linalg.LinAlgError):
                    continue
                self.held = manoeuvre
                return

    def _choices(self, altitude_ft: float, moved: Manoeuvre) -> Iterator[Manoeuvre]:
        """The manoeuvre if all about it is left; else with as much of its climb as is left, else with less turn."""
        tas, gamma, rate = moved
        about = np.array([moved, (tas, gamma - NEAR_DEG, rate), (tas, gamma + NEAR_DEG, rate)])
        about = np.concatenate([about, [(tas, gamma, rate - NEAR_DEG_S), (tas, gamma, rate + NEAR_DEG_S)]])
        at = float(np.clip(altitude_ft, *ALTITUDE_FT))
        bounds = (self.failure, *self.bounds)
        if manoeuvres(at, *about.T, *bounds).feasible.all():
            yield moved
        for turn in (rate, self.held.turn_rate_deg_s):
            path = _nearest(gamma, climb_interval(at, tas, turn, *bounds), NEAR_DEG)
            if path is None:
                continue
            inside = _nearest(turn, turn_rate_interval(at, tas, path, *bounds), NEAR_DEG_S)
            if inside is not None:
                yield Manoeuvre(tas, path, inside)
        for path in (gamma, self.held.gamma_deg):
            turns = turn_rate_interval(at, tas, path, *bounds)
            if (inside := _nearest(rate, turns, NEAR_DEG_S)) is not None:
                yield Manoeuvre(tas, path, inside)
        yield self.held

    def commands(self, states: np.ndarray, now_s: float) -> np.ndarray:
        """Commands (4) of the controls in deg and % at states (8)."""
        part = (now_s - self._since_s) / ASKED_EVERY_S
        between = [here + part * (there - here) for here, there in zip(self._before, self._next, strict=True)]
        rates = (self._next.states - self._before.states) / ASKED_EVERY_S
        return Hold(*between).commands(states, rates)

    def _asked(self, altitude_ft: float, manoeuvre: Manoeuvre) -> Manoeuvres:
        return manoeuvres(float(np.clip(altitude_ft, *ALTITUDE_FT)), *manoeuvre, self.failure, *self.bounds)

    @staticmethod
    def _hold(found: Manoeuvres) -> Hold:
        with threadpool_limits(1):
            return hold(found, 0)
