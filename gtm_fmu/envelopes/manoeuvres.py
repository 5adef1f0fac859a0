"""Can this be flown: many steady manoeuvres at once, with the margins that the limits leave.

A manoeuvre is asked for by altitude, speed, flight path and turn rate. It is feasible if any trim keeps every limit.
With a jammed rudder there is one trim at most; a range leaves a choice, of which the trim with the least sideslip is
reported, and margins are those of that trim. Where no trim keeps every limit, they are those of a trim outside that
exceeds them little: no bound is exceeded less nearby.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from gtm_fmu.aircraft import ranges
from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.aircraft.ranges import ALPHA_DEG, PHI_DEG, Range
from gtm_fmu.airframe.names import ALPHA, ELEVATOR, PHI, PSI_DOT, THROTTLE, V
from gtm_fmu.core import query, solver
from gtm_fmu.errors import InputError
from gtm_fmu.trims import manoeuvre
from gtm_fmu.trims.manoeuvre import Trim
from gtm_fmu.units import DEG_PER_RAD, FT_S_PER_KT, N_PER_LBF, RAD_PER_DEG

_SIDES = ("lower", "upper")
_LIMITED = {"alpha": (ALPHA, DEG_PER_RAD, "deg"), "phi": (PHI, DEG_PER_RAD, "deg")}


class Asked(NamedTuple):
    """Manoeuvres (n): altitude in ft, true airspeed in kn, flight path in deg, turn rate in deg/s."""

    altitude_ft: np.ndarray
    tas_kt: np.ndarray
    gamma_deg: np.ndarray
    turn_rate_deg_s: np.ndarray


@dataclass(frozen=True)
class Manoeuvres:
    """Answers about n manoeuvres.

    Attributes:
        asked: the manoeuvres, n each.
        failures: what was left of the aircraft, one for each manoeuvre.
        bounds_deg: of alpha and of phi.
        answers: (n) `core.query.ANSWER`, in the core's units.
    """

    asked: Asked
    failures: tuple[Failure, ...]
    bounds_deg: tuple[Range, Range]
    answers: np.ndarray

    def __len__(self) -> int:
        """How many manoeuvres."""
        return len(self.answers)

    @property
    def feasible(self) -> np.ndarray:
        """Whether a trim keeps every limit (n)."""
        return self.answers["status"] == solver.TRIMMED

    @property
    def is_trimmed(self) -> np.ndarray:
        """Whether there is a trim at all (n), inside the limits or not."""
        return self.answers["status"] != solver.NO_TRIM

    @property
    def stable(self) -> np.ndarray:
        """Whether no mode grows (n), on every side of the breakpoints; False where not feasible."""
        return self.answers["stable"] != 0

    @property
    def controllable(self) -> np.ndarray:
        """Whether every growing mode is reached by the controls that move (n); False where not feasible."""
        return self.answers["controllable"] != 0

    @property
    def thrust_margin_n(self) -> np.ndarray:
        """Net thrust in N (n, 2) above that at the throttles' lower limits, and below that at the upper ones."""
        return self.answers["thrust_margin"] * N_PER_LBF

    @property
    def binding(self) -> tuple[str | None, ...]:
        """The limit with the least margin in scaled units (n), as ``throttle.upper``; the most exceeded one if any is.

        None where there is no trim.
        """
        return tuple(
            f"{failure.airframe.unknowns[answer['binding']]}.{_SIDES[answer['side']]}"
            if answer["binding"] >= 0
            else None
            for failure, answer in zip(self.failures, self.answers, strict=True)
        )

    def margins(self, k: int) -> dict[str, tuple[float, float]]:
        """Distances of manoeuvre ``k`` to the lower and the upper limit, negative where one is exceeded.

        Of alpha, phi, elevator, aileron and rudder in deg (``alpha_deg`` ..), of the throttle or of each engine's in %.
        Jammed controls are left out; everything is where there is no trim.
        """
        if not self.is_trimmed[k]:
            return {}
        failure, margin = self.failures[k], self.answers["margin"][k]
        places = dict(_LIMITED)
        jams = dict(zip(failure.controls, failure.jammed, strict=True))
        for column, control in enumerate(failure.controls, ELEVATOR):
            if not jams[control]:
                places[control] = (column, 1.0, "pct" if column >= THROTTLE else "deg")
        return {
            f"{name}_{unit}": (float(margin[column, 0] * factor), float(margin[column, 1] * factor))
            for name, (column, factor, unit) in places.items()
        }

    def trim(self, k: int) -> Trim | None:
        """The trim of manoeuvre ``k``, or the near one outside the limits; None where there is none."""
        if not self.is_trimmed[k]:
            return None
        failure, y = self.failures[k], self.unknowns(k)
        lower, upper = self.bounds(k)
        hit = manoeuvre.limits_hit(y, lower, upper, failure.airframe)
        inside = bool(self.feasible[k])
        return Trim.of_unknowns(y, self.asked.altitude_ft[k], self.asked.gamma_deg[k], inside, hit, failure)

    def unknowns(self, k: int) -> np.ndarray:
        """Of the trim of manoeuvre ``k`` (9 or 10), in the core's units."""
        return self.answers["y"][k, : len(self.failures[k].airframe.unknowns)].copy()

    def bounds(self, k: int) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper bounds (9 or 10 each) of manoeuvre ``k``, core units; they hold speed and turn rate."""
        lower, upper = manoeuvre.bounds(self.failures[k], *self.bounds_deg)
        lower[V] = upper[V] = self.asked.tas_kt[k] * FT_S_PER_KT
        lower[PSI_DOT] = upper[PSI_DOT] = self.asked.turn_rate_deg_s[k] * RAD_PER_DEG
        return lower, upper

    def to_dict(self, k: int) -> dict[str, Any]:
        """The answer about manoeuvre ``k``, ready for JSON."""
        trim = self.trim(k)
        return {
            "feasible": bool(self.feasible[k]),
            "stable": bool(self.stable[k]) if self.feasible[k] else None,
            "controllable": bool(self.controllable[k]) if self.feasible[k] else None,
            "binding": self.binding[k],
            "margins": {name: list(margin) for name, margin in self.margins(k).items()},
            "thrust_margin_n": self.thrust_margin_n[k].tolist() if trim else None,
            "trim": trim and trim.to_dict(),
        }


def manoeuvres(
    altitude_ft: ArrayLike,
    tas_kt: ArrayLike,
    gamma_deg: ArrayLike = 0.0,
    turn_rate_deg_s: ArrayLike = 0.0,
    limits: ControlLimits | Failure | Sequence[ControlLimits | Failure] | None = None,
    alpha_deg: Range = ALPHA_DEG,
    phi_deg: Range = PHI_DEG,
) -> Manoeuvres:
    """Whether steady manoeuvres can be flown, with their margins: 150 000 a second and more with a jammed rudder.

    Args:
        altitude_ft: (n,) geometric altitude in ft, or what broadcasts with the next three to n manoeuvres.
        tas_kt: (n,) true airspeed in kn.
        gamma_deg: (n,) flight-path angle in deg, positive in a climb.
        turn_rate_deg_s: (n,) turn rate in deg/s, positive to the right.
        limits: a failure for all of them, or one for each; None: no failure.
        alpha_deg: least and greatest angle of attack in deg.
        phi_deg: least and greatest bank in deg.

    Returns:
        Verdicts, margins and trims of the n manoeuvres, in the order of the broadcast arrays.

    Raises:
        InputError: a value outside what is allowed, shapes that do not fit, or another number of failures.
    """
    values = [
        ranges.check_values("altitude in ft", altitude_ft, ranges.ALTITUDE_FT),
        ranges.check_values("tas in kn", tas_kt, ranges.TAS_KT),
        ranges.check_values("gamma in deg", gamma_deg, ranges.GAMMA_DEG),
        ranges.check_values("turn rate in deg/s", turn_rate_deg_s, ranges.TURN_RATE_DEG_S),
    ]
    try:
        asked = Asked(*(np.ravel(column) for column in np.broadcast_arrays(*values)))
    except ValueError:
        shapes = ", ".join(str(value.shape) for value in values)
        raise InputError(f"The shapes {shapes} of altitude, speed, path and turn rate do not fit together.") from None
    n = len(asked.altitude_ft)
    failures = _failures(limits, n)
    answers = np.zeros(n, query.ANSWER)
    for failure, rows in rows_of_each(failures).items():
        lower, upper = (np.tile(bound, (len(rows), 1)) for bound in manoeuvre.bounds(failure, alpha_deg, phi_deg))
        lower[:, V] = upper[:, V] = asked.tas_kt[rows] * FT_S_PER_KT
        lower[:, PSI_DOT] = upper[:, PSI_DOT] = asked.turn_rate_deg_s[rows] * RAD_PER_DEG
        gamma = asked.gamma_deg[rows] * RAD_PER_DEG
        answers[rows] = query.query(asked.altitude_ft[rows], gamma, lower, upper, failure.airframe)
    return Manoeuvres(asked, failures, (alpha_deg, phi_deg), answers)


def rows_of_each(failures: tuple[Failure, ...]) -> dict[Failure, np.ndarray]:
    """Rows of the manoeuvres with each failure."""
    if len({id(failure) for failure in failures}) == 1:
        return {failures[0]: np.arange(len(failures))}
    rows: dict[Failure, list[int]] = {}
    for k, failure in enumerate(failures):
        rows.setdefault(failure, []).append(k)
    return {failure: np.array(places) for failure, places in rows.items()}


def _failures(limits: Any, n: int) -> tuple[Failure, ...]:
    if limits is None or isinstance(limits, ControlLimits | Failure):
        return (Failure.of(limits),) * n
    failures = tuple(Failure.of(each) for each in limits)
    if len(failures) != n:
        raise InputError(f"There are {n} manoeuvres but {len(failures)} failures; give one for all, or one for each.")
    return failures
