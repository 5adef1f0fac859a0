"""Flights as time goes on: the compiled simulation against the plain model, and the bypassed one against the core."""

import numpy as np
import pytest

from gtm_fmu import core
from gtm_fmu.airframe.names import SERVO_GROUPS, SIMULATION_OUTPUTS
from gtm_fmu.core.simulation import Simulation
from gtm_fmu.errors import InputError
from gtm_fmu.trims.steady import trim
from gtm_fmu.units import KT_PER_FT_S
from tests.reference import plain_actuators, plain_configuration, plain_model
from tests.reference.plain_simulation import Flight
from tests.reference.spec_values import POINT_A

BYPASSED = {"has_servos": 0, "has_throttle_lag": 0, "command_delay": 0, "surface_delay": 0}
TRIM = np.array([2.414942, -0.394239, 0.004192, 39.839881])  # SPEC 13, level at 800 ft, alpha 3 deg
ALPHA, PHI = np.radians([3, -0.01616])
LEVEL = np.zeros(12)
LEVEL[[0, 2, 6, 7, 8, 9]] = 164.14225 * np.cos(ALPHA), 164.14225 * np.sin(ALPHA), 0.66, -1.3176, 800, PHI
LEVEL[10] = np.arctan(np.tan(ALPHA) * np.cos(PHI))
STEP = 0.005


def output(simulation, u, name):
    return simulation.evaluate(u)[1][SIMULATION_OUTPUTS.index(name)]


def bus(u):
    """What inputs command of each signal (SPEC 4), flaps and spoilers all together."""
    elevator, aileron, rudder, throttle, flaps, spoilers, gear = u
    full = plain_configuration.allocated([elevator, aileron, rudder, throttle])
    full |= {name: flaps for name in full if name.startswith("FLAP")}
    full |= {name: spoilers for name in full if name.startswith("SPL")}
    return full | {"GEAR": gear}


def random_commands(rng, count):
    """Doublets of everything, some beyond the travel of the servos."""
    low, high = np.array([[-8, -25, -35, 10, -5, -5, 0], [12, 25, 35, 90, 35, 60, 1]])
    return [np.append(TRIM, [0, 0, 0]), *rng.uniform(low, high, (count, 7)).round(3)]


@pytest.mark.parametrize(
    ("seed", "settings", "wind"),
    [
        (1, {}, (0, 0, 0, 0, 0, 0)),
        (2, {"has_fuel_burn": 1, "has_dead_band": 1}, (12, -7, 3, 1, -2, 2)),
        (3, {"damage_case": 2, "failure_time": 0.1, "has_shear": 0, "engine_left_running": 0}, (9, 4, 0, 0, 0, 0)),
        (
            4,
            {"damage_case": 4, "failure_time": 0.06, "has_stall_asymmetry": 1, "runway_altitude": 700},
            (5,) + (0,) * 5,
        ),
    ],
)
def test_flights(seed, settings, wind):
    """Commands change every 20 ms, where nothing has settled: 0.2 s, to 1e-9 of the plain model."""
    rng = np.random.default_rng(seed)
    commands = random_commands(rng, 9)
    onset = settings.get("failure_time", np.inf)
    flight = Flight(
        times=[0.02 * i for i in range(10)],
        buses=[bus(u) for u in commands],
        settings=lambda time: {
            "wind": wind,
            "shear": bool(settings.get("has_shear", 1)),
            "h_runway": settings.get("runway_altitude", 12.0),
            "stall_asymmetry": bool(settings.get("has_stall_asymmetry", 0)),
            "engines_on": (time < onset or bool(settings.get("engine_left_running", 1)), True),
        },
        onset=onset,
        damage_case=settings.get("damage_case", 0),
        has_dead_band=bool(settings.get("has_dead_band", 0)),
    )
    expected, positions = flight.run(LEVEL, bool(settings.get("has_fuel_burn", 0)), 0.2, STEP)
    simulation = Simulation(LEVEL, settings)
    for u in commands:
        simulation.advance([*u, *wind], 0.02, STEP)
    np.testing.assert_allclose(simulation.x, expected, rtol=1e-9, atol=1e-9)
    names = ("ELLOB", "AILR", "RUDU", "FLAPLIB", "SPLLIB", "SPLLOB")
    if not flight.has_dead_band:
        for group, name in zip(SERVO_GROUPS, names, strict=True):
            assert output(simulation, commands[-1], f"surface_{group}") == pytest.approx(positions[name], abs=1e-9)
    assert output(simulation, commands[-1], "throttle_position") == pytest.approx(positions["THROTL"], abs=1e-9)


