"""Many trims at once: the compiled batch solver (exact Newton on the six accelerations).

With the rudder jammed, the trim at given altitude, speed, flight-path angle and turn rate is unique. With a movable
rudder there is a family of them, and the one with the least sideslip is taken: beta = 0 wherever the limits allow it.
"""

import numpy as np

from gtm_fmu import manoeuvre
from gtm_fmu.core import solver
from gtm_fmu.errors import InputError
from gtm_fmu.failures import WIDEST, ControlLimits, Failure, Range
from gtm_fmu.manoeuvre import ALPHA_DEG, PHI_DEG, Trim
from gtm_fmu.units import FT_S_PER_KT, RAD_PER_DEG


def trim(
    altitude_ft: float,
    tas_kt: float,
    gamma_deg: float = 0.0,
    turn_rate_deg_s: float = 0.0,
    limits: ControlLimits | Failure | None = None,
    alpha_deg: Range = ALPHA_DEG,
    phi_deg: Range = PHI_DEG,
) -> Trim:
    """The trim with the least sideslip inside the limits, or the nearest to one.

    Of separate throttles, where several trims have no sideslip, the ones closest together are taken.

    Raises:
        InputError: altitude, speed, flight path or bounds outside what is allowed.
    """
    altitude_ft = manoeuvre.check_range("altitude in ft", altitude_ft, manoeuvre.ALTITUDE_FT)
    gamma_deg = manoeuvre.check_range("gamma in deg", gamma_deg, manoeuvre.GAMMA_DEG)
    held = (tas_kt, tas_kt), (turn_rate_deg_s, turn_rate_deg_s)
    failure = Failure.of(limits)
    lower, upper = manoeuvre.bounds(failure, alpha_deg, phi_deg, *held)
    found = solver.trims([altitude_ft], [gamma_deg * RAD_PER_DEG], lower[None], upper[None], failure.airframe)
    y, status = found.y[0], found.status[0]
    hit = manoeuvre.limits_hit(y, lower, upper)
    return Trim.of_unknowns(y, altitude_ft, gamma_deg, status == solver.TRIMMED, hit, failure)


def trims(
    altitude_ft,
    tas_kt,
    gamma_deg,
    turn_rate_deg_s,
    limits: ControlLimits | Failure | None = None,
    rudder_deg=None,
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
        manoeuvre.check_values("altitude in ft", altitude_ft, manoeuvre.ALTITUDE_FT),
        manoeuvre.check_values("tas in kt", tas_kt, manoeuvre.TAS_KT),
        manoeuvre.check_values("gamma in deg", gamma_deg, manoeuvre.GAMMA_DEG),
        manoeuvre.check_values("turn rate in deg/s", turn_rate_deg_s, manoeuvre.TURN_RATE_DEG_S),
    ]
    if rudder_deg is not None:
        rudder_deg = manoeuvre.check_values("rudder in deg", rudder_deg, WIDEST["rudder_deg"])
        if rudder_deg.shape[-1:] != (2,) or np.any(rudder_deg[..., 0] > rudder_deg[..., 1]):
            raise InputError("rudder in deg: some limits are no pairs or reversed; give (.., 2), the lower first.")
        conditions += [rudder_deg[..., 0], rudder_deg[..., 1]]
    columns = [np.ravel(column) for column in np.broadcast_arrays(*conditions)]
    n = columns[0].size
    lower, upper = np.tile(lower, (n, 1)), np.tile(upper, (n, 1))
    lower[:, manoeuvre.V] = upper[:, manoeuvre.V] = columns[1] * FT_S_PER_KT
    lower[:, manoeuvre.PSI_DOT] = upper[:, manoeuvre.PSI_DOT] = columns[3] * RAD_PER_DEG
    if rudder_deg is not None:
        lower[:, manoeuvre.RUDDER], upper[:, manoeuvre.RUDDER] = columns[4], columns[5]
    return solver.trims(columns[0], columns[2] * RAD_PER_DEG, lower, upper, failure.airframe)
