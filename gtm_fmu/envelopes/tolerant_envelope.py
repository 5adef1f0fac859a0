"""The envelope that is left for sure, and the one that is possible, where the aircraft is not known for sure.

Guaranteed speeds are inside the envelopes of all aircraft of the box of `tolerances.Tolerances`, and keep their margins
in a gust. Possible speeds are inside the envelope of some aircraft, in still air. So the guaranteed V_min is the highest
V_min of the box, the possible one the lowest.

Each is sought at corners. The slopes of an end over the ten numbers of the box (`core.slopes.tolerance_slopes`) tell to
which corner to go, the exact solution there tells what it is, and its slopes whether a neighbouring corner would be worse.

With a gust w across the wings alpha has to stay inside its bounds at alpha +- atan(w / V). These bounds hang on the
speed itself, so that an end is a root: V = V_min(bounds at V). They widen with V. So V_min(V) falls and the root is
unique; V_max(V) rises, and repeated solution comes down to the largest root. A gust of u kn along the flight path then
takes u from either end.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.aircraft.ranges import ALPHA_DEG, PHI_DEG, Range
from gtm_fmu.airframe.names import THROTTLE, V
from gtm_fmu.core import solver
from gtm_fmu.core.slopes import tolerance_slopes
from gtm_fmu.envelopes.envelope import THROTTLE_WITHOUT_LIMIT, Envelope, FlightCondition
from gtm_fmu.envelopes.tolerances import NOMINAL, Place, Tolerances
from gtm_fmu.trims import manoeuvre
from gtm_fmu.trims.manoeuvre import Trim
from gtm_fmu.units import KT_PER_FT_S, RAD_PER_DEG

_SAME_KT = 1e-4
_MOST_PLACES, _MOST_SOLUTIONS = 12, 60


@dataclass(frozen=True)
class TolerantEnd:
    """An end of the guaranteed or of the possible envelope.

    Attributes:
        tas_kt: the speed, with the margin for a gust along the flight path.
        trim: the manoeuvre at the end before that margin is taken.
        place: of the aircraft that has it, from its nominal values: mass and coefficients as fractions, cg in ft.
        gust_alpha_deg, gust_load_factor: what the gust across the wings does there, in deg and in g.
    """

    tas_kt: float
    trim: Trim
    place: dict[str, float]
    gust_alpha_deg: float = 0.0
    gust_load_factor: float = 0.0

    def to_dict(self) -> dict[str, Any]:
        """All values, ready for JSON."""
        return {
            "tas_kt": self.tas_kt,
            "aircraft": self.place,
            "gust_alpha_deg": self.gust_alpha_deg,
            "gust_load_factor": self.gust_load_factor,
            "trim": self.trim.to_dict(),
        }


Ends = tuple[TolerantEnd, TolerantEnd]


@dataclass(frozen=True)
class TolerantEnvelope:
    """An envelope with what its tolerances make of it.

    Attributes:
        guaranteed: V_min and V_max that are inside the envelopes of all aircraft, with the margins of the gust kept;
            None where an aircraft has no envelope, or where nothing lies between.
        possible: V_min and V_max that some aircraft has; None where none was found.
    """

    tolerances: Tolerances
    nominal: Envelope
    guaranteed: Ends | None
    possible: Ends | None

    def to_dict(self) -> dict[str, Any]:
        """Tolerances, and both envelopes with their ends, ready for JSON."""
        return {
            "tolerances": asdict(self.tolerances),
            "guaranteed": _ends_dict(self.guaranteed),
            "possible": _ends_dict(self.possible),
        }


def _ends_dict(ends: Ends | None) -> dict[str, Any]:
    if ends is None:
        return {"feasible": False, "v_min_kt": None, "v_max_kt": None, "at_v_min": None, "at_v_max": None}
    low, high = ends
    speeds = {"feasible": True, "v_min_kt": low.tas_kt, "v_max_kt": high.tas_kt}
    return speeds | {"at_v_min": low.to_dict(), "at_v_max": high.to_dict()}


def tolerant_envelope(
    altitude_ft: float,
    gamma_deg: float,
    limits: ControlLimits | Failure | None = None,
    tolerances: Tolerances | None = None,
    alpha_deg: Range = ALPHA_DEG,
    phi_deg: Range = PHI_DEG,
) -> TolerantEnvelope:
    """Exact envelope of a flight condition, with the guaranteed and the possible one.

    Raises:
        InputError: altitude, flight path or bounds outside what is allowed.
    """
    return tolerant_envelope_of(FlightCondition(altitude_ft, gamma_deg, limits, alpha_deg, phi_deg), tolerances)


def tolerant_envelope_of(condition: FlightCondition, tolerances: Tolerances | None = None) -> TolerantEnvelope:
    """The same of a flight condition."""
    tolerances = tolerances or Tolerances()
    in_still_air = replace(tolerances, gust_kt=0.0)
    worst = [_Search(condition, tolerances, sign).worst() for sign in (1.0, -1.0)]
    best = [_Search(condition, in_still_air, sign).best() for sign in (1.0, -1.0)]
    return TolerantEnvelope(tolerances, condition.envelope(), _ends(tolerances, *worst), _ends(in_still_air, *best))



class _Solved(NamedTuple):
    """An end at a place of the box: the manoeuvre y of a condition, which has that aircraft and the gust's alpha."""

    place: Place
    condition: FlightCondition
    y: np.ndarray

    @property
    def tas_kt(self) -> float:
        """Its speed."""
        return float(self.y[V] * KT_PER_FT_S)


