"""The compiled core against the plain NumPy model, against SPEC 13, and its exact Jacobians against differences."""

import ctypes
from collections import Counter
from itertools import product

import numpy as np
import pytest

from gtm_fmu import core
from gtm_fmu.airframe.names import CONTROLS, OUTPUTS, STATES
from gtm_fmu.core.library import library_path
from tests.reference import plain_model, spec_values

pytestmark = pytest.mark.slow

ALTITUDE = STATES.index("altitude")


def random_points(count, seed, alpha_deg=(-5, 30), beta_deg=(-30, 30), theta_limit_deg=80):
    """States at 0..36089 ft, by default over alpha -5..30, beta +-30 deg; controls to beyond their limits."""
    rng = np.random.default_rng(seed)
    low, high = np.array([alpha_deg, beta_deg]).T
    alpha, beta = np.radians(rng.uniform(low, high, (count, 2))).T
    V = rng.uniform(30, 350, count)
    direction = np.array([np.cos(alpha) * np.cos(beta), np.sin(beta), np.sin(alpha) * np.cos(beta)]).T
    rates = rng.uniform(-1, 1, (count, 3)) * [16, 6, 5]
    position = rng.uniform([-1.4, -3.1, 0], [1.4, 3.1, 36089], (count, 3))
    theta_limit = np.radians(theta_limit_deg)
    attitude = rng.uniform([-3.1, -theta_limit, 0], [3.1, theta_limit, 6.2], (count, 3))
    x = np.hstack([V[:, None] * direction, rates, position, attitude])
    u = rng.uniform([-35, -35, -35, -5], [35, 35, 35, 105], (count, 4))
    return x, u


@pytest.fixture(scope="module")
def points():
    return random_points(2000, seed=1)


def rate_split(x):
    air = plain_model.air_data(x)
    split = plain_model.kalviste_split(air.alpha, air.beta, *x[3:6])
    return split, plain_model.normalised_rates(split, air.tas)


def plain_model_rows(function, x, u):
    return np.array([function(*row) for row in zip(x, u, strict=True)])


def test_random_points_visit_every_branch(points):
    """All three cases of the rate split with both signs, the limits of the rotary rate, thrust stuck at 0 and not."""
    x, u = points
    visits: Counter[tuple] = Counter()
    for split, rates in map(rate_split, x):
        visits[split.case, np.sign(split.p if split.case == 3 else split.omega)] += 1
        visits["limited", np.sign(rates.omega_hat)] += abs(rates.omega_hat) == 0.5
    visits.update(("thrust", thrust > 0) for thrust in core.outputs(x, u)[:, OUTPUTS.index("thrust_left")])
    branches = [*product((1, 2, 3), (-1, 1)), ("limited", -1), ("limited", 1), ("thrust", True), ("thrust", False)]
    assert min(visits[branch] for branch in branches) > 20, visits


def largest_difference(value, expected):
    """Relative to the larger of |expected| and 1 (or the column's largest value where that is below 1)."""
    floor = np.minimum(1, np.abs(expected).max(axis=0))
    return np.max(np.abs(value - expected) / np.maximum(floor, np.abs(expected)))


def assert_core_is_the_plain_model(x, u):
    for name in ("derivatives", "outputs"):
        expected = plain_model_rows(getattr(plain_model, name), x, u)
        assert largest_difference(getattr(core, name)(x, u), expected) < 1e-10


def test_core_is_the_plain_model(points):
    assert_core_is_the_plain_model(*points)


def test_core_is_the_plain_model_beyond_the_tables():
    """Every direction of flight, also backwards; deflections far outside: the end intervals extrapolate (SPEC 1)."""
    x, u = random_points(500, seed=3, alpha_deg=(-180, 180), beta_deg=(-89, 89))
    assert_core_is_the_plain_model(x, 2 * u)


@pytest.mark.parametrize("altitude_ft", [-1500.0, 0.0, 36089.0, 36500.0, 60000.0])
def test_core_is_the_plain_model_beyond_the_first_layer(altitude_ft, points):
    """Above and below the first layer the atmosphere stays at the limit (SPEC 2)."""
    x, u = points[0][:50].copy(), points[1][:50]
    x[:, ALTITUDE] = altitude_ft
    assert_core_is_the_plain_model(x, u)


def changed(**values):
    """Test point A with some states changed."""
    x = spec_values.POINT_A.x.copy()
    for name, value in values.items():
        x[STATES.index(name)] = value
    return x


def test_core_is_the_plain_model_where_terms_vanish():
    """No rate, no incidence, hardly any speed, deflections at breakpoints: terms of SPEC 5.5 drop out, none is 0/0."""
    states = (
        {"p": 0.0},
        {"r": 0.0},
        {"p": 0.0, "q": 0.0, "r": 0.0},
        {"v": 0.0},
        {"w": 0.0},
        {"w": 0.0, "p": 0.0},
        {"w": 0.0, "r": 0.0},
        {"v": 0.0, "w": 0.0, "p": 0.0, "q": 0.0, "r": 0.0, "phi": 0.0, "theta": 0.0, "psi": 0.0},
        {"u": 0.0},
        {"u": 1.2, "v": 0.1, "w": 0.1},
    )
    controls = ([0.0, 0, 0, 0], [10.0, 10, 10, 100], [-30.0, -20, -30, 50])
    points = product((changed(**state) for state in states), controls)
    x, u = (np.array(rows) for rows in zip(*points, strict=True))
    assert_core_is_the_plain_model(x, u)
    for jacobian in (core.jacobian, core.outputs_jacobian):
        assert np.all(np.isfinite(jacobian(x, u)[1]))


