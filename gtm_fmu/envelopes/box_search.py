"""The aircraft of the box of `tolerances.Tolerances` whose end of an envelope is the worst, or the best.

Slopes of an end over the ten numbers of the box (`core.slopes.tolerance_slopes`) tell which corners to solve; the exact
solutions there tell what they are.
"""

import math
from collections.abc import Collection, Mapping
from itertools import chain, combinations
from typing import NamedTuple

import numpy as np

from gtm_fmu.airframe.names import PSI_DOT, THROTTLE, V
from gtm_fmu.core import solver
from gtm_fmu.core.slopes import tolerance_slopes
from gtm_fmu.envelopes.envelope import THROTTLE_WITHOUT_LIMIT, FlightCondition
from gtm_fmu.envelopes.gust_ends import end_in_gust
from gtm_fmu.envelopes.tolerances import CG_AXES, NOMINAL, Place, Tolerances
from gtm_fmu.units import KT_PER_FT_S, RAD_PER_DEG

_SAME_KT = 1e-4
_NOTHING_KT = 0.02
"""A corner told to be worse by less is not solved."""


class Solved(NamedTuple):
    """An end at a place of the box: the manoeuvre y of a condition, which has that aircraft and the gust's alpha."""

    place: Place
    condition: FlightCondition
    y: np.ndarray

    @property
    def tas_kt(self) -> float:
        """Its speed."""
        return float(self.y[V] * KT_PER_FT_S)


def _slopes(condition: FlightCondition, y: np.ndarray, column: int, sign: float) -> np.ndarray:
    """Of the least ``sign`` times an unknown, which y has, over mass, cg and coefficients (10, 2): below and above."""
    objective = np.zeros(len(y))
    objective[column] = sign
    lower, upper = condition.bounds
    if column == THROTTLE:
        upper = upper.copy()
        upper[THROTTLE] = THROTTLE_WITHOUT_LIMIT
    at = condition.altitude_ft, condition.gamma_deg * RAD_PER_DEG
    return tolerance_slopes(*at, lower, upper, objective, y, condition.failure.airframe)


class EndSearch:
    """For V_min (``sign`` 1) or V_max (-1): from the nominal aircraft to those of the box with the farthest ends."""

    def __init__(self, condition: FlightCondition, tolerances: Tolerances, sign: float) -> None:
        self.condition, self.tolerances, self.sign = condition, tolerances, sign
        self.known: dict[Place, Solved | None] = {}

    def worst(self) -> Solved | None:
        """The highest V_min or the lowest V_max of all corners and the nominal place; None where one has no envelope.

        An end is the better one of its branches, so that a corner that is worse for one may not be for another. Hence
        each corner is solved that may be the worst by the slopes of those before, and then the neighbours of the worst.
        """
        here = self.at(NOMINAL)
        if here is None:
            return None
        order = _Order(self.tolerances, self.sign)
        order.add_turns(here)
        while (place := order.worst(here.tas_kt, self.known) or self._next_neighbour(here)) is not None:
            there = self.at(place)
            if there is None:
                return None
            order.add(there)
            here = self._farther(there, here, 1) or here
        return self._climbed(here, 1)

    def best(self) -> Solved | None:
        """The lowest V_min or the highest V_max; None where no aircraft with an envelope is found.

        The best of all branches is the best of one, which its slopes lead to.
        """
        start = self._place_with_envelope()
        here = None if start is None else self.at(start)
        if here is None:
            return None
        order = _Order(self.tolerances, self.sign)
        order.add_turns(here)
        for there in (here, *map(self.at, order.best())):
            here = self._farther(self._climbed(there, -1), here, -1) or here
        while (place := self._next_neighbour(here)) is not None:
            here = self._climbed(self._farther(self.at(place), here, -1), -1) or here
        return here

    def at(self, place: Place) -> Solved | None:
        """The end of the aircraft at a place; None without an envelope."""
        if place not in self.known:
            condition = self.condition.changed(failure=self.tolerances.moved(self.condition.failure, place))
            found = end_in_gust(condition, self.tolerances, self.sign)
            self.known[place] = found and Solved(place, *found)
        return self.known[place]

    def _farther(self, there: Solved | None, here: Solved, way: int) -> Solved | None:
        """The first end if it is worse (``way`` 1) or better (-1) than the second."""
        return there if there and way * self.sign * (there.tas_kt - here.tas_kt) > _SAME_KT else None

    def _climbed(self, here: Solved | None, way: int) -> Solved | None:
        """The end that slopes lead to from another, all numbers moved at once, or the one that counts most alone."""
        while here is not None:
            gains = _gains(_slopes(here.condition, here.y, V, self.sign), here.place, self.tolerances, way)
            at_once = {k: to for k, (to, _) in gains.items()}
            most = max(gains, key=lambda k: gains[k][1], default=None)
            moves = [] if most is None else [at_once, {most: at_once[most]}]
            ends = (self._farther(self.at(_moved(here.place, moved)), here, way) for moved in moves)
            if (there := next(filter(None, ends), None)) is None:
                break
            here = there
        return here

    def _next_neighbour(self, here: Solved) -> Place | None:
        """A corner not known yet that differs in one number that counts, or in two of the centre of gravity.

        Slopes see no jump on the way to it, and none of what two offsets do together.
        """
        slopes = np.abs(_slopes(here.condition, here.y, V, self.sign)).max(axis=1) * KT_PER_FT_S
        counting = [k for k in self.tolerances.axes if not slopes[k] * self.tolerances.sizes[k] < _NOTHING_KT]
        singles = ({k: to} for k in counting for to in (-1.0, 1.0))
        pairs = ({k: -here.place[k] for k in pair} for pair in combinations(set(counting) & set(CG_AXES), 2))
        places = (_moved(here.place, moved) for moved in chain(singles, pairs))
        return next((place for place in places if place not in self.known), None)

    def _place_with_envelope(self) -> Place | None:
        """The nominal place or, where that has no envelope, the corner to which the least throttle falls, if that has.

        Where there is no least throttle the excess over the limits is looked at instead, along each axis of the box.
        """
        if self.at(NOMINAL):
            return NOMINAL
        least = self.condition.least_throttle_end()
        if least.status == solver.TRIMMED and self.condition.failure.airframe.throttles == solver.ONE_THROTTLE:
            slopes = _slopes(self.condition, least.y, THROTTLE, 1.0)
            gains = _gains(slopes, NOMINAL, self.tolerances, -1)
            moved = {k: to for k, (to, _) in gains.items()}
        else:
            moved = self._nearer()
        place = _moved(NOMINAL, moved)
        return place if self.at(place) else None

    def _nearer(self) -> dict[int, float]:
        """To which side of each axis of the box the limits are exceeded less."""

        def excess(place: Place) -> float:
            condition = self.condition.changed(failure=self.tolerances.moved(self.condition.failure, place))
            return condition.end(self.sign).violation

        nominal, moved = excess(NOMINAL), {}
        for k in self.tolerances.axes:
            sides = {to: excess(_moved(NOMINAL, {k: to})) for to in (-1.0, 1.0)}
            to = min(sides, key=lambda to: sides[to])
            if sides[to] < nominal:
                moved[k] = to
        return moved


