"""Many trims at once: the compiled batch solver (exact Newton on the six accelerations).

A trim is settled by three conditions, one of which may be a jammed rudder (see `conditions`). Where there are fewer
there is a family of trims, and the one with the least sideslip is taken: beta = 0 wherever the limits allow it.
"""

from typing import Unpack

import numpy as np
from numpy.typing import ArrayLike

from gtm_fmu.aircraft import ranges
from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.aircraft.ranges import ALPHA_DEG, PHI_DEG, WIDEST, Range
from gtm_fmu.airframe.names import ALPHA, PSI_DOT, RUDDER, V
from gtm_fmu.core import solver
from gtm_fmu.errors import InputError
from gtm_fmu.trims import manoeuvre
from gtm_fmu.trims.conditions import Asked, Conditions, conditions
from gtm_fmu.trims.manoeuvre import Trim
from gtm_fmu.units import DEG_PER_RAD, FT_S_PER_KT, RAD_PER_DEG

_SCANNED, _WIDEST_SCAN = 257, 1.4  # points, and rad or rad/s: 80 deg of bank, 80 deg/s
_ZOOMED, _ZOOMS = 17, 13  # points, and how often their spacing becomes the range: 16^13 below rounding
_MET = 1e-9  # g, deg


def trim(
    altitude_ft: float,
    tas_kt: float | None = None,
    gamma_deg: float = 0.0,
    turn_rate_deg_s: float | None = None,
    limits: ControlLimits | Failure | None = None,
    alpha_deg: Range = ALPHA_DEG,
    phi_deg: Range = PHI_DEG,
    **asked: Unpack[Asked],
) -> Trim:
    """The trim that meets what is asked inside the limits, or the nearest to one.

    With a movable rudder a speed and two conditions may be asked for, with a jammed one a speed and one: turn rate,
    bank, sideslip, angle of attack, load factor. An angle of attack may also take the place of the speed. Where only a
    speed is given the flight is straight. Of several trims the one with the least sideslip is taken; of turns to either
    side the one to the right, or the one that the bounds ``phi_deg`` leave. Of separate throttles, where several trims
    have no sideslip, the ones closest together are taken.

    Args:
        altitude_ft: geometric altitude in ft.
        tas_kt: true airspeed in kn; None where another speed or an angle of attack is asked for.
        gamma_deg: flight-path angle in deg, positive in a climb.
        turn_rate_deg_s: turn rate in deg/s, positive to the right; None leaves it to the other conditions, or to
            straight flight.
        limits: what the failure leaves of the controls, or a whole `Failure`; None: nothing has failed.
        alpha_deg: least and greatest angle of attack in deg.
        phi_deg: least and greatest bank in deg.
        asked: `conditions.Asked`, further conditions by name, or a speed as ``eas_kt`` or ``cas_kt``.

    Raises:
        InputError: altitude, speed, flight path, bounds or conditions outside what is allowed, or too many or too few.
    """
    altitude_ft = ranges.check_range("altitude in ft", altitude_ft, ranges.ALTITUDE_FT)
    gamma_deg = ranges.check_range("gamma in deg", gamma_deg, ranges.GAMMA_DEG)
    failure = Failure.of(limits)
    wanted = conditions(altitude_ft, failure, alpha_deg, phi_deg, tas_kt, turn_rate_deg_s, asked)
    lower, upper = wanted.bounds(failure, alpha_deg, phi_deg, leaving=wanted.scanned)
    at = altitude_ft, gamma_deg * RAD_PER_DEG
    missed: tuple[str, ...] = ()
    if wanted.scanned is None:
        found = _at_rows(at, lower[None], upper[None], failure)
    else:
        found, missed = _by_scan(at, lower, upper, failure, wanted)
    y, inside = found.y[0], found.status[0] == solver.TRIMMED and not missed
    hit = (*manoeuvre.limits_hit(y, lower, upper, failure.airframe), *missed)
    return Trim.of_unknowns(y, altitude_ft, gamma_deg, inside, hit, failure)


def _at_rows(at: tuple[float, float], lower: np.ndarray, upper: np.ndarray, failure: Failure) -> solver.Solutions:
    altitude, gamma = (np.full(len(lower), value) for value in at)
    return solver.trims(altitude, gamma, lower, upper, failure.airframe)


