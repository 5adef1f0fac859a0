"""The variables of GtmAircraft: those of GtmDynamics, and what stands between pilot and airframe (SPEC 10).

Order follows `gtm_fmu.airframe.names`; start values are the trimmed level flight of GtmDynamics.
"""

from dataclasses import replace
from functools import cache
from typing import Any

from fmu_src.description.dynamics_variables import dynamics_description
from fmu_src.description.model_description import DISPLAY_UNITS, ModelDescription, Variable, si
from gtm_fmu.airframe.configuration import RANGES
from gtm_fmu.airframe.damage import DAMAGE_CASES
from gtm_fmu.airframe.names import CONTROLS, SERVO_GROUPS, SIMULATION_SETTINGS
from gtm_fmu.core.simulation import DEFAULTS

USAGE = (
    "The aircraft as it flies: commands reach the surfaces through transport delays and through servos of the first "
    "order with limits of rate and position, the throttle reaches the engines through its lag, and there are wind, "
    "gusts and fuel. It starts in a trimmed level flight at 800 ft, its servos at their commands. For trims and linear "
    "models, in which commands are positions, use GtmDynamics.",
    "Whatever fails, fails failure.time seconds after the start and stays so: damage.case, engine.*.running, and "
    "limits.*, inside which the commands are then held. Equal limits are a jam, to which the servo runs; a rate of 0 "
    "is a jam where the surface stands. authority.* says what is left of each control now.",
    "A step integrates by the classical Runge-Kutta method in parts of solver.substep, which are divided where a "
    "command arrives or the failure begins; servos and lag move in closed form. Inputs are constant over a step. "
    "Outputs are those at its end; before the first step the actuators have settled.",
    "A step of more than 1000000 parts is refused. Up to 2048 changes of the commands may be on their way through the "
    "delays at once; a step that adds one more is refused.",
    "With servos.on and engine.lag false and delays of 0 the aircraft moves as GtmDynamics.",
    "A state without derivatives (airspeed below 1 ft/s, sideslip or pitch of 90 deg), a value that is not finite or "
    "out of range, or reversed limits are logged in one sentence; the step is discarded and all values stay as before "
    "it. No output is ever NaN.",
)
DAMAGE_CASE_NAMES = "; ".join(f"{case} {damage.name}" for case, damage in enumerate(DAMAGE_CASES) if case)

# in the order of names.SIMULATION_INPUTS, controls aside: name, unit, display unit, nominal (SI), description
_INPUTS = {
    "flaps": ("control.flaps", "deg", 0.1, "Flaps, all four, positive down"),
    "spoilers": ("control.spoilers", "deg", 0.1, "Spoilers, all four, positive up"),
    "gear": ("control.gear", "1", 1.0, "Landing gear, 0 up .. 1 down; ground reaction is not modelled"),
    "wind_north": ("wind.north", "ft/s", 10.0, "Wind, where the air moves: north"),
    "wind_east": ("wind.east", "ft/s", 10.0, "Wind, where the air moves: east"),
    "wind_down": ("wind.down", "ft/s", 10.0, "Wind, where the air moves: down"),
    "gust_x": ("gust.x", "ft/s", 10.0, "Gust along the body x axis, beside the wind and without shear"),
    "gust_y": ("gust.y", "ft/s", 10.0, "Gust along the body y axis"),
    "gust_z": ("gust.z", "ft/s", 10.0, "Gust along the body z axis"),
}
_RUNWAY = RANGES["runway_altitude_ft"]
# in the order of names.SIMULATION_SETTINGS: name, unit, least, greatest, description; two values only: true or false
_SETTINGS: dict[str, tuple[str, str, float, float, str]] = {
    "failure_time": ("failure.time", "s", 0.0, 1e9, "When the failure begins, in s after the start"),
    "damage_case": ("damage.case", "1", 0.0, len(DAMAGE_CASES) - 1.0, f"Damage, a whole number: {DAMAGE_CASE_NAMES}"),
    "stabilizer": ("stabilizer.setting", "deg", *RANGES["stabilizer_deg"], "Stabiliser, which has no servo"),
    "runway_altitude": ("wind.runway_altitude", "ft", *_RUNWAY, "Altitude from which the wind's shear begins"),
    "command_delay": ("delay.commands", "s", 0.0, 1.0, "Transport delay of all commands before the servos"),
    "surface_delay": ("delay.surfaces", "s", 0.0, 1.0, "Transport delay of all surfaces after the servos"),
}
_SWITCHES = {
    "engine_left_running": ("engine.left.running", "Whether the left engine still runs after the failure"),
    "engine_right_running": ("engine.right.running", "Whether the right engine still runs after the failure"),
    "has_shear": ("wind.shear", "Whether the wind grows with the height above the runway"),
    "has_stall_asymmetry": ("stall.asymmetry", "Whether the wings stall apart"),
    "has_servos": ("servos.on", "Whether servos move the surfaces; if not, they follow their commands at once"),
    "has_dead_band": ("servos.dead_band", "Whether the surfaces have play"),
    "has_throttle_lag": ("engine.lag", "Whether the engines lag behind the throttle"),
    "has_fuel_burn": ("fuel.burn", "Whether the engines use up fuel"),
}


