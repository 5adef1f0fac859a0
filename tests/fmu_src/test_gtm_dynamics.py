"""GtmDynamics through FMPy against the core in this process and a plain Runge-Kutta of the test's own."""

import math
import re
from contextlib import suppress

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

from fmu_src.slaves.gtm_dynamics import FAULTS
from gtm_fmu import core
from gtm_fmu.aircraft.client import FmuClient, FmuError
from gtm_fmu.airframe.names import CONTROLS, STATES
from gtm_fmu.core import library_path

from .conftest import read

pytestmark = pytest.mark.slow

FT, DEG = 0.3048, math.pi / 180
STATE_SI = np.array([FT] * 3 + [1] * 5 + [FT] + [1] * 3)
CONTROL_SI = np.array([DEG] * 3 + [0.01])
KN = 0.3048 / 0.592487
LBF = 4.4482216152605
OUTPUT_SI = np.array([KN, KN, DEG, DEG, 1, LBF / FT**2, DEG, DEG, 1, 1, 1, LBF, LBF, 0.01, 0.01])
OUTPUT_NAMES = ("air.tas", "air.eas", "air.alpha", "air.beta", "air.mach", "air.dynamic_pressure", "path.gamma")
OUTPUT_NAMES += ("path.track", "load.x", "load.y", "load.z", "engine.left.thrust", "engine.right.thrust")
OUTPUT_NAMES += ("engine.left.rotor_speed", "engine.right.rotor_speed")
VARIABLES = 52
STATE_NAMES = tuple(f"state.{name}" for name in STATES)
CONTROL_NAMES = tuple(f"control.{name}" for name in CONTROLS)


@pytest.fixture(scope="module")
def opened(dynamics_fmu):
    with FmuClient(dynamics_fmu) as fmu:
        yield fmu


@pytest.fixture
def fmu(opened):
    opened.reset()
    opened.messages.clear()
    return opened


def native(fmu) -> tuple[np.ndarray, np.ndarray]:
    """State and controls of the FMU in the units of the specification."""
    return fmu.get(STATE_NAMES) / STATE_SI, fmu.get(CONTROL_NAMES) / CONTROL_SI


def runge_kutta_4(x, u, h):
    k1 = core.derivatives(x, u)
    k2 = core.derivatives(x + h / 2 * k1, u)
    k3 = core.derivatives(x + h / 2 * k2, u)
    k4 = core.derivatives(x + h * k3, u)
    return x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


def elevator_doublet_deg(time_s: float) -> float:
    return 3.0 if 1 <= time_s < 2 else -3.0 if 2 <= time_s < 3 else 0.0


def test_flies_straight_out_of_the_box(fmu):
    """The start values are a trim of SPEC 13: nothing moves for a minute but the position."""
    record = fmu.simulate(60, 0.02, ("state.altitude", "state.phi", "state.psi", "air.tas", "path.gamma"))
    assert np.ptp(record["state.altitude"]) < 1e-4
    assert np.abs(record["state.psi"]).max() < 1e-4
    assert np.abs(record["path.gamma"]).max() < 1e-6
    assert record["air.tas"][-1] / FT == pytest.approx(164.14225, abs=1e-5)


def test_doublet_agrees_with_two_other_integrations(fmu):
    """10 s of an elevator doublet to 1e-9 of the largest value of each state (at least of 1)."""
    x, u0 = native(fmu)
    advanced, stepped = x.copy(), x.copy()
    trim = fmu.get(("control.elevator",))[0]
    by_core, by_test = [], []

    def commands(time_s):
        return {"control.elevator": trim + elevator_doublet_deg(time_s) * DEG}

    record = fmu.simulate(10, 0.02, STATE_NAMES, commands)
    for i in range(500):
        u = u0 + np.array([elevator_doublet_deg(i * 0.02), 0, 0, 0])
        advanced = core.advance(advanced, u, 0.02, 0.005)
        for _ in range(4):
            stepped = runge_kutta_4(stepped, u, 0.005)
        by_core.append(advanced)
        by_test.append(stepped)
    got = np.array([record[name] for name in STATE_NAMES]).T[1:] / STATE_SI
    size = np.maximum(np.abs(got).max(axis=0), 1)
    assert np.abs(got[:, 4]).max() > 0.2  # rad/s: the doublet moves the aircraft
    for expected in (by_core, by_test):
        assert (np.abs(got - expected) / size).max() < 1e-9


def test_last_substep_is_shortened(fmu):
    x, u = native(fmu)
    u[1] += 2
    fmu.set(("control.aileron",), [u[1] * DEG])
    fmu.step(0.0137)
    for h in (0.005, 0.005, 0.0037):
        x = runge_kutta_4(x, u, h)
    np.testing.assert_allclose(native(fmu)[0], x, rtol=1e-13, atol=1e-15)


def test_substep_is_a_parameter(fmu):
    x, u = native(fmu)
    u[0] -= 5
    fmu.set(("solver.substep", "control.elevator"), [0.1, u[0] * DEG])
    fmu.step(0.1)
    np.testing.assert_allclose(native(fmu)[0], runge_kutta_4(x, u, 0.1), rtol=1e-13, atol=1e-15)


