"""Turn, straight, turn: paths from a pose to a place or a pose where turns to the left and right have their own radii.

With turns to the right counted positive, the centre of a turn of signed radius r from p on heading psi is
c = p + r n(psi), n = (-sin psi, cos psi). The straight part has the length L and the heading theta for which
    c_b - c_a = L t(theta) + (r_b - r_a) n(theta),  t = (cos theta, sin theta),
so L^2 = |c_b - c_a|^2 - (r_b - r_a)^2. A place without a heading is a last turn of radius zero.
"""

import math
from itertools import product
from typing import NamedTuple

import numpy as np

_TURN = 2.0 * math.pi


class Path(NamedTuple):
    """Signed radii of both turns in m, their angles and the straight part's length; radians, to the right positive."""

    first_m: float
    first_angle: float
    straight_m: float
    last_m: float
    last_angle: float

    @property
    def length_m(self) -> float:
        """Of the whole path."""
        return abs(self.first_m * self.first_angle) + self.straight_m + abs(self.last_m * self.last_angle)


def path(
    start: tuple[float, float, float],
    end: tuple[float, float, float | None],
    radii_m: tuple[float, float],
    kind: int,
) -> Path | None:
    """The path from north, east and heading in rad to another by one pair of turns; None where there is none.

    Args:
        radii_m: of turns to the left and to the right, both positive.
        kind: 0 .. 3, turns left and left, left and right, right and left, right and right; to an end without a heading
            0 and 1, a turn to the left or to the right.
    """
    signed = (-radii_m[0], radii_m[1])
    first, last = (signed[kind // 2], signed[kind % 2]) if end[2] is not None else (signed[kind], 0.0)
    north, east = (b - a for a, b in zip(_centre(start, first), _centre(end, last), strict=True))
    difference = last - first
    square = north * north + east * east - difference * difference
    if square < 0:
        return None
    straight = math.sqrt(square)
    theta = math.atan2(east, north) - math.atan2(difference, straight)
    last_angle = 0.0 if end[2] is None else _angle(end[2] - theta, last)
    return Path(first, _angle(theta - start[2], first), straight, last, last_angle)


def _centre(pose: tuple[float, float, float | None], radius: float) -> tuple[float, float]:
    north, east, heading = pose
    heading = 0.0 if heading is None else heading
    return north - radius * math.sin(heading), east + radius * math.cos(heading)


def _angle(turned: float, side: float) -> float:
    """The turn to this side, from 0 to a whole one."""
    angle = math.fmod(turned, _TURN) if side > 0 else -math.fmod(turned, _TURN)
    angle = angle + _TURN if angle < -1e-9 else max(angle, 0.0)
    return math.copysign(angle if angle < _TURN - 1e-9 else 0.0, side)


def lengths_m(
    north_m: np.ndarray,
    east_m: np.ndarray,
    heading: np.ndarray,
    end: tuple[np.ndarray, np.ndarray, float | None],
    radii_m: tuple[float, float],
) -> np.ndarray:
    """Of the shortest path from each pose (n; heading in rad) to its end (n), infinite where there is none."""
    shortest = np.full(len(north_m), np.inf)
    signed = (-radii_m[0], radii_m[1])
    last_heading = 0.0 if end[2] is None else end[2]
    for first, last in product(signed, signed if end[2] is not None else (0.0,)):
        north = end[0] - last * math.sin(last_heading) - (north_m - first * np.sin(heading))
        east = end[1] + last * math.cos(last_heading) - (east_m + first * np.cos(heading))
        difference = last - first
        square = north * north + east * east - difference * difference
        straight = np.sqrt(np.maximum(square, 0.0))
        theta = np.arctan2(east, north) - np.arctan2(difference, straight)
        length = abs(first) * np.mod(math.copysign(1.0, first) * (theta - heading) + 1e-9, _TURN) + straight
        if end[2] is not None:
            length += abs(last) * np.mod(math.copysign(1.0, last) * (end[2] - theta) + 1e-9, _TURN)
        shortest = np.where(square >= 0, np.minimum(shortest, length), shortest)
    return shortest
