"""What the aircraft can still do at an altitude: its fastest turns, tightest turns, climbs and glides, exact.

Each extreme is one of all steady manoeuvres inside the limits, turning or not. At one flight path they are optima of the
core's search over all starts. Over the flight path they are searched by such optima at many, then between them.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from gtm_fmu.aircraft import ranges
from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.aircraft.ranges import ALPHA_DEG, PHI_DEG, Range
from gtm_fmu.airframe.names import PSI_DOT, THROTTLE, V
from gtm_fmu.core import solver
from gtm_fmu.envelopes.sections import speed_interval
from gtm_fmu.trims import manoeuvre
from gtm_fmu.trims.manoeuvre import Trim
from gtm_fmu.units import DEG_PER_RAD, KT_PER_FT_S, RAD_PER_DEG

_GRID_DEG = 1.5
_PATH_TOLERANCE_DEG, _BEYOND_DEG = 1e-5, 0.01
_GOLDEN = 0.5 * (math.sqrt(5) - 1)
_FRACTION_STEPS, _FRACTION_TOLERANCE = 12, 1e-9
_FT_MIN_PER_FT_S = 60.0


@dataclass(frozen=True)
class Extreme:
    """One extreme.

    Attributes:
        name: with its unit at the end, as ``turn_radius_left_ft``.
        value: None where there is no such manoeuvre.
        trim: the manoeuvre that reaches it.
    """

    name: str
    value: float | None
    trim: Trim | None

    def to_dict(self) -> dict[str, Any]:
        """All values, ready for JSON."""
        return {"value": self.value, "trim": self.trim and self.trim.to_dict()}


@dataclass(frozen=True)
class Performance:
    """Extremes at an altitude under the limits that a failure leaves.

    Attributes:
        gamma_deg: flight path of the turns and of the speeds.
        straight_tas_kt: intervals of speed at which straight flight is possible at this flight path.
        extremes: in the order in which they are told.
    """

    altitude_ft: float
    gamma_deg: float
    failure: Failure
    straight_tas_kt: tuple[Range, ...]
    extremes: tuple[Extreme, ...]

    def __getitem__(self, name: str) -> Extreme:
        """The extreme of this name."""
        return next(extreme for extreme in self.extremes if extreme.name == name)

    def to_dict(self) -> dict[str, Any]:
        """All values, ready for JSON."""
        return {
            "altitude_ft": self.altitude_ft,
            "gamma_deg": self.gamma_deg,
            "straight_flight": bool(self.straight_tas_kt),
            "straight_tas_kt": [list(interval) for interval in self.straight_tas_kt],
            "extremes": {extreme.name: extreme.to_dict() for extreme in self.extremes},
        }


class _Best(NamedTuple):
    """A manoeuvre: what it reaches, the larger the better, at which flight path in rad, with which unknowns."""

    value: float
    gamma: float
    y: np.ndarray


class _Search:
    """Optima of one aircraft at an altitude; everything in the core's units."""

    def __init__(self, altitude_ft: float, failure: Failure, alpha_deg: Range, phi_deg: Range) -> None:
        self.altitude_ft, self.failure, self.airframe = altitude_ft, failure, failure.airframe
        self.lower, self.upper = manoeuvre.bounds(failure, alpha_deg, phi_deg)

    def with_idle(self) -> "_Search":
        """The same with the throttles at their lowest."""
        idle = _Search.__new__(_Search)
        idle.altitude_ft, idle.failure, idle.airframe = self.altitude_ft, self.failure, self.airframe
        idle.lower, idle.upper = self.lower.copy(), self.upper.copy()
        idle.upper[THROTTLE:] = idle.lower[THROTTLE:]
        return idle

    def least(
        self, objective: np.ndarray, gamma: float, starts: np.ndarray | None = None, side: int = 0
    ) -> np.ndarray | None:
        """Unknowns of least objective.y, from given starts or from all over; None where nothing is inside.

        ``side``: -1 for turns to the left only, 1 for those to the right.
        """
        lower, upper = self.lower.copy(), self.upper.copy()
        if side:
            (lower if side > 0 else upper)[PSI_DOT] = 0.0
        at = self.altitude_ft, gamma, lower, upper, objective
        if starts is None:
            found = solver.envelope_end(*at, self.airframe)
        else:
            found = solver.extreme(*at, starts, self.airframe)
        return found.y if found.status == solver.TRIMMED else None

    def unit(self, column: int, sign: float) -> np.ndarray:
        """The objective of one unknown."""
        objective = np.zeros(len(self.lower))
        objective[column] = sign
        return objective

    def tightest(self, gamma: float, side: int) -> np.ndarray | None:
        """Unknowns of least V / |psi_dot| to one side: a fraction, so V - r |psi_dot| is made least until r stays."""
        best = self.least(self.unit(PSI_DOT, -side), gamma, side=side)
        if best is None or abs(best[PSI_DOT]) < 1e-9:
            return None
        for _ in range(_FRACTION_STEPS):
            ratio = best[V] / abs(best[PSI_DOT])
            objective = self.unit(V, 1.0)
            objective[PSI_DOT] = -side * ratio
            found = self.least(objective, gamma, side=side)
            if found is None or found[V] - ratio * abs(found[PSI_DOT]) >= -_FRACTION_TOLERANCE * found[V]:
                break
            best = found
        return best

    def vertical(self, gamma: float, sign: float, starts: np.ndarray | None = None) -> _Best | None:
        """The manoeuvre of most (sign +) or least (sign -) speed along a path, by its vertical speed in ft/s."""
        y = self.least(self.unit(V, -sign), gamma, starts)
        return None if y is None else _Best(float(y[V] * math.sin(gamma)), gamma, y)

    def highest_path(self) -> _Best | None:
        """The largest flight-path angle with a manoeuvre."""
        inside, outside = None, None
        for gamma in self._paths():
            if (found := self._any(gamma)) is not None:
                inside = found
                break
            outside = gamma
        if inside is None:
            return None
        if outside is None:
            return inside
        while True:
            inside = self._last_inside(inside, outside)
            beyond = inside.gamma + _BEYOND_DEG * RAD_PER_DEG
            if beyond >= outside or (found := self._any(beyond)) is None:
                return inside
            inside = found

    def fastest_vertical(self, highest: _Best, is_down: bool) -> _Best:
        """Most vertical speed at paths up to the highest: of a climb, or of a glide that sinks least."""
        sign, top = -1.0 if is_down else 1.0, highest.gamma
        paths = [gamma for gamma in self._paths() if gamma < top and (is_down or gamma > 0)]
        found = [best for gamma in paths if (best := self.vertical(gamma, sign)) is not None]
        found.append(_Best(float(highest.y[V] * math.sin(top)), top, highest.y))
        found.sort(key=lambda best: best.gamma)
        peaks = sorted(range(len(found)), key=lambda k: -found[k].value)[:2]
        refined = [self._refined(found, k, sign) for k in peaks]
        best = max(refined, key=lambda each: each.value)
        again = self.vertical(best.gamma, sign)
        return best if again is None or again.value <= best.value else again

    def _paths(self) -> Iterator[float]:
        """Flight-path angles from the steepest climb to the steepest descent."""
        low, high = ranges.GAMMA_DEG
        return iter((np.arange(high, low, -_GRID_DEG) * RAD_PER_DEG).tolist())

    def _any(self, gamma: float, starts: np.ndarray | None = None) -> _Best | None:
        y = self.least(self.unit(V, 1.0), gamma, starts)
        return None if y is None else _Best(gamma, gamma, y)

    def _last_inside(self, inside: _Best, outside: float) -> _Best:
        """Between a path with a manoeuvre and one without, from near starts."""
        starts = inside.y[None]
        while outside - inside.gamma > _PATH_TOLERANCE_DEG * RAD_PER_DEG:
            middle = 0.5 * (inside.gamma + outside)
            found = self._any(middle, starts)
            if found is None and len(starts) < 3:
                found = self._any(middle)
            if found is None:
                outside = middle
            else:
                inside = found
                starts = np.concatenate([starts, found.y[None]])[-3:]
        return inside

    def _refined(self, found: list[_Best], k: int, sign: float) -> _Best:
        """The best between the neighbours of one, by golden sections from near starts."""
        around = found[max(k - 1, 0) : k + 2]
        starts = np.array([each.y for each in around])
        low, high, best = around[0].gamma, around[-1].gamma, found[k]

        def value(gamma: float) -> float:
            nonlocal best
            here = self.vertical(gamma, sign, starts)
            if here is not None and here.value > best.value:
                best = here
            return -math.inf if here is None else here.value

        left, right = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
        at_left, at_right = value(left), value(right)
        while high - low > _PATH_TOLERANCE_DEG * RAD_PER_DEG:
            if at_left >= at_right:
                high, right, at_right = right, left, at_left
                left = high - _GOLDEN * (high - low)
                at_left = value(left)
            else:
                low, left, at_left = left, right, at_right
                right = low + _GOLDEN * (high - low)
                at_right = value(right)
        return best


