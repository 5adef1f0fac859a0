"""The boundary of an envelope in the plane of speed and turn rate: polygons, and the limits that hold their pieces.

A grid of trims shows where the boundary runs: between a trim and a cell without one. Each crossing of a line of the
grid is the extreme of the speed or of the turn rate on it, sought from the trim. A search that reaches the cell has
found a trim that the grid missed, and the way around is taken anew. Between two crossings points are added
on lines across, until the polygon is straight there and one limit holds it.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby, pairwise
from typing import Any

import contourpy
import numpy as np

from gtm_fmu.airframe.names import PSI_DOT, THROTTLE, V
from gtm_fmu.core import solver
from gtm_fmu.envelopes.envelope import FlightCondition
from gtm_fmu.trims import manoeuvre
from gtm_fmu.units import DEG_PER_RAD, FT_S_PER_KT, RAD_PER_DEG

RATE_TOLERANCE_DEG_S, SPEED_TOLERANCE_KT = 0.05, 0.1
"""A point of the polygon is off by less than one of the two."""

_TOLERANCE = np.array([RATE_TOLERANCE_DEG_S, SPEED_TOLERANCE_KT])
_UNKNOWN = (PSI_DOT, V)
_PER_UNIT = np.array([DEG_PER_RAD, 1.0 / FT_S_PER_KT])
_STRAIGHT = 0.25  # of the tolerances
_STEPS = np.array([1.0, 1.0])  # deg/s, kn, of the grid; finer where an envelope has few of them
_CURVE_STEPS = (0.5, 1.0)
_FEWEST = 12
_FINEST = 1e-3  # of the steps
_REACHED = 1e-6  # of the steps
_MOST_WINDOWS, _MOST_SHEETS, _MOST_HALVINGS = 12, 6, 12
_FARTHEST = 2.0  # steps of the grid, from the crossings to a point between them


@dataclass(frozen=True)
class Piece:
    """A part of the boundary that the same limits hold: turn rates (n) in deg/s and speeds (n) in kn.

    A throttle's lower limit holds it too where the net thrust sticks at zero. No limits: the aircraft itself has no
    manoeuvre beyond. Of the curve that two jams leave they are the jams, as
    ``rudder.jam``, unless another limit holds all of it.
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
    """Closed polygons around the manoeuvres, each in pieces that begin where the one before ends.

    There are several where speeds have gaps; a hole is a polygon inside another; where two jams leave only a curve, one
    piece is the curve. Parts narrower than a cell of the grid (1 kn x 1 deg/s, of small envelopes a twelfth) may be
    missing or cut. The limits of a piece have the names of `manoeuvre.limits_hit`.
    """

    polygons: tuple[tuple[Piece, ...], ...]

    @property
    def outlines(self) -> tuple[tuple[np.ndarray, np.ndarray], ...]:
        """Turn rates and speeds once around each of the polygons, back to the first point."""
        return tuple(
            (
                np.concatenate([around[0].turn_rate_deg_s[:1], *(piece.turn_rate_deg_s[1:] for piece in around)]),
                np.concatenate([around[0].tas_kt[:1], *(piece.tas_kt[1:] for piece in around)]),
            )
            for around in self.polygons
        )


@dataclass(frozen=True)
class _Vertex:
    """A trim y on the boundary, at its turn rate and speed (2), and the limits that hold it."""

    place: np.ndarray
    y: np.ndarray
    limits: tuple[str, ...]


def envelope_boundary(condition: FlightCondition) -> Boundary:
    """The boundary of all steady manoeuvres of a flight condition; without an envelope it has no polygon."""
    seeds = condition.extremes()
    if not len(seeds):
        return Boundary(())
    tracer = _Tracer(condition, seeds)
    if not tracer.found.feasible.any():
        return Boundary(((tracer.curve(seeds),),))
    return Boundary(tuple(_pieces(ring) for ring in tracer.rings()))


