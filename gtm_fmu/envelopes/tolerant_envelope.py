"""The envelope that is left for sure, and the one that is possible, where the aircraft is not known for sure.

Guaranteed speeds are inside the envelopes of all aircraft of the box of `tolerances.Tolerances`, and keep their margins
in a gust. Possible speeds are inside the envelope of some aircraft, in still air. So the guaranteed V_min is the
highest V_min of the box, the possible one the lowest.

Each is sought at the corners of the box (`box_search`), the guaranteed ones under the bounds of alpha that a gust
across the wings leaves (`gust_ends`). A gust along the flight path then takes its speed from either end.
"""

from dataclasses import asdict, dataclass, replace
from typing import Any

from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.aircraft.ranges import ALPHA_DEG, PHI_DEG, Range
from gtm_fmu.envelopes.box_search import EndSearch, Solved
from gtm_fmu.envelopes.envelope import Envelope, FlightCondition
from gtm_fmu.envelopes.tolerances import Tolerances
from gtm_fmu.trims import manoeuvre
from gtm_fmu.trims.manoeuvre import Trim


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

    def speeds_kt(self, kind: str) -> Range | None:
        """V_min and V_max in kn of a ``kind``, guaranteed, nominal or possible; None where there are none."""
        if kind == "nominal":
            low, high = self.nominal.v_min_kt, self.nominal.v_max_kt
            return None if low is None or high is None else (low, high)
        ends: Ends | None = getattr(self, kind)
        return ends and (ends[0].tas_kt, ends[1].tas_kt)

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

    Args:
        altitude_ft, gamma_deg: flight condition in ft and deg.
        limits: of the controls, or a failure; default the undamaged aircraft.
        tolerances: of the aircraft, and the gust; default none.
        alpha_deg, phi_deg: bounds of angle of attack and bank in deg.

    Raises:
        InputError: altitude, flight path or bounds outside what is allowed.
    """
    return tolerant_envelope_of(FlightCondition(altitude_ft, gamma_deg, limits, alpha_deg, phi_deg), tolerances)


def tolerant_envelope_of(condition: FlightCondition, tolerances: Tolerances | None = None) -> TolerantEnvelope:
    """The same of a flight condition."""
    tolerances = tolerances or Tolerances()
    in_still_air = replace(tolerances, gust_kt=0.0)
    worst = [EndSearch(condition, tolerances, sign).worst() for sign in (1.0, -1.0)]
    best = [EndSearch(condition, in_still_air, sign).best() for sign in (1.0, -1.0)]
    return TolerantEnvelope(tolerances, condition.envelope(), _ends(tolerances, *worst), _ends(in_still_air, *best))


def _ends(tolerances: Tolerances, low: Solved | None, high: Solved | None) -> Ends | None:
    gust_kt = tolerances.gust_kt
    if low is None or high is None or low.tas_kt + gust_kt > high.tas_kt - gust_kt:
        return None
    return _end(tolerances, low, gust_kt), _end(tolerances, high, -gust_kt)


def _end(tolerances: Tolerances, found: Solved, margin_kt: float) -> TolerantEnd:
    condition = found.condition
    lower, upper = condition.bounds
    hit = manoeuvre.limits_hit(found.y, lower, upper, condition.failure.airframe)
    trim = Trim.of_unknowns(found.y, condition.altitude_ft, condition.gamma_deg, True, hit, condition.failure)
    gust = tolerances.gust_alpha_deg(trim.tas_kt), tolerances.gust_load_factor(trim)
    return TolerantEnd(trim.tas_kt + margin_kt, trim, tolerances.told(found.place), *gust)