class _Order:
    """All corners by what the slopes of the ends that are known say of theirs.

    Left and right turns are branches of their own, of which the better one is the end. Each branch is carried on to a
    corner from that of its places that differs in the fewest numbers.
    """

    def __init__(self, tolerances: Tolerances, sign: float) -> None:
        self.sizes, self.sign = tolerances.sizes, sign
        self.corners = list(tolerances.corners())
        self.rows = np.array(self.corners)
        self.told: dict[int, list[np.ndarray]] = {-1: [], 1: []}
        self.distances: dict[int, list[np.ndarray]] = {-1: [], 1: []}

    def add(self, found: Solved) -> None:
        """Carry the branch of an end on to every corner."""
        self._add(found, found.y, 1 if found.y[PSI_DOT] >= 0 else -1)

    def add_turns(self, found: Solved) -> None:
        """The same with the best turn to either side of this aircraft."""
        condition, objective = found.condition, np.zeros(len(found.y))
        objective[V] = self.sign
        at = condition.altitude_ft, condition.gamma_deg * RAD_PER_DEG
        for side in (-1, 1):
            lower, upper = (bound.copy() for bound in condition.bounds)
            (lower if side > 0 else upper)[PSI_DOT] = 0.0
            end = solver.envelope_end(*at, lower, upper, objective, condition.failure.airframe)
            if end.status == solver.TRIMMED:
                self._add(found, end.y, side)

    def _add(self, found: Solved, y: np.ndarray, side: int) -> None:
        slopes = _slopes(found.condition, y, V, self.sign)
        away = self.rows - found.place
        steps = np.where(away == 0, 0.0, np.where(away < 0, slopes[:, 0], slopes[:, 1]) * away * self.sizes)
        told = (self.sign * y[V] + steps.sum(axis=1)) * KT_PER_FT_S
        self.told[side].append(np.where(np.isnan(told), np.inf, told))  # no manoeuvre is left there
        self.distances[side].append(np.abs(away).sum(axis=1))

    def best(self) -> list[Place]:
        """The corner of each branch that is told to be the best."""
        return [self.corners[int(np.argmin(told[-1]))] for told in self.told.values() if told]

    def worst(self, tas_kt: float, known: Collection[Place]) -> Place | None:
        """The corner, of those not known, that is told to be the worst; None if none is told worse than a speed."""
        each = np.arange(len(self.corners))
        branches = [
            np.array(told)[np.argmin(self.distances[side], axis=0), each] for side, told in self.told.items() if told
        ]
        ends = np.min(branches, axis=0)
        ends[[corner in known for corner in self.corners]] = -np.inf
        k = int(np.argmax(ends))
        return self.corners[k] if ends[k] > self.sign * tas_kt + _NOTHING_KT else None


def _moved(place: Place, to: Mapping[int, float]) -> Place:
    return tuple(to.get(k, value) for k, value in enumerate(place))


def _gains(slopes: np.ndarray, place: Place, tolerances: Tolerances, way: int) -> dict[int, tuple[float, float]]:
    """For each number that moves an objective the way asked: to which side of the box, and how far to first order.

    A side to which no manoeuvre is left is the worst of all.
    """
    gains = {}
    for k, size in enumerate(tolerances.sizes.tolist()):
        sides = [
            (to, (size * abs(to - place[k]) * gain) if math.isfinite(gain) else way * math.inf)
            for to, gain in ((-1.0, -way * slopes[k, 0]), (1.0, way * slopes[k, 1]))
            if to != place[k]
        ]
        to, gain = max(sides, key=lambda side: side[1])
        if size and gain > 0:
            gains[k] = to, gain
    return gains
