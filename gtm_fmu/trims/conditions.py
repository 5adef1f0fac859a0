"""What a trim is asked for besides altitude and flight-path angle, and the bounds that mean it.

A steady manoeuvre has nine unknowns and six equations, so three conditions settle it: a speed, say, and two of turn
rate, bank, sideslip, angle of attack and load factor. A jammed rudder is one of the three. With fewer the turn rate is
zero unless something else settles the turn, and of what is then left the trim with the least sideslip is taken.
"""

from dataclasses import dataclass, fields
from typing import Any, TypedDict

import numpy as np

from gtm_fmu.aircraft import airspeed, ranges
from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.ranges import Range
from gtm_fmu.airframe.names import CONTROLS, PHI, PSI_DOT
from gtm_fmu.errors import InputError
from gtm_fmu.trims import manoeuvre

SIDESLIP_DEG: Range = (-30.0, 30.0)
LOAD_FACTOR: Range = (-2.0, 8.0)

_SPEEDS = {"tas_kt": lambda speed, _: speed, "eas_kt": airspeed.tas_of_eas, "cas_kt": airspeed.tas_of_cas}
_WORDS = {
    "tas_kt": "speed",
    "turn_rate_deg_s": "turn rate",
    "bank_deg": "bank",
    "sideslip_deg": "sideslip",
    "angle_of_attack_deg": "angle of attack",
    "load_factor": "load factor",
}


class Asked(TypedDict, total=False):
    """Conditions beside true airspeed and turn rate; None where nothing is asked.

    Speeds in kn, one of them only; angles in deg; ``load_factor`` is the reading of an accelerometer along the body's
    upward axis in g (``load_z`` of SPEC 8 with the other sign).
    """

    eas_kt: float | None
    cas_kt: float | None
    bank_deg: float | None
    sideslip_deg: float | None
    angle_of_attack_deg: float | None
    load_factor: float | None