def _real(name: str, display: str, causality: str, description: str, **others: Any) -> Variable:
    unit, scale = DISPLAY_UNITS.get(display, (display, 1.0))
    shown = display if display in DISPLAY_UNITS else None
    return Variable(
        name=name, description=description, causality=causality, unit=unit, display_unit=shown, scale=scale, **others
    )


def _parameter(name: str, display: str, start: float, least: float, greatest: float, description: str) -> Variable:
    return _real(
        name,
        display,
        "parameter",
        description,
        variability="tunable",
        initial="exact",
        start=si(start, display),
        minimum=si(least, display),
        maximum=si(greatest, display),
        nominal=1.0,
        bounded=True,
    )


def _switch(name: str, start: float, description: str) -> Variable:
    return Variable(
        name=name,
        description=description,
        causality="parameter",
        variability="tunable",
        initial="exact",
        boolean=True,
        start=start,
    )


def _output(name: str, display: str, nominal: float, description: str, depends_on: tuple[str, ...] = ()) -> Variable:
    return _real(name, display, "output", description, initial="calculated", nominal=nominal, depends_on=depends_on)


def _setting(name: str, limits: dict[str, Variable]) -> Variable:
    """A variable of `names.SIMULATION_SETTINGS`."""
    if name in _SETTINGS:
        fmu_name, display, least, greatest, description = _SETTINGS[name]
        return _parameter(fmu_name, display, DEFAULTS[name], least, greatest, description)
    if name in _SWITCHES:
        fmu_name, description = _SWITCHES[name]
        return _switch(fmu_name, DEFAULTS[name], description)
    control, end = name.rsplit("_", 1)
    if end == "rate":
        fastest, text = DEFAULTS[name], f"Fastest motion of the {control} after the failure; 0: it stands still"
        return _parameter(f"limits.{control}.rate", "deg/s", fastest, 0.0, fastest, text)
    limit = limits[f"limits.{control}.{end}"]
    return replace(limit, scale=DISPLAY_UNITS[limit.display_unit or ""][1])


@cache
def aircraft_description() -> ModelDescription:
    """The description of GtmAircraft."""
    study = dynamics_description()
    controls = tuple(
        replace(control, description=f"{control.description.split(';')[0]}: the command")
        for control in study.groups["controls"]
    )
    limits = {variable.name: variable for variable in study.groups["limits"]}
    inputs = tuple(
        _real(name, display, "input", text, start=0.0, nominal=nominal)
        for name, display, nominal, text in _INPUTS.values()
    )
    air = tuple(variable.name for variable in inputs if variable.name.startswith(("wind", "gust")))
    fuel = _real("fuel.used", "lb", "output", "Fuel used", initial="exact", start=0.0, nominal=1.0)
    states = (*study.groups["states"], replace(fuel, depends_on=("fuel.used",)))
    knowns = (*(state.name for state in states), *air)
    burning = _output("der(fuel.used)", "lb/s", 0.1, "Rate of fuel.used")
    return ModelDescription(
        name="GtmAircraft",
        title="Flight of the NASA Generic Transport Model GTM-T2: servos, delays, engine lag, wind, fuel and failures",
        groups={
            "states": states,
            "derivatives": (
                *(replace(rate, depends_on=knowns) for rate in study.groups["derivatives"]),
                replace(burning, derivative_of="fuel.used"),
            ),
            "controls": (*controls, *inputs),
            "outputs": (
                *(replace(output, depends_on=knowns) for output in study.groups["outputs"]),
                *(
                    _output(f"surface.{name}", "deg", 0.1, f"Position: {name.replace('_', ', ')}")
                    for name in SERVO_GROUPS
                ),
                _output("engine.throttle", "%", 0.5, "Throttle after the lag, which both engines follow"),
                *(
                    _output(f"engine.{side}.fuel_flow", "lb/min", 0.01, f"Fuel flow of the {side} engine")
                    for side in ("left", "right")
                ),
                *(
                    _output(f"authority.{name}.{end}", control.display_unit or "1", 0.1, f"{text} of {control.name}")
                    for name, control in zip(CONTROLS, controls, strict=True)
                    for end, text in (("lower", "Least position left"), ("upper", "Greatest position left"))
                ),
            ),
            "settings": tuple(_setting(name, limits) for name in SIMULATION_SETTINGS),
            "solver": study.groups["solver"],
        },
        stop_time=study.stop_time,
        step_size=study.step_size,
        usage=USAGE,
        has_free_start=True,
    )
