"""The native dynamics FMU against the core in this process, the Python FMU, SciPy and finite differences."""

import math
from ctypes import byref, c_size_t, c_ubyte, c_void_p
from itertools import pairwise

import fmpy
import numpy as np
import pytest
from fmpy.fmi2 import FMU2Slave
from scipy.integrate import solve_ivp

from gtm_fmu import core
from gtm_fmu.aircraft.client import FmuClient
from tests.fmu_src.native_flight import (
    CONTROLS,
    DEG,
    DX,
    GROUPS,
    NU,
    NX,
    U0,
    U_SI,
    X0,
    X_SI,
    Y_SI,
    U,
    X,
    Y,
    fly,
    put,
    random_points,
    read,
)
from tests.fmu_src.native_session import DISCARD, ERROR, OK, SESSIONS

pytestmark = pytest.mark.slow


class TestEvaluation:
    @pytest.mark.parametrize("kind", ["cs", "me"])
    def test_derivatives_and_outputs(self, start, kind):
        session = start(kind, is_exited=False)
        for x, u in zip(*random_points(100), strict=True):
            put(session, x, u)
            np.testing.assert_allclose(read(session, DX) / X_SI, core.derivatives(x, u), rtol=1e-11, atol=1e-12)
            np.testing.assert_allclose(read(session, Y), core.outputs(x, u) * Y_SI, rtol=1e-11, atol=1e-12)

    def test_continuous_states(self, start):
        session = start("me")
        session.call("EnterContinuousTimeMode")
        for x, u in zip(*random_points(20), strict=True):
            session.set([int(place) for place in U], list(u * U_SI))
            assert session.continuous("SetContinuousStates", x * X_SI)[0] == OK
            assert session.continuous("GetContinuousStates", np.zeros(NX))[1] == list(x * X_SI)
            status, rates = session.continuous(session.derivatives_function, np.zeros(NX))
            assert status == OK
            np.testing.assert_allclose(rates / X_SI, core.derivatives(x, u), rtol=1e-11, atol=1e-12)
        nominals = session.continuous("GetNominalsOfContinuousStates", np.zeros(NX))[1]
        assert nominals == [variable.nominal for variable in GROUPS["states"]]

    def test_specified_test_point(self, start):
        """SPEC 13, test point A."""
        session = start("me", is_exited=False)
        put(
            session,
            np.array([150, 8, 12, 0.1, -0.05, 0.2, 0.66, -1.3176, 5000, 0.2, 0.08, 1.0]),
            np.array([-2, 3, 5, 50]),
        )
        got = np.array(session.get_named("air.tas", "air.alpha", "der(state.u)", "der(state.p)", "der(state.altitude)"))
        expected = np.array([89.28289596612, 4.573921259901, 3.689609767479, -7.948727049401, -1.320251773024])
        np.testing.assert_allclose(got / (0.3048 / 0.592487, DEG, 0.3048, 1, 0.3048), expected, rtol=1e-9)


