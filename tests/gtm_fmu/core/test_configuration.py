"""Every configuration of the compiled core against SPEC 13, the study's core and relations in closed form."""

import ctypes
import pickle
from dataclasses import fields, replace

import numpy as np
import pytest

from gtm_fmu.airframe.configuration import RANGES
from gtm_fmu.airframe.damage import DAMAGE_CASES
from gtm_fmu.airframe.names import OUTPUTS, STATES, TWO_THROTTLE_CONTROLS, TWO_THROTTLE_UNKNOWNS
from gtm_fmu.airframe.surfaces import ALLOCATION, COMMANDED, FLAPS, SIGNALS, SPOILERS
from gtm_fmu.core import configuration as configured
from gtm_fmu.core import motion
from gtm_fmu.core.configuration import Configuration
from gtm_fmu.core.library import library
from gtm_fmu.errors import InputError
from tests.gtm_fmu.core.test_core_against_plain_model import random_points
from tests.reference import plain_configuration, spec_values
from tests.reference.spec_values import POINT_A, POINT_C, assert_as_printed

ELEVATOR = len(STATES)
NEAR_ZERO_DEG = 1e-14
"""A stabiliser setting that leads to the tables that are not folded, and moves nothing."""


def apart(u):
    """Controls (.., 4) with a throttle for each engine."""
    return np.concatenate([u, u[..., -1:]], axis=-1)


def point_c(damage_case):
    """Test point C (SPEC 13): no surface follows a command."""
    bus = POINT_C.bus
    return Configuration(
        damage_case=damage_case,
        fuel_used_lb=POINT_C.fuel_used,
        stabilizer_deg=bus["STAB"],
        gear=bus["GEAR"],
        spoiler_deg=tuple(bus[name] for name in SPOILERS),
        flap_deg=tuple(bus[name] for name in FLAPS),
        surface_gain=(0,) * len(COMMANDED),
        surface_offset_deg=tuple(bus[name] for name in COMMANDED),
        wind_ft_s=POINT_C.wind[:3],
        gust_ft_s=POINT_C.wind[3:],
    )


def assert_all_as_printed(values, printed, half_units=1):
    for value, text in zip(values, printed.split(), strict=True):
        assert_as_printed(value, text, half_units)


def assert_agrees(value, expected, tolerance):
    """Rows (n, k) or Jacobians (n, k, m), relative to |expected| or to the largest of its k-th row if that is more."""
    largest = np.abs(expected).max(axis=(0, *range(2, np.ndim(expected))), keepdims=True)
    assert np.all(np.abs(value - expected) <= tolerance * np.maximum(np.abs(expected), largest))


SETTINGS = {
    "study": Configuration(),
    **{
        f"damage {case}": Configuration(
            damage_case=case,
            fuel_used_lb=1.5 * case,
            stabilizer_deg=-9.0 + 2 * case,
            gear=case % 2,
            spoiler_deg=(3.0 * case, 0.0, 20.0, 50.0 - case),
            flap_deg=(5.0, 6.0, 7.0, 8.0),
            surface_gain=(1, 0.9, 1, 0.8, 1, 0.7, 0.6, 0),
            surface_offset_deg=(0, 1, 2, 0, 0, -3, 4, -12),
            engine_running=(True, case != 3),
            wind_ft_s=(8, -9, 3),
            gust_ft_s=(1, -2, 1.5),
            has_shear=case != 2,
            has_stall_asymmetry=case > 3,
        )
        for case in range(7)
    },
}


def random_manoeuvres(count, seed):
    """Altitude in ft, gamma in rad and unknowns y (count, 10), on the trim manifold or not."""
    rng = np.random.default_rng(seed)
    low = [80, -0.08, -0.3, -0.4, -0.6, -30, -20, -30, 0, 0]
    high = [340, 0.3, 0.3, 0.4, 0.6, 30, 20, 30, 100, 100]
    return rng.uniform(0, 30000, count), rng.uniform(-0.15, 0.15, count), rng.uniform(low, high, (count, 10))