def random_points(count):
    rng = np.random.default_rng(7)
    x = rng.uniform(-1, 1, (count, 12)) * (40, 40, 40, 1, 1, 1, 1, 3, 15000, 1, 1, 3)
    x[:, [0, 8]] += 150, 15000
    return x, rng.uniform(-1, 1, (count, 4)) * (30, 20, 30, 50) + (0, 0, 0, 50)


def test_derivatives_in_initialization_mode(fmu):
    for x, u in zip(*random_points(200), strict=True):
        expected = core.derivatives(x, u)
        got = fmu.evaluate(x * STATE_SI, u * CONTROL_SI) / STATE_SI
        np.testing.assert_allclose(got, expected, rtol=1e-10, atol=1e-12)
        np.testing.assert_allclose(fmu.get(STATE_NAMES), x * STATE_SI, rtol=0)


def test_outputs(fmu):
    for x, u in zip(*random_points(50), strict=True):
        fmu.evaluate(x * STATE_SI, u * CONTROL_SI)
        np.testing.assert_allclose(fmu.get(OUTPUT_NAMES), core.outputs(x, u) * OUTPUT_SI, rtol=1e-10, atol=1e-12)


def test_specified_test_point(fmu):
    """SPEC 13, test point A."""
    x = np.array([150, 8, 12, 0.1, -0.05, 0.2, 0.66, -1.3176, 5000, 0.2, 0.08, 1.0])
    fmu.evaluate(x * STATE_SI, np.array([-2, 3, 5, 50]) * CONTROL_SI)
    got = fmu.get(("air.tas", "air.eas", "air.alpha", "air.beta", "engine.left.thrust", "engine.left.rotor_speed"))
    expected = [89.28289596612, 82.87941756245, 4.573921259901, 3.043178238316, 4.042207033, 74.3187752867]
    np.testing.assert_allclose(got / (KN, KN, DEG, DEG, LBF, 0.01), expected, rtol=1e-9)
    rates = fmu.get(("der(state.u)", "der(state.p)", "der(state.altitude)", "der(state.psi)"))
    expected = [3.689609767479, -7.948727049401, -1.320251773024, 0.1866768965702]
    np.testing.assert_allclose(rates / (FT, 1, FT, 1), expected, rtol=1e-9)


class TestState:
    def fly(self, fmu, steps):
        for i in range(steps):
            fmu.set(("control.rudder",), [math.sin(i) * 0.2])
            fmu.step(0.02)
        return fmu.get(STATE_NAMES + OUTPUT_NAMES)

    def test_set_back(self, fmu):
        self.fly(fmu, 5)
        state = fmu.instance.getFMUstate()
        first = self.fly(fmu, 50)
        fmu.instance.setFMUstate(state)
        np.testing.assert_array_equal(self.fly(fmu, 50), first)
        fmu.instance.freeFMUstate(state)

    def test_serialised_into_another_instance(self, fmu, dynamics_fmu):
        self.fly(fmu, 5)
        fmu.set(("limits.rudder.upper",), [0.05])
        state = fmu.instance.getFMUstate()
        content = fmu.instance.serializeFMUstate(state)
        first = self.fly(fmu, 50)
        with FmuClient(dynamics_fmu) as other:
            other.step(0.02)
            copy = other.instance.deSerializeFMUstate(content)
            other.instance.setFMUstate(copy)
            np.testing.assert_array_equal(self.fly(other, 50), first)
            other.instance.freeFMUstate(copy)
        fmu.instance.freeFMUstate(state)


class TestLimits:
    def test_command_is_held_and_logged_once(self, fmu):
        x, u = native(fmu)
        fmu.set(("control.rudder", "limits.rudder.upper"), [20 * DEG, 5 * DEG])
        for _ in range(10):
            fmu.step(0.02)
        expected = core.advance(x, np.array([*u[:2], 5, u[3]]), 0.2, 0.005)
        np.testing.assert_allclose(native(fmu)[0], expected, rtol=1e-11, atol=1e-13)
        assert [message.status for message in fmu.messages] == [1]
        assert f"control.rudder {20 * DEG!r} is outside its limits and is held at {5 * DEG!r}" in fmu.messages[0].text
        fmu.set(("control.rudder",), [0.0])
        fmu.step(0.02)
        assert len(fmu.messages) == 1
        fmu.set(("control.rudder",), [-40 * DEG])
        fmu.step(0.02)
        assert len(fmu.messages) == 2
        assert "held at -0.523598775598" in fmu.messages[1].text

    def test_jam(self, fmu):
        fmu.set(("limits.aileron.lower", "limits.aileron.upper"), [3 * DEG, 3 * DEG])
        x, u = native(fmu)
        u[1] = 3
        np.testing.assert_allclose(fmu.get(fmu.derivatives) / STATE_SI, core.derivatives(x, u), rtol=1e-10, atol=1e-12)

    def test_reversed(self, fmu):
        before = fmu.get(STATE_NAMES)
        fmu.step(0.0)
        fmu.set(("limits.elevator.lower", "limits.elevator.upper"), [0.1, -0.1])
        with pytest.raises(FmuError, match=r"limits.elevator is reversed: lower 0.1 is above upper -0.1 .* refused"):
            fmu.step(0.02)
        assert fmu.messages[-1].status == 2
        np.testing.assert_array_equal(fmu.instance.getReal(range(12)), before)
        fmu.set(("limits.elevator.lower",), [-0.2])
        fmu.step(0.02)

    @pytest.mark.parametrize(
        ("name", "value"), [("limits.rudder.lower", -31 * DEG), ("limits.throttle.upper", 1.1), ("solver.substep", 0.0)]
    )
    def test_parameter_out_of_bounds(self, fmu, name, value):
        before = fmu.get((name,))
        with pytest.raises(FmuError, match=f"{name} was given as .*, allowed is"):
            fmu.set((name,), [value])
        np.testing.assert_array_equal(fmu.get((name,)), before)
        with pytest.raises(FmuError, match=name):
            fmu.step(0.02)

    def test_bound_of_another_rounding_is_taken(self, fmu):
        fmu.set(("limits.rudder.lower",), [-30 / 57.295779513])
        fmu.step(0.02)
        assert fmu.messages == []