@pytest.mark.parametrize("point", [spec_values.POINT_A, spec_values.POINT_B], ids=["A", "B"])
def test_derivatives_at_the_specified_points(point):
    np.testing.assert_allclose(core.derivatives(point.x, point.u), point.xdot, rtol=1e-9, atol=0)


def test_outputs_at_the_specified_point():
    point = spec_values.POINT_A
    outputs = dict(zip(OUTPUTS, core.outputs(point.x, point.u), strict=True))
    for name, printed in spec_values.POINT_A_OUTPUTS.items():
        assert abs(outputs[name] / float(printed) - 1) < 1e-9


# ft/s, rad/s, rad, ft, rad, deg, %
STEPS = np.array([0.02] * 3 + [1e-3] * 3 + [1e-3, 1e-3, 5.0] + [1e-3] * 3 + [0.02] * 3 + [0.1])


def cell(x, u):
    """Everything that is constant where the airframe is smooth: table intervals, case, signs and limits in force."""
    tables = plain_model.airframe_tables()
    air, (split, rates) = plain_model.air_data(x), rate_split(x)
    alpha, beta = np.degrees([air.alpha, air.beta])
    elevator, aileron, rudder, throttle = u
    arguments = {
        "C6_bas": (alpha, beta),
        "dC6_rud": (alpha, beta, -abs(rudder)),
        "dC6_ail": (alpha, beta, aileron),
        "dC3_ele": (alpha, beta, 0.0, elevator),
        "dC3_p": (alpha, rates.p_hat),
        "dC3_q": (alpha, rates.q_hat),
        "dC3_r": (alpha, rates.r_hat),
        "dC6_w": (alpha, rates.omega_hat, beta),
    }
    intervals = [
        plain_model.interval(breakpoints, argument)
        for name, values in arguments.items()
        for breakpoints, argument in zip(tables[name].axes, values, strict=True)
    ]
    has_thrust = plain_model.thrust(throttle, air.pressure_ratio, air.qbar) > 0
    return (*intervals, split.case, abs(rates.omega_hat) == 0.5, rudder >= 0, has_thrust)


def derivatives_and_outputs(x, u):
    return np.concatenate([plain_model.derivatives(x, u), plain_model.outputs(x, u)])


def central_differences(x, u):
    """Jacobian (27, 16) of `derivatives_and_outputs` by Richardson's rule; None where a point leaves the cell."""
    z, columns = np.concatenate([x, u]), []
    for step in np.diag(STEPS):
        coarse, fine = ([((z + h)[:12], (z + h)[12:]), ((z - h)[:12], (z - h)[12:])] for h in (step, step / 2))
        if len({cell(*point) for point in coarse}) > 1:
            return None
        slopes = [
            (derivatives_and_outputs(*ahead) - derivatives_and_outputs(*behind)) / h
            for (ahead, behind), h in ((coarse, 2 * step.max()), (fine, step.max()))
        ]
        columns.append((4 * slopes[1] - slopes[0]) / 3)
    return np.array(columns).T


def test_jacobians_are_the_differences_of_the_plain_model():
    """Away from kinks: table intervals, case, signs and limits are the same on both sides of every difference.

    Richardson's rule leaves an error of the fourth order in the step, under 1e-8 of the entry at these steps (1e-3 of
    the scale on which the model turns), and the rounding of the values over the step: 5e-14 of the row's largest.
    """
    x, u = random_points(120, seed=2, theta_limit_deg=60)
    dx, derivative_slopes = core.jacobian(x, u)
    y, output_slopes = core.outputs_jacobian(x, u)
    np.testing.assert_allclose(dx, core.derivatives(x, u), rtol=1e-13, atol=1e-13)
    np.testing.assert_allclose(y, core.outputs(x, u), rtol=1e-13, atol=1e-13)
    exact = np.concatenate([derivative_slopes, output_slopes], axis=1)
    assert exact.shape == (len(x), len(STATES) + len(OUTPUTS), len(STATES) + len(CONTROLS))

    differences = [central_differences(*point) for point in zip(x, u, strict=True)]
    smooth = [i for i, slopes in enumerate(differences) if slopes is not None]
    assert len(smooth) > 90
    expected = np.array([differences[i] for i in smooth])
    rounding = 5e-14 * np.abs(np.concatenate([dx, y], axis=1)).max(axis=0)[:, None] / STEPS
    assert np.all(np.abs(exact[smooth] - expected) <= 1e-8 * np.abs(expected) + rounding)


