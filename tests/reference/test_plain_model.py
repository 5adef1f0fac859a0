"""The plain model against what is printed in SPEC 13 and 3, and against NASA's published level trims."""

import numpy as np
import pytest
from scipy.optimize import root

from gtm_fmu.airframe.names import OUTPUTS
from gtm_study.paper import nasa_comparison
from tests.reference import plain_model, spec_values
from tests.reference.spec_values import TRIMS, Trim, assert_as_printed, half_unit, numbers

NASA_PLOTS = nasa_comparison.READINGS
POINTS = {"A": spec_values.POINT_A, "B": spec_values.POINT_B}


@pytest.mark.parametrize("name", POINTS)
def test_derivatives_at_the_test_points(name, tables):
    point = POINTS[name]
    np.testing.assert_allclose(plain_model.derivatives(point.x, point.u, tables), point.xdot, rtol=1e-12)


def test_coefficients_at_point_a(tables):
    point = spec_values.POINT_A
    coefficients = plain_model.coefficients(point.x, point.u, tables)
    for value, printed in zip(coefficients, spec_values.POINT_A_COEFFICIENTS.split(), strict=True):
        assert_as_printed(value, printed)


def test_outputs_at_point_a():
    point = spec_values.POINT_A
    values = dict(zip(OUTPUTS, plain_model.outputs(point.x, point.u), strict=True))
    for name, printed in spec_values.POINT_A_OUTPUTS.items():
        assert_as_printed(values[name], printed)
    air = plain_model.atmosphere(point.x[8])
    assert_as_printed(air.density, spec_values.POINT_A_DENSITY)
    assert_as_printed(air.pressure_ratio, spec_values.POINT_A_PRESSURE_RATIO)
    assert_as_printed(plain_model.angular_momentum(point.u[3]), spec_values.POINT_A_ANGULAR_MOMENTUM)


@pytest.mark.parametrize("row", spec_values.ATMOSPHERE, ids=lambda row: f"{row.h} ft")
def test_atmosphere_and_static_thrust(row):
    air = plain_model.atmosphere(row.h)
    assert_as_printed(air.density, row.density)
    assert_as_printed(air.pressure_ratio, row.pressure_ratio)
    for throttle, printed in zip((0, 50, 100), row.thrust, strict=True):
        assert_as_printed(plain_model.thrust(throttle, air.pressure_ratio, qbar=0.0), printed)


def test_mass_and_inertia():
    assert_as_printed(plain_model.MASS, spec_values.MASS)
    for name, value in zip(("Ixx", "Iyy", "Izz"), plain_model.INERTIAS[:3], strict=True):
        assert_as_printed(value, spec_values.INERTIA[name])


def solve_trim(h, gamma, held, start):
    """V (ft/s), alpha, beta, phi, psi_dot (deg, deg/s) and the controls of a trim; `start` names the unknowns."""

    def accelerations(unknowns):
        y = {**held, **dict(zip(start, unknowns, strict=True))}
        x = plain_model.steady_state(h, y["V"], *np.radians([gamma, y["psi_dot"], y["alpha"], y["beta"], y["phi"]]))
        return plain_model.derivatives(x, [y[name] for name in ("elevator", "aileron", "rudder", "throttle")])[:6]

    solution = root(accelerations, list(start.values()), options={"xtol": 1e-13})
    assert np.abs(solution.fun).max() < 1e-9, f"no trim found: {solution.message}"
    return {**held, **dict(zip(start, solution.x, strict=True))}


def speed(eas, h):
    """V in ft/s of an equivalent airspeed in kn."""
    return eas / plain_model.KT_PER_FT_S / plain_model.atmosphere(h).root_density_ratio


@pytest.mark.parametrize("trim", TRIMS, ids=lambda trim: trim.name)
def test_trims_to_the_printed_digits(trim: Trim):
    """Solved from a start well away; within one last digit, as two of the printed numbers miss by 0.6 and 0.7 of it."""
    names = ("alpha", "beta", "phi", "elevator", "aileron", "rudder", "throttle", "V")
    printed = {name: getattr(trim, name) for name in names}
    y = {name: float(value) for name, value in printed.items()}
    if trim.psi_dot is not None:
        y["psi_dot"] = trim.psi_dot
    if trim.eas is not None:
        y["V"] = speed(trim.eas, trim.h)
        assert_as_printed(y["V"], trim.V)
    away = dict(zip(names, (0.7, 1.0, 2.0, -1.0, 1.5, 1.0, 6.0, 5.0), strict=True))
    start = {name: y[name] + away[name] if name in away else 5.0 for name in trim.free}

    solved = solve_trim(trim.h, trim.gamma, {name: y[name] for name in y if name not in trim.free}, start)

    for name in trim.free:
        if name in printed:
            assert_as_printed(solved[name], printed[name])


