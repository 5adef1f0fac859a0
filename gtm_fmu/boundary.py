"""The boundary of an envelope: lowest and highest turn rate over speed, and the limits that hold its pieces."""

from bisect import bisect_left
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise
from typing import Any

import numpy as np

SPEED_TOLERANCE_KT, RATE_TOLERANCE_DEG_S = 0.1, 0.05
"""A point of the polygon is off by less than one of the two."""

_WIDEST_STEP_KT = 4.0  # between the speeds at which both turn rates are sought from everywhere
_NARROWEST_KT = 1e-6  # between two points, where a limit of speed holds a range of turn rates
_STRAIGHT_DEG_S = 0.25 * RATE_TOLERANCE_DEG_S  # a kink between two points shows at least by half at their middle


@dataclass(frozen=True)
class BoundaryPoint:
    """A manoeuvre of extreme turn rate at its speed: trim unknowns y (9 or 10), and the limits that hold it."""

    tas_kt: float
    turn_rate_deg_s: float
    y: np.ndarray
    limits: tuple[str, ...]


Extreme = Callable[[float, np.ndarray | None], BoundaryPoint | None]
"""The point at a speed in kt, sought from trims (n, 9 or 10) or from everywhere; None where no manoeuvre was found."""


@dataclass(frozen=True)
class Piece:
    """A part of the boundary that the same limits hold: turn rates (n) in deg/s and speeds (n) in kt.

    No limits: no turn at these speeds is faster, whatever the limits.
    """

    limits: tuple[str, ...]
    turn_rate_deg_s: np.ndarray
    tas_kt: np.ndarray

    def to_dict(self) -> dict[str, Any]:
        """All values, ready for JSON."""
        points = {"turn_rate_deg_s": self.turn_rate_deg_s.tolist(), "tas_kt": self.tas_kt.tolist()}
        return {"limits": list(self.limits), **points}


@dataclass(frozen=True)
class Boundary:
    """Lowest and highest turn rate (n) in deg/s over true airspeed (n) in kt.

    Between two speeds it is drawn straight. Near the ceiling some turn rates between the two may have no manoeuvre: the
    narrow notches of a few envelopes, which a grid (`grid.envelope_grid`) shows. In a gap of the speeds (see
    `envelope.FlightCondition.intervals`) there is one point, and its turn rates are NaN. ``limits_min`` and
    ``limits_max`` (n) name the limits that hold each point (`manoeuvre.limits_hit`).
    """

    tas_kt: np.ndarray
    turn_rate_min_deg_s: np.ndarray
    turn_rate_max_deg_s: np.ndarray
    limits_min: tuple[tuple[str, ...], ...]
    limits_max: tuple[tuple[str, ...], ...]

    @classmethod
    def nothing(cls) -> "Boundary":
        """Where there is no manoeuvre."""
        return cls(np.empty(0), np.empty(0), np.empty(0), (), ())

    @property
    def polygons(self) -> tuple[tuple[Piece, ...], ...]:
        """For each interval of speeds its closed boundary, in pieces that each begin where the one before ends.

        It leads from the lowest speed up along the lowest turn rates and back along the highest.
        """
        gaps = np.flatnonzero(np.isnan(self.turn_rate_min_deg_s)).tolist()
        ends = [-1, *gaps, len(self.tas_kt)]
        return tuple(self._around(before + 1, after) for before, after in pairwise(ends) if after - before > 1)

    @property
    def outlines(self) -> tuple[tuple[np.ndarray, np.ndarray], ...]:
        """Turn rates and speeds once around each of the `polygons`, back to the first point."""
        return tuple(
            (
                np.concatenate([around[0].turn_rate_deg_s[:1], *(piece.turn_rate_deg_s[1:] for piece in around)]),
                np.concatenate([around[0].tas_kt[:1], *(piece.tas_kt[1:] for piece in around)]),
            )
            for around in self.polygons
        )

    def _around(self, start: int, stop: int) -> tuple[Piece, ...]:
        points = slice(start, stop)
        speeds, lowest, highest = (
            self.tas_kt[points],
            self.turn_rate_min_deg_s[points],
            self.turn_rate_max_deg_s[points],
        )
        if len(speeds) == 1:
            return (Piece(self.limits_min[start], lowest, speeds),)
        rates, speeds = np.append(lowest, highest[-2::-1]), np.append(speeds, speeds[-2::-1])
        edges = [*_edges(self.limits_min[points]), *reversed(_edges(self.limits_max[points]))]
        pieces, first = [], 0
        for limits, run in groupby(edges):
            last = first + len(list(run))
            pieces.append(Piece(limits, rates[first : last + 1], speeds[first : last + 1]))
            first = last
        return tuple(pieces)


