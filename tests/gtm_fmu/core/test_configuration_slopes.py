"""Exact Jacobians of every configuration against differences, and their side at breakpoints."""

import numpy as np
import pytest

from gtm_fmu.airframe.names import STATES, TWO_THROTTLE_CONTROLS
from gtm_fmu.core import configuration as configured
from gtm_fmu.core.configuration import Configuration
from tests.gtm_fmu.core.test_configuration import SETTINGS, assert_agrees, random_manoeuvres
from tests.gtm_fmu.core.test_core_against_plain_model import random_points
from tests.reference.spec_values import POINT_A

STEPS = np.array([0.02] * 3 + [1e-3] * 3 + [1e-3, 1e-3, 5.0] + [1e-3] * 3 + [0.02] * 3 + [0.1] * 2)
TRIM_STEPS = np.array([0.02, 1e-4, 1e-4, 1e-3, 1e-3] + [0.02] * 3 + [0.1] * 2)


def assert_slopes_are_differences(function, slopes, z, steps):
    """Central differences (n, rows, columns) with Richardson's rule; a column across a kink is left out.

    At a kink, and only there, the rule's two steps disagree by far more than its error, which is of the fourth order.
    """
    left_out = 0
    for j, h in enumerate(steps):
        step = h * np.eye(len(steps))[j]
        coarse, fine = ((function(z + step * k) - function(z - step * k)) / (2 * h * k) for k in (1, 0.5))
        scale = np.maximum(np.abs(fine), 1e-3 * np.abs(slopes).max(axis=-1))
        smooth = np.all(np.abs(coarse - fine) <= 1e-4 * scale, axis=-1)
        left_out += np.sum(~smooth)
        rounding = 2e-13 * np.abs(function(z)).max(axis=-1, keepdims=True) / h
        error = np.abs(slopes[..., j] - (4 * fine - coarse) / 3)
        assert np.all((error <= 1e-7 * scale + rounding)[smooth])
    assert left_out < 0.06 * z.shape[0] * len(steps)


@pytest.mark.parametrize("name", SETTINGS)
def test_jacobians_are_differences(name):
    configuration = SETTINGS[name]
    x, u = random_points(150, seed=22, theta_limit_deg=60)
    z = np.hstack([x, u, np.random.default_rng(23).uniform(0, 100, (150, 1))])
    z[::2, STATES.index("altitude")] *= 0.02  # half of them where the wind grows with height
    for function, jacobian in (
        (configured.derivatives, configured.jacobian),
        (configured.outputs, configured.outputs_jacobian),
    ):
        value, slopes = jacobian(z[:, :12], z[:, 12:], configuration)
        assert_agrees(value, function(z[:, :12], z[:, 12:], configuration), 1e-13)
        assert_slopes_are_differences(
            lambda at, of=function: of(at[:, :12], at[:, 12:], configuration), slopes, z, STEPS
        )


@pytest.mark.parametrize("name", SETTINGS)
def test_trim_jacobians_are_differences(name):
    altitude, gamma, y = random_manoeuvres(150, seed=24)
    F, slopes = configured.trim_jacobian(y, altitude, gamma, SETTINGS[name])
    assert_agrees(F, configured.trim_residual(y, altitude, gamma, SETTINGS[name]), 1e-13)
    assert_slopes_are_differences(
        lambda at: configured.trim_residual(at, altitude, gamma, SETTINGS[name]), slopes, y, TRIM_STEPS
    )


BREAKPOINTS = [("elevator", 10.0), ("aileron", 0.0), ("aileron", -10.0), ("rudder", 10.0)]


@pytest.mark.parametrize("case", range(1, 7))
@pytest.mark.parametrize(("control", "breakpoint_"), BREAKPOINTS)
def test_slopes_at_a_breakpoint_are_those_above(case, control, breakpoint_):
    """Of the command, also for the left aileron, which moves against it."""
    configuration = Configuration(damage_case=case, stabilizer_deg=-3)
    u, column = np.array([-2.0, 3, 5, 50, 50]), TWO_THROTTLE_CONTROLS.index(control)
    slopes = []
    for u[column] in (breakpoint_, breakpoint_ + 1e-7, breakpoint_ - 1e-7):
        slopes.append(configured.jacobian(POINT_A.x, u, configuration)[1][:6, len(STATES) + column])
    at, above, below = slopes
    np.testing.assert_allclose(at, above, rtol=1e-5, atol=1e-7)
    is_lost = control == "rudder" and case in (1, 2)
    assert (np.max(np.abs(at - below)) > 1e-3) != is_lost


@pytest.mark.parametrize("case", range(7))
def test_slopes_in_sideslip_at_a_breakpoint_are_those_above(case):
    """beta = 0, where a left panel's table is looked up from the other side."""
    configuration = Configuration(damage_case=case, stabilizer_deg=-3, spoiler_deg=(5, 10, 15, 20))
    x, u, v = POINT_A.x.copy(), np.array([-2.0, 3, 5, 50, 50]), STATES.index("v")
    slopes = []
    for x[v] in (0, 1e-6, -1e-6):
        slopes.append(configured.jacobian(x, u, configuration)[1][:6, v])
    at, above, below = slopes
    np.testing.assert_allclose(at, above, rtol=1e-5, atol=1e-7)
    assert np.max(np.abs(at - below)) > 1e-3