class _Tracer:
    """Vertices of the boundary about a grid of trims."""

    def __init__(self, condition: FlightCondition, seeds: np.ndarray):
        self._condition = condition
        self._at = condition.altitude_ft, condition.gamma_deg * RAD_PER_DEG
        self._airframe = condition.failure.airframe
        self._crossings: dict[tuple[float, float], _Vertex] = {}
        ends = _PER_UNIT * np.array([seeds[:, _UNKNOWN].min(axis=0), seeds[:, _UNKNOWN].max(axis=0)])
        self._steps = np.minimum(_STEPS, [np.inf, max((ends[1, 1] - ends[0, 1]) / _FEWEST, _FINEST)])
        while True:
            self._axes = [
                start + step * np.arange(-margin, np.ceil((stop - start) / step) + margin + 1)
                for start, stop, step, margin in zip(*ends, self._steps, (40, 2), strict=True)
            ]
            self._axes[1] += 0.37 * self._steps[1]  # an end of the envelope on a line has no area there
            axes = self._axes[1] * FT_S_PER_KT, self._axes[0] * RAD_PER_DEG
            self.found = solver.grid(*self._at, *condition.bounds, *axes, seeds, self._airframe)
            columns = np.count_nonzero(self.found.feasible.any(axis=0))
            if columns >= _FEWEST or self._steps[0] < _FINEST:
                break
            self._steps[0] *= 0.5 if columns > 2 else 0.1

    def rings(self) -> Iterator[list[_Vertex]]:
        """Vertices of each polygon, with the manoeuvres on the left of the way around."""
        for corners in self._corners():
            ring = []
            for start, end in pairwise([*corners, corners[0]]):
                box = 0.5 * np.abs(end.place - start.place) + _FARTHEST * self._steps
                ring += [start, *self._between(start, end, (0.5 * (start.place + end.place), box))]
            yield ring

    def _corners(self) -> list[list[_Vertex]]:
        """The crossings of each polygon with the lines of the grid, once every trim of a cell is known."""
        cells = 0
        while cells < (cells := int(np.count_nonzero(self.found.feasible))):
            lines = contourpy.contour_generator(z=self.found.feasible.astype(float)).lines(0.5)
            around = [[self._crossing(*place) for place in np.asarray(line)[:-1].tolist()] for line in lines]
        rings = [[each for each, after in pairwise([*ring, ring[0]]) if _are_apart(each, after)] for ring in around]
        return [ring for ring in rings if ring]

    def curve(self, seeds: np.ndarray) -> Piece:
        """Manoeuvres where they have no area: the curve of two jams, from end to end.

        It is followed along speed, or along turn rate where the curve turns back in speed: no limit holds an end there.
        """
        axis, ends = 1, [self._vertex(y) for y in seeds[[0, -1]]]
        if not all(end.limits for end in ends):
            axis, ends = 0, [self._vertex(y) for y in self._turning_most()]
        held, unit = _UNKNOWN[axis], _PER_UNIT[axis]
        objective = np.eye(len(seeds[0]))[THROTTLE]  # any will do: one manoeuvre is left there
        first, last = (end.place[axis] for end in ends)
        vertices = ends[:1]
        for value in np.linspace(first, last, int(abs(last - first) / _CURVE_STEPS[axis]) + 2)[1:-1]:
            lower, upper = (bound.copy() for bound in self._condition.bounds)
            lower[held] = upper[held] = value / unit
            start = vertices[-1].y[None]
            best = solver.extreme(*self._at, lower, upper, objective, start, self._airframe)
            if best.status == solver.TRIMMED:
                vertices.append(self._vertex(best.y))
        vertices.append(ends[-1])
        common = set.intersection(*(set(vertex.limits) for vertex in vertices))
        failure = self._condition.failure
        jams = [f"{name}.jam" for name, is_jammed in zip(failure.controls, failure.jammed, strict=True) if is_jammed]
        return Piece(tuple(sorted(common) or jams), *np.array([vertex.place for vertex in vertices]).T)

    def _turning_most(self) -> list[np.ndarray]:
        """Manoeuvres of the least and of the greatest turn rate."""
        bounds = self._condition.bounds
        objective = np.eye(len(bounds[0]))[PSI_DOT]
        return [solver.envelope_end(*self._at, *bounds, sign * objective, self._airframe).y for sign in (1.0, -1.0)]

    def _crossing(self, column: float, row: float) -> _Vertex:
        """Where the boundary crosses a line of the grid, between the two cells about a half of an index.

        Where the trims go on to the cell without one, that has one from now on.
        """
        if (column, row) in self._crossings:
            return self._crossings[column, row]
        cells = [(int(rounded(row)), int(rounded(column))) for rounded in (np.floor, np.ceil)]
        inside, outside = sorted(cells, key=lambda cell: not self.found.feasible[cell])
        start, end = (np.array([self._axes[0][j], self._axes[1][i]]) for i, j in (inside, outside))
        y = self.found.y[inside]
        found = self._extreme(start, end, y[None]) or self._vertex(y)
        if np.all(np.abs(found.place - end) <= _REACHED * self._steps):
            self.found.feasible[outside], self.found.y[outside] = True, found.y
        self._crossings[column, row] = found
        return found

    def _vertex(self, y: np.ndarray) -> _Vertex:
        limits = manoeuvre.limits_hit(y, *self._condition.bounds, self._airframe)
        states = solver.trim_states(*self._at, y, self._airframe)
        if not limits and manoeuvre.is_idling(*states, self._airframe.configuration):
            throttles = (name for name in self._condition.failure.controls if name.startswith("throttle"))
            limits = tuple(f"{name}.lower" for name in throttles)
        return _Vertex(_PER_UNIT * y[list(_UNKNOWN)], y, limits)

    def _extreme(self, start: np.ndarray, end: np.ndarray, starts: np.ndarray) -> _Vertex | None:
        """The trim farthest from one place towards another on a line of equal speed or turn rate."""
        axis = int(np.argmax(np.abs(end - start)))
        sign, found = np.sign((end - start)[axis]), None
        for _ in range(_MOST_SHEETS):
            lower, upper = self._bounds(start, end)
            objective = np.zeros(len(lower))
            objective[_UNKNOWN[axis]] = -sign
            best = solver.extreme(*self._at, lower, upper, objective, starts, self._airframe)
            if best.status != solver.TRIMMED:
                break
            found = self._vertex(best.y)
            start = found.place.copy()
            start[axis] += 0.5 * sign * _TOLERANCE[axis]
            cold = self._trim(start) if sign * (end - start)[axis] > 0 else None
            if cold is None:
                break
            starts = cold[None]  # the trims that were followed end here, but others go on
        return found

    def _trim(self, place: np.ndarray) -> np.ndarray | None:
        lower, upper = self._bounds(place, place)
        altitude, gamma = (np.array([value]) for value in self._at)
        cold = solver.trims(altitude, gamma, lower[None], upper[None], self._airframe)
        return cold.y[0] if cold.status[0] == solver.TRIMMED else None

    def _bounds(self, start: np.ndarray, end: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Bounds that hold turn rate and speed between two places."""
        lower, upper = (bound.copy() for bound in self._condition.bounds)
        ends = np.array([start, end]) / _PER_UNIT
        lower[list(_UNKNOWN)], upper[list(_UNKNOWN)] = ends.min(axis=0), ends.max(axis=0)
        return lower, upper

    def _between(self, start: _Vertex, end: _Vertex, box: tuple, halvings: int = 0) -> Iterator[_Vertex]:
        """Vertices between two, in order, inside a box (middle and half of its sides)."""
        along = (end.place - start.place) / _TOLERANCE
        length = np.abs(along).max()
        if length < 1.0 or halvings == _MOST_HALVINGS:
            return
        axis = int(abs(along[0]) > abs(along[1]))
        sign = float(np.sign(along[1] if axis == 0 else -along[0]))
        middle = self._outermost(start, end, axis, sign * min(length * _TOLERANCE[axis], self._steps[axis]))
        if middle is None or np.any(np.abs(middle.place - box[0]) > box[1]):
            return
        bow = (middle.place - 0.5 * (start.place + end.place))[axis] / _TOLERANCE[axis]
        if abs(bow) < _STRAIGHT and start.limits == middle.limits == end.limits:
            yield middle
            return
        yield from self._between(start, middle, box, halvings + 1)
        yield middle
        yield from self._between(middle, end, box, halvings + 1)

    def _outermost(self, start: _Vertex, end: _Vertex, axis: int, reach: float) -> _Vertex | None:
        """The boundary on the line across the middle of two vertices, sought about it and then beyond."""
        middle, found = 0.5 * (start.place + end.place), None
        out = reach * np.eye(2)[axis]
        near, far, starts = middle - out, middle + out, np.array([start.y, end.y])
        for _ in range(_MOST_WINDOWS):
            farther = self._extreme(near, far, starts)
            if farther is None:
                break
            gap = self._gap(middle, farther.place, reach)
            if gap is not None:  # what lies beyond it is another part of the boundary
                far = gap
                continue
            found = farther
            if abs((far - found.place)[axis]) > 1e-6 * abs(reach):
                break
            near, far, starts = found.place, found.place + 2 * out, found.y[None]
        return found

    def _gap(self, middle: np.ndarray, place: np.ndarray, reach: float) -> np.ndarray | None:
        """A point without a trim on the way from the middle out to a place, if it is long; None if none is met."""
        way = place - middle
        if way.sum() * np.sign(reach) < _TOLERANCE[np.argmax(np.abs(way))]:
            return None
        points = (middle + share * way for share in (0.0, 0.25, 0.5, 0.75))
        return next((point for point in points if self._trim(point) is None), None)


def _are_apart(one: _Vertex, other: _Vertex) -> bool:
    return bool(np.any(np.abs(one.place - other.place) > _REACHED * _TOLERANCE))


def _pieces(ring: list[_Vertex]) -> tuple[Piece, ...]:
    """The ring of vertices cut where the limits change."""
    held = [_held(start.limits, end.limits) for start, end in pairwise([*ring, ring[0]])]
    turn = next((k for k in range(len(held)) if held[k] != held[k - 1]), 0)
    ring, held = ring[turn:] + ring[:turn], held[turn:] + held[:turn]
    places = np.array([vertex.place for vertex in [*ring, ring[0]]])
    pieces, first = [], 0
    for limits, run in groupby(held):
        last = first + len(list(run))
        pieces.append(Piece(limits, *places[first : last + 1].T))
        first = last
    return tuple(pieces)


def _held(start: tuple[str, ...], end: tuple[str, ...]) -> tuple[str, ...]:
    """What holds an edge: of its ends' limits the fewer, since more meet at a corner."""
    return end if set(end) < set(start) and end else start or end
