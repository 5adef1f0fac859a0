"""The plain model of SPEC 10 against SPEC 13 to the printed digits, and its actuators against closed forms."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from tests.reference import plain_actuators, plain_configuration, plain_model, spec_values
from tests.reference.plain_configuration import Configuration, allocated
from tests.reference.spec_values import POINT_A, POINT_B, POINT_C, assert_as_printed


def assert_all_as_printed(values, printed, half_units=1):
    for value, text in zip(values, printed.split(), strict=True):
        assert_as_printed(value, text, half_units)


@pytest.mark.parametrize("point", [POINT_A, POINT_B], ids=["A", "B"])
def test_undamaged_points(point, tables):
    configuration = Configuration(allocated(point.u))
    xdot = plain_configuration.derivatives(point.x, configuration, tables)
    np.testing.assert_allclose(xdot, point.xdot, rtol=1e-12)
    np.testing.assert_allclose(
        plain_configuration.outputs(point.x, configuration), plain_model.outputs(point.x, point.u), rtol=1e-13
    )


@pytest.mark.parametrize("case", spec_values.POINT_A_DAMAGED)
def test_damage_at_point_a(case, tables):
    configuration = Configuration(allocated(POINT_A.u), damage_case=case)
    xdot = plain_configuration.derivatives(POINT_A.x, configuration, tables)
    assert_all_as_printed(xdot[:6], spec_values.POINT_A_DAMAGED[case])


def point_c(case):
    return Configuration(POINT_C.bus, POINT_C.fuel_used, case, POINT_C.wind)


@pytest.mark.parametrize("case", spec_values.POINT_C_ACCELERATIONS)
def test_accelerations_at_point_c(case, tables):
    xdot = plain_configuration.derivatives(POINT_C.x, point_c(case), tables)
    assert_all_as_printed(xdot[:6], spec_values.POINT_C_ACCELERATIONS[case])


def test_wind_at_point_c():
    """The second component, -13.0196509943749 in exact arithmetic, is printed with its last digit rounded twice."""
    assert_as_printed(plain_configuration.shear_gain(POINT_C.x[8] - 12), spec_values.POINT_C_SHEAR_GAIN)
    wind = plain_configuration.wind_body(POINT_C.x, point_c(0))
    assert_all_as_printed(wind, spec_values.POINT_C_WIND_BODY)


def test_mass_at_point_c():
    mass, cg, inertias = plain_configuration.mass_properties(POINT_C.fuel_used, POINT_C.bus["GEAR"], 6)
    assert_as_printed(mass, spec_values.POINT_C_MASS)
    assert_all_as_printed(cg, spec_values.POINT_C_CG)
    assert_all_as_printed(inertias, spec_values.POINT_C_INERTIAS)


def test_a_uniform_wind_moves_the_aircraft_with_the_air():
    """Without shear: accelerations and air data of still air, seen from the air; only the path over ground differs."""
    wind, case = np.array([20.0, -30.0, 4.0]), 2
    x = POINT_A.x.copy()
    D = plain_model.direction_cosines(*x[9:])
    x[:3] += D @ wind
    still = Configuration(allocated(POINT_A.u), damage_case=case)
    blown = Configuration(allocated(POINT_A.u), damage_case=case, wind=(*wind, 0, 0, 0), shear=False)
    expected = plain_configuration.derivatives(POINT_A.x, still)
    xdot = plain_configuration.derivatives(x, blown)
    carried = np.cross(x[3:6], D @ wind)  # the wind, constant on earth, turns as seen from the body
    np.testing.assert_allclose(xdot[:3] + carried, expected[:3], rtol=1e-12)
    np.testing.assert_allclose(xdot[3:6], expected[3:6], rtol=1e-12)
    y, y_still = plain_configuration.outputs(x, blown), plain_configuration.outputs(POINT_A.x, still)
    np.testing.assert_allclose(np.delete(y, [6, 7]), np.delete(y_still, [6, 7]), rtol=1e-11)
    np.testing.assert_allclose(xdot[8], expected[8] - wind[2], rtol=1e-12)


def test_stall_asymmetry():
    """The corners of SPEC 5.6, half way between them, and nothing outside; off unless asked for."""
    values = [
        plain_configuration.stall_roll(*angles) for angles in ((13.5, 0), (13, -1), (14, 1.5), (15, 0), (13.5, 2))
    ]
    np.testing.assert_allclose(values, [0.01, 0.005, 0.0025, 0, 0], atol=1e-17)
    x = plain_model.steady_state(5000, 150, 0, 0, np.radians(13), 0, 0)
    off, on = (
        plain_configuration.coefficients(x, Configuration(allocated(POINT_A.u), stall_asymmetry=switch))
        for switch in (False, True)
    )
    np.testing.assert_allclose(on - off, [0, 0, 0, 0.005, 0, 0], atol=1e-12)


def test_an_engine_switched_off_gives_nothing():
    x = POINT_A.x
    both, left, none = (
        plain_configuration.outputs(x, Configuration(allocated(POINT_A.u), engines_on=on))[11:]
        for on in ((True, True), (True, False), (False, False))
    )
    np.testing.assert_array_equal(left, both * [1, 0, 1, 0])
    np.testing.assert_array_equal(none, np.zeros(4))


@pytest.mark.parametrize(
    ("signal", "position", "command", "rate"),
    [
        ("ELLOB", 0, 5, 50 * np.pi),
        ("ELLOB", 0, -5, -50 * np.pi),
        ("ELRIB", 0, 9.5, 95 * np.pi),
        ("ELRIB", 0, 9.6, 300),
        ("AILL", 10, -10, -300),
        ("ELLIB", 20, 25, 0),
        ("ELLIB", 19.9, 25, 51 * np.pi),
        ("ELLIB", -30, -31, 0),
        ("AILR", 20, 19, -10 * np.pi),
        ("RUDU", 29, 31, 20 * np.pi),
        ("SPLLIB", 15, 16, 0),
        ("SPLROB", 15, 16, 10 * np.pi),
        ("SPLROB", 0, -1, 0),
        ("FLAPLOB", 30, 31, 0),
        ("STEER", 0, 4, 80 * np.pi),
        ("STEER", 30, 31, 0),
    ],
)
def test_servo_rates(signal, position, command, rate):
    assert plain_actuators.servo_rate(signal, position, command) == pytest.approx(rate, rel=1e-14)


def test_throttle_lag():
    """Unit gain at rest; after a step 0 to 100 the printed dip and overshoot, and the exact response."""
    assert plain_actuators.throttle_lag_output(plain_actuators.throttle_lag_start(70)) == pytest.approx(70, rel=1e-15)
    np.testing.assert_allclose(
        plain_actuators.throttle_lag_rate(plain_actuators.throttle_lag_start(70), 70), 0, atol=1e-13
    )
    t = np.linspace(0, 12, 1201)
    start = plain_actuators.throttle_lag_start(0)
    run = solve_ivp(lambda _, z: plain_actuators.throttle_lag_rate(z, 100), (0, 12), start, t_eval=t, rtol=1e-10)
    y = np.array([plain_actuators.throttle_lag_output(z) for z in run.y.T])
    assert_as_printed(y.min(), "-1.3")
    assert_as_printed(y.max(), "102")
    A = np.array([[-1.336, -0.7314], [1, 0]])  # the system of SPEC 10.2: z = (I - exp(A t)) z(settled)
    exact = [(np.array([-0.1474, 0.7314]) @ (np.eye(2) - expm(A * time)))[1] * 100 / 0.7314 for time in t]
    np.testing.assert_allclose(y, exact, atol=1e-6)


def test_fuel_flow_and_exhaust_temperature():
    """Worked by hand at 0 and 100 % rotor speed."""
    assert plain_actuators.fuel_flow(0) == pytest.approx(0.12217850149775, rel=1e-14)
    assert plain_actuators.fuel_flow(100) == pytest.approx(0.51225336771705, rel=1e-13)
    assert plain_actuators.fuel_used_rate((100, 0)) == pytest.approx(0.6344318692148 / 60, rel=1e-13)
    assert plain_actuators.fuel_used_rate((100, 0), (True, False)) == pytest.approx(0.51225336771705 / 60, rel=1e-13)
    assert plain_actuators.exhaust_temperature(0) == 664.99
    assert plain_actuators.exhaust_temperature(100) == pytest.approx(602.03, rel=1e-13)
