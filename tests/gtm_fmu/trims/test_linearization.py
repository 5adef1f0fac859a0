"""Linear models against differences, python-control, systems of known controllability and NASA's published modes."""

import control
import numpy as np
import pytest

from fmu_src.fmus import build_fmu
from gtm_fmu.aircraft.client import FmuClient
from gtm_fmu.aircraft.evaluation import FmuAirframe
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.airframe.names import CONTROLS, LINEAR_STATES, STATES
from gtm_fmu.core import motion
from gtm_fmu.trims import linearization, steady
from gtm_study.paper import nasa_comparison

NASA = nasa_comparison.READINGS
ROWS = [STATES.index(name) for name in LINEAR_STATES]
JAM = ControlLimits(rudder_deg=(12.0, 12.0))


@pytest.fixture(scope="module")
def trim():
    found = steady.trim(9000.0, 117.0, 1.3, -2.2, JAM)  # away from every breakpoint of the tables
    assert found.feasible
    return found


def readings(name: str) -> np.ndarray:
    return np.genfromtxt(NASA / f"{name}.csv", delimiter=",", names=True)


def test_exact_model_equals_central_differences(trim):
    x, u = trim.state_and_controls
    A, B = linearization.slopes(x, u)
    for k, row in enumerate(ROWS):
        step = np.zeros(len(x))
        step[row] = 1e-5 * max(1.0, abs(x[row]))
        slope = (motion.derivatives(x + step, u) - motion.derivatives(x - step, u))[ROWS] / (2 * step[row])
        np.testing.assert_allclose(A[:, k], slope, atol=2e-8 * max(1.0, np.abs(A[:, k]).max()))
    for k in range(len(CONTROLS)):
        step = np.zeros(len(u))
        step[k] = 1e-4
        slope = (motion.derivatives(x, u + step) - motion.derivatives(x, u - step))[ROWS] / (2 * step[k])
        np.testing.assert_allclose(B[:, k], slope, atol=1e-8)


def test_first_order_differences_over_the_fmu_come_within_their_error(trim, tmp_path):
    exact = linearization.linearize(trim)
    with FmuClient(build_fmu("dynamics", tmp_path)) as client:
        paper = linearization.linearize_fmu(FmuAirframe(client), trim)
    assert paper.inputs == exact.inputs == ("elevator", "aileron", "throttle")
    # Step 1e-6: rounding of derivatives of order 100 gives 1e-14 x 100 / 1e-6, curvature 1e-6 times second derivatives.
    scale = np.maximum(1.0, np.abs(exact.A))
    assert np.abs((paper.A - exact.A) / scale).max() < 2e-5
    np.testing.assert_allclose(paper.B, exact.B, atol=1e-5)
    np.testing.assert_allclose(np.sort_complex(paper.eigenvalues), np.sort_complex(exact.eigenvalues), atol=1e-4)


