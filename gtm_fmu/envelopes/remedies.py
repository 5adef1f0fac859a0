"""Which limits keep a manoeuvre from being flown, and how far each alone would have to move to make it possible.

One limit is taken away, all others stay: the trim that needs least of it tells where it would have to be. A limit may
move as far as the undamaged aircraft's, the throttle's upper one beyond 100 % (more thrust than there is), those of
alpha and bank as far as they may be asked for.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.ranges import WIDEST, WIDEST_ALPHA_DEG, WIDEST_PHI_DEG, Range
from gtm_fmu.airframe.names import ALPHA, ELEVATOR, PHI, RUDDER, THROTTLE, TWO_THROTTLE_CONTROLS
from gtm_fmu.core import solver
from gtm_fmu.envelopes.envelope import THROTTLE_WITHOUT_LIMIT
from gtm_fmu.envelopes.manoeuvres import Manoeuvres
from gtm_fmu.units import DEG_PER_RAD, RAD_PER_DEG

_DEFLECTIONS = 13


@dataclass(frozen=True)
class Remedy:
    """A limit that would make a manoeuvre possible by itself.

    Attributes:
        name: of the limit, as ``throttle.upper``.
        units: deg or %.
        value: where the limit is.
        needed: where it would have to be.
    """

    name: str
    units: str
    value: float
    needed: float

    @property
    def move(self) -> float:
        """By how much the limit would have to move, in its unit."""
        return self.needed - self.value

    def to_dict(self) -> dict[str, Any]:
        """All values, ready for JSON."""
        return {
            "limit": self.name,
            "units": self.units,
            "value": self.value,
            "needed": self.needed,
            "move": self.move,
        }


def remedies(found: Manoeuvres, k: int) -> tuple[Remedy, ...]:
    """The limits that alone would make manoeuvre ``k`` possible, the least move in scaled units first.

    Empty where it is feasible, and where no limit is enough by itself.

    Args:
        found: manoeuvres as `manoeuvres` gives them.
        k: which of them.
    """
    if found.feasible[k]:
        return ()
    failure, (lower, upper) = found.failures[k], found.bounds(k)
    airframe = failure.airframe
    scale = solver.scale(airframe)
    dead = _dead(failure)
    moving = {ALPHA: WIDEST_ALPHA_DEG, PHI: WIDEST_PHI_DEG} | {
        column: WIDEST.get(_label(name), WIDEST["throttle_pct"])
        for column, name in enumerate(failure.controls, ELEVATOR)
        if not dead[name]
    }
    at = float(found.asked.altitude_ft[k]), float(found.asked.gamma_deg[k] * RAD_PER_DEG)
    starts = _starts(at, lower, upper, airframe)
    if not len(starts):
        return ()
    remedied: list[tuple[float, Remedy]] = []
    for column, widest in moving.items():
        factor = DEG_PER_RAD if column in (ALPHA, PHI) else 1.0
        for side, sign in (("lower", -1.0), ("upper", 1.0)):
            limit = (lower if sign < 0 else upper)[column]
            farthest = _farthest(column, widest, sign) / factor
            if sign * (farthest - limit) <= 0:
                continue
            low, high = lower.copy(), upper.copy()
            (low if sign < 0 else high)[column] = farthest
            objective = np.zeros(len(lower))
            objective[column] = sign
            best = solver.extreme(*at, low, high, objective, starts, airframe)
            if best.status == solver.TRIMMED and sign * (best.y[column] - limit) > 0:
                name = f"{airframe.unknowns[column]}.{side}"
                units = "%" if column >= THROTTLE else "deg"
                remedy = Remedy(name, units, float(limit * factor), float(best.y[column] * factor))
                remedied.append((abs(best.y[column] - limit) / scale[column], remedy))
    return tuple(remedy for _, remedy in sorted(remedied, key=lambda pair: pair[0]))


def _dead(failure: Failure) -> dict[str, bool]:
    """Which controls move nothing; one throttle does if no engine follows it."""
    dead = dict(zip(TWO_THROTTLE_CONTROLS, solver.dead_controls(failure.configuration), strict=True))
    return dead | {"throttle": dead["throttle_left"] and dead["throttle_right"]}


def _farthest(column: int, widest: Range, sign: float) -> float:
    if column >= THROTTLE and sign > 0:
        return THROTTLE_WITHOUT_LIMIT
    return widest[0] if sign < 0 else widest[1]


def _label(control: str) -> str:
    return f"{control}_pct" if control.startswith("throttle") else f"{control}_deg"


def _starts(at: tuple[float, float], lower: np.ndarray, upper: np.ndarray, airframe: solver.Airframe) -> np.ndarray:
    """Trims without regard to the limits, over the rudder's range and its own limits (m, 9 or 10)."""
    deflections = np.unique(np.append(np.linspace(*WIDEST["rudder_deg"], _DEFLECTIONS), [lower[RUDDER], upper[RUDDER]]))
    lowers, uppers = (np.tile(bound, (len(deflections), 1)) for bound in (lower, upper))
    lowers[:, RUDDER] = uppers[:, RUDDER] = deflections
    altitude, gamma = (np.full(len(deflections), value) for value in at)
    found = solver.trims(altitude, gamma, lowers, uppers, airframe)
    return found.y[found.status != solver.NO_TRIM]
