"""Mass, centre of gravity and coefficients that are not what they should be: the equations of motion in closed form."""

from dataclasses import replace

import numpy as np
import pytest

from gtm_fmu import ControlLimits, Failure, envelope
from gtm_fmu.airframe.names import COEFFICIENTS
from gtm_fmu.core import configuration as configured
from gtm_fmu.core.configuration import Configuration
from gtm_fmu.core.slopes import TOLERANCES, tolerance_slopes
from gtm_fmu.errors import InputError
from gtm_fmu.trims import manoeuvre
from tests.gtm_fmu.core.test_configuration_against_plain_model import plain
from tests.reference import plain_configuration

GRAVITY = 32.17405  # ft/s^2 (SPEC 1)
S, CHORD, SPAN = 5.9018, 0.9153, 6.8488  # ft^2, ft, ft (SPEC 3)
REFERENCE = np.array([-(4.5462 + 0.25 * CHORD), 0.0, -0.9401])  # ft, of the moments (SPEC 3)
X = np.array([150.0, 12.0, 14.0, 0, 0, 0, 0, 0, 8000.0, 0.2, 0.1, 0])  # no rates: their products vanish
U = np.array([2.0, -5.0, 10.0, 60.0, 60.0])
AIRCRAFT = {"study": Configuration(), "damaged": Configuration(damage_case=5, fuel_used_lb=3.0, flap_deg=(4.0,) * 4)}


def loads(configuration: Configuration) -> tuple[np.ndarray, np.ndarray]:
    """Force (3) and moment (3) that the accelerations at X mean, with the mass and inertia of the configuration."""
    mass, _, (xx, yy, zz, xz, yz, xy) = configuration.mass_properties
    dx = configured.derivatives(X, U, configuration)
    phi, theta = X[9], X[10]
    down = np.array([-np.sin(theta), np.cos(theta) * np.sin(phi), np.cos(theta) * np.cos(phi)])
    inertia = np.array([[xx, -xy, -xz], [-xy, yy, -yz], [-xz, -yz, zz]])
    return mass * (dx[:3] - GRAVITY * down), inertia @ dx[3:6]


@pytest.fixture(params=AIRCRAFT)
def aircraft(request) -> Configuration:
    return AIRCRAFT[request.param]


def test_more_mass_and_inertia_under_the_same_loads(aircraft):
    heavier = replace(aircraft, mass_factor=1.1)
    assert heavier.mass_properties.mass == pytest.approx(1.1 * aircraft.mass_properties.mass, rel=1e-14)
    np.testing.assert_allclose(heavier.mass_properties.inertia, 1.1 * aircraft.mass_properties.inertia, rtol=1e-14)
    for ours, expected in zip(loads(heavier), loads(aircraft), strict=True):
        np.testing.assert_allclose(ours, expected, rtol=1e-11, atol=1e-11)


def test_the_moment_of_the_loads_about_a_centre_of_gravity_elsewhere(aircraft):
    offset = np.array([0.02, -0.01, 0.03])
    force, moment = loads(aircraft)
    moved = replace(aircraft, cg_offset_ft=tuple(offset))
    np.testing.assert_allclose(moved.mass_properties.cg, aircraft.mass_properties.cg + offset, atol=1e-14)
    np.testing.assert_allclose(loads(moved)[0], force, rtol=1e-11)
    np.testing.assert_allclose(loads(moved)[1], moment - np.cross(offset, force), rtol=1e-9, atol=1e-10)


@pytest.mark.parametrize("k", range(6), ids=COEFFICIENTS)
def test_a_coefficient_by_a_factor(aircraft, k):
    """Its part of the load (SPEC 5), by the plain model's coefficients; forces have a moment about the cg."""
    setting = plain(U, aircraft)
    C = plain_configuration.coefficients(X, setting)[k]
    pressure_area = plain_configuration.air_data(X, setting).qbar * S
    force, moment = np.zeros(3), np.zeros(3)
    if k < 3:
        force[k] = 0.2 * pressure_area * C
        moment = np.cross(REFERENCE - aircraft.mass_properties.cg, force)
    else:
        moment[k - 3] = 0.2 * pressure_area * (SPAN, CHORD, SPAN)[k - 3] * C
    changed = loads(replace(aircraft, coefficient_factor=tuple(1.2 if j == k else 1.0 for j in range(6))))
    for ours, before, more in zip(changed, loads(aircraft), (force, moment), strict=True):
        np.testing.assert_allclose(ours, before + more, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("aircraft", AIRCRAFT.values(), ids=AIRCRAFT)
def test_jacobians_have_the_factors_too(aircraft):
    changed = replace(
        aircraft, mass_factor=0.9, cg_offset_ft=(0.02, 0.01, -0.02), coefficient_factor=(0.9,) * 5 + (1.1,)
    )
    slopes = configured.jacobian(X, U, changed)[1]
    for column in range(3):  # rates are on a breakpoint at zero
        step = 0.01
        move = step * np.eye(12)[column]
        ends = [configured.derivatives(X + sign * move, U, changed) for sign in (1, -1)]
        np.testing.assert_allclose(slopes[:, column], (ends[0] - ends[1]) / (2 * step), rtol=1e-3, atol=1e-4)


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ({"mass_factor": 0.4}, "mass_factor"),
        ({"cg_offset_ft": (0, 2, 0)}, "cg_offset_ft"),
        ({"coefficient_factor": (1, 1, 1, 1, 1, 1.6)}, "coefficient_factor"),
        ({"cg_offset_ft": 0.1}, "give 3 values"),
    ],
)
def test_values_outside_what_is_allowed(setting, message):
    with pytest.raises(InputError, match=message):
        Configuration(**setting)


def test_slopes_are_differences_of_exact_ends():
    """Each number of the box by itself, at both ends, against the exact solver."""
    limits, step = ControlLimits(rudder_deg=(15, 15)), 2e-3
    here = envelope(10000, 0, limits)
    bounds = manoeuvre.bounds(here.failure)
    for sign, trim, name in ((1.0, here.at_v_min, "v_min_kt"), (-1.0, here.at_v_max, "v_max_kt")):
        slopes = tolerance_slopes(10000, 0, *bounds, sign * np.eye(9)[0], trim.unknowns, here.failure.airframe)
        for k, told in enumerate(sign * slopes * 0.592487):
            ends = []
            for way in (1, -1):
                moved = way * step * np.eye(len(TOLERANCES))[k]
                changed = Configuration(
                    mass_factor=1 + moved[0], cg_offset_ft=tuple(moved[1:4]), coefficient_factor=tuple(1 + moved[4:])
                )
                ends.append(getattr(envelope(10000, 0, Failure(limits, changed)), name))
            assert told == pytest.approx((ends[0] - ends[1]) / (2 * step), rel=0.01, abs=0.01)
