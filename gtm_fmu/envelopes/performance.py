"""What the aircraft can still do at an altitude: its fastest turns, tightest turns, climbs and glides, exact.

Each extreme is one of all steady manoeuvres inside the limits, turning or not, slipping or not. At one flight path they
are optima of the core's search over all starts. Over flight paths such optima at many are compared, and the best is
closed in on between its neighbours.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from gtm_fmu.aircraft import ranges
from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.aircraft.ranges import ALPHA_DEG, PHI_DEG, Range
from gtm_fmu.airframe.names import PSI_DOT, THROTTLE, V
from gtm_fmu.core import solver
from gtm_fmu.envelopes.sections import speed_interval
from gtm_fmu.progress import Advance
from gtm_fmu.trims import manoeuvre
from gtm_fmu.trims.manoeuvre import Trim
from gtm_fmu.units import DEG_PER_RAD, KT_PER_FT_S, RAD_PER_DEG

_STEP_DEG, _PATH_TOLERANCE_DEG = 1.0, 1e-6
"""Of flight paths: no climb or glide that is possible begins and ends within such a step."""
_PATHS, _SINKING_DEG = 25, 12.0
"""Flight paths at which the vertical speed is looked at first, and how far below the flattest glide."""
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

    def __init__(
        self, altitude_ft: float, failure: Failure, alpha_deg: Range, phi_deg: Range, is_idle: bool = False
    ) -> None:
        self.altitude_ft, self.failure, self.airframe = altitude_ft, failure, failure.airframe
        self.lower, self.upper = manoeuvre.bounds(failure, alpha_deg, phi_deg)
        if is_idle:  # the throttles at their lowest
            self.upper[THROTTLE:] = self.lower[THROTTLE:]

    def least(self, objective: np.ndarray, gamma: float, side: int = 0) -> np.ndarray | None:
        """Unknowns of least objective.y, sought from all over; None where nothing is inside.

        ``side``: -1 for turns to the left only, 1 for those to the right.
        """
        lower, upper = self.lower.copy(), self.upper.copy()
        if side:
            (lower if side > 0 else upper)[PSI_DOT] = 0.0
        found = solver.envelope_end(self.altitude_ft, gamma, lower, upper, objective, self.airframe)
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

    def steepest(self) -> _Best | None:
        """The largest flight-path angle at which there is any manoeuvre."""
        low, high = ranges.GAMMA_DEG
        for gamma in np.arange(high, low, -_STEP_DEG) * RAD_PER_DEG:
            if (y := self.least(self.unit(V, 1.0), float(gamma))) is not None:
                break
        else:
            return None
        inside, outside = float(gamma), min(float(gamma) + _STEP_DEG * RAD_PER_DEG, high * RAD_PER_DEG)
        while outside - inside > _PATH_TOLERANCE_DEG * RAD_PER_DEG:
            middle = 0.5 * (inside + outside)
            found = self.least(self.unit(V, 1.0), middle)
            if found is None:
                outside = middle
            else:
                inside, y = middle, found
        return _Best(inside, inside, y)

    def rising_most(self, lowest: float, highest: float) -> _Best | None:
        """The largest vertical speed in ft/s on flight paths in rad between two: climbs, or descents.

        On a climb it is that of the fastest manoeuvre, on a descent of the slowest one.
        """
        objective = self.unit(V, -1.0 if highest > 0 else 1.0)
        known: dict[float, np.ndarray] = {}

        def rate(gamma: float) -> float:
            y = self.least(objective, gamma)
            if y is None:
                return -math.inf
            known[gamma] = y
            return float(y[V]) * math.sin(gamma)

        gammas = np.linspace(lowest, highest, _PATHS).tolist()
        rates = [rate(gamma) for gamma in gammas]
        if not known:
            return None
        k = int(np.argmax(rates))
        between = gammas[max(k - 1, 0)], gammas[min(k + 1, _PATHS - 1)]
        minimize_scalar(lambda gamma: -rate(gamma), bounds=between, method="bounded", options={"xatol": 1e-6})
        gamma, y = max(known.items(), key=lambda item: float(item[1][V]) * math.sin(item[0]))
        return _Best(float(y[V]) * math.sin(gamma), gamma, y)


def performance(
    altitude_ft: float,
    limits: ControlLimits | Failure | None = None,
    gamma_deg: float = 0.0,
    alpha_deg: Range = ALPHA_DEG,
    phi_deg: Range = PHI_DEG,
    progress: Advance | None = None,
) -> Performance:
    """Every extreme at an altitude in ft; speeds and turns at the flight path ``gamma_deg``.

    Speeds in kn, turn rates in deg/s (to the left negative), radii in ft, vertical speeds in ft/min. A glide has the
    throttles at their lowest; then once more with both engines out.

    Args:
        altitude_ft: geometric altitude in ft.
        limits: what the failure leaves of the controls, or a whole `Failure`; None: nothing has failed.
        gamma_deg: flight-path angle in deg of the speeds and turns.
        alpha_deg: least and greatest angle of attack in deg.
        phi_deg: least and greatest bank in deg.
        progress: called with how many parts are done, and of how many.

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
        lambda: _glides(_Search(altitude_ft, failure, alpha_deg, phi_deg, is_idle=True), ""),
        lambda: _glides(_Search(altitude_ft, out, alpha_deg, phi_deg), "_engines_out"),
    )
    extremes: list[Extreme] = []
    for k, part in enumerate(parts):
        extremes += part()
        if progress:
            progress(k + 1, len(parts))
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
    steepest = search.steepest()
    fastest = search.rising_most(0.0, steepest.gamma) if steepest and steepest.gamma > 0 else None
    return [
        _extreme(search, "steepest_climb_deg", steepest, DEG_PER_RAD),
        _extreme(search, "fastest_climb_ft_min", fastest, _FT_MIN_PER_FT_S),
    ]


def _glides(search: _Search, suffix: str) -> list[Extreme]:
    flattest = search.steepest()
    sink = search.rising_most(flattest.gamma - _SINKING_DEG * RAD_PER_DEG, flattest.gamma) if flattest else None
    return [
        _extreme(search, f"flattest_glide{suffix}_deg", flattest, DEG_PER_RAD),
        _extreme(search, f"least_sink{suffix}_ft_min", sink, -_FT_MIN_PER_FT_S),
    ]
