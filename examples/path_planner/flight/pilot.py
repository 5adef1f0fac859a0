"""The autopilot of a flight along a plan: it moves from one steady manoeuvre towards another, inside what is left.

What it is to hold is a manoeuvre that the failure leaves, always, and where there is room a little inside. One that is
not left is replaced by the nearest with another flight path or another turn rate that is, else by the one before.
Between the moments at which it is asked, what holds the manoeuvre (`examples.transitions.autopilot`) is interpolated.
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
NEAR_DEG, NEAR_DEG_S = 0.5, 0.1
"""Of flight path and of turn rate that is kept to the ends of those that are left."""

GAINS_HOLD = np.array([500.0, 2.0, 1.0, 0.5])
"""By how much altitude in ft, speed in kn, flight path in deg and turn in deg/s may change until gains are new."""
KEPT_ALPHA_DEG, KEPT_BANK_DEG = 0.3, 0.4
"""To the bounds of alpha and bank."""


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
        self.held, self.failure = held, failure
        alpha, bank = bounds
        self.bounds = (alpha[0], alpha[1] - KEPT_ALPHA_DEG), (bank[0] + KEPT_BANK_DEG, bank[1] - KEPT_BANK_DEG)
        self._gained: tuple[Failure, np.ndarray, Hold] | None = None
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
        """The manoeuvre if all about it is left; else those with less climb or less turn, the nearest first."""
        tas, gamma, rate = moved
        about = np.array([moved, (tas, gamma - NEAR_DEG, rate), (tas, gamma + NEAR_DEG, rate)])
        about = np.concatenate([about, [(tas, gamma, rate - NEAR_DEG_S), (tas, gamma, rate + NEAR_DEG_S)]])
        at = float(np.clip(altitude_ft, *ALTITUDE_FT))
        bounds = (self.failure, *self.bounds)
        if manoeuvres(at, *about.T, *bounds).feasible.all():
            yield moved
        others = []
        for turn in (rate, self.held.turn_rate_deg_s):
            if (path := _nearest(gamma, climb_interval(at, tas, turn, *bounds), NEAR_DEG)) is not None:
                others.append(Manoeuvre(tas, path, turn))
        for path in (gamma, self.held.gamma_deg):
            if (turn := _nearest(rate, turn_rate_interval(at, tas, path, *bounds), NEAR_DEG_S)) is not None:
                others.append(Manoeuvre(tas, path, turn))
        yield from sorted(others, key=lambda each: abs(each.gamma_deg - gamma) + abs(each.turn_rate_deg_s - rate))
        yield self.held

    def commands(self, states: np.ndarray, now_s: float) -> np.ndarray:
        """Commands (4) of the controls in deg and % at states (8)."""
        part = (now_s - self._since_s) / ASKED_EVERY_S
        between = [here + part * (there - here) for here, there in zip(self._before, self._next, strict=True)]
        rates = (self._next.states - self._before.states) / ASKED_EVERY_S
        return Hold(*between).commands(states, rates)

    def _asked(self, altitude_ft: float, manoeuvre: Manoeuvre) -> Manoeuvres:
        return manoeuvres(float(np.clip(altitude_ft, *ALTITUDE_FT)), *manoeuvre, self.failure, *self.bounds)

    def _hold(self, found: Manoeuvres) -> Hold:
        """What holds a manoeuvre, with the gains of one nearby if they are known."""
        here = np.array(found.asked).ravel()
        if self._gained is not None:
            failure, there, known = self._gained
            if failure is self.failure and (np.abs(here - there) < GAINS_HOLD).all():
                return hold(found, 0, known)
        with threadpool_limits(1):
            found_hold = hold(found, 0)
        self._gained = self.failure, here, found_hold
        return found_hold