def _slopes(condition: FlightCondition, y: np.ndarray, column: int, sign: float) -> np.ndarray:
    """Of the least ``sign`` times an unknown, which y has, over the ten numbers of the box (10, 2): below and above."""
    objective = np.zeros(len(y))
    objective[column] = sign
    lower, upper = condition.bounds
    if column == THROTTLE:
        upper = upper.copy()
        upper[THROTTLE] = THROTTLE_WITHOUT_LIMIT
    at = condition.altitude_ft, condition.gamma_deg * RAD_PER_DEG
    return tolerance_slopes(*at, lower, upper, objective, y, condition.failure.airframe)


def _ends(tolerances: Tolerances, low: _Solved | None, high: _Solved | None) -> Ends | None:
    gust_kt = tolerances.gust_kt
    if low is None or high is None or low.tas_kt + gust_kt > high.tas_kt - gust_kt:
        return None
    return _end(tolerances, low, gust_kt), _end(tolerances, high, -gust_kt)


def _end(tolerances: Tolerances, found: _Solved, margin_kt: float) -> TolerantEnd:
    condition = found.condition
    hit = manoeuvre.limits_hit(found.y, *condition.bounds, condition.failure.airframe)
    trim = Trim.of_unknowns(found.y, condition.altitude_ft, condition.gamma_deg, True, hit, condition.failure)
    gust = tolerances.gust_alpha_deg(trim.tas_kt), tolerances.gust_load_factor(trim)
    return TolerantEnd(trim.tas_kt + margin_kt, trim, tolerances.told(found.place), *gust)


