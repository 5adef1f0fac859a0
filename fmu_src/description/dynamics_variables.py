"""The variables of GtmDynamics: one table for the slave, its clients and its documentation.

Order and names follow `gtm_fmu.airframe.names`; the structure (what depends on what) is read from the airframe's own
expressions. The start values are the trimmed level flight of SPEC 13: 800 ft, alpha 3 deg, gamma 0.
"""

import math
from functools import cache

import numpy as np

from fmu_src.description.model_description import DISPLAY_UNITS, ModelDescription, Variable, si
from gtm_fmu.aircraft.ranges import WIDEST
from gtm_fmu.airframe.names import (
    COEFFICIENTS,
    CONTROLS,
    LOOKUPS,
    OUTPUTS,
    STATES,
    control_variable,
    state_variable,
)
from gtm_fmu.airframe.tables import LATERAL, LONGITUDINAL
from gtm_fmu.core.generate import airframe_functions

_ALPHA, _PHI = (math.radians(angle) for angle in (3.0, -0.01616))
_START = {
    "u": 164.14225 * math.cos(_ALPHA),
    "w": 164.14225 * math.sin(_ALPHA),
    "latitude": 0.66,
    "longitude": -1.3176,
    "altitude": 800.0,
    "phi": _PHI,
    "theta": math.atan(math.tan(_ALPHA) * math.cos(_PHI)),  # level flight without sideslip
    "elevator": 2.414942,
    "aileron": -0.394239,
    "rudder": 0.004192,
    "throttle": 39.839881,
}
"""In the units of the airframe (SPEC 1); what is not named starts at zero."""

