"""modelDescription.xml of GtmDynamics against FMPy's validation, the specification and the core's own derivatives."""

import math
import subprocess
import sys

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu

from fmu_src.description.dynamics_variables import dynamics_description
from gtm_fmu import core
from gtm_fmu.airframe.names import CONTROLS, OUTPUTS, STATES


@pytest.fixture(scope="module")
def description(dynamics_fmu):
    return fmpy.read_model_description(dynamics_fmu, validate=False)


@pytest.fixture(scope="module")
def variables(description):
    return {variable.name: variable for variable in description.modelVariables}


def test_fmpy_validation_is_clean(dynamics_fmu):
    assert validate_fmu(str(dynamics_fmu)) == []


def test_fmpy_command_line_validates(dynamics_fmu):
    run = subprocess.run([sys.executable, "-m", "fmpy", "validate", dynamics_fmu], capture_output=True, text=True)
    assert (run.returncode, run.stdout.strip(), run.stderr.strip()) == (0, "No problems found.", "")


def test_kind_and_capabilities(description):
    slave = description.coSimulation
    assert (description.fmiVersion, slave.modelIdentifier) == ("2.0", "GtmDynamics")
    assert slave.needsExecutionTool
    assert slave.canHandleVariableCommunicationStepSize
    assert slave.canGetAndSetFMUstate
    assert slave.canSerializeFMUstate
    assert description.variableNamingConvention == "structured"
    experiment = description.defaultExperiment  # texts, or numbers from older FMPy
    assert [float(each) for each in (experiment.startTime, experiment.stopTime, experiment.stepSize)] == [0, 60, 0.02]


def test_variables_of_the_airframe_are_there(variables):
    assert {f"state.{name}" for name in STATES} <= variables.keys()
    assert {f"der(state.{name})" for name in STATES} <= variables.keys()
    assert {f"control.{name}" for name in CONTROLS} <= variables.keys()
    limits = {f"limits.{name}.{end}" for name in CONTROLS for end in ("lower", "upper")}
    outputs = {"air.tas", "air.eas", "air.alpha", "air.beta", "air.mach", "air.dynamic_pressure", "path.gamma"}
    outputs |= {"path.track", "load.x", "load.y", "load.z"}
    outputs |= {f"engine.{side}.{what}" for side in ("left", "right") for what in ("thrust", "rotor_speed")}
    assert limits | outputs | {"solver.substep"} <= variables.keys()
    assert len(outputs) == len(OUTPUTS)
    assert len(variables) == 2 * len(STATES) + len(CONTROLS) + len(limits) + len(outputs) + 1


def test_every_variable_says_what_it_is(variables):
    for variable in variables.values():
        assert variable.description
        assert variable.unit
        assert variable.nominal is not None
        if variable.causality in ("input", "parameter"):
            assert float(variable.min) <= float(variable.start) <= float(variable.max)


@pytest.mark.parametrize(
    ("unit", "display", "amount"),
    [
        ("m", "ft", 0.3048),
        ("m/s", "kn", 0.3048 / 0.592487),  # SPEC 1
        ("rad", "deg", math.pi / 180),
        ("1", "%", 0.01),
        ("N", "lbf", 4.4482216152605),
        ("Pa", "lbf/ft2", 47.88025898),
    ],
)
def test_display_units(description, unit, display, amount):
    units = {unit.name: {d.name: float(d.factor) for d in unit.displayUnits} for unit in description.unitDefinitions}
    assert 1 / units[unit][display] == pytest.approx(amount, rel=1e-9)


@pytest.mark.parametrize(
    ("name", "value", "display"),
    [  # SPEC 13, first trim at 800 ft; SPEC 9, limits
        ("state.altitude", 800, "ft"),
        ("control.elevator", 2.414942, "deg"),
        ("control.aileron", -0.394239, "deg"),
        ("control.rudder", 0.004192, "deg"),
        ("control.throttle", 39.839881, "%"),
        ("limits.aileron.lower", -20, "deg"),
        ("limits.aileron.upper", 20, "deg"),
        ("limits.rudder.lower", -30, "deg"),
        ("limits.elevator.upper", 30, "deg"),
        ("limits.throttle.upper", 100, "%"),
    ],
)
def test_start_values(description, variables, name, value, display):
    variable = variables[name]
    unit = next(unit for unit in description.unitDefinitions if unit.name == variable.unit)
    factor = next(float(d.factor) for d in unit.displayUnits if d.name == display)
    assert float(variable.start) * factor == pytest.approx(value, rel=1e-12)


def test_states_and_derivatives_are_paired(description):
    assert [unknown.variable.name for unknown in description.derivatives] == [f"der(state.{name})" for name in STATES]
    assert [unknown.variable.derivative.name for unknown in description.derivatives] == [f"state.{n}" for n in STATES]
    assert {u.variable.initial for u in description.derivatives} == {"calculated"}
    assert {u.variable.derivative.initial for u in description.derivatives} == {"exact"}


def test_dependencies_are_those_of_the_core(description):
    """Every nonzero derivative at random states is declared, and what is declared is nonzero somewhere."""
    rng = np.random.default_rng(1)
    x = rng.uniform(-1, 1, (300, 12)) * (60, 60, 40, 1, 1, 1, 0.6, 3, 15000, 1, 1, 3) + np.eye(12)[0] * 150
    u = rng.uniform(-1, 1, (300, 4)) * (25, 18, 28, 45) + (0, 0, 0, 50)
    knowns = [f"state.{name}" for name in STATES] + [f"control.{name}" for name in CONTROLS]
    found = {}
    groups = dynamics_description().groups
    for group, (_, slopes) in (
        ("derivatives", core.jacobian(x, u)),
        ("outputs", core.outputs_jacobian(x, u)),
    ):
        used = (slopes != 0).any(axis=0)
        for variable, row in zip(groups[group], used, strict=True):
            found[variable.name] = {known for known, is_used in zip(knowns, row, strict=True) if is_used}
    declared = {u.variable.name: {known.name for known in u.dependencies} for u in description.outputs}
    for name, knowns_used in found.items():
        extra = {"state.psi"} if name == "path.gamma" else set()  # sqrt(Vn^2 + Ve^2) holds psi, and it cancels
        assert declared[name] == knowns_used | extra, name
    assert all(declared[f"state.{name}"] == {f"state.{name}"} for name in STATES)


def test_initial_unknowns_depend_on_limits_too(description):
    initial = {
        unknown.variable.name: {known.name for known in unknown.dependencies} for unknown in description.initialUnknowns
    }
    assert {"limits.throttle.lower", "limits.throttle.upper"} <= initial["engine.left.rotor_speed"]
    assert not any(name.startswith("limits.") for name in initial["air.tas"])
