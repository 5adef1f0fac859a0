"""The envelope left by a failure: exact V_min and V_max of a flight condition.

Steady manoeuvres at given altitude and flight-path angle form a manifold of three dimensions (two with the rudder
jammed). V_min and V_max are linear objectives on it under the limits. They have local optima, so the core seeks each
from some starts. A restricted rudder may hold any deflection of its range, so its envelope is the union of the jammed
ones.
"""

from dataclasses import asdict, dataclass, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from gtm_fmu.aircraft import ranges
from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.aircraft.ranges import ALPHA_DEG, PHI_DEG, Range
from gtm_fmu.airframe.names import RUDDER, THROTTLE, TWO_THROTTLE_CONTROLS, V
from gtm_fmu.core import solver
from gtm_fmu.envelopes import multipliers
from gtm_fmu.envelopes.multipliers import Slope
from gtm_fmu.trims import manoeuvre
from gtm_fmu.trims.manoeuvre import Trim
from gtm_fmu.units import FT_S_PER_KT, KT_PER_FT_S, RAD_PER_DEG

_KNOWN_ENDS = 4096
THROTTLE_WITHOUT_LIMIT = 400.0  # %, beyond any need; the thrust polynomial rises all the way

_GAP_STEP_KT, _EDGE_TOLERANCE_KT, _HELD = 0.5, 0.001, 1e-6

# Unknown and sign of what is made least: the envelope's two ends, and the throttle that tells whether there is one.
_V_MIN, _V_MAX, _T_MIN = (V, 1.0), (V, -1.0), (THROTTLE, 1.0)


@dataclass(frozen=True)
class Envelope:
    """Lowest and highest true airspeed of the steady manoeuvres inside the limits, with the trims that reach them.

    Attributes:
        feasible: such manoeuvres exist. If not, speeds and trims are None.
        t_min_pct: least throttle of a steady manoeuvre that keeps every other limit; an envelope exists when it is
            no more than the throttle's upper limit. None if even that does not exist, or if each engine has a throttle.
        alpha_deg, phi_deg: bounds of the manoeuvres.
        nearest: without an envelope, the manoeuvre that exceeds the limits least, if any was found.
    """

    altitude_ft: float
    gamma_deg: float
    failure: Failure
    feasible: bool
    v_min_kt: float | None
    v_max_kt: float | None
    t_min_pct: float | None
    at_v_min: Trim | None
    at_v_max: Trim | None
    nearest: Trim | None = None
    alpha_deg: Range = ALPHA_DEG
    phi_deg: Range = PHI_DEG

    @cached_property
    def slopes(self) -> tuple[Slope, ...]:
        """What moves V_min and V_max: altitude, flight path, every limit and the airframe; none without an envelope."""
        if not (self.at_v_min and self.at_v_max):
            return ()
        bounds = manoeuvre.bounds(self.failure, self.alpha_deg, self.phi_deg)
        ends = self.at_v_min.unknowns, self.at_v_max.unknowns
        return multipliers.slopes(self.altitude_ft, self.gamma_deg, self.failure, bounds, ends)

    @property
    def limits(self) -> ControlLimits:
        """Of the controls."""
        return self.failure.limits

    def to_dict(self) -> dict[str, Any]:
        """All values, ready for JSON."""
        values = {name: getattr(self, name) for name in ("feasible", "v_min_kt", "v_max_kt", "t_min_pct")}
        values |= {"altitude_ft": self.altitude_ft, "gamma_deg": self.gamma_deg, "limits": asdict(self.limits)}
        if self.failure != Failure(self.limits):
            values["failure"] = {name: value for name, value in asdict(self.failure).items() if name != "limits"}
        ends = {name: getattr(self, name) for name in ("at_v_min", "at_v_max", "nearest")}
        return values | {name: trim and trim.to_dict() for name, trim in ends.items()}


