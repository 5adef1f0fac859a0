"""Both sides of the breakpoints that trims lie on, by one-sided differences of the plain model."""

import numpy as np
import pytest

from fmu_src.fmus import build_fmu
from gtm_fmu.aircraft.client import FmuClient
from gtm_fmu.aircraft.evaluation import FmuAirframe
from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.airframe.names import LINEAR_STATES, STATES
from gtm_fmu.core.configuration import Configuration
from gtm_fmu.envelopes.grid import assess
from gtm_fmu.errors import InputError
from gtm_fmu.trims import linearization, steady
from gtm_fmu.trims.breakpoints import Breakpoint
from gtm_fmu.trims.linearization import linearize
from tests.reference import plain_model

ROWS = [STATES.index(name) for name in LINEAR_STATES]
RATES = ("p", "q", "r")
ZERO_RATES = [f"{name}_deg_s = 0" for name in RATES]


def plain_slopes(trim, sides: dict[str, int]) -> np.ndarray:
    """A (8, 8) by one-sided differences to the given sides, central ones of the other states."""
    x, u = trim.state_and_controls
    columns = []
    for name, row in zip(LINEAR_STATES, ROWS, strict=True):
        step = np.zeros(len(x))
        step[row] = 1e-6 * (100.0 if name in "uvw" else 1.0)
        if name in sides:
            step *= sides[name]
            columns.append((plain_model.derivatives(x + step, u) - plain_model.derivatives(x, u)) / step[row])
        else:
            both = (plain_model.derivatives(x + sign * step, u) for sign in (1, -1))
            columns.append(np.subtract(*both) / (2 * step[row]))
    return np.array(columns).T[ROWS]


def growth(A) -> float:
    return float(np.linalg.eigvals(A).real.max())


@pytest.fixture(scope="module")
def straight():
    """Level flight with a free rudder: no sideslip, which is a breakpoint; 0.0020 1/s above it and -0.0018 below."""
    return steady.trim(10000, 70)


def test_a_straight_trim_names_its_breakpoints_and_both_verdicts(straight):
    model = linearize(straight)
    assert [sides.name for sides in model.sides] == ["beta_deg = 0", *ZERO_RATES]
    beta = model.sides[0]
    assert beta.stable == (True, False)
    assert model.stable is False
    expected = [growth(plain_slopes(straight, {"v": side} | dict.fromkeys(RATES, 1))) for side in (-1, 1)]
    assert beta.growth_per_s == pytest.approx(expected, abs=2e-6)
    assert beta.growth_per_s == pytest.approx((-0.00179, 0.00199), abs=1e-5)
    assert all(sides.stable == (False, False) for sides in model.sides[1:])  # above beta = 0
    above = plain_slopes(straight, dict.fromkeys(("v", *RATES), 1))
    np.testing.assert_allclose(model.A, above, atol=2e-4)


def test_the_grid_takes_all_sides(straight):
    for tas_kt in (70, 90, 118.5):
        trim = steady.trim(10000, tas_kt)
        verdict = assess(10000, 0, trim.unknowns[None], Failure())
        model = linearize(trim)
        assert (verdict.stable[0], verdict.controllable[0]) == (model.stable, model.controllable)


def test_away_from_breakpoints_there_are_no_sides():
    model = linearize(steady.trim(9000, 117, 1.3, -2.2, ControlLimits(rudder_deg=(12, 12))))
    assert model.sides == ()
    assert model.verdicts["at_breakpoint"] == model.verdicts["stable_sides"] == []


def test_a_turn_without_sideslip_lies_on_one():
    (beta,) = linearize(steady.trim(9000, 117, 1.3, 2.2)).sides
    assert beta.name == "beta_deg = 0"


def test_a_jam_on_a_breakpoint_is_no_side_of_a_model_without_rudder():
    jammed = linearize(steady.trim(10000, 118.5, 0, 2, ControlLimits(rudder_deg=(10, 10))))
    held = linearize(steady.trim(10000, 118.5, 0, 2, ControlLimits(rudder_deg=(10, 30))))
    assert jammed.sides == ()
    assert [sides.name for sides in held.sides] == ["rudder_deg = 10"]
    np.testing.assert_allclose(held.A, jammed.A, atol=1e-6)


def test_surfaces_with_an_offset_have_their_breakpoints_elsewhere():
    """Both rudders 3 deg beside their command: their table's breakpoint at 10 deg is met at 7 deg of command."""
    offset = Configuration(surface_offset_deg=(0, 0, 0, 0, 0, 0, 3, 3))
    names = []
    for rudder_deg in (7, 10):
        limits = ControlLimits(rudder_deg=(rudder_deg, 30))
        trim = steady.trim(10000, 118.5, 0, 2, Failure(limits, offset), phi_deg=(-60, 60))
        assert trim.rudder_deg == rudder_deg
        names.append([sides.name for sides in linearize(trim).sides])
    assert names == [["rudder_deg = 7"], []]


def test_over_an_fmu_the_sides_are_the_same(straight, tmp_path):
    exact = linearize(straight)
    with FmuClient(build_fmu("dynamics", tmp_path)) as client:
        model = linearization.linearize_fmu(FmuAirframe(client), straight)
    assert model.sides[0].stable == (True, False)
    assert model.sides[0].growth_per_s == pytest.approx(exact.sides[0].growth_per_s, abs=1e-6)
    assert [sides.name for sides in model.sides] == ["beta_deg = 0", "q_deg_s = 0"]  # the other two jumps are smaller


class TestWhatIsNoTrim:
    def test_a_point_with_accelerations(self):
        limits = ControlLimits(rudder_deg=(30, 30))
        nearest = steady.trim(30000, 300, 5, 0, limits)
        assert not nearest.feasible
        with pytest.raises(InputError, match="no trim inside its limits"):
            linearize(nearest)

    def test_limits_that_the_trim_exceeds_are_named(self):
        nearest = steady.trim(10000, 118.5, 0, 0, ControlLimits(rudder_deg=(10, 10), aileron_deg=(-5, 5)))
        with pytest.raises(InputError, match=r"outside aileron\.lower"):
            linearize(nearest)

    def test_a_trim_carries_its_jam(self):
        limits = ControlLimits(rudder_deg=(10, 10))
        trim = steady.trim(10000, 118.5, 0, 0, limits)
        assert trim.failure == Failure(limits)
        assert linearize(trim).inputs == linearize(trim, limits).inputs == ("elevator", "aileron", "throttle")

    @pytest.mark.parametrize("limits", [ControlLimits(), Failure(throttle_left_pct=(0, 100))])
    def test_other_limits_are_refused(self, limits):
        trim = steady.trim(10000, 118.5, 0, 0, ControlLimits(rudder_deg=(10, 10)))
        with pytest.raises(InputError, match="not the limits that the trim was found with"):
            linearize(trim, limits)


def test_stable_means_on_every_combination_of_sides():
    """Two breakpoints: each side is stable with the other above, but not both below."""
    above = np.diag([-1.0] * 8)
    row = np.array([0])
    jump = np.zeros((2, 1, 8, 8))
    jump[0, 0, 0, 0] = 0.6  # below
    found = [Breakpoint("a", 0.0, row, jump), Breakpoint("b", 0.0, row, jump)]
    model = linearization.LinearModel.of_slopes(above, (), found)
    assert [sides.stable for sides in model.sides] == [(True, True)] * 2
    assert [sides.growth_per_s for sides in model.sides] == [(pytest.approx(-0.4), -1.0)] * 2
    assert model.stable is False
    assert linearization.LinearModel.of_slopes(above, (), found[:1]).stable is True