def performance(
    altitude_ft: float,
    limits: ControlLimits | Failure | None = None,
    gamma_deg: float = 0.0,
    alpha_deg: Range = ALPHA_DEG,
    phi_deg: Range = PHI_DEG,
    progress: Callable[[float], None] | None = None,
) -> Performance:
    """Every extreme at an altitude in ft; speeds and turns at the flight path ``gamma_deg``.

    Speeds in kn, turn rates in deg/s (to the left negative), radii in ft, vertical speeds in ft/min. A glide has the
    throttles at their lowest; then once more with both engines out.

    Args:
        progress: called with the part that is done, 0 to 1.

    Raises:
        InputError: a value outside what is allowed.
    """
    altitude_ft = ranges.check_range("altitude in ft", altitude_ft, ranges.ALTITUDE_FT)
    gamma_deg = ranges.check_range("gamma in deg", gamma_deg, ranges.GAMMA_DEG)
    failure = Failure.of(limits)
    out = replace(failure, configuration=replace(failure.configuration, engine_running=(False, False)))
    search = _Search(altitude_ft, failure, alpha_deg, phi_deg)
    parts = (
        lambda: _at_one_path(search, gamma_deg * RAD_PER_DEG),
        lambda: _climbs(search),
        lambda: _glides(search.with_idle(), ""),
        lambda: _glides(_Search(altitude_ft, out, alpha_deg, phi_deg), "_engines_out"),
    )
    extremes: list[Extreme] = []
    for k, part in enumerate(parts):
        extremes += part()
        if progress:
            progress((k + 1) / len(parts))
    straight = speed_interval(altitude_ft, gamma_deg, 0.0, failure, alpha_deg, phi_deg)
    return Performance(altitude_ft, gamma_deg, failure, straight.intervals, tuple(extremes))