@pytest.mark.parametrize("case", spec_values.POINT_A_DAMAGED)
def test_damage_at_point_a(case):
    dx = configured.derivatives(POINT_A.x, apart(POINT_A.u), Configuration(damage_case=case))
    assert_all_as_printed(dx[:6], spec_values.POINT_A_DAMAGED[case])


@pytest.mark.parametrize("case", spec_values.POINT_C_ACCELERATIONS)
def test_accelerations_at_point_c(case):
    u = [7, 8, 9, POINT_C.bus["THROTL"], POINT_C.bus["THROTR"]]  # the first three move nothing
    dx = configured.derivatives(POINT_C.x, u, point_c(case))
    assert_all_as_printed(dx[:6], spec_values.POINT_C_ACCELERATIONS[case])


def test_mass_at_point_c():
    mass, cg, inertia = point_c(6).mass_properties
    assert_as_printed(mass, spec_values.POINT_C_MASS)
    assert_all_as_printed(cg, spec_values.POINT_C_CG)
    assert_all_as_printed(inertia, spec_values.POINT_C_INERTIAS)


def test_wind_at_point_c():
    """The second component is printed with its last digit rounded twice (see the plain model's test)."""
    assert_all_as_printed(configured.wind_body(POINT_C.x, point_c(0)), spec_values.POINT_C_WIND_BODY)
    steady = configured.wind_body(POINT_C.x, replace(point_c(0), gust_ft_s=(0, 0, 0)))
    gain = np.linalg.norm(steady) / np.linalg.norm(POINT_C.wind[:3])
    assert_as_printed(gain, spec_values.POINT_C_SHEAR_GAIN)


def test_signals_and_lost_surfaces_are_those_of_the_plain_model():
    assert SIGNALS == plain_configuration.SIGNALS
    assert [case.lost for case in DAMAGE_CASES] == [case.lost for case in plain_configuration.DAMAGE.values()]


@pytest.mark.parametrize("stabilizer_deg", [0.0, NEAR_ZERO_DEG], ids=["folded", "unfolded"])
def test_the_default_configuration_is_the_study(stabilizer_deg):
    """Through the folded tables and through the others, at random states and where slopes are one-sided."""
    configuration = Configuration(stabilizer_deg=stabilizer_deg)
    x, u = random_points(2000, seed=21)
    x[:20, STATES.index("v")] = 0  # beta = 0, a breakpoint
    u[:60, :3] = np.round(u[:60, :3], -1)  # breakpoints of every surface, 0 too
    for name in ("jacobian", "outputs_jacobian"):
        value, slopes = getattr(configured, name)(x, apart(u), configuration)
        expected, expected_slopes = getattr(motion, name)(x, u)
        both = np.concatenate([slopes[..., :-2], slopes[..., -2:].sum(axis=-1, keepdims=True)], axis=-1)
        assert_agrees(value, expected, 1e-12)
        assert_agrees(both, expected_slopes, 1e-12)
    assert_agrees(configured.derivatives(x, apart(u), configuration), motion.derivatives(x, u), 1e-12)
    assert_agrees(configured.outputs(x, apart(u), configuration), motion.outputs(x, u), 1e-12)


def test_the_default_of_the_core_is_the_default_of_the_binding():
    size = library().gtm_configuration_size()
    default = ctypes.create_string_buffer(size)
    library().gtm_study_configuration(default)
    struct = configured._struct(Configuration())
    for field in fields(Configuration):
        expected, value = (getattr(each, field.name) for each in (struct, configured._Struct.from_buffer(default)))
        assert np.array_equal(expected, value), field.name


def test_a_trim_of_the_study_takes_the_folded_tables():
    """Accelerations of the study's own core at the state of the manoeuvre."""
    altitude, gamma, y = random_manoeuvres(300, seed=25)
    y[:, -1] = y[:, -2]
    F = configured.trim_residual(y, altitude, gamma, Configuration())
    for row, *at in zip(F, altitude, gamma, y, strict=True):
        x, u = configured.trim_state(*at, Configuration())
        np.testing.assert_allclose(row, motion.derivatives(x, u[:4])[:6], rtol=1e-11, atol=1e-11)