@dataclass(frozen=True)
class Conditions:
    """Two or three conditions, as numbers; None where an unknown is left to the others.

    Attributes:
        tas_kt: true airspeed, whichever speed was asked for.
    """

    tas_kt: float | None
    turn_rate_deg_s: float | None
    bank_deg: float | None
    sideslip_deg: float | None
    angle_of_attack_deg: float | None
    load_factor: float | None

    def bounds(
        self, failure: Failure, alpha_deg: Range, phi_deg: Range, leaving: str | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Bounds (9 or 10 each) of the unknowns in the core's units, which hold what is asked.

        The load factor is no unknown; ``leaving`` is another condition that they do not hold.
        """

        def held(name: str, otherwise: Range) -> Range:
            value = getattr(self, name)
            return otherwise if value is None or name == leaving else (value, value)

        return manoeuvre.bounds(
            failure,
            held("angle_of_attack_deg", alpha_deg),
            held("bank_deg", phi_deg),
            held("tas_kt", ranges.TAS_KT),
            held("turn_rate_deg_s", ranges.TURN_RATE_DEG_S),
            held("sideslip_deg", ranges.BETA_DEG),
        )

    @property
    def number(self) -> int:
        """How many conditions these are."""
        return len(self.words)

    @property
    def words(self) -> list[str]:
        """What they are."""
        return [_WORDS[f.name] for f in fields(self) if getattr(self, f.name) is not None]

    @property
    def scanned(self) -> str | None:
        """The condition that turns to either side, or several of one side, may meet, if there is one.

        That is the load factor, or the angle of attack at a speed where it is to settle the turn.
        """
        if self.load_factor is not None:
            return "load_factor"
        settles_turn = self.tas_kt is not None and self.turn_rate_deg_s is None and self.bank_deg is None
        return "angle_of_attack_deg" if settles_turn and self.angle_of_attack_deg is not None else None

    @property
    def turning(self) -> int:
        """The unknown that such a condition settles: bank, or the turn rate where the bank is given."""
        return PHI if self.bank_deg is None else PSI_DOT


def conditions(
    altitude_ft: float,
    failure: Failure,
    alpha_deg: Range,
    phi_deg: Range,
    tas_kt: float | None,
    turn_rate_deg_s: float | None,
    asked: Asked,
) -> Conditions:
    """What is asked, checked, with the turn rate that is meant where none is given.

    Bounds ``alpha_deg`` and ``phi_deg`` with equal ends ask for that value where nothing else settles speed or turn.

    Raises:
        InputError: a value outside what is allowed or outside these bounds, none or several speeds, or more or fewer
            conditions than a trim takes.
    """
    alpha_deg = ranges.check_pair("alpha in deg", alpha_deg, ranges.WIDEST_ALPHA_DEG)
    phi_deg = ranges.check_pair("phi in deg", phi_deg, ranges.WIDEST_PHI_DEG)
    speed = _speed(altitude_ft, tas_kt, asked)
    wider = "give a value inside, or wider bounds of"
    within: dict[str, tuple[Any, ...]] = {
        "turn_rate_deg_s": ("turn rate in deg/s", turn_rate_deg_s, ranges.TURN_RATE_DEG_S),
        "bank_deg": ("bank in deg", asked.get("bank_deg"), phi_deg, f"{wider} phi"),
        "sideslip_deg": ("sideslip in deg", asked.get("sideslip_deg"), SIDESLIP_DEG),
        "angle_of_attack_deg": (
            "angle of attack in deg",
            asked.get("angle_of_attack_deg"),
            alpha_deg,
            f"{wider} alpha",
        ),
        "load_factor": ("load factor", asked.get("load_factor"), LOAD_FACTOR),
    }
    given = {name: None if check[1] is None else ranges.check_range(*check) for name, check in within.items()}
    if given["angle_of_attack_deg"] is None and speed is None and alpha_deg[0] == alpha_deg[1]:
        given["angle_of_attack_deg"] = alpha_deg[0]
    settles_turn = any(given[name] is not None for name in ("turn_rate_deg_s", "bank_deg", "load_factor"))
    if not settles_turn and phi_deg[0] == phi_deg[1]:
        given["bank_deg"], settles_turn = phi_deg[0], True
    is_jammed = failure.jammed[CONTROLS.index("rudder")]
    settles_turn = settles_turn or Conditions(speed, **given).number == _most(is_jammed)
    if not settles_turn and (speed is None or given["angle_of_attack_deg"] is None):
        given["turn_rate_deg_s"] = 0.0
    found = Conditions(speed, **given)
    _check_number(found, is_jammed)
    return found


def _speed(altitude_ft: float, tas_kt: float | None, asked: Asked) -> float | None:
    """True airspeed in kn."""
    speeds = {"tas_kt": tas_kt, "eas_kt": asked.get("eas_kt"), "cas_kt": asked.get("cas_kt")}
    given = {name: value for name, value in speeds.items() if value is not None}
    if len(given) > 1:
        raise InputError(f"{' and '.join(given)} are both speeds; give one of them.")
    for name, value in given.items():
        label = f"{name.removesuffix('_kt')} in kn"
        speed = _SPEEDS[name](ranges.check_range(label, value, ranges.TAS_KT), altitude_ft)
        return ranges.check_range("tas in kn", speed, ranges.TAS_KT)
    return None


def _most(is_jammed: bool) -> int:
    return 2 if is_jammed else 3


def _check_number(found: Conditions, is_jammed: bool) -> None:
    is_turn_known = found.bank_deg is not None and found.turn_rate_deg_s
    if found.tas_kt is None and found.angle_of_attack_deg is None and not is_turn_known:
        raise InputError("No speed is given; give one (tas, eas or cas), or an angle of attack, which settles it.")
    if found.number > _most(is_jammed):
        rudder = "jammed" if is_jammed else "movable"
        raise InputError(
            f"A trim with a {rudder} rudder takes {_most(is_jammed)} conditions, and these are {found.number}: "
            f"{', '.join(found.words)}; leave some out."
        )
