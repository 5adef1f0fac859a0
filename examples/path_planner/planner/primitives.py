"""Steady manoeuvres that the failure leaves, asked for again wherever the altitude changes."""

import math
from typing import NamedTuple

import numpy as np

from examples.path_planner.planner.sources import EnvelopeSource
from examples.path_planner.planner.tracks import displacement
from gtm_fmu.units import M_S_PER_KT, RAD_PER_DEG

LAYER_FT = 250.0
"""Between altitudes at which the FMU is asked while a path is sought."""
SAMPLES = 16
"""Points of a manoeuvre at which the ground is looked at."""
_STRAIGHT_M, _TURNED_DEG, _LEAST_TURN_DEG_S = 500.0, 15.0, 0.3


class Manoeuvre(NamedTuple):
    """A steady manoeuvre; the same order as questions to a source behind the altitude."""

    gamma_deg: float
    tas_kt: float
    turn_rate_deg_s: float


class Leg(NamedTuple):
    """A manoeuvre that is held for some seconds."""

    manoeuvre: Manoeuvre
    duration_s: float


class Steps(NamedTuple):
    """Manoeuvres of one duration each (m), and where they lead from the origin and heading north, without wind.

    Attributes:
        legs: the manoeuvres.
        time_s, ahead_m, right_m, up_ft, turned_deg: after parts of the duration (m, samples), the last is the end.
    """

    legs: tuple[Leg, ...]
    time_s: np.ndarray
    ahead_m: np.ndarray
    right_m: np.ndarray
    up_ft: np.ndarray
    turned_deg: np.ndarray

    @classmethod
    def of(cls, legs: tuple[Leg, ...]) -> "Steps":
        """The tracks of some legs."""
        table = np.array([(*leg.manoeuvre, leg.duration_s) for leg in legs]).reshape(len(legs), 4)
        gamma, tas, rate, duration = (column[:, None] for column in table.T)
        time = duration * np.linspace(1 / SAMPLES, 1, SAMPLES)
        return cls(legs, time, *displacement(tas, gamma, rate, time))


class Primitives:
    """What can be flown at a speed, by altitude."""

    def __init__(
        self,
        source: EnvelopeSource,
        tas_kt: float,
        gammas_deg: tuple[float, ...],
        reserve: float,
        altitude_ft: float,
    ) -> None:
        self.source, self.tas_kt, self.gammas_deg, self.reserve = source, tas_kt, gammas_deg, reserve
        self._feasible: dict[tuple[float, Manoeuvre], bool] = {}
        self._steps: dict[int, Steps] = {}
        self.candidates = self._candidates(altitude_ft)

    def _candidates(self, altitude_ft: float) -> tuple[Leg, ...]:
        """Straight flight, the tightest turns to both sides and half of them, on every flight path that is left."""
        found = []
        for gamma in self.gammas_deg:
            ends = self.source.turn_rates(altitude_ft, gamma, self.tas_kt)
            if ends is not None:
                found += [self._leg(Manoeuvre(gamma, self.tas_kt, rate)) for rate in self.rates(ends)]
        return tuple(found)

    def rates(self, ends: tuple[float, float]) -> tuple[float, ...]:
        """Turn rates in deg/s to choose from; zero only where the aircraft can fly straight and turn both ways."""
        left, right = ends
        if left < -_LEAST_TURN_DEG_S and right > _LEAST_TURN_DEG_S:
            return (self.reserve * left, 0.5 * left, 0.0, 0.5 * right, self.reserve * right)
        loose, tight = sorted(ends, key=abs)
        side = math.copysign(1.0, tight)
        slow, fast = max(side * loose, 0.0) / self.reserve + _LEAST_TURN_DEG_S, abs(tight) * self.reserve
        if slow >= fast:
            return (0.5 * (left + right),)
        return side * slow, side * math.sqrt(slow * fast), side * fast

    def _leg(self, manoeuvre: Manoeuvre) -> Leg:
        if manoeuvre.turn_rate_deg_s:
            return Leg(manoeuvre, _TURNED_DEG / abs(manoeuvre.turn_rate_deg_s))
        speed = manoeuvre.tas_kt * M_S_PER_KT * math.cos(manoeuvre.gamma_deg * RAD_PER_DEG)
        return Leg(manoeuvre, _STRAIGHT_M / speed)

    def are_feasible(self, altitude_ft: float, manoeuvres: list[Manoeuvre]) -> list[bool]:
        """Whether they can be flown at an altitude; each is asked once."""
        new = [m for m in dict.fromkeys(manoeuvres) if (altitude_ft, m) not in self._feasible]
        if new:
            answers = self.source.are_feasible(np.array([(altitude_ft, *m) for m in new]))
            self._feasible |= {(altitude_ft, m): bool(answer) for m, answer in zip(new, answers, strict=True)}
        return [self._feasible[altitude_ft, m] for m in manoeuvres]

    def can_fly(self, manoeuvre: Manoeuvre, from_ft: float, to_ft: float) -> bool:
        """Whether a manoeuvre can be flown at every layer from one altitude to another, those beyond the ends too."""
        return all(self.are_feasible(layer * LAYER_FT, [manoeuvre])[0] for layer in layers(from_ft, to_ft))

    def steps(self, altitude_ft: float) -> Steps:
        """Candidates that can be flown from an altitude to their ends."""
        layer = math.floor(altitude_ft / LAYER_FT)
        if layer not in self._steps:
            bottom, top = layer * LAYER_FT, (layer + 1) * LAYER_FT
            reach = [max(abs(leg.duration_s * _climb_ft_s(leg.manoeuvre)), 0.0) for leg in self.candidates]
            kept = [
                leg
                for leg, up in zip(self.candidates, reach, strict=True)
                if self.can_fly(
                    leg.manoeuvre,
                    bottom - (up if leg.manoeuvre.gamma_deg < 0 else 0.0),
                    top + (up if leg.manoeuvre.gamma_deg > 0 else 0.0),
                )
            ]
            self._steps[layer] = Steps.of(tuple(kept))
        return self._steps[layer]


def layers(from_ft: float, to_ft: float) -> range:
    """Numbers of the layers that hold a range of altitudes between them."""
    low, high = min(from_ft, to_ft), max(from_ft, to_ft)
    return range(max(0, math.floor(low / LAYER_FT)), math.ceil(high / LAYER_FT) + 1)


def _climb_ft_s(manoeuvre: Manoeuvre) -> float:
    return float(displacement(*map(np.float64, (manoeuvre.tas_kt, manoeuvre.gamma_deg, 0.0)), np.float64(1.0))[2])