def _edges(limits: Sequence[tuple[str, ...]]) -> list[tuple[str, ...]]:
    """What holds the edges between points: the lower one's limits, but at an end those that it has in common."""
    held = list(limits[:-1])
    for edge, end, inner in ((0, 0, 1), (-1, -1, -2)):
        common = tuple(name for name in limits[end] if name in limits[inner])
        held[edge] = common or limits[end] or limits[inner]
    return held


def traced(intervals: Iterable[tuple[BoundaryPoint, BoundaryPoint]], lowest: Extreme, highest: Extreme) -> Boundary:
    """The boundary over intervals of speed, each from its slowest to its fastest manoeuvre.

    Extremes are sought from everywhere every few knots and from their neighbours, then between two points until the
    straight line holds halfway and at both quarters, or the two are within both tolerances.
    """
    columns: list[tuple] = []
    for slowest, fastest in intervals:
        if columns:
            columns.append((0.5 * (columns[-1][0] + slowest.tas_kt), np.nan, np.nan, (), ()))
        low, high = (_side(slowest, fastest, *goal) for goal in ((lowest, -1), (highest, 1)))
        known = sorted({point.tas_kt for point in low + high})
        for one, other in zip(_at(known, low, lowest), _at(known, high, highest), strict=True):
            columns.append((one.tas_kt, one.turn_rate_deg_s, other.turn_rate_deg_s, one.limits, other.limits))
    if not columns:
        return Boundary.nothing()
    speeds, rates_min, rates_max, limits_min, limits_max = zip(*columns, strict=True)
    return Boundary(np.array(speeds), np.array(rates_min), np.array(rates_max), limits_min, limits_max)


def _at(speeds: list[float], side: list[BoundaryPoint], extreme: Extreme) -> Iterator[BoundaryPoint]:
    """Points of a side at more speeds than its own."""
    known = [point.tas_kt for point in side]
    for speed in speeds:
        k = bisect_left(known, speed)
        if known[k] == speed:
            yield side[k]
            continue
        before, after = side[k - 1], side[k]
        share = (speed - before.tas_kt) / (after.tas_kt - before.tas_kt)
        rate = before.turn_rate_deg_s + share * (after.turn_rate_deg_s - before.turn_rate_deg_s)
        found = extreme(speed, np.array([before.y, after.y]))
        yield found or BoundaryPoint(speed, rate, before.y, before.limits)


def _side(slowest: BoundaryPoint, fastest: BoundaryPoint, extreme: Extreme, sign: int) -> list[BoundaryPoint]:
    """Points of the extreme turn rate, the highest (sign 1) or the lowest (-1), dense enough for straight lines."""
    steps = max(int(np.ceil((fastest.tas_kt - slowest.tas_kt) / _WIDEST_STEP_KT)), 1)
    speeds = np.linspace(slowest.tas_kt, fastest.tas_kt, steps + 1)[1:-1].tolist()
    points = [slowest, *(extreme(speed, None) for speed in speeds), fastest]
    for k, neighbour in [*((k, k - 1) for k in range(1, steps)), *((k, k + 1) for k in range(steps - 1, 0, -1))]:
        if (near := points[neighbour]) is not None:
            found = [point for point in (points[k], extreme(speeds[k - 1], near.y[None])) if point is not None]
            points[k] = max(found, key=lambda point: sign * point.turn_rate_deg_s, default=None)
    coarse = [point for point in points if point is not None]
    fine = coarse[:1]
    for before, after in pairwise(coarse):
        fine += [*_between(before, after, extreme), after]
    return fine


def _between(
    before: BoundaryPoint, after: BoundaryPoint, extreme: Extreme, is_half: bool = False
) -> Iterator[BoundaryPoint]:
    """Points between two, in order; ``is_half`` tells that a straight line held in the middle of twice as much."""
    wide, high = after.tas_kt - before.tas_kt, abs(after.turn_rate_deg_s - before.turn_rate_deg_s)
    if wide < _NARROWEST_KT or (wide < SPEED_TOLERANCE_KT and high < RATE_TOLERANCE_DEG_S):
        return
    speed = 0.5 * (before.tas_kt + after.tas_kt)
    middle = extreme(speed, np.array([before.y, after.y])) or extreme(speed, None)
    if middle is None:
        return
    bow = middle.turn_rate_deg_s - 0.5 * (before.turn_rate_deg_s + after.turn_rate_deg_s)
    is_straight = abs(bow) < _STRAIGHT_DEG_S and before.limits == middle.limits == after.limits
    if is_straight and is_half:
        yield middle
        return
    yield from _between(before, middle, extreme, is_straight)
    yield middle
    yield from _between(middle, after, extreme, is_straight)