# name: unit of the airframe, display unit, nominal value (SI), description
_STATES = {
    "u": ("ft/s", "kn", 50.0, "Forward component of the velocity, body axes"),
    "v": ("ft/s", "kn", 5.0, "Rightward component of the velocity, body axes"),
    "w": ("ft/s", "kn", 5.0, "Downward component of the velocity, body axes"),
    "p": ("rad/s", "deg/s", 0.5, "Roll rate, body axes"),
    "q": ("rad/s", "deg/s", 0.5, "Pitch rate, body axes"),
    "r": ("rad/s", "deg/s", 0.5, "Yaw rate, body axes"),
    "latitude": ("rad", "deg", 1.0, "Geographic latitude"),
    "longitude": ("rad", "deg", 1.0, "Geographic longitude"),
    "altitude": ("ft", "ft", 1000.0, "Geometric altitude above the sea"),
    "phi": ("rad", "deg", 0.5, "Bank angle, not wrapped"),
    "theta": ("rad", "deg", 0.5, "Pitch angle, not wrapped"),
    "psi": ("rad", "deg", 1.0, "Heading angle, not wrapped"),
}
_DERIVATIVE_UNITS = {
    "m/s": ("m/s2", "ft/s2"),
    "rad/s": ("rad/s2", "deg/s2"),
    "rad": ("rad/s", "deg/s"),
    "m": ("m/s", "ft/min"),
}
# name: unit, nominal value (SI), description
_CONTROLS = {
    "elevator": ("deg", 0.1, "Elevator, positive trailing edge down (nose down)"),
    "aileron": ("deg", 0.1, "Aileron, positive right one down (rolls left)"),
    "rudder": ("deg", 0.1, "Rudder, positive trailing edge left (yaws left)"),
    "throttle": ("%", 0.5, "Throttle of both engines"),
}
# name of the airframe: name in the FMU, unit, display unit, min, max, nominal (SI), description
_OUTPUTS = {
    "tas": ("air.tas", "kn", "kn", 0.0, None, 50.0, "True airspeed"),
    "eas": ("air.eas", "kn", "kn", 0.0, None, 50.0, "Equivalent airspeed"),
    "alpha": ("air.alpha", "deg", "deg", -math.pi, math.pi, 0.1, "Angle of attack"),
    "beta": ("air.beta", "deg", "deg", -math.pi / 2, math.pi / 2, 0.1, "Angle of sideslip"),
    "mach": ("air.mach", "1", None, 0.0, None, 0.1, "Mach number; the model has no Mach effects"),
    "dynamic_pressure": ("air.dynamic_pressure", "lbf/ft2", "lbf/ft2", 0.0, None, 1000.0, "Dynamic pressure"),
    "gamma": ("path.gamma", "deg", "deg", -math.pi / 2, math.pi / 2, 0.1, "Flight-path angle, positive in a climb"),
    "track": ("path.track", "deg", "deg", 0.0, 2 * math.pi, 1.0, "Ground track, clockwise from north"),
    "load_x": ("load.x", "1", None, None, None, 1.0, "Accelerometer reading in g, body x axis"),
    "load_y": ("load.y", "1", None, None, None, 1.0, "Accelerometer reading in g, body y axis"),
    "load_z": ("load.z", "1", None, None, None, 1.0, "Accelerometer reading in g, body z axis (-1 in level flight)"),
    "thrust_left": ("engine.left.thrust", "lbf", "lbf", 0.0, None, 50.0, "Net thrust of the left engine"),
    "thrust_right": ("engine.right.thrust", "lbf", "lbf", 0.0, None, 50.0, "Net thrust of the right engine"),
    "rotor_speed_left": ("engine.left.rotor_speed", "%", "%", 0.0, None, 1.0, "Rotor speed of the left engine"),
    "rotor_speed_right": ("engine.right.rotor_speed", "%", "%", 0.0, None, 1.0, "Rotor speed of the right engine"),
}
USAGE = (
    "The aircraft starts in a trimmed level flight at 800 ft and flies on straight until a command changes. Inputs are "
    "held constant over a communication step and inside limits.*, which say what a failure leaves of each control: "
    "equal limits are a jam. A command outside is held and logged once.",
    "The states may be set before and in Initialization Mode, where der(state.*) and all other outputs can be read at "
    "once: this evaluates x, u -> der(x) for trim and linearisation without a step.",
    "A step integrates by the classical Runge-Kutta method in parts of solver.substep, the last one shortened. A state "
    "without derivatives (airspeed below 1 ft/s, sideslip or pitch of 90 deg), a value that is not finite, reversed "
    "limits or a step of more than 1000000 parts are logged in one sentence; the step is discarded and all values stay "
    "as before it. No output is ever NaN.",
)


def _unit(unit: str) -> tuple[str, float]:
    """SI unit of a unit, and its amount in one."""
    return DISPLAY_UNITS.get(unit, (unit, 1.0))


def _state(name: str) -> Variable:
    native, display, nominal, description = _STATES[name]
    unit, scale = _unit(native)
    return Variable(
        name=state_variable(name),
        description=description,
        causality="output",
        initial="exact",
        unit=unit,
        display_unit=display,
        start=si(_START.get(name, 0.0), native),
        nominal=nominal,
        depends_on=(state_variable(name),),
        scale=scale,
    )


def _derivative(state: Variable, depends_on: tuple[str, ...]) -> Variable:
    unit, display = _DERIVATIVE_UNITS[state.unit]
    return Variable(
        name=f"der({state.name})",
        description=f"Rate of {state.name}",
        causality="output",
        initial="calculated",
        unit=unit,
        display_unit=display,
        nominal=state.nominal,
        derivative_of=state.name,
        depends_on=depends_on,
        scale=state.scale,
    )


def _control(name: str, least: float, greatest: float) -> Variable:
    display, nominal, description = _CONTROLS[name]
    unit, scale = _unit(display)
    return Variable(
        name=control_variable(name),
        description=f"{description}; held inside limits.{name}",
        causality="input",
        unit=unit,
        display_unit=display,
        start=si(_START[name], display),
        minimum=si(least, display),
        maximum=si(greatest, display),
        nominal=nominal,
        scale=scale,
    )