def _by_scan(
    at: tuple[float, float], lower: np.ndarray, upper: np.ndarray, failure: Failure, wanted: Conditions
) -> tuple[solver.Solutions, tuple[str, ...]]:
    """The trim that meets `Conditions.scanned`, or the nearest to it, and how that misses it, as ``alpha.lower``.

    The unknown that it settles is scanned from bound to bound; of the places where the condition is passed the
    rightmost inside the bounds is closed in on.
    """
    k, load_factor, alpha_deg = wanted.turning, wanted.load_factor, wanted.angle_of_attack_deg or 0.0

    def scan(start: float, stop: float, points: int) -> tuple[solver.Solutions, np.ndarray]:
        lowers, uppers = np.tile(lower, (points, 1)), np.tile(upper, (points, 1))
        lowers[:, k] = uppers[:, k] = np.linspace(start, stop, points)
        found = _at_rows(at, lowers, uppers, failure)
        if load_factor is None:
            excess = found.y[:, ALPHA] * DEG_PER_RAD - alpha_deg
        else:
            states = solver.trim_states(*at, found.y, failure.airframe)
            excess = manoeuvre.load_factors(*states, failure.airframe.configuration) - load_factor
        return found, np.where(found.status == solver.NO_TRIM, np.nan, excess)

    found, excess = scan(max(lower[k], -_WIDEST_SCAN), min(upper[k], _WIDEST_SCAN), _SCANNED)
    for _ in range(_ZOOMS):
        passed = np.flatnonzero(excess[:-1] * excess[1:] <= 0)
        if not len(passed):
            break
        place = max(passed, key=lambda place: (-max(found.status[place : place + 2]), place))
        found, excess = scan(found.y[place, k], found.y[place + 1, k], _ZOOMED)
    miss = np.where(np.isnan(excess), np.inf, np.abs(excess))
    best = int(np.argmin(miss))
    name, side = "alpha" if load_factor is None else "load_factor", "upper" if excess[best] > 0 else "lower"
    missed = () if miss[best] <= _MET else (f"{name}.{side}",)
    return solver.Solutions(*(values[best : best + 1] for values in found)), missed


def trims(
    altitude_ft: ArrayLike,
    tas_kt: ArrayLike,
    gamma_deg: ArrayLike,
    turn_rate_deg_s: ArrayLike,
    limits: ControlLimits | Failure | None = None,
    rudder_deg: ArrayLike | None = None,
    alpha_deg: Range = ALPHA_DEG,
    phi_deg: Range = PHI_DEG,
) -> solver.Solutions:
    """Trims of many conditions under the same limits; inputs broadcast against each other to n conditions.

    Args:
        altitude_ft, tas_kt, gamma_deg, turn_rate_deg_s: arrays.
        rudder_deg: None, or (.., 2) lower and upper rudder limits of each condition instead of those of ``limits``.

    Returns:
        Unknowns (n, 9 or 10) in the core's units, residual, violation and status of each condition (see `core.solver`).

    Raises:
        InputError: a condition or bound outside what is allowed.
    """
    failure = Failure.of(limits)
    lower, upper = manoeuvre.bounds(failure, alpha_deg, phi_deg)
    conditions = [
        ranges.check_values("altitude in ft", altitude_ft, ranges.ALTITUDE_FT),
        ranges.check_values("tas in kn", tas_kt, ranges.TAS_KT),
        ranges.check_values("gamma in deg", gamma_deg, ranges.GAMMA_DEG),
        ranges.check_values("turn rate in deg/s", turn_rate_deg_s, ranges.TURN_RATE_DEG_S),
    ]
    if rudder_deg is not None:
        rudder_deg = ranges.check_values("rudder in deg", rudder_deg, WIDEST["rudder_deg"])
        if rudder_deg.shape[-1:] != (2,) or np.any(rudder_deg[..., 0] > rudder_deg[..., 1]):
            raise InputError("rudder in deg: some limits are no pairs or reversed; give (.., 2), the lower first.")
        conditions += [rudder_deg[..., 0], rudder_deg[..., 1]]
    columns = [np.ravel(column) for column in np.broadcast_arrays(*conditions)]
    n = columns[0].size
    lower, upper = np.tile(lower, (n, 1)), np.tile(upper, (n, 1))
    lower[:, V] = upper[:, V] = columns[1] * FT_S_PER_KT
    lower[:, PSI_DOT] = upper[:, PSI_DOT] = columns[3] * RAD_PER_DEG
    if rudder_deg is not None:
        lower[:, RUDDER], upper[:, RUDDER] = columns[4], columns[5]
    return solver.trims(columns[0], columns[2] * RAD_PER_DEG, lower, upper, failure.airframe)
