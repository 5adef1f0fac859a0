"""The variables of GtmManoeuvre: can this be flown after a failure, how far is every limit, and how may it turn."""

from dataclasses import replace
from functools import cache

from fmu_src.description.failure_variables import FAILURE_USAGE, failure_inputs
from fmu_src.description.model_description import ModelDescription, Variable, output, si, verdict
from fmu_src.description.surrogate_variables import CASE, SPEED
from gtm_fmu import units
from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.ranges import TAS_KT, TURN_RATE_DEG_S
from gtm_fmu.airframe.names import BINDING, LIMITED
from gtm_fmu.trims.manoeuvre import bounds

USAGE = (
    "Says whether a steady turn, or straight flight at a turn rate of zero, at this altitude, flight path and true "
    "airspeed can be flown after a failure: feasible, and if so stable and controllable as a linear model. trim.* is "
    "the trim with the least sideslip. margin.* say how far it is from each limit, negative where it is exceeded, and "
    "zero for a jam; binding is the limit with the least margin relative to the typical size of what it limits. They "
    "are told of infeasible manoeuvres too, of the trim that exceeds the limits least. Where found is false there is "
    "no such trim, and margins and trim are zero. Where one throttle drives both engines, both throttles are it.",
    "turn_rate.least and turn_rate.greatest are the ends of the turns that can be flown at this speed and flight path. "
    "There are none where least is above greatest, which are then the bounds that turn_rate has, reversed. Between the "
    "ends there may be gaps: ask about the manoeuvre itself.",
    FAILURE_USAGE,
    "Outputs follow the inputs at once, also in Initialization Mode, within microseconds. The ends of the turn rate "
    "take up to some milliseconds and are found only when they are asked for.",
    "Values that are not finite or outside their bounds, reversed limits and a damage.case that is no whole number are "
    "logged in one sentence; the step is discarded and all values stay as before it. No output is ever NaN.",
)

_ANGLE = ("deg", 1.0)  # display unit, and SI in the core's unit
_SURFACE = ("deg", units.RAD_PER_DEG)
_THROTTLE = ("%", 0.01)
_THRUST = ("lbf", units.N_PER_LBF)
_UNITS = dict(zip(LIMITED, (*[_ANGLE] * 3, *[_SURFACE] * 3, *[_THROTTLE] * 2), strict=True))
_TEXTS = dict(
    zip(
        LIMITED,
        ("Angle of attack", "Sideslip", "Bank", "Elevator", "Aileron", "Rudder", "Left throttle", "Right throttle"),
        strict=True,
    )
)


def _asked() -> tuple[Variable, ...]:
    altitude, gamma = (replace(variable, bounded=True) for variable in CASE[:2])
    slowest, fastest = (si(speed, "kn") for speed in TAS_KT)
    tas = replace(SPEED, minimum=slowest, maximum=fastest, bounded=True, scale=units.M_PER_FT)
    least, greatest = (si(rate, "deg/s") for rate in TURN_RATE_DEG_S)
    turn_rate = Variable(
        name="turn_rate",
        description="Turn rate, positive to the right",
        causality="input",
        unit="rad/s",
        display_unit="deg/s",
        start=0.0,
        minimum=least,
        maximum=greatest,
        bounded=True,
    )
    return altitude, replace(gamma, scale=1.0), replace(tas, description="True airspeed"), turn_rate


def _output(name: str, measure: tuple[str, float], description: str) -> Variable:
    display, scale = measure
    return output(name, display, description, scale=scale)


_VERDICTS = (
    verdict("feasible", "Whether a steady manoeuvre inside all limits exists"),
    verdict("stable", "Whether it is stable"),
    verdict("controllable", "Whether it is controllable with what is left"),
    verdict("found", "Whether margins and trim are told, of a manoeuvre inside the limits or not"),
    verdict("binding", "The limit that is nearest, or exceeded most", items=BINDING),
)
_MARGINS = (
    *(
        _output(f"margin.{name}.{end}", _UNITS[name], f"{_TEXTS[name]}: margin to the {end} limit")
        for name in LIMITED
        for end in ("lower", "upper")
    ),
    _output("margin.thrust.lower", _THRUST, "Thrust: how much less the throttles can give"),
    _output("margin.thrust.upper", _THRUST, "Thrust: how much more the throttles can give"),
)
_TRIM = (
    *(_output(f"trim.{name}", _UNITS[name], f"{_TEXTS[name]} of the trim") for name in LIMITED),
    _output("trim.thrust", _THRUST, "Net thrust of the engines that run"),
)
_TURN_RATES = (
    replace(_output("turn_rate.least", ("deg/s", 1.0), "Turn furthest to the left at this speed"), deferred=True),
    replace(_output("turn_rate.greatest", ("deg/s", 1.0), "Turn furthest to the right at this speed"), deferred=True),
)


@cache
def manoeuvre_description() -> ModelDescription:
    """The description of GtmManoeuvre; computed in the core's units (ft, ft/s, rad; deg of surfaces, % of throttle)."""
    case, failure = _asked(), failure_inputs()
    names = tuple(variable.name for variable in (*case, *failure))
    lower, upper = bounds(Failure())

    def depending(outputs: tuple[Variable, ...], knowns: tuple[str, ...] = names) -> tuple[Variable, ...]:
        return tuple(replace(output, depends_on=knowns) for output in outputs)

    return ModelDescription(
        name="GtmManoeuvre",
        title="Whether a steady manoeuvre of the GTM-T2 can be flown after a failure, and how far its limits are",
        groups={
            "case": case,
            "failure": failure,
            "verdicts": depending(_VERDICTS),
            "margins": depending(_MARGINS),
            "trim": depending(_TRIM),
            "turn_rates": depending(_TURN_RATES, tuple(name for name in names if name != "turn_rate")),
        },
        stop_time=1.0,
        step_size=0.1,
        usage=USAGE,
        constants={"lower": lower.tolist(), "upper": upper.tolist()},
    )