class _Search:
    """For V_min (``sign`` 1) or V_max (-1): from the nominal aircraft to those of the box with the farthest ends."""

    def __init__(self, condition: FlightCondition, tolerances: Tolerances, sign: float) -> None:
        self.condition, self.tolerances, self.sign = condition, tolerances, sign
        self.known: dict[Place, _Solved | None] = {}

    def worst(self) -> _Solved | None:
        """The highest V_min or the lowest V_max; None where an aircraft is found without any envelope."""
        return self._farthest(NOMINAL, 1)

    def best(self) -> _Solved | None:
        """The lowest V_min or the highest V_max; None where no aircraft with an envelope is found."""
        start = self._place_with_envelope()
        return None if start is None else self._farthest(start, -1)

    def at(self, place: Place) -> _Solved | None:
        """The end of the aircraft at a place; None without an envelope."""
        if place not in self.known:
            condition = self.condition.changed(failure=self.tolerances.moved(self.condition.failure, place))
            found = _end_in_gust(condition, self.tolerances, self.sign)
            self.known[place] = found and _Solved(place, *found)
        return self.known[place]

    def _farthest(self, start: Place, way: int) -> _Solved | None:
        """From place to place while the end gets worse (``way`` 1) or better (-1)."""
        here = self.at(start)
        for _ in range(_MOST_PLACES):
            if here is None:
                break
            slopes = _slopes(here.condition, here.y, V, self.sign)
            if not (gains := _gains(slopes, here.place, self.tolerances, way)):
                break
            at_once = {k: to for k, (to, _) in gains.items()}
            most = max(gains, key=lambda k: gains[k][1])
            for moved in (at_once, {most: at_once[most]}):
                there = self.at(_moved(here.place, moved))
                if there is None and way > 0:
                    return None
                if there and way * self.sign * (there.tas_kt - here.tas_kt) > _SAME_KT:
                    break
            else:
                break
            here = there
        return here

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
        for k in np.flatnonzero(self.tolerances.sizes).tolist():
            sides = {to: excess(_moved(NOMINAL, {k: to})) for to in (-1.0, 1.0)}
            to = min(sides, key=lambda to: sides[to])
            if sides[to] < nominal:
                moved[k] = to
        return moved


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


def _end_in_gust(
    condition: FlightCondition, tolerances: Tolerances, sign: float
) -> tuple[FlightCondition, np.ndarray] | None:
    """The end with alpha inside its bounds in the gust across the wings: the condition with these bounds, and y."""

    def kept(tas_kt: float) -> tuple[FlightCondition, np.ndarray] | None:
        alpha_deg = tolerances.alpha_kept(condition.alpha_deg, tas_kt)
        narrowed = alpha_deg and condition.changed(alpha_deg=alpha_deg)
        found = narrowed and narrowed.end(sign)
        return (narrowed, found.y) if found and found.status == solver.TRIMMED else None

    still = condition.end(sign)
    if still.status != solver.TRIMMED:
        return None
    if not tolerances.gust_kt:
        return condition, still.y
    speed = float(still.y[V] * KT_PER_FT_S)
    if sign < 0:
        return _largest_root(kept, speed)
    fastest = condition.end(-1.0)
    return _only_root(kept, speed, float(fastest.y[V] * KT_PER_FT_S)) if fastest.status == solver.TRIMMED else None


_Kept = Callable[[float], tuple[FlightCondition, np.ndarray] | None]


def _largest_root(kept: _Kept, speed: float) -> tuple[FlightCondition, np.ndarray] | None:
    """Of V = V_max(bounds of alpha at V), from above."""
    for _ in range(_MOST_SOLUTIONS):
        if (found := kept(speed)) is None:
            return None
        lower = float(found[1][V] * KT_PER_FT_S)
        if speed - lower < _SAME_KT:
            return found
        speed = lower
    return None


def _only_root(kept: _Kept, slowest: float, fastest: float) -> tuple[FlightCondition, np.ndarray] | None:
    """Of V = V_min(bounds of alpha at V) between two speeds, by secants or halves."""
    low: tuple[float, float | None] = slowest, None
    high: tuple[float, float | None] = fastest, None
    speed = slowest
    for k in range(_MOST_SOLUTIONS):
        found = kept(speed)
        excess = float(found[1][V] * KT_PER_FT_S) - speed if found else None
        if found and excess is not None and abs(excess) < _SAME_KT:
            return found
        if excess is None or excess > 0:
            low = speed, excess
        else:
            high = speed, excess
        if k == 0:
            speed = slowest + excess if excess is not None else fastest
            continue
        if high[1] is None:
            if speed >= fastest:
                return None
            speed = fastest
        elif low[1] is None or k % 4 == 3:
            speed = 0.5 * (low[0] + high[0])
        else:
            speed = low[0] + (high[0] - low[0]) * low[1] / (low[1] - high[1])
    return None