def _output(name: str, depends_on: tuple[str, ...]) -> Variable:
    fmu_name, native, display, minimum, maximum, nominal, description = _OUTPUTS[name]
    unit, scale = _unit(native)
    return Variable(
        name=fmu_name,
        description=description,
        causality="output",
        initial="calculated",
        unit=unit,
        display_unit=display,
        minimum=minimum,
        maximum=maximum,
        nominal=nominal,
        depends_on=depends_on,
        scale=scale,
    )


def _limits(control: Variable) -> tuple[Variable, Variable]:
    """What a failure leaves of a control; the whole range by default."""

    def limit(end: str, start: float | None) -> Variable:
        return Variable(
            name=f"{control.name.replace('control', 'limits')}.{end}",
            description=f"{end.capitalize()} limit of {control.name}; both limits equal: a jam",
            causality="parameter",
            bounded=True,
            variability="tunable",
            initial="exact",
            unit=control.unit,
            display_unit=control.display_unit,
            start=start,
            minimum=control.minimum,
            maximum=control.maximum,
            nominal=control.nominal,
        )

    return limit("lower", control.minimum), limit("upper", control.maximum)


def _structure() -> dict[str, dict[str, tuple[str, ...]]]:
    """Known variables (states and controls) that each derivative and output of the airframe depends on, by its name."""
    functions = {function.name(): function for function in airframe_functions()}
    knowns = [state_variable(name) for name in STATES] + [control_variable(name) for name in CONTROLS]

    def pattern(function: str, argument: int) -> np.ndarray:
        sparsity = functions[function].jac_sparsity(0, argument)
        dense = np.zeros(sparsity.shape, bool)
        dense[tuple(np.array(index, int) for index in sparsity.get_triplet())] = True
        return dense

    def direct(function: str) -> np.ndarray:
        return np.hstack([pattern(function, 0), pattern(function, 1)])

    components = {"p_hat": LATERAL, "r_hat": LATERAL, "q_hat": LONGITUDINAL, "elevator": LONGITUDINAL}  # SPEC 5.4, 5.5
    tables = np.array([[name in components.get(k, COEFFICIENTS) for k in LOOKUPS] for name in COEFFICIENTS])
    depends = {}
    for function, names in (("cas_derivatives", STATES), ("cas_outputs", OUTPUTS)):
        used = direct(function) | (pattern(function, 2) @ tables @ direct("cas_lookup"))
        depends[function] = {
            name: tuple(known for known, is_used in zip(knowns, row, strict=True) if is_used)
            for name, row in zip(names, used, strict=True)
        }
    return depends


@cache
def dynamics_description() -> ModelDescription:
    """The description of GtmDynamics."""
    depends = _structure()
    states = tuple(_state(name) for name in STATES)
    controls = tuple(_control(name, *ends) for name, ends in zip(CONTROLS, WIDEST.values(), strict=True))
    limits = {control.name: _limits(control) for control in controls}
    substep = Variable(
        name="solver.substep",
        description="Longest step of the fixed-step Runge-Kutta integration (4th order) inside a communication step",
        causality="parameter",
        bounded=True,
        variability="tunable",
        initial="exact",
        unit="s",
        start=0.005,
        minimum=1e-4,
        maximum=0.1,
        nominal=0.005,
    )
    return ModelDescription(
        name="GtmDynamics",
        title="Six-degree-of-freedom flight dynamics of the NASA Generic Transport Model GTM-T2 (5.5 % scale)",
        groups={
            "states": states,
            "derivatives": tuple(
                _derivative(state, depends["cas_derivatives"][name]) for name, state in zip(STATES, states, strict=True)
            ),
            "controls": controls,
            "outputs": tuple(_output(name, depends["cas_outputs"][name]) for name in OUTPUTS),
            "limits": tuple(limit for pair in limits.values() for limit in pair),
            "solver": (substep,),
        },
        stop_time=60.0,
        step_size=0.02,
        usage=USAGE,
        limits={control: (lower.name, upper.name) for control, (lower, upper) in limits.items()},
    )