class TestSteps:
    def test_agreement_for_a_minute(self, native_fmus, native_folders, dynamics_fmu):
        """Native against the Python FMU and the core: 60 s of doublets of all controls, to 1e-9."""
        rng = np.random.default_rng(5)
        signs = rng.choice([-1.0, 1.0], (60, NU)) * (0.03, 0.02, 0.02, 0.1)
        sessions = [SESSIONS[fmi](native_folders[fmi], "cs") for fmi in (2, 3)]
        for session in sessions:
            session.initialize()
        tracks = [[], [], [], []]
        x = X0 / X_SI
        names = tuple(f"control.{name}" for name in CONTROLS)
        with FmuClient(dynamics_fmu) as other:
            for i in range(3000):
                second = i // 50
                turn = 1.0 if i % 50 < 25 else -1.0
                u = U0 + turn * signs[second]
                other.set(names, u)
                other.step(0.02)
                tracks[2].append(other.get(other.states))
                x = core.advance(x, u / U_SI, 0.02, 0.005)
                tracks[3].append(x * X_SI)
                for session, track in zip(sessions, tracks, strict=False):
                    session.set([int(place) for place in U], list(u))
                    assert session.step(i * 0.02, 0.02) == OK
                    track.append(read(session, X))
        for session in sessions:
            session.free()
        states = np.array(tracks)
        size = np.maximum(np.abs(states).max(axis=(0, 1)), 1)
        assert np.abs(states[0][:, 9]).max() > 0.1
        assert (np.abs(states - states[3]) / size).max() < 1e-9
        np.testing.assert_array_equal(states[0], states[1])

    def test_reference_results(self, native_fmus, fmi, native_folders):
        """FMPy with the inputs that travel in the FMU gets the results that travel with them."""
        folder = native_folders[fmi] / "extra" / "alt.gtm-fmu"
        given, expected = (
            np.genfromtxt(folder / f"reference_{kind}.csv", delimiter=",", names=True, deletechars="")
            for kind in ("input", "result")
        )
        recorded = (folder / "reference_result.csv").read_text().splitlines()[0].split(",")[1:]
        names = [(name, np.float64) for name in ("time", *(f"control.{name}" for name in CONTROLS))]
        at_steps = [tuple(row) for row in given]
        jumps = [(now[0], *before[1:]) for before, now in pairwise(at_steps)]
        held = [row for pair in zip(at_steps, [*jumps, at_steps[-1]], strict=True) for row in pair]
        for kind, signals, tolerance in (("CoSimulation", at_steps, 1e-8), ("ModelExchange", held, 1e-4)):
            got = fmpy.simulate_fmu(
                str(native_fmus[fmi]),
                stop_time=10.0,
                output_interval=0.02,
                fmi_type=kind,
                input=np.array(signals, dtype=names),
                output=recorded,
                relative_tolerance=1e-8,
            )
            at = np.searchsorted(got["time"], expected["time"] - 1e-6)
            np.testing.assert_allclose(got["time"][at], expected["time"], atol=1e-6)
            for name, column in zip(recorded, expected.dtype.names[1:], strict=True):
                error = np.abs(got[name][at] - expected[column]).max() / max(1.0, np.abs(expected[column]).max())
                assert error < tolerance, (kind, name)

    def test_tolerance_against_scipy(self, start):
        """One second of a step of elevator and aileron, by SciPy's method of order 8 and by its RK45."""
        u = U0 + np.array([0.03, 0.02, 0, 0])

        def rates(_, x):
            return core.derivatives(x / X_SI, u / U_SI) * X_SI

        sizes = np.array([variable.nominal for variable in GROUPS["states"]])
        exact = solve_ivp(rates, (0, 1), X0, method="DOP853", rtol=1e-12, atol=1e-12 * sizes).y[:, -1]
        errors = []
        for tolerance in (1e-4, 1e-6, 1e-8, 1e-10):
            session = start()
            session.set_named(solver__tolerance=tolerance)
            session.set([int(place) for place in U], list(u))
            assert session.step(0.0, 1.0) == OK
            errors.append((np.abs(read(session, X) - exact) / (sizes + np.abs(exact))).max())
            same = solve_ivp(rates, (0, 1), X0, method="RK45", rtol=tolerance, atol=tolerance * sizes, first_step=1.0)
            theirs = (np.abs(same.y[:, -1] - exact) / (sizes + np.abs(exact))).max()
            assert errors[-1] < 10 * max(theirs, tolerance)
        assert errors[-1] < 1e-8
        assert errors[0] > errors[2]

    def test_tolerance_that_cannot_be_kept(self, start):
        session = start()
        session.set_named(solver__tolerance=1e-30, control__elevator=0.3)
        assert session.step(0.0, 0.1) == DISCARD
        text = session.texts()[-1]
        assert text.startswith(
            "The step cannot be integrated to solver.tolerance. The step at 0 s is refused and the FMU"
        )
        np.testing.assert_array_equal(read(session, X), X0)

    def test_adaptive_step_into_a_fault(self, start):
        """Pitching up with full throttle until the pitch angle is 90 deg, or the speed is gone: refused, never NaN."""
        session = start(is_exited=False)
        session.set_named(solver__tolerance=1e-6, state__theta=1.5, state__q=2.0)
        session.call("ExitInitializationMode")
        status = session.step(0.0, 100.0)
        assert status in (OK, DISCARD)
        assert np.isfinite(session.get(range(53))[1]).all()

    @pytest.mark.parametrize("tolerance", [0.0, 1e-7])
    def test_state_set_back_and_copied(self, start, tolerance):
        session, other = start(), start()
        get, set_, free = session.state_functions
        size_of, serialize, deserialize = session.serialize_functions
        session.set_named(solver__tolerance=tolerance, limits__rudder__upper=0.05)
        fly(session, 60)
        state, copy, size = c_void_p(), c_void_p(), c_size_t()
        assert session.call(get, byref(state)) == OK
        assert session.call(size_of, state, byref(size)) == OK
        content = (c_ubyte * size.value)()
        assert session.call(serialize, state, content, size) == OK
        first = fly(session, 100, first=60)
        assert session.call(set_, state) == OK
        np.testing.assert_array_equal(fly(session, 100, first=60), first)
        assert other.call(deserialize, content, size, byref(copy)) == OK
        assert other.call(set_, copy) == OK
        np.testing.assert_array_equal(fly(other, 100, first=60), first)
        for one, handle in ((session, state), (other, copy)):
            assert one.call(free, byref(handle)) == OK

    def test_reset(self, start):
        session = start()
        first = fly(session, 50)
        session.set_named(limits__elevator__upper=0.0)
        session.call("Reset")
        session.initialize()
        np.testing.assert_array_equal(read(session, X), X0)
        np.testing.assert_array_equal(fly(session, 50), first)


