"""What a figure shows, in words and in the paper's symbols, for matplotlib (its mathtext) and for pages (HTML)."""

from dataclasses import fields
from typing import Any, NamedTuple

from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.inputs import Column, EngineOut
from gtm_fmu.aircraft.ranges import WIDEST, Range
from gtm_fmu.airframe.damage import DAMAGE_CASES
from gtm_fmu.core.configuration import Configuration


class Label(NamedTuple):
    """Of an axis or a limit."""

    tex: str
    html: str


SPEED = Label("true airspeed $V$, kn", "true airspeed <i>V</i>, kn")
TURN_RATE = Label(
    r"turn rate $\dot\psi$, deg/s", "turn rate <i>\N{GREEK SMALL LETTER PSI}\N{COMBINING DOT ABOVE}</i>, deg/s"
)
V_MAX = Label("$V_{max}$, kn", "<i>V</i><sub>max</sub>, kn")

NO_FAILURE = "no failure"

_SYMBOLS = {
    "altitude": "h",
    "gamma": "\N{GREEK SMALL LETTER GAMMA}",
    "alpha": "\N{GREEK SMALL LETTER ALPHA}",
    "phi": "\N{GREEK SMALL LETTER PHI}",
    "elevator": "\N{GREEK SMALL LETTER DELTA}e",
    "aileron": "\N{GREEK SMALL LETTER DELTA}a",
    "rudder": "\N{GREEK SMALL LETTER DELTA}r",
    "throttle": "\N{GREEK SMALL LETTER DELTA}th",
}
_NAMES = {"gamma": "flight-path angle", "alpha": "angle of attack", "phi": "bank angle"}
_UNITS = {"deg": "\N{DEGREE SIGN}", "%": " %", "pct": " %", "ft": " ft", "lb": " lb"}


def symbol(name: str, subscript: str = "") -> Label:
    """The paper's symbol of an input or an unknown."""
    letter, index = _SYMBOLS[name][0], ", ".join(filter(None, (_SYMBOLS[name][1:], subscript)))
    tex, html = (f"_{{{index}}}", f"<sub>{index}</sub>") if index else ("", "")
    return Label(f"${letter}{tex}$", f"<i>{letter}</i>{html}")


def words(name: str) -> str:
    """Name of an input or an unknown as it is spoken, as ``left throttle``."""
    name, _, side = name.partition("_")
    return " ".join(filter(None, (side, _NAMES.get(name, name))))


def quantity(name: str) -> Label:
    """Name and symbol of an input or an unknown, as ``rudder`` with its delta."""
    spoken, known = words(name), name.partition("_")[0]
    return Label(*(f"{spoken} {text}" for text in symbol(known))) if known in _SYMBOLS else Label(spoken, spoken)


def with_units(label: Label, units: str) -> Label:
    """The label of an axis."""
    return Label(*(f"{text}, {units}" for text in label))


def value(number: float, units: str) -> str:
    """A number with its unit."""
    return f"{number:g}{_UNITS.get(units, '')}"


def failure(what: Failure, but: Column | None = None) -> str:
    """What is failed, but for the control that a figure varies."""
    limited: dict[str, tuple[Range | None, Range | None]] = {
        label: (getattr(what.limits, label), widest) for label, widest in WIDEST.items()
    }
    limited |= {label: (getattr(what, label), None) for label in ("throttle_left_pct", "throttle_right_pct")}
    parts = [
        _limits(label, limits)
        for label, (limits, widest) in limited.items()
        if limits not in (None, widest) and not (but and label == but.label)
    ]
    return ", ".join([*parts, *_airframe(what.configuration)]) or NO_FAILURE


def condition(altitude_ft: float | None = None, gamma_deg: float | None = None) -> str:
    """Altitude and flight-path angle in the paper's symbols."""
    given = (("altitude", altitude_ft, "ft"), ("gamma", gamma_deg, "deg"))
    return ", ".join(f"{_SYMBOLS[name]} = {value(at, unit)}" for name, at, unit in given if at is not None)


def _limits(label: str, limits: Range) -> str:
    name, unit = label.rsplit("_", 1)
    low, high = limits
    words = " ".join(reversed(name.split("_")))
    return f"{words} jammed at {value(low, unit)}" if low == high else f"{words} {low:g} .. {value(high, unit)}"


def _airframe(configuration: Configuration) -> list[str]:
    """What differs from the study's airframe."""
    usual, parts = Configuration(), []
    for name in (f.name for f in fields(configuration)):
        given: Any = getattr(configuration, name)
        if given == getattr(usual, name):
            continue
        if name == "damage_case":
            parts.append(DAMAGE_CASES[given].name)
        elif name == "engine_running":
            out = next(engine for engine in EngineOut if engine.running == given)
            parts.append("both engines out" if out is EngineOut.BOTH else f"{out} engine out")
        else:
            words, _, unit = name.rpartition("_") if name.rpartition("_")[2] in _UNITS else (name, "", "")
            numbers = sorted(set(given)) if isinstance(given, tuple) else [given]
            parts.append(f"{words.replace('_', ' ')} " + ", ".join(value(number, unit) for number in numbers))
    return parts
