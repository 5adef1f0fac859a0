"""Options of the command line that several commands take, spelt out from a table."""

import inspect
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.inputs import LIMITED, QUANTITIES, EngineOut, failure, limit_columns
from gtm_fmu.aircraft.ranges import ALPHA_DEG, PHI_DEG, WIDEST
from gtm_fmu.errors import InputError

if TYPE_CHECKING:
    from gtm_fmu.envelopes.tolerances import Tolerances

Pair = tuple[float, float]


class Option(NamedTuple):
    """Type with its ``typer.Option``, and the default."""

    annotation: Any
    default: Any = None


def takes(options: Mapping[str, Option]) -> Callable[[Callable], Callable]:
    """Give a command these options, by name, in the place of its ``**given``."""

    def spelt_out(parameter: inspect.Parameter) -> list[inspect.Parameter]:
        keyword = inspect.Parameter.KEYWORD_ONLY
        if parameter.kind is not inspect.Parameter.VAR_KEYWORD:
            return [parameter.replace(kind=keyword)]
        return [
            inspect.Parameter(name, keyword, default=o.default, annotation=o.annotation) for name, o in options.items()
        ]

    def decorate(command: Callable) -> Callable:
        signature = inspect.signature(command)
        parameters = [new for parameter in signature.parameters.values() for new in spelt_out(parameter)]
        command.__signature__ = signature.replace(parameters=parameters)  # type: ignore[attr-defined]
        return command

    return decorate


def pair(text: str) -> Any:
    """Two numbers."""
    return typer.Option(metavar="LOWER UPPER", help=text)


Altitude = Annotated[float, typer.Option(help="Geometric altitude, 0 to 36089 ft.")]
Gamma = Annotated[float, typer.Option(help="Flight-path angle in deg, positive in a climb.")]
Alpha = Annotated[Pair, pair("Bounds of the angle of attack in deg, at the widest -20 40.")]
Phi = Annotated[Pair, pair("Bounds of the bank angle in deg, at the widest -80 80.")]
REQUIRED = inspect.Parameter.empty
CONDITION: dict[str, Option] = {
    "altitude_ft": Option(Altitude, REQUIRED),
    "gamma_deg": Option(Gamma, 0.0),
    "alpha_deg": Option(Alpha, ALPHA_DEG),
    "phi_deg": Option(Phi, PHI_DEG),
}
"""Options that tell a flight condition, and the bounds of angle of attack and bank."""

Json = Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")]


DAMAGE_CASES = (
    "Lost: 1 rudder, 2 vertical tail, 3 flap, 4 wing tip, 5 elevator, 6 stabiliser (3 to 6: the left one); 0 none."
)
ENGINES = "Engines that do not run."
SETTINGS = {
    "stabilizer": "Stabiliser in deg.",
    "flaps": "All flaps in deg.",
    "spoilers": "All spoilers in deg.",
    "gear": "Landing gear: 0 up, 1 down.",
    "fuel_used": "Fuel burnt in lb.",
}


def _limits(control: str) -> Option:
    column, widest = LIMITED[control]
    if column.label in WIDEST:
        text = f"{control.capitalize()} limits in {column.units}; equal values are a jam."
        return Option(Annotated[Pair, pair(text)], widest)
    side = control.removeprefix("throttle_")
    text = f"Throttle limits of the {side} engine alone, in %; the engines are then controlled separately."
    return Option(Annotated[Pair | None, pair(text)])


FAILURE: dict[str, Option] = {
    **{LIMITED[control][0].label: _limits(control) for control in LIMITED},
    "damage_case": Option(Annotated[int, typer.Option(help=DAMAGE_CASES)], 0),
    "engine_out": Option(Annotated[EngineOut, typer.Option(help=ENGINES)], EngineOut.NONE),
    **{
        QUANTITIES[name][0].label: Option(Annotated[float, typer.Option(help=text)], 0.0)
        for name, text in SETTINGS.items()
    },
}
"""Options that tell a failure."""


TOLERANCES: dict[str, Option] = {
    name: Option(Annotated[float, typer.Option(help=text)], 0.0)
    for name, text in {
        "gust_kt": "Gust in kn that is kept room for, along the flight path and across the wings.",
        "mass_tolerance": "Mass and inertia may be off by this part: 0.05 is 5 % more or less.",
        "cg_tolerance": "The centre of gravity may be off by this part of the mean chord, along each axis.",
        "aero_tolerance": "Each of the six total coefficients may be off by this part.",
    }.items()
}
"""Options that tell what is not known for sure."""


SPEEDS = "give one speed, or an angle of attack in its place"
ASKED: dict[str, Option] = {
    name: Option(Annotated[float | None, typer.Option(help=text)])
    for name, text in {
        "tas_kt": f"True airspeed in kn; {SPEEDS}.",
        "eas_kt": f"Equivalent airspeed in kn; {SPEEDS}.",
        "cas_kt": f"Calibrated airspeed in kn; {SPEEDS}.",
        "turn_rate_deg_s": "Turn rate (of heading) in deg/s, positive to the right; 0 where nothing else settles it.",
        "bank_deg": "Bank to fly at, in deg.",
        "sideslip_deg": "Sideslip to fly at, in deg; the least where this is left open.",
        "angle_of_attack_deg": "Angle of attack to fly at, in deg.",
        "load_factor": "Load factor to fly at, in g along the body's upward axis.",
    }.items()
}
"""Options that tell what a trim is to meet."""


def check_varied(control: str, given: Mapping[str, Any]) -> None:
    """Refuse limits of a control that a command varies itself.

    Raises:
        InputError: they are given too.
    """
    label = LIMITED[control][0].label if control in LIMITED else None
    if label and given[label] != FAILURE[label].default:
        raise InputError(f"The {control} is varied; leave out its limits, or vary another control.")


def given_tolerances(given: Mapping[str, Any]) -> "Tolerances | None":
    """What the options `TOLERANCES` tell; None where everything is known for sure.

    Raises:
        InputError: a value outside what is allowed.
    """
    if not any(given[name] != option.default for name, option in TOLERANCES.items()):
        return None
    from gtm_fmu.envelopes.tolerances import Tolerances

    return Tolerances(**{name: given[name] for name in TOLERANCES})


def given_failure(given: Mapping[str, Any]) -> Failure:
    """The failure that the options `FAILURE` tell.

    Raises:
        InputError: a value outside what is allowed, or limits of the throttle beside those of both engines' throttles.
    """
    together, *apart = (LIMITED[control][0].label for control in LIMITED if control.startswith("throttle"))
    if all(given[label] for label in apart) and given[together] != FAILURE[together].default:
        raise InputError(
            "--throttle-pct has no effect beside --throttle-left-pct and --throttle-right-pct; leave one of them out."
        )
    values = {"damage_case": given["damage_case"], "engine_out": list(EngineOut).index(given["engine_out"])}
    values |= {name: given[QUANTITIES[name][0].label] for name in SETTINGS}
    for control, (column, _) in LIMITED.items():
        if (limits := given[column.label]) is not None:
            values |= dict(zip((end.name for end in limit_columns(control)), limits, strict=True))
    return failure(values)
