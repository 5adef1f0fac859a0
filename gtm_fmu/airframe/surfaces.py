"""The surface bus: its signals, their commands and how each one enters the coefficients (SPEC 4, 5.2-5.4, 10.4)."""

from typing import NamedTuple

SIGNALS = (
    *("ELLOB", "ELLIB", "ELROB", "ELRIB"),
    *("AILL", "AILR"),
    *("RUDU", "RUDL"),
    *("SPLLIB", "SPLLOB", "SPLRIB", "SPLROB"),
    *("FLAPLIB", "FLAPLOB", "FLAPRIB", "FLAPROB"),
    *("STAB", "GEAR", "BRAKE", "THROTL", "THROTR", "STEER"),
)
"""deg; GEAR 0 .. 1; BRAKE and throttles in % (SPEC 4)."""

AERODYNAMIC = SIGNALS[: SIGNALS.index("GEAR")]
"""The signals that are surfaces, each with a six-vector of coefficients."""

COMMANDED = SIGNALS[: SIGNALS.index("SPLLIB")]
SPOILERS = SIGNALS[SIGNALS.index("SPLLIB") : SIGNALS.index("FLAPLIB")]
FLAPS = SIGNALS[SIGNALS.index("FLAPLIB") : SIGNALS.index("STAB")]


class Drive(NamedTuple):
    """The command that moves a surface, and the sign it arrives with."""

    command: str
    sign: float


ALLOCATION = {
    **dict.fromkeys(("ELLOB", "ELLIB", "ELROB", "ELRIB"), Drive("elevator", 1.0)),
    "AILL": Drive("aileron", -1.0),
    "AILR": Drive("aileron", 1.0),
    **dict.fromkeys(("RUDU", "RUDL"), Drive("rudder", 1.0)),
}
"""What moves each of the `COMMANDED` surfaces (SPEC 4)."""


class Panel(NamedTuple):
    """A surface with a table over alpha, beta and its own deflection.

    Attributes:
        surface: its signal.
        table: name in the database; that of the rudder is completed to both signs of the deflection.
        is_left: the table is the right panel's, so beta, CY, Cl and Cn change sign.
        weights: parts of CX CY CZ Cl Cm Cn.
    """

    surface: str
    table: str
    is_left: bool = False
    weights: tuple[float, ...] = (1.0, 1.0, 1.0, 1.0, 1.0, 1.0)


_INBOARD = (0.45, 0.45, 0.45, 0.26, 0.45, 0.26)
_OUTBOARD = (0.55, 0.55, 0.55, 0.74, 0.55, 0.74)

PANELS = (
    Panel("AILL", "dC6_ail", is_left=True),
    Panel("AILR", "dC6_ail"),
    Panel("RUDU", "dC6_rud", weights=(0.5, 0.5, 0.5, 0.67, 0.67, 0.5)),
    Panel("RUDL", "dC6_rud", weights=(0.5, 0.5, 0.5, 0.33, 0.33, 0.5)),
    Panel("SPLLIB", "dC6_spo", is_left=True, weights=_INBOARD),
    Panel("SPLLOB", "dC6_spo", is_left=True, weights=_OUTBOARD),
    Panel("SPLRIB", "dC6_spo", weights=_INBOARD),
    Panel("SPLROB", "dC6_spo", weights=_OUTBOARD),
)

ELEVATOR_PART = 0.25
"""Part of the elevator's table that each segment takes (SPEC 5.4)."""

ELEVATOR_ARMS = {"ELLOB": -0.07, "ELLIB": -0.03, "ELROB": 0.07, "ELRIB": 0.03}
"""Lever of each segment in roll (of CZ) and, with the other sign, in yaw (of CX), in spans (SPEC 5.4)."""