def _extreme(search: _Search, name: str, found: _Best | None, factor: float) -> Extreme:
    if found is None:
        return Extreme(name, None, None)
    hit = manoeuvre.limits_hit(found.y, search.lower, search.upper, search.airframe)
    trim = Trim.of_unknowns(found.y, search.altitude_ft, found.gamma * DEG_PER_RAD, True, hit, search.failure)
    return Extreme(name, found.value * factor, trim)


def _at_one_path(search: _Search, gamma: float) -> list[Extreme]:
    def best(y: np.ndarray | None, value: Callable[[np.ndarray], float]) -> _Best | None:
        return None if y is None else _Best(value(y), gamma, y)

    def radius(y: np.ndarray) -> float:
        return float(y[V] * math.cos(gamma) / abs(y[PSI_DOT]))

    extremes = [
        _extreme(search, name, best(search.least(search.unit(V, sign), gamma), lambda y: float(y[V])), KT_PER_FT_S)
        for name, sign in (("v_min_kt", 1.0), ("v_max_kt", -1.0))
    ]
    for side, word in ((-1, "left"), (1, "right")):
        turn = search.least(search.unit(PSI_DOT, -side), gamma, side=side)
        rate = best(turn, lambda y: float(y[PSI_DOT]))
        extremes.append(_extreme(search, f"turn_rate_{word}_deg_s", rate, DEG_PER_RAD))
        tight = best(search.tightest(gamma, side), radius)
        extremes.append(_extreme(search, f"turn_radius_{word}_ft", tight, 1.0))
    return extremes


def _climbs(search: _Search) -> list[Extreme]:
    steepest = search.highest_path()
    climbs = steepest is not None and steepest.gamma > 0
    fastest = search.fastest_vertical(steepest, is_down=False) if steepest and climbs else None
    return [
        _extreme(search, "steepest_climb_deg", steepest, DEG_PER_RAD),
        _extreme(search, "fastest_climb_ft_min", fastest, _FT_MIN_PER_FT_S),
    ]


def _glides(search: _Search, suffix: str) -> list[Extreme]:
    flattest = search.highest_path()
    sink = search.fastest_vertical(flattest, is_down=True) if flattest else None
    return [
        _extreme(search, f"flattest_glide{suffix}_deg", flattest, DEG_PER_RAD),
        _extreme(search, f"least_sink{suffix}_ft_min", sink, -_FT_MIN_PER_FT_S),
    ]