class FlightCondition:
    """Extremes of the steady manoeuvres at one altitude and flight-path angle, for any limits of the rudder.

    Raises:
        InputError: altitude, flight path or bounds outside what is allowed.
    """

    def __init__(
        self,
        altitude_ft: float,
        gamma_deg: float,
        limits: ControlLimits | Failure | None = None,
        alpha_deg: Range = ALPHA_DEG,
        phi_deg: Range = PHI_DEG,
    ):
        self.altitude_ft = ranges.check_range("altitude in ft", altitude_ft, ranges.ALTITUDE_FT)
        self.gamma_deg = ranges.check_range("gamma in deg", gamma_deg, ranges.GAMMA_DEG)
        self.failure = Failure.of(limits)
        self.alpha_deg, self.phi_deg = alpha_deg, phi_deg
        self._lower, self._upper = manoeuvre.bounds(self.failure, alpha_deg, phi_deg)
        self._is_rudder_dead = solver.dead_controls(self.failure.configuration)[TWO_THROTTLE_CONTROLS.index("rudder")]

    def changed(
        self,
        altitude_ft: float | None = None,
        gamma_deg: float | None = None,
        failure: Failure | None = None,
        alpha_deg: Range | None = None,
    ) -> "FlightCondition":
        """The same with another ``altitude_ft``, ``gamma_deg``, ``failure`` or bounds ``alpha_deg``."""
        altitude_ft = self.altitude_ft if altitude_ft is None else altitude_ft
        gamma_deg = self.gamma_deg if gamma_deg is None else gamma_deg
        alpha_deg = self.alpha_deg if alpha_deg is None else alpha_deg
        return FlightCondition(altitude_ft, gamma_deg, failure or self.failure, alpha_deg, self.phi_deg)

    @property
    def limits(self) -> ControlLimits:
        """Of the controls."""
        return self.failure.limits

    def envelope(self, rudder_deg: Range | None = None) -> Envelope:
        """V_min and V_max with the rudder inside ``rudder_deg`` (default: the limits of this condition)."""
        limits = self.limits if rudder_deg is None else replace(self.limits, rudder_deg=rudder_deg)
        low, high = (self._extreme(limits.rudder_deg, goal) for goal in (_V_MIN, _V_MAX))
        feasible = low.status == high.status == solver.TRIMMED
        return Envelope(
            altitude_ft=self.altitude_ft,
            gamma_deg=self.gamma_deg,
            failure=replace(self.failure, limits=limits),
            feasible=feasible,
            v_min_kt=float(low.y[V] * KT_PER_FT_S) if feasible else None,
            v_max_kt=float(high.y[V] * KT_PER_FT_S) if feasible else None,
            t_min_pct=self.least_throttle(limits.rudder_deg),
            at_v_min=self._trim(low, limits) if feasible else None,
            at_v_max=self._trim(high, limits) if feasible else None,
            nearest=None
            if feasible
            else self._trim(min(low, high, key=lambda end: (end.status, end.violation)), limits),
            alpha_deg=self.alpha_deg,
            phi_deg=self.phi_deg,
        )

    def least_throttle(self, rudder_deg: Range | None = None) -> float | None:
        """t_min in %: the least throttle inside all other limits, the rudder inside ``rudder_deg``; None if none does.

        None too where each engine has a throttle of its own.
        """
        if self._has_two_throttles:
            return None
        found = self._extreme(self.limits.rudder_deg if rudder_deg is None else rudder_deg, _T_MIN)
        return float(found.y[THROTTLE]) if found.status == solver.TRIMMED else None

    def intervals(self, rudder_deg: Range | None = None) -> tuple[Range, ...]:
        """Speeds in kn with a steady manoeuvre, the rudder inside ``rudder_deg``: one interval, or several with gaps.

        Gaps are looked for every 0.5 kn (near the ceiling the thrust required has humps over speed) and their ends
        found to 0.001 kn.
        """
        whole = self.envelope(rudder_deg)
        if not (whole.feasible and whole.at_v_min and whole.at_v_max):
            return ()
        limits_deg = whole.limits.rudder_deg
        slowest, fastest = whole.at_v_min.tas_kt, whole.at_v_max.tas_kt
        start, previous, intervals = slowest, slowest, []
        y: np.ndarray | None = whole.at_v_min.unknowns
        for speed in np.append(np.arange(slowest, fastest, _GAP_STEP_KT)[1:], fastest).tolist():
            found = self._trim_at(limits_deg, speed, y) if speed < fastest else whole.at_v_max.unknowns
            if found is not None and y is None:
                start = self._edge(limits_deg, speed, previous, found)
            elif found is None and y is not None:
                intervals.append((start, self._edge(limits_deg, previous, speed, y)))
            previous, y = speed, found
        return (*intervals, (start, fastest))

    @property
    def _has_two_throttles(self) -> bool:
        return self.failure.airframe.throttles == solver.TWO_THROTTLES

    def _trim_at(self, rudder_deg: Range, tas_kt: float, near: np.ndarray | None) -> np.ndarray | None:
        """Unknowns of a trim at one speed, sought from a near one first; None where there is none."""
        for starts in (None,) if near is None else (near[None], None):
            found = self._extreme(rudder_deg, _T_MIN, tas_kt, starts)
            if found.status == solver.TRIMMED and np.all(found.y[THROTTLE:] <= self._upper[THROTTLE:] + _HELD):
                return found.y
        return None

    def _edge(self, rudder_deg: Range, inside: float, outside: float, y: np.ndarray) -> float:
        """Speed in kn, between one with the trim y and one without any, where the trims end."""
        while abs(outside - inside) > _EDGE_TOLERANCE_KT:
            middle = 0.5 * (inside + outside)
            found = self._trim_at(rudder_deg, middle, y)
            inside, outside, y = (inside, middle, y) if found is None else (middle, outside, found)
        return inside

    def end(self, sign: float) -> solver.Extreme:
        """The manoeuvre of V_min (``sign`` 1) or V_max (-1), or the one least beyond the limits; core units."""
        return self._extreme(self.limits.rudder_deg, (V, sign))

    def least_throttle_end(self) -> solver.Extreme:
        """The manoeuvre of the least throttle that keeps every other limit, or what exceeds these least."""
        return self._extreme(self.limits.rudder_deg, _T_MIN)

    def extremes(self) -> np.ndarray:
        """Trim unknowns (n, 9 or 10) at V_min and V_max under these limits; none without an envelope."""
        ends = [self.end(sign) for sign in (1.0, -1.0)]
        return np.array([end.y for end in ends if end.status == solver.TRIMMED]).reshape(-1, len(self._lower))

    @property
    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper bounds (9 or 10 each) of the trim unknowns, in the core's units."""
        return self._lower, self._upper

    def _trim(self, found: solver.Extreme, limits: ControlLimits) -> Trim | None:
        if found.status == solver.NO_TRIM:
            return None
        lower, upper = self._bounds_with(limits.rudder_deg)
        hit = manoeuvre.limits_hit(found.y, lower, upper, self.failure.airframe)
        inside = found.status == solver.TRIMMED
        return Trim.of_unknowns(
            found.y, self.altitude_ft, self.gamma_deg, inside, hit, replace(self.failure, limits=limits)
        )

    def _bounds_with(self, rudder_deg: Range) -> tuple[np.ndarray, np.ndarray]:
        lower, upper = self._lower.copy(), self._upper.copy()
        lower[RUDDER], upper[RUDDER] = (np.clip(0.0, *rudder_deg),) * 2 if self._is_rudder_dead else rudder_deg
        return lower, upper

    def _extreme(
        self, rudder_deg: Range, goal: tuple[int, float], tas_kt: float | None = None, starts: np.ndarray | None = None
    ) -> solver.Extreme:
        """Extreme of the goal's unknown, at one speed or any, from given starts or from the core's own."""
        lower, upper = self._bounds_with(rudder_deg)
        unknown, sign = goal
        if unknown == THROTTLE and not self._has_two_throttles:
            upper[THROTTLE] = THROTTLE_WITHOUT_LIMIT
        if tas_kt is not None:
            lower[V] = upper[V] = tas_kt * FT_S_PER_KT
        at, airframe = (self.altitude_ft, self.gamma_deg * RAD_PER_DEG), self.failure.airframe
        if starts is not None:
            return solver.extreme(*at, lower, upper, _objective(goal, len(lower)), starts, airframe)
        found = []
        for piece in solver.rudder_pieces(lower[RUDDER], upper[RUDDER]):
            lower[RUDDER], upper[RUDDER] = piece
            found.append(_end_of_piece(*at, tuple(lower.tolist()), tuple(upper.tolist()), goal, airframe))
        best = min(end.status for end in found)
        among = (end for end in found if end.status == best)
        return min(among, key=lambda end: sign * end.y[unknown] if best == solver.TRIMMED else end.violation)


