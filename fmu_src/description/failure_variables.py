"""What a failure leaves, as inputs: variables of GtmAircraft under their names, and what only the solver knows.

Order follows `gtm_fmu.airframe.names.FAILURE`.
"""

from dataclasses import replace
from functools import cache

from fmu_src.description.aircraft_variables import aircraft_description
from fmu_src.description.model_description import Variable, si
from gtm_fmu.aircraft.ranges import ALPHA_DEG, PHI_DEG, WIDEST_ALPHA_DEG, WIDEST_PHI_DEG, Range
from gtm_fmu.airframe.configuration import RANGES
from gtm_fmu.airframe.names import CONTROLS

FAILURE_USAGE = (
    "The inputs from limits.* on say what a failure leaves; their names, units and ranges are those of GtmAircraft's, "
    "and at their start values nothing has failed. Equal limits are a jam. Both engines follow one throttle, inside "
    "limits.throttle and the limits.throttle.left and .right of those that run; with engine.separate true, each has a "
    "throttle of its own, inside limits.throttle and its own limits. A control whose surfaces are lost, or whose "
    "engines are out, is of no consequence. limits.alpha and limits.bank bound the manoeuvres."
)

SLOPES_USAGE = (
    "Partial derivatives of all real outputs with respect to the real inputs come from the trims themselves, by the "
    "theorem on implicit functions and the multipliers of the ends, not from differences of what was found. On a "
    "breakpoint of the aerodynamic tables they are those of one side (of a limit at an end: inwards), and of two "
    "limits that are equal one counts. Both limits of a jam are one deflection: its slope is that of the limit that "
    "would give more if it gave way, so that their sum is the slope of the deflection. Those of damage.case and of "
    "control.gear, which jump, are zero. Where nothing settles a trim there are none, which is logged in one sentence."
)

# name: which variable of GtmAircraft, range in its display unit (None: its own), description
_SETTINGS = (
    ("stabilizer.setting", RANGES["stabilizer_deg"], "Stabiliser"),
    ("control.flaps", RANGES["flap_deg"], "Position of the flaps, all four, positive down"),
    ("control.spoilers", RANGES["spoiler_deg"], "Position of the spoilers, all four, positive up"),
    ("control.gear", RANGES["gear"], "Landing gear, 0 up .. 1 down"),
    ("fuel.used", RANGES["fuel_used_lb"], "Fuel used"),
)


def _input(variable: Variable, **changed: object) -> Variable:
    """A parameter, input or output of GtmAircraft as an input."""
    kept = {"causality": "input", "initial": None, "depends_on": (), "nominal": None}
    kept["variability"] = "discrete" if variable.boolean else "continuous"
    return replace(variable, **{**kept, **changed})  # type: ignore[arg-type]


def _limits(aircraft: dict[str, Variable], control: str, of: str, text: str) -> tuple[Variable, ...]:
    """Both limits of a control, like those of another one."""
    return tuple(
        _input(aircraft[f"limits.{of}.{end}"], name=f"limits.{control}.{end}", description=f"{end.capitalize()} {text}")
        for end in ("lower", "upper")
    )


def _bounds(name: str, text: str, usual: Range, widest: Range) -> tuple[Variable, ...]:
    """Bounds of an angle, in rad for the core too."""
    least, greatest = (si(value, "deg") for value in widest)
    return tuple(
        Variable(
            name=f"limits.{name}.{end}",
            description=f"{end.capitalize()} bound of the {text}",
            causality="input",
            unit="rad",
            display_unit="deg",
            start=si(start, "deg"),
            minimum=least,
            maximum=greatest,
            bounded=True,
        )
        for end, start in zip(("lower", "upper"), usual, strict=True)
    )


@cache
def failure_inputs() -> tuple[Variable, ...]:
    """The inputs, computed in the core's units."""
    aircraft = {variable.name: variable for variable in aircraft_description().variables}
    running = tuple(f"engine.{side}.running" for side in ("left", "right"))
    separate = "Whether each engine has a throttle of its own"
    return (
        *(
            limit
            for control in CONTROLS
            for limit in _limits(aircraft, control, control, f"limit of the {control}; both equal: a jam")
        ),
        *(
            limit
            for side in ("left", "right")
            for limit in _limits(
                aircraft, f"throttle.{side}", "throttle", f"limit of the {side} engine's throttle, besides the other"
            )
        ),
        *_bounds("alpha", "angle of attack", ALPHA_DEG, WIDEST_ALPHA_DEG),
        *_bounds("bank", "bank angle", PHI_DEG, WIDEST_PHI_DEG),
        _input(aircraft[running[0]], name="engine.separate", start=0.0, description=separate),
        _input(aircraft["damage.case"]),
        *(_input(aircraft[name], description=f"Whether the {name.split('.')[1]} engine runs") for name in running),
        *(_setting(aircraft[name], allowed, text) for name, allowed, text in _SETTINGS),
    )


def _setting(variable: Variable, allowed: Range, text: str) -> Variable:
    display = variable.display_unit or variable.unit
    least, greatest = (si(value, display) for value in allowed)
    return _input(variable, minimum=least, maximum=greatest, bounded=True, description=text)