class TestLimits:
    def test_command_is_held_and_logged_once(self, start):
        session = start()
        session.set_named(control__rudder=20 * DEG, limits__rudder__upper=5 * DEG)
        for i in range(10):
            assert session.step(i * 0.02, 0.02) == OK
            read(session, Y)
        u = U0 / U_SI
        u[2] = 5
        expected = core.advance(X0 / X_SI, u, 0.2, 0.005)
        np.testing.assert_allclose(read(session, X) / X_SI, expected, rtol=1e-11, atol=1e-13)
        assert session.texts() == [
            f"control.rudder {20 * DEG!r} is outside its limits and is held at {5 * DEG!r} (SI)."
        ]
        session.set_named(control__rudder=0.0)
        session.step(0.2, 0.02)
        assert session.texts() == []
        session.set_named(control__rudder=-40 * DEG)
        session.step(0.22, 0.02)
        assert "held at -0.523598775598" in session.texts()[0]

    def test_reversed(self, start):
        session = start()
        session.set_named(limits__elevator__lower=0.1, limits__elevator__upper=-0.1)
        assert session.step(0.0, 0.02) == DISCARD
        assert session.texts() == [
            "limits.elevator.lower 0.1 is above limits.elevator.upper -0.1 (SI). The step is refused."
        ]
        assert session.get([int(place) for place in DX])[0] == DISCARD
        session.set_named(limits__elevator__lower=-0.2)
        assert session.step(0.0, 0.02) == OK

    @pytest.mark.parametrize(
        ("name", "value"),
        [("limits__rudder__lower", -31 * DEG), ("limits__throttle__upper", 1.1), ("solver__substep", 0.0)],
    )
    def test_parameter_out_of_bounds(self, start, name, value):
        session = start()
        dotted = name.replace("__", ".")
        before = session.get_named(dotted)
        assert session.set_named(**{name: value}) == DISCARD
        assert f"{dotted} was given as" in session.texts()[0]
        assert session.get_named(dotted) == before
        assert session.step(0.0, 0.02) == DISCARD
        assert dotted in session.texts()[0]
        assert session.set_named(**{name: before[0]}) == OK
        assert session.step(0.0, 0.02) == OK

    def test_bound_of_another_rounding_is_taken(self, start):
        session = start()
        assert session.set_named(limits__rudder__lower=-30 / 57.295779513) == OK


BAD_STATES = {
    "nan": ({"state.w": math.nan}, "a finite number"),
    "inf": ({"state.altitude": -math.inf}, "a finite number"),
    "huge": ({"state.u": 1e200}, "not finite"),
    "slow": ({"state.u": 0.2, "state.v": 0.1, "state.w": 0.1}, "below 1 ft/s"),
    "sideways": ({"state.u": 0.0, "state.v": 50.0, "state.w": 0.0}, "sideslip is 90 deg"),
    "up": ({"state.theta": math.pi / 2}, "pitch angle is 90 or -90 deg"),
    "pole": ({"state.latitude": math.pi / 2}, "latitude is 90 or -90 deg"),
    "command nan": ({"control.throttle": math.nan}, "a finite number"),
}


@pytest.mark.parametrize(("values", "sentence"), BAD_STATES.values(), ids=BAD_STATES)
@pytest.mark.parametrize("tolerance", [0.0, 1e-6])
def test_bad_state_is_discarded_and_nothing_is_nan(start, values, sentence, tolerance):
    session = start(is_exited=False)
    session.set_named(solver__tolerance=tolerance)
    everything = range(53)
    good = session.get(everything)[1]
    session.set([session.names[name] for name in values], list(values.values()))
    status, after = session.get(everything)
    assert status == DISCARD
    assert np.isfinite(after).all()
    assert after[12:24] == good[12:24]  # derivatives of the last good state
    assert session.directional([int(DX[0])], [int(X[0])], [1.0])[0] == DISCARD
    assert any(sentence in text for text in session.texts())
    session.call("ExitInitializationMode")
    assert session.step(0.0, 0.02) == DISCARD
    assert session.get(everything)[1] == after
    assert session.set([session.names[name] for name in values], [good[session.names[name]] for name in values]) in (
        OK,
        ERROR,
    )


def test_fmpy_client_drives_the_native_fmu(native_fmus):
    """The project's own client takes it as it takes the Python one."""
    with FmuClient(native_fmus[2]) as fmu:
        x, u = (points[0] for points in random_points(1))
        np.testing.assert_allclose(fmu.evaluate(x * X_SI, u * U_SI) / X_SI, core.derivatives(x, u), rtol=1e-11)
        fmu.reset()
        fmu.step(0.1)
        assert isinstance(fmu.instance, FMU2Slave)