def test_spin_is_a_trim_to_the_printed_digits():
    """The six accelerations at the printed spin are what the rounding of its digits can leave (about 1e-5 ft/s^2)."""
    spin = spec_values.SPIN
    elevator, aileron, rudder, throttle = spin.u
    printed = (elevator, aileron, spin.eas, spin.alpha, spin.beta, *spin.rates, spin.phi, spin.theta)

    def state(values):
        eas, alpha, beta, *angles = values[2:]
        alpha, beta, p, q, r, phi, theta = np.radians([alpha, beta, *angles])
        direction = np.array([np.cos(alpha) * np.cos(beta), np.sin(beta), np.sin(alpha) * np.cos(beta)])
        return np.array([*speed(eas, spin.h) * direction, p, q, r, 0, 0, spin.h, phi, theta, 0])

    def accelerations(values):  # rudder and throttle are at their limits, so their printed values are exact
        return plain_model.derivatives(state(values), [values[0], values[1], float(rudder), float(throttle)])[:6]

    values = np.array([float(text) for text in printed])
    errors = np.array([half_unit(text) for text in printed])
    slopes = np.array(
        [(accelerations(values + d) - accelerations(values - d)) / 2e-5 for d in 1e-5 * np.eye(len(values))]
    ).T
    bound = np.abs(slopes) @ errors

    assert np.all(bound < 5e-5)
    assert np.all(np.abs(accelerations(values)) <= bound)
    x = state(values)
    assert plain_model.kalviste_split(np.arctan2(x[2], x[0]), np.radians(values[4]), *x[3:6]).case == 1
    gamma = plain_model.outputs(x, numbers(" ".join(spin.u)))[OUTPUTS.index("gamma")]
    assert abs(gamma - float(spin.gamma)) < 2e-6


def read_plot(name):
    """The readings of one published plot; nan where a marker is hidden."""
    return np.genfromtxt(NASA_PLOTS / name, delimiter=",", names=True)


def solve_level_trim(held, start):
    """Level flight at 800 ft, as on every published plot."""
    return solve_trim(
        800, 0, {"beta": 0.0, "psi_dot": 0.0, **held}, {"phi": 0.0, "aileron": 0.0, "rudder": 0.0, **start}
    )


def assert_as_read(value, reading, error):
    """Within the reading error of the plot, where there is a reading."""
    assert np.isnan(reading) or abs(value - reading) <= error, f"{value} was read as {reading}"


@pytest.mark.parametrize("row", read_plot("level_trim_vs_eas.csv"), ids=lambda row: f"eas {row['eas_kt']:.0f}")
def test_published_level_trims_over_airspeed(row):
    alpha = 3.0 if np.isnan(row["alpha_deg"]) else row["alpha_deg"]
    start = {"alpha": alpha, "elevator": row["elevator_deg"], "throttle": row["throttle_pct"]}
    trim = solve_level_trim({"V": speed(row["eas_kt"], 800)}, start)
    assert_as_read(trim["alpha"], row["alpha_deg"], 0.1)
    assert_as_read(trim["elevator"], row["elevator_deg"], 0.1)
    assert_as_read(trim["throttle"], row["throttle_pct"], 0.15)


@pytest.mark.parametrize("row", read_plot("level_trim_vs_alpha.csv"), ids=lambda row: f"alpha {row['alpha_deg']:.0f}")
def test_published_level_trims_over_angle_of_attack(row):
    eas = 54.0 if np.isnan(row["eas_kt"]) else row["eas_kt"]
    start = {"V": speed(eas, 800), "elevator": row["elevator_deg"], "throttle": row["throttle_pct"]}
    trim = solve_level_trim({"alpha": row["alpha_deg"]}, start)
    assert_as_read(trim["V"], speed(row["eas_kt"], 800), speed(0.1, 800))
    assert_as_read(trim["elevator"], row["elevator_deg"], 0.1)
    assert_as_read(trim["throttle"], row["throttle_pct"], 0.15)