@pytest.mark.parametrize("name", SETTINGS)
def test_trim_residuals_are_accelerations_relative_to_the_air(name):
    """Velocity relative to the air is (u, v, w) - w_b, and a steady wind turns in body axes: dw_b/dt = -omega x w_b."""
    configuration = SETTINGS[name]
    altitude, gamma, y = random_manoeuvres(50, seed=26)
    F = configured.trim_residual(y, altitude, gamma, configuration)
    for row, *at in zip(F, altitude, gamma, y, strict=True):
        x, u = configured.trim_state(*at, configuration)
        outputs = dict(zip(OUTPUTS, configured.outputs(x, u, configuration), strict=True))
        assert outputs["tas"] == pytest.approx(at[2][0] * 0.592487)
        assert outputs["alpha"] == pytest.approx(np.degrees(at[2][1]), abs=1e-9)
        dx = configured.derivatives(x, u, configuration)[:6]
        dx[:3] += np.cross(x[3:6], configured.wind_body(x, configuration))
        np.testing.assert_allclose(row, dx, rtol=1e-10, atol=1e-10)


def test_a_trim_state_in_still_air_flies_along_gamma():
    altitude, gamma, y = 5000.0, 0.05, np.array([180, 0.05, 0.02, 0.1, 0.2, 1, 2, 3, 40, 60])
    x, u = configured.trim_state(altitude, gamma, y, Configuration(damage_case=4))
    outputs = dict(zip(OUTPUTS, configured.outputs(x, u, Configuration(damage_case=4)), strict=True))
    assert outputs["gamma"] == pytest.approx(np.degrees(gamma), abs=1e-9)
    dx = configured.derivatives(x, u, Configuration(damage_case=4))
    np.testing.assert_allclose(dx[[9, 10, 11]], [0, 0, 0.1], atol=1e-14)  # phi, theta constant; psi_dot as given
    np.testing.assert_array_equal(u, y[5:])


@pytest.mark.parametrize("case", range(7))
def test_gains_and_offsets_move_each_surface(case):
    """Position = gain * command with its sign + offset (SPEC 4): the same as jammed there."""
    x, u = random_points(60, seed=27)
    gain = np.linspace(0.3, 1, len(COMMANDED))
    offset = np.linspace(-8, 7, len(COMMANDED))
    moving = Configuration(damage_case=case, surface_gain=tuple(gain), surface_offset_deg=tuple(offset))
    for row, controls in zip(x, apart(u), strict=True):
        commands = [
            controls[TWO_THROTTLE_CONTROLS.index(ALLOCATION[name].command)] * ALLOCATION[name].sign
            for name in COMMANDED
        ]
        jammed = replace(moving, surface_gain=(0,) * 8, surface_offset_deg=tuple(gain * commands + offset))
        expected = configured.derivatives(row, controls, jammed)
        assert_agrees(configured.derivatives(row, controls, moving), expected, 1e-12)


def test_lost_surfaces_do_nothing():
    """The rudder is gone in cases 1 and 2; in case 4 only the right aileron rolls, so about half as well."""
    x, u = random_points(50, seed=28)
    slopes = {case: configured.jacobian(x, apart(u), Configuration(damage_case=case))[1] for case in range(7)}
    rudder, aileron = (ELEVATOR + TWO_THROTTLE_CONTROLS.index(name) for name in ("rudder", "aileron"))
    for case in range(7):
        assert np.any(slopes[case][:, :6, rudder]) == (case not in (1, 2))
    x, u = POINT_A.x, apart(np.zeros(4))
    roll = [configured.jacobian(x, u, Configuration(damage_case=case))[1][3, aileron] for case in (0, 4)]
    assert 0.3 < roll[1] / roll[0] < 0.8