@pytest.mark.parametrize(
    ("name", "breakpoint_"),
    [
        ("v", 0.0),
        ("q", 0.0),
        ("elevator", 10.0),
        ("elevator", -20.0),
        ("aileron", 10.0),
        ("rudder", 0.0),
        ("rudder", 10.0),
    ],
)
def test_jacobian_at_a_breakpoint_is_that_of_the_interval_above(name, breakpoint_):
    """The side that the header of the core promises; the slope below is another one."""
    x, u = changed(p=0.0, r=0.0), np.array([-5.0, 5.0, 5.0, 50.0])
    z, j = np.concatenate([x, u]), (*STATES, *CONTROLS).index(name)
    slopes = []
    for z[j] in (breakpoint_, breakpoint_ + 1e-7, breakpoint_ - 1e-7):
        slopes.append(core.jacobian(z[:12], z[12:])[1][:6, j])
    at, above, below = slopes
    np.testing.assert_allclose(at, above, rtol=1e-5, atol=1e-7)
    assert np.max(np.abs(at - below)) > 1e-3


def pointer(array):
    return array.ctypes.data_as(ctypes.POINTER(ctypes.c_double))


def test_batches_give_the_bits_of_single_calls(points):
    """The C functions for one row against those for many, and arrays of any leading shape."""
    x, u = (np.ascontiguousarray(rows[:240]) for rows in points)
    library = ctypes.CDLL(str(library_path()))
    dx, y, dx_too, jacobian = np.empty((240, 12)), np.empty((240, 15)), np.empty((240, 12)), np.empty((240, 12, 16))
    for i in range(240):
        library.gtm_derivatives(pointer(x[i]), pointer(u[i]), pointer(dx[i]))
        library.gtm_outputs(pointer(x[i]), pointer(u[i]), pointer(y[i]))
        library.gtm_jacobian(pointer(x[i]), pointer(u[i]), pointer(dx_too[i]), pointer(jacobian[i]))
    x, u = x.reshape(4, 60, 12), u.reshape(4, 60, 4)
    np.testing.assert_array_equal(core.derivatives(x, u).reshape(dx.shape), dx)
    np.testing.assert_array_equal(core.outputs(x, u).reshape(y.shape), y)
    np.testing.assert_array_equal(core.jacobian(x, u)[0].reshape(dx.shape), dx_too)
    np.testing.assert_array_equal(core.jacobian(x, u)[1].reshape(jacobian.shape), jacobian)


@pytest.mark.parametrize(
    ("fault", "x"),
    [
        (0, changed()),
        (0, changed(u=1.0, v=0.0, w=0.0)),
        (0, changed(u=-150.0)),
        (0, changed(theta=np.radians(89.9))),
        (0, changed(latitude=np.radians(-89.9))),
        *((1, changed(**{name: value})) for name in STATES for value in (np.nan, np.inf, -np.inf)),
        (2, changed(u=0.0, v=0.0, w=0.0)),
        (2, changed(u=0.5, v=-0.5, w=0.5)),
        (3, changed(u=0.0, w=0.0, v=150.0)),
        (3, changed(u=0.0, w=0.0, v=-150.0)),
        (4, changed(theta=np.pi / 2)),
        (4, changed(theta=-np.pi / 2)),
        (5, changed(latitude=np.pi / 2)),
        (5, changed(latitude=-np.pi / 2)),
    ],
)
def test_state_faults(fault, x):
    assert core.state_fault(x) == fault
    if fault == 0:
        assert np.all(np.isfinite(core.derivatives(x, spec_values.POINT_A.u)))


def test_a_random_state_has_no_fault(points):
    assert not any(core.state_fault(x) for x in points[0])


def runge_kutta(x, u, steps):
    """The classical method on the plain model."""
    for h in steps:
        k1 = plain_model.derivatives(x, u)
        k2 = plain_model.derivatives(x + h / 2 * k1, u)
        k3 = plain_model.derivatives(x + h / 2 * k2, u)
        k4 = plain_model.derivatives(x + h * k3, u)
        x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return x


def test_advance_is_runge_kutta_with_a_shortened_last_step():
    point = spec_values.POINT_A
    expected = runge_kutta(point.x, point.u, [0.02] * 12 + [0.01])
    assert largest_difference(core.advance(point.x, point.u, 0.25, 0.02), expected) < 1e-10


@pytest.mark.parametrize(("duration", "substep"), [(5001, 0.005), (1e300, 0.1), (-1, 0.1), (1, 0), (np.nan, 0.1)])
def test_advance_refuses_what_it_cannot_do_in_time(duration, substep):
    point = spec_values.POINT_A
    with pytest.raises(ValueError, match=r"give positive numbers, and 1000000 steps at most"):
        core.advance(point.x, point.u, duration, substep)


def test_advance_stops_at_a_state_without_derivatives():
    """Straight up at 2 ft/s: the speed is lost within the second, and then the call says so."""
    x = changed(u=2.0, v=0.0, w=0.0, p=0.0, q=0.0, r=0.0, phi=0.0, theta=1.5)
    with pytest.raises(FloatingPointError, match="fault 2"):
        core.advance(x, np.zeros(4), 1.0, 0.005)