def test_directional_derivatives_of_the_native_fmu_are_exact(trim, tmp_path):
    exact = linearization.linearize(trim)
    with FmuClient(build_fmu("dynamics-native", tmp_path)) as client:
        airframe = FmuAirframe(client)
        native = linearization.linearize_fmu(airframe, trim)
        stepped = linearization.linearize_fmu(airframe, trim, epsilon=1e-6)
    np.testing.assert_allclose(native.A, exact.A, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(native.B, exact.B, rtol=1e-12, atol=1e-12)
    assert 0 < np.abs(stepped.A - exact.A).max() < 1e-2  # a step means the paper's differences


def test_python_control_linearises_the_same_system(trim):
    x, u = trim.state_and_controls

    def rates(t, state, inputs, parameters):
        full = x.copy()
        full[ROWS] = state
        return motion.derivatives(full, inputs)[ROWS]

    system = control.nlsys(rates, None, inputs=list(CONTROLS), states=list(LINEAR_STATES), outputs=list(LINEAR_STATES))
    other = control.linearize(system, x[ROWS], u, eps=1e-6)
    A, B = linearization.slopes(x, u)
    np.testing.assert_allclose(A, other.A, atol=2e-3)  # its differences of step 1e-6 times the entry
    np.testing.assert_allclose(B, other.B, atol=2e-3)


def test_state_space_carries_names_poles_and_kalmans_matrix(trim):
    model = linearization.linearize(trim)
    system = model.state_space()
    assert system.state_labels == list(LINEAR_STATES)
    assert system.input_labels == ["elevator", "aileron", "throttle"]
    np.testing.assert_allclose(np.sort_complex(system.poles()), np.sort_complex(model.eigenvalues), atol=1e-9)
    kalman = control.ctrb(system.A, system.B)
    assert model.kalman_condition == pytest.approx(np.linalg.cond(kalman), rel=1e-3)
    assert 1e8 < model.kalman_condition < 1e13  # why its rank is no test here
    frequency, damping, _ = control.damp(system, doprint=False)
    assert model.stable == bool((damping > 0).all())
    assert len(frequency) == len(LINEAR_STATES)


def test_reduced_modes_are_those_of_the_longitudinal_part():
    model = linearization.linearize(steady.trim(800.0, 97.0))
    rows = [LINEAR_STATES.index(name) for name in ("u", "w", "q", "theta")]
    part = control.ss(model.A[np.ix_(rows, rows)], np.zeros((4, 1)), np.eye(4), 0)
    frequency, damping, _ = control.damp(part, doprint=False)
    for mode in model.longitudinal_modes():
        k = np.abs(frequency / (2 * np.pi) - mode.frequency_hz).argmin()
        assert mode.frequency_hz == pytest.approx(frequency[k] / (2 * np.pi), rel=1e-9)
        assert mode.damping == pytest.approx(damping[k], rel=1e-6)


def scaled_system(A, B):
    """Matrices whose scaled form is A, B."""
    S = linearization.STATE_SCALE
    return A * S[:, None] / S, B * S[:, None] / linearization.INPUT_SCALE[: B.shape[1]]


def test_pbh_finds_uncontrollable_unstable_modes():
    A, B = np.diag([0.5, -1.0, -2.0, -3.0, -4.0, -5.0, -6.0, -7.0]), np.ones((8, 1))
    reached = scaled_system(A, B)
    B_blind = B.copy()
    B_blind[0] = 0.0  # the unstable mode is out of reach
    blind = scaled_system(A, B_blind)
    harmless = B.copy()
    harmless[3] = 0.0  # a stable one is
    stable_blind = scaled_system(A, harmless)
    scale = linearization.INPUT_SCALE[:1]

    def margin(system):
        return linearization.controllability_margin(*system, np.linalg.eigvals(system[0]), scale)

    assert margin(reached) > linearization.PBH_THRESHOLD
    assert margin(blind) < 1e-12
    assert margin(stable_blind) > linearization.PBH_THRESHOLD


def test_margins_of_many_trims_are_those_of_each(trim):
    x, u = trim.state_and_controls
    A, B = linearization.slopes(np.stack([x, x * 1.02]), np.stack([u, u]))
    eigenvalues = np.linalg.eigvals(A)
    together = linearization.controllability_margin(A, B, eigenvalues)
    single = [linearization.controllability_margin(A[k], B[k], eigenvalues[k]) for k in range(2)]
    np.testing.assert_array_equal(together, single)


def test_stable_means_no_positive_real_part():
    assert linearization.is_stable(np.array([-1.0 + 2j, -1.0 - 2j, 0.0]))
    assert not linearization.is_stable(np.array([-1.0, 1e-9]))


# Reading errors of the plots (their README, SPEC 13): 0.1 deg, 0.1 kn, 0.15 % throttle, 0.01 Hz.


def test_level_trims_over_alpha_agree_with_nasa():
    table = readings("level_trim_vs_alpha")
    assert table["alpha_deg"].max() == 28.0
    for row in table:
        found = nasa_comparison.trim_at_alpha(float(row["alpha_deg"]))
        assert found.elevator_deg == pytest.approx(row["elevator_deg"], abs=0.1)
        assert found.throttle_pct == pytest.approx(row["throttle_pct"], abs=0.15)
        if np.isfinite(row["eas_kt"]):
            assert found.eas_kt == pytest.approx(row["eas_kt"], abs=0.1)


def test_level_trims_over_speed_agree_with_nasa():
    table = readings("level_trim_vs_eas")
    for row in table:
        found = nasa_comparison.trim_at_eas(float(row["eas_kt"]))
        assert found.elevator_deg == pytest.approx(row["elevator_deg"], abs=0.1)
        assert found.throttle_pct == pytest.approx(row["throttle_pct"], abs=0.15)
        if np.isfinite(row["alpha_deg"]):
            assert found.alpha_deg == pytest.approx(row["alpha_deg"], abs=0.1)


def test_longitudinal_modes_agree_with_nasa_on_the_nearer_side():
    table = readings("longitudinal_modes_vs_alpha")
    for row in table:
        sides = nasa_comparison.modes(float(row["alpha_deg"]))
        off = [
            (abs(phugoid.frequency_hz - row["phugoid_hz"]), abs(short.frequency_hz - row["sp_hz"]))
            for phugoid, short in sides
        ]
        assert min(phugoid for phugoid, _ in off) < 0.01
        assert min(short for _, short in off) < 0.01