@pytest.mark.parametrize("running", [(True, True), (False, True), (True, False), (False, False)])
def test_an_engine_that_is_off_gives_nothing(running):
    u, configuration = [0, 0, 0, 80, 60], Configuration(engine_running=running)
    outputs = configured.outputs(POINT_A.x, u, configuration)
    values = dict(zip(OUTPUTS, outputs, strict=True))
    for on, side in zip(running, ("left", "right"), strict=True):
        assert (values[f"thrust_{side}"] > 1) == (values[f"rotor_speed_{side}"] > 50) == on
        assert on or values[f"thrust_{side}"] == values[f"rotor_speed_{side}"] == 0
    assert (
        np.any(configured.jacobian(POINT_A.x, [0, 0, 0, 80, 60], Configuration(engine_running=running))[1][:6, 15])
        == running[0]
    )


def test_faults_are_those_of_the_motion_relative_to_the_air():
    x = POINT_A.x.copy()
    x[[1, 2, 9, 10, 11]] = 0.0
    tail = Configuration(wind_ft_s=(150, 0, 0), has_shear=False)
    assert configured.state_fault(x, tail) == 2
    assert configured.state_fault(x, Configuration()) == 0
    assert configured.state_fault(np.where(np.arange(12) == 10, np.pi / 2, x), Configuration()) == 4


def test_a_configuration_is_a_value():
    configuration = SETTINGS["damage 5"]
    again = pickle.loads(pickle.dumps(configuration))
    assert again == configuration
    assert hash(again) == hash(configuration)
    x, u = random_points(5, seed=29)
    np.testing.assert_array_equal(
        configured.derivatives(x, apart(u), again), configured.derivatives(x, apart(u), configuration)
    )


@pytest.mark.parametrize("name", RANGES)
def test_values_outside_their_range_are_refused(name):
    lowest, highest = RANGES[name]
    default = getattr(Configuration(), name)
    for value in (lowest - 0.01, highest + 0.01, np.nan, np.inf, -np.inf):
        given = (*default[:-1], value) if isinstance(default, tuple) else value
        with pytest.raises(InputError, match=rf"^{name} is .*; allowed are {lowest:g} \.\. {highest:g}\.$"):
            Configuration(**{name: given})
    for value in (lowest, highest):
        Configuration(**{name: (*default[:-1], value) if isinstance(default, tuple) else value})


@pytest.mark.parametrize(
    ("name", "value", "wanted"),
    [
        ("damage_case", 7, "allowed are 0 .. 6"),
        ("damage_case", -1, "allowed are 0 .. 6"),
        ("damage_case", 2**32, "allowed are 0 .. 6"),
        ("damage_case", 1.5, "give a whole number"),
        ("damage_case", "2", "give a whole number"),
        ("gear", "down", "give a number"),
        ("gear", None, "give a number"),
        ("flap_deg", 5.0, "give 4 values, each a number"),
        ("spoiler_deg", (1.0, 2.0), "give 4 values, each a number"),
        ("surface_gain", (1.0,) * 9, "give 8 values, each a number"),
        ("wind_ft_s", (1.0, "east", 0.0), "give 3 values, each a number"),
        ("engine_running", True, "give 2 values, each true or false"),
    ],
)
def test_values_of_the_wrong_kind_are_refused(name, value, wanted):
    with pytest.raises(InputError, match=f"^{name} is .*; {wanted}"):
        Configuration(**{name: value})


def test_arrays_of_any_leading_shape():
    x, u = random_points(24, seed=30)
    u, configuration = apart(u), SETTINGS["damage 2"]
    flat = configured.jacobian(x, u, configuration)[1]
    shaped = configured.jacobian(x.reshape(2, 3, 4, 12), u.reshape(2, 3, 4, 5), configuration)[1]
    np.testing.assert_array_equal(shaped.reshape(flat.shape), flat)
    np.testing.assert_array_equal(
        configured.derivatives(x, u[0], configuration)[7], configured.derivatives(x[7], u[0], configuration)
    )
    with pytest.raises(ValueError, match="u has shape"):
        configured.derivatives(x, u[:, :4], configuration)
    assert len(TWO_THROTTLE_UNKNOWNS) == 10
    with pytest.raises(ValueError, match="y has shape"):
        configured.trim_residual(np.zeros(9), 0.0, 0.0, configuration)
