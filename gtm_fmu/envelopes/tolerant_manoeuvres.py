"""Manoeuvres that can be flown for sure, or possibly, where the aircraft is not known for sure.

A manoeuvre is guaranteed if every aircraft at the corners of the box of `tolerances.Tolerances`, and the nominal one,
can fly it at its speed and at those that a gust along the flight path makes of it, with alpha inside its bounds in a
gust across the wings at each of these speeds. It is possible if one of these aircraft can fly it in still air. Every
corner is solved: there are 1024 with all tolerances.
"""

from dataclasses import asdict, dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from gtm_fmu.aircraft import ranges
from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.airframe.names import ALPHA, PSI_DOT, V
from gtm_fmu.core import query, solver
from gtm_fmu.envelopes.manoeuvres import Manoeuvres, rows_of_each
from gtm_fmu.envelopes.tolerances import NOMINAL, Tolerances
from gtm_fmu.trims import manoeuvre
from gtm_fmu.units import FT_S_PER_KT, RAD_PER_DEG

_SUMMED = ("margin", "thrust_margin")


class Unfit(NamedTuple):
    """An aircraft of the box that cannot fly a manoeuvre.

    Attributes:
        place: mass and coefficients as fractions from their nominal values, cg in ft.
        tas_kt: speed that the gust made of the one asked for.
    """

    place: dict[str, float]
    tas_kt: float


@dataclass(frozen=True)
class TolerantManoeuvres:
    """Answers about n manoeuvres with tolerances.

    Attributes:
        guaranteed: whether all aircraft can fly it, in the gust too (n).
        possible: whether some aircraft can fly it (n).
        unfit: of what is not guaranteed, the first aircraft that was found not to fly it (n).
        least: the answers of the nominal aircraft with the least margins of all aircraft, gust and all, in their place;
            of no meaning where it is not guaranteed.
    """

    tolerances: Tolerances
    guaranteed: np.ndarray
    possible: np.ndarray
    unfit: tuple[Unfit | None, ...]
    least: Manoeuvres

    def to_dict(self, k: int) -> dict[str, Any]:
        """The answer about manoeuvre ``k``, ready for JSON; margins in deg, % and N."""
        is_sure, unfit = bool(self.guaranteed[k]), self.unfit[k]
        margins = {name: list(margin) for name, margin in self.least.margins(k).items()} if is_sure else None
        return {
            "tolerances": asdict(self.tolerances),
            "guaranteed": is_sure,
            "possible": bool(self.possible[k]),
            "least_margins": margins,
            "least_thrust_margin_n": self.least.thrust_margin_n[k].tolist() if is_sure else None,
            "not_flown_by": unfit and {"aircraft": unfit.place, "tas_kt": unfit.tas_kt},
        }


def tolerant_manoeuvres(found: Manoeuvres, tolerances: Tolerances) -> TolerantManoeuvres:
    """Whether manoeuvres are guaranteed, and whether they are possible.

    Args:
        found: the n manoeuvres with the answers about the nominal aircraft.
        tolerances: of the aircraft, and the gust.
    """
    guaranteed, possible = np.ones(len(found), dtype=bool), found.feasible.copy()
    least = found.answers.copy()
    for name in _SUMMED:
        least[name] = np.inf
    unfit: list[Unfit | None] = [None] * len(found)
    speeds_kt = dict.fromkeys((0.0, -tolerances.gust_kt, tolerances.gust_kt))
    for failure, rows in rows_of_each(found.failures).items():
        for place in (NOMINAL, *tolerances.corners()):
            moved = tolerances.moved(failure, place)
            for change_kt in speeds_kt:
                asked = rows[guaranteed[rows]]
                answers = _answers(found, asked, moved, tolerances, change_kt)
                is_flown = answers["status"] == solver.TRIMMED
                for k in asked[~is_flown].tolist():
                    unfit[k] = Unfit(tolerances.told(place), float(found.asked.tas_kt[k] + change_kt))
                guaranteed[asked[~is_flown]] = False
                for name in _SUMMED:
                    least[name][asked] = np.minimum(least[name][asked], answers[name])
            asked = rows[~possible[rows]]
            if tolerances.has_box:
                answers = _answers(found, asked, moved, Tolerances(), 0.0)
                possible[asked] = answers["status"] == solver.TRIMMED
            if not guaranteed[rows].any() and possible[rows].all():
                break
    return TolerantManoeuvres(tolerances, guaranteed, possible, tuple(unfit), replace(found, answers=least))


def _answers(
    found: Manoeuvres, rows: np.ndarray, failure: Failure, tolerances: Tolerances, change_kt: float
) -> np.ndarray:
    """Answers (m) about rows (m) flown by an aircraft at changed speeds, with alpha inside its bounds in the gust."""
    answers = np.zeros(len(rows), query.ANSWER)
    answers["status"] = solver.NO_TRIM
    asked, tas_kt = found.asked, found.asked.tas_kt[rows] + change_kt
    alpha_deg = [tolerances.alpha_kept(found.bounds_deg[0], speed) for speed in tas_kt.tolist()]
    low, high = ranges.TAS_KT
    can = [k for k, (kept, speed) in enumerate(zip(alpha_deg, tas_kt, strict=True)) if kept and low <= speed <= high]
    if not can:
        return answers
    at = rows[can]
    lower, upper = (np.tile(bound, (len(can), 1)) for bound in manoeuvre.bounds(failure, *found.bounds_deg))
    lower[:, V] = upper[:, V] = tas_kt[can] * FT_S_PER_KT
    lower[:, PSI_DOT] = upper[:, PSI_DOT] = asked.turn_rate_deg_s[at] * RAD_PER_DEG
    lower[:, ALPHA], upper[:, ALPHA] = np.array([alpha_deg[k] for k in can]).T * RAD_PER_DEG
    gamma = asked.gamma_deg[at] * RAD_PER_DEG
    answers[can] = query.query(asked.altitude_ft[at], gamma, lower, upper, failure.airframe)
    return answers