BAD_STATES = {
    "nan": ({"state.w": math.nan}, "a finite number"),
    "inf": ({"state.altitude": -math.inf}, "a finite number"),
    "huge": ({"state.u": 1e200}, "not finite"),
    "slow": ({"state.u": 0.2, "state.v": 0.1, "state.w": 0.1}, "below 1 ft/s"),
    "sideways": ({"state.u": 0.0, "state.v": 50.0, "state.w": 0.0}, "sideslip is 90 deg"),
    "up": ({"state.theta": math.pi / 2}, "pitch angle is 90 or -90 deg"),
    "down": ({"state.theta": -math.pi / 2}, "pitch angle is 90 or -90 deg"),
    "pole": ({"state.latitude": math.pi / 2}, "latitude is 90 or -90 deg"),
    "command nan": ({"control.throttle": math.nan}, "a finite number"),
    "command inf": ({"control.elevator": math.inf}, "a finite number"),
}


class TestBadStates:
    @pytest.mark.parametrize(("values", "sentence"), BAD_STATES.values(), ids=BAD_STATES)
    def test_step_is_discarded_and_nothing_is_nan(self, fmu, values, sentence):
        """By the raw FMI calls: status Discard, one sentence, all values finite and as before."""
        instance = fmu.instance
        references = [fmu.reference(name) for name in values]
        before = instance.getReal(range(VARIABLES))
        with suppress(FMICallException):  # a number that is not finite
            instance.setReal(references, list(values.values()))
        instance.exitInitializationMode()
        taken = read(fmu, references)[1]
        fmu.messages.clear()
        with pytest.raises(Exception, match="fmi2DoStep failed with status 2"):
            instance.doStep(0.0, 0.02)
        (message,) = fmu.messages
        assert message.status == 2
        assert sentence in message.text
        status, after = read(fmu, range(VARIABLES))
        assert status == 2
        assert [after[place] for place in references] == taken
        assert [x for place, x in enumerate(after) if place not in references] == [
            x for place, x in enumerate(before) if place not in references
        ]
        assert np.isfinite(after).all()

    @pytest.mark.parametrize(("values", "sentence"), BAD_STATES.values(), ids=BAD_STATES)
    def test_evaluation_is_refused(self, fmu, values, sentence):
        good = {**dict(zip(STATE_NAMES, fmu.get(STATE_NAMES), strict=True))}
        good |= dict(zip(CONTROL_NAMES, fmu.get(CONTROL_NAMES), strict=True))
        bad = good | values
        with pytest.raises(FmuError, match=sentence):
            fmu.evaluate([bad[name] for name in STATE_NAMES], [bad[name] for name in CONTROL_NAMES])
        rates = fmu.evaluate([good[name] for name in STATE_NAMES], [good[name] for name in CONTROL_NAMES])
        assert np.abs(rates[:6]).max() < 1e-4

    def test_every_fault_of_the_core_has_a_sentence(self):
        """A fault without one would raise in the slave."""
        header = (library_path().parent / "gtm_core.h").read_text()
        codes = re.search(r"enum gtm_fault \{(.*?)\}", header, re.DOTALL).group(1)
        assert set(FAULTS) == {int(code) for code in re.findall(r"GTM_\w+ = (\d+)", codes)} - {0}

    def test_goes_on_after_a_good_value(self, fmu):
        fmu.step(0.02)
        with pytest.raises(FmuError, match=r"control.rudder was given as nan"):
            fmu.set(("control.rudder",), [math.nan])
        with pytest.raises(FmuError, match=r"control.rudder was given as nan.*The step at 0.02 s is refused"):
            fmu.step(0.02)
        fmu.set(("control.rudder",), [0.0])
        fmu.step(0.02)

    @pytest.mark.parametrize("step_size", [-0.1, math.nan, math.inf])
    def test_bad_step_size(self, fmu, step_size):
        with pytest.raises(FmuError, match=r"A step of .* was asked for, allowed is a finite one"):
            fmu.step(step_size)