def test_the_study_without_actuators():
    """Servos, lag and delays bypassed: the flight of the study's own motion."""
    simulation, state, rng = Simulation(LEVEL, BYPASSED), LEVEL, np.random.default_rng(5)
    for _ in range(250):
        u = TRIM + rng.uniform(-1, 1, 4) * (2, 3, 5, 20)
        simulation.advance(u, 0.02, STEP)
        state = core.advance(state, u, 0.02, STEP)
        np.testing.assert_allclose(simulation.x[:12], state, rtol=1e-10, atol=1e-10)
    dx, y = simulation.evaluate(u)
    np.testing.assert_allclose(dx[:12], core.derivatives(state, u), rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(y[:15], core.outputs(state, u), rtol=1e-9, atol=1e-9)


def test_a_command_arrives_after_its_delays():
    """A step of 1 deg after 1 s: nothing moves for 15 ms, then 1 - exp(-2 pi 5 t); the throttle lags by 5 ms."""
    simulation, u = Simulation(LEVEL), np.append(TRIM, 0)
    simulation.advance(u, 1.0, STEP)
    u += [1, 0, 0, 10, 0]
    for k in range(1, 30):
        simulation.advance(u, 0.001, STEP)
        moved = max(0, k - 15) / 1000
        assert output(simulation, u, "surface_elevator") == pytest.approx(
            TRIM[0] + 1 - np.exp(-2 * np.pi * 5 * moved), abs=1e-11
        )
        lagged = output(simulation, u, "throttle_position") - TRIM[3]
        assert (abs(lagged) < 1e-11) == (k <= 5), "the zero in the right half plane shows at once"


@pytest.mark.parametrize(
    ("duration", "substep", "tolerance"), [(0.3, 0.0013, 1e-8), (0.003, 0.1, 1e-6), (0.3, 0.01, 1e-5)]
)
def test_parts_of_a_step(duration, substep, tolerance):
    """Actuators move in closed form, whatever the steps; the motion depends on them by the error of its method only."""
    runs = []
    for each, part in ((duration, substep), (0.001, 0.001)):
        simulation, u = Simulation(LEVEL), TRIM + np.array([0, 0, 2, 20])
        simulation.advance(TRIM, 0.1, 0.001)
        for _ in range(round(0.3 / each)):
            simulation.advance(u, each, part)
        runs.append(simulation)
    for name in ("surface_rudder", "throttle_position"):
        assert output(runs[0], u, name) == pytest.approx(output(runs[1], u, name), abs=1e-11)
    np.testing.assert_allclose(runs[0].x, runs[1].x, rtol=tolerance, atol=tolerance)


class TestFailures:
    def test_a_jam_at_its_time(self):
        settings = {"rudder_lower": 12, "rudder_upper": 12, "failure_time": 0.5}
        simulation = Simulation(LEVEL, settings)
        simulation.advance(TRIM, 0.5, STEP)
        assert output(simulation, TRIM, "rudder_least") == 12
        assert output(simulation, TRIM, "surface_rudder") == pytest.approx(TRIM[2], abs=1e-12)
        simulation.advance(TRIM, 1.0, STEP)
        assert output(simulation, TRIM, "surface_rudder") == pytest.approx(12, abs=1e-9)

    def test_the_time_may_be_inside_a_step(self):
        runs = []
        for steps in (1, 10):
            simulation = Simulation(LEVEL, {"aileron_lower": -3, "damage_case": 1, "failure_time": 0.0613})
            for _ in range(steps):
                simulation.advance(TRIM - [0, 10, 0, 0], 0.2 / steps, 0.001)
            runs.append(simulation.x)
        np.testing.assert_allclose(runs[0], runs[1], rtol=1e-8, atol=1e-8)

    def test_a_surface_that_stands_still(self):
        simulation = Simulation(LEVEL, {"rudder_rate": 0, "failure_time": 0.05})
        simulation.advance(TRIM + np.array([0, 0, 10, 0]), 0.03, STEP)
        simulation.advance(TRIM - [0, 0, 10, 0], 0.02, STEP)
        stands = output(simulation, TRIM, "surface_rudder")
        assert stands == output(simulation, TRIM, "rudder_least") == output(simulation, TRIM, "rudder_greatest")
        simulation.advance(TRIM, 1.0, STEP)
        assert output(simulation, TRIM, "surface_rudder") == stands

    def test_before_it_the_travel_of_the_servos_is_left(self):
        simulation = Simulation(LEVEL, {"elevator_upper": 5, "failure_time": 1})
        assert [output(simulation, TRIM, f"elevator_{end}") for end in ("least", "greatest")] == [-30, 20]


def test_fuel():
    """Burnt by the flow of SPEC 10.3; the aircraft gets lighter, so the accelerometer reads more."""
    rate = plain_actuators.fuel_used_rate([plain_model.rotor_speed(TRIM[3])] * 2)
    simulation = Simulation(LEVEL, {"has_fuel_burn": 1})
    simulation.advance(TRIM, 60, 0.02)
    assert simulation.x[12] == pytest.approx(60 * rate, rel=1e-12)
    full, empty = Simulation(LEVEL), Simulation(np.append(LEVEL, 11.48))
    assert output(empty, TRIM, "load_z") == pytest.approx(
        output(full, TRIM, "load_z") * 57.75 / (57.75 - 11.48), rel=2e-3
    )


def test_start_values_are_those_of_the_specification():
    dx, _ = Simulation(POINT_A.x).evaluate(POINT_A.u)
    np.testing.assert_allclose(dx[:12], POINT_A.xdot, rtol=1e-11)


@pytest.mark.parametrize(
    ("settings", "u", "duration", "substep", "message"),
    [
        ({"rudder_lower": 5, "rudder_upper": -5}, TRIM, 0.1, STEP, "reversed"),
        ({"damage_case": 1.5}, TRIM, 0.1, STEP, "outside its range"),
        ({"damage_case": 7}, TRIM, 0.1, STEP, "outside its range"),
        ({"command_delay": -1}, TRIM, 0.1, STEP, "outside its range"),
        ({}, np.append(TRIM, [0, 0, 0, 1e4]), 0.1, STEP, "outside its range"),
        ({}, TRIM, -0.1, STEP, "negative"),
        ({}, TRIM, 0.1, 0, "not positive"),
        ({}, TRIM, 5001, STEP, "more than 1000000"),
    ],
)
def test_refusals_change_nothing(settings, u, duration, substep, message):
    simulation = Simulation(LEVEL, settings)
    with pytest.raises(FloatingPointError, match=message):
        simulation.advance(u, duration, substep)
    np.testing.assert_array_equal(simulation.x[:12], LEVEL)


def swept(time: float) -> np.ndarray:
    """Commands of a manoeuvre in which all controls move all the time."""
    return TRIM + np.sin(40 * time + np.arange(4)) * (3, 4, 5, 10)


class TestCommandsOnTheirWay:
    """Changes of the commands within the transport delays: 75 of them by default with steps of 0.2 ms."""

    def test_short_steps(self):
        """Steps of 0.2 ms over 20 ms: to 1e-9 of the plain model."""
        step, count = 0.0002, 100
        commands = [swept(step * i) for i in range(count)]
        times = [step * i for i in range(count)]
        expected, _ = Flight(times, [bus([*u, 0, 0, 0]) for u in commands]).run(LEVEL, False, step * count, step)
        simulation = Simulation(LEVEL)
        for u in commands:
            simulation.advance(u, step, step)
        np.testing.assert_allclose(simulation.x, expected, rtol=1e-9, atol=1e-9)

    def test_altitude_of_steps_of_two_lengths(self):
        """40 ms of a manoeuvre that moves each millisecond, in steps of 0.2 and 0.25 ms with a tremble of 1e-10 deg."""
        altitudes_m = []
        for step, count in ((0.0002, 200), (0.00025, 160)):
            simulation = Simulation(LEVEL)
            for i in range(count):
                simulation.advance(swept(round((i + 0.5) * step // 0.001) / 1000) + 1e-10 * (i % 2), step, step)
            altitudes_m.append(simulation.x[8] * 0.3048)
        assert abs(altitudes_m[0] - 243.84) > 1e-5
        assert altitudes_m[0] == pytest.approx(altitudes_m[1], abs=1e-10)

    @pytest.mark.parametrize(
        ("settings", "step"),
        [
            ({"command_delay": 1.0, "surface_delay": 0.0}, 0.01),
            ({"command_delay": 1.0, "surface_delay": 1.0}, 0.02),
            ({"command_delay": 1.0, "surface_delay": 1.0}, 0.001),
        ],
    )
    def test_long_delays(self, settings, step):
        """Surfaces are where they would have been without delays, that much earlier."""
        delay = settings["command_delay"] + settings["surface_delay"]
        positions = {}
        for name, run, end in (("late", settings, 2.6), ("at once", dict.fromkeys(settings, 0.0), 2.6 - delay)):
            simulation = Simulation(LEVEL, run)
            for i in range(round(end / step)):
                simulation.advance(swept(step * i), step, 0.01)
            y = simulation.evaluate(swept(0))[1]
            positions[name] = [y[SIMULATION_OUTPUTS.index(f"surface_{group}")] for group in SERVO_GROUPS[:3]]
        assert np.abs(np.array(positions["late"]) - TRIM[:3]).min() > 0.05
        np.testing.assert_allclose(positions["late"], positions["at once"], rtol=0, atol=1e-9)

    def test_a_refused_step_forgets_and_adds_nothing(self):
        """Also where the ring of what is remembered is nearly full and goes round."""
        runs = [Simulation(LEVEL, {"command_delay": 1.0, "surface_delay": 1.0}) for _ in range(2)]
        for i in range(4200):
            for simulation in runs:
                simulation.advance(swept(0.001 * i), 0.001, 0.01)
            with pytest.raises(FloatingPointError, match="outside its range"):
                runs[1].advance([5, 5, 5, 50, 0, 0, 0, 1e4], 0.001, 0.01)
        np.testing.assert_array_equal(runs[0].x, runs[1].x)
        np.testing.assert_array_equal(runs[0].evaluate(TRIM)[1], runs[1].evaluate(TRIM)[1])

    def test_limit(self):
        """2048 changes fit; one more is refused and nothing changes, and shorter delays make room."""
        simulation = Simulation(LEVEL, {"command_delay": 1.0, "surface_delay": 1.0})
        for i in range(2048):
            simulation.advance(swept(0.0001 * i), 0.0001, STEP)
        before = simulation.x.copy()
        for _ in range(2):
            with pytest.raises(
                FloatingPointError, match="more than 2048 times within the delays: take longer steps or"
            ):
                simulation.advance(swept(1.0), 0.0001, STEP)
            np.testing.assert_array_equal(simulation.x, before)
        simulation.settings["surface_delay"] = simulation.settings["command_delay"] = 0.05
        simulation.advance(swept(1.0), 0.0001, STEP)


def test_unknown_setting():
    with pytest.raises(InputError, match="'wind'"):
        Simulation(LEVEL, {"wind": 1})


def test_the_time_of_a_failure_is_met_by_steps_that_do_not_sum_up_to_it():
    simulation = Simulation(LEVEL, {"rudder_lower": 12, "rudder_upper": 12, "failure_time": 30})
    clock = 0.0  # `sum` of Python 3.12 and newer would not round
    for _ in range(1500):
        simulation.advance(TRIM, 0.02, 0.02)
        clock += 0.02
    assert clock < 30
    assert output(simulation, TRIM, "rudder_least") == 12


@pytest.mark.parametrize(("alpha_off_deg", "altitude_ft"), [(0, 1290.0), (2, 1286.2)])
def test_published_climbing_turn(alpha_off_deg, altitude_ft):
    """SPEC 13: 60 s of the climbing turn (eas 95, gamma 3, 10 deg/s) from 800 ft, from trim and alpha 2 deg off it."""
    turn = trim(800, 162.23401 * KT_PER_FT_S, 3, 10, phi_deg=(-60, 60))
    x, u = turn.state_and_controls
    alpha = np.radians(turn.alpha_deg + alpha_off_deg)
    x[[0, 2]] = np.hypot(x[0], x[2]) * np.array([np.cos(alpha), np.sin(alpha)])
    assert Simulation(x).advance(u, 60, STEP)[8] == pytest.approx(altitude_ft, abs=0.05)