def _objective(goal: tuple[int, float], unknowns: int) -> np.ndarray:
    objective = np.zeros(unknowns)
    objective[goal[0]] = goal[1]
    return objective


@lru_cache(maxsize=_KNOWN_ENDS)
def _end_of_piece(
    altitude_ft: float,
    gamma: float,
    lower: tuple[float, ...],
    upper: tuple[float, ...],
    goal: tuple[int, float],
    airframe: solver.Airframe,
) -> solver.Extreme:
    """An end over one of the `solver.rudder_pieces`, which many ranges of the same condition share."""
    found = solver.envelope_end(altitude_ft, gamma, lower, upper, _objective(goal, len(lower)), airframe)
    found.y.flags.writeable = False
    return found


def envelope(
    altitude_ft: float,
    gamma_deg: float,
    limits: ControlLimits | Failure | None = None,
    alpha_deg: Range = ALPHA_DEG,
    phi_deg: Range = PHI_DEG,
) -> Envelope:
    """Exact V_min and V_max of a flight condition under the limits a failure leaves.

    Args:
        altitude_ft: geometric altitude in ft.
        gamma_deg: flight-path angle in deg, positive in a climb.
        limits: what the failure leaves of the controls, or a whole `Failure`; None: nothing has failed.
        alpha_deg: least and greatest angle of attack in deg.
        phi_deg: least and greatest bank in deg.

    Raises:
        InputError: altitude, flight path or bounds outside what is allowed.
    """
    return FlightCondition(altitude_ft, gamma_deg, limits, alpha_deg, phi_deg).envelope()
