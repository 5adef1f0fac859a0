"""The grid of steady manoeuvres against cold solutions of every cell, single linear models and the boundary."""

import numpy as np
import pytest
from matplotlib.path import Path

from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.airframe.names import ELEVATOR
from gtm_fmu.core import solver
from gtm_fmu.envelopes.boundary import envelope_boundary
from gtm_fmu.envelopes.envelope import FlightCondition
from gtm_fmu.envelopes.grid import EnvelopeGrid, envelope_grid
from gtm_fmu.errors import InputError
from gtm_fmu.trims import linearization, manoeuvre, steady
from gtm_fmu.trims.manoeuvre import Trim
from tests.gtm_fmu.envelopes import brute_force

CASES = [
    (10000.0, 0.0, (0.0, 0.0)),
    (20000.0, -3.0, (0.0, 0.0)),
    (10000.0, -5.0, (20.0, 20.0)),
    (10000.0, 0.0, (-30.0, 30.0)),
    (25000.0, 2.0, (5.0, 25.0)),
    (5000.0, 4.0, (-25.0, -15.0)),
]


def solved(case, step_kt=4.0, step_deg_s=2.0) -> EnvelopeGrid:
    altitude_ft, gamma_deg, rudder_deg = case
    condition = FlightCondition(altitude_ft, gamma_deg, ControlLimits(rudder_deg=rudder_deg))
    return envelope_grid(condition, step_kt, step_deg_s)


@pytest.mark.parametrize("case", CASES)
def test_every_cell_agrees_with_its_cold_trim(case):
    grid = solved(case)
    cold = steady.trims(
        grid.altitude_ft, grid.tas_kt[:, None], grid.gamma_deg, grid.turn_rate_deg_s, rudder_deg=case[2]
    )
    cold_feasible = (cold.status == solver.TRIMMED).reshape(grid.feasible.shape)
    assert cold_feasible.any()
    np.testing.assert_array_equal(grid.feasible, cold_feasible)
    difference = (grid.y - cold.y.reshape(grid.y.shape)) / solver.scale()
    assert np.abs(difference[grid.feasible]).max() < 1e-8


@pytest.mark.parametrize(
    "name", ["jam with a notch", "hard restriction", "left engine out, elevator restricted, flaps down"]
)
def test_nothing_is_missed_that_brute_force_finds(name):
    """A lean part of what `brute_force` holds: of its 12 cases at 1 kn x 1 deg/s nothing was missed."""
    condition = FlightCondition(*brute_force.CASES[name])
    grid = envelope_grid(condition, 3.0, 2.0)
    cells, missed, excess_rad = brute_force.missed(grid, condition, beyond=1, rudder_step_deg=1.5)
    assert cells > 10
    assert missed == 0
    assert excess_rad < 1e-9  # no jam has less sideslip
    residual, violation = brute_force.worst_residual(grid)
    assert residual < 1e-9
    assert violation < 1e-6


def test_enclosed_cells_are_found_where_the_flood_from_neighbours_fails():
    """With the elevator restricted the trims of least sideslip jump between neighbours, which leave a slit of cells."""
    condition = FlightCondition(*brute_force.CASES["left engine out, elevator restricted, flaps down"])
    grid = envelope_grid(condition, 1.0, 0.5)
    inside = (grid.tas_kt[:, None] <= 80.0) & (grid.tas_kt[:, None] >= 70.0) & (np.abs(grid.turn_rate_deg_s) <= 8.5)
    assert grid.feasible[inside].all()


def test_stability_is_that_of_single_linear_models():
    grid = solved(CASES[4])
    cells = np.argwhere(grid.feasible)[::7]
    verdicts = set()
    for i, j in cells:
        trim = Trim.of_unknowns(grid.y[i, j], grid.altitude_ft, grid.gamma_deg, True, (), grid.failure)
        model = linearization.linearize(trim)
        assert (model.stable, model.controllable) == (grid.stable[i, j], grid.controllable[i, j])
        verdicts.add(model.stable)
    assert verdicts == {True, False}  # both occur, so the comparison means something
    np.testing.assert_array_equal(grid.accepted, grid.feasible)  # none is uncontrollable here


@pytest.mark.parametrize("case", CASES[:3])
def test_the_boundary_encloses_exactly_the_feasible_cells(case):
    grid = solved(case, 2.0, 0.5)
    altitude_ft, gamma_deg, rudder_deg = case
    boundary = envelope_boundary(FlightCondition(altitude_ft, gamma_deg, ControlLimits(rudder_deg=rudder_deg)))
    (outline,) = (Path(np.column_stack(points)) for points in boundary.outlines)
    cells = np.array([(rate, speed) for speed in grid.tas_kt for rate in grid.turn_rate_deg_s])
    inside = outline.contains_points(cells).reshape(grid.feasible.shape)
    by_a_tolerance = [
        outline.contains_points(cells + off).reshape(inside.shape)
        for off in ((0.05, 0), (-0.05, 0), (0, 0.1), (0, -0.1))
    ]
    assert inside.any()
    assert grid.feasible[np.all(by_a_tolerance, axis=0)].all()
    assert not grid.feasible[~np.any(by_a_tolerance, axis=0)].any()


def test_boundary_names_the_limits_that_hold_it():
    condition = FlightCondition(10000.0, -5.0, ControlLimits(rudder_deg=(10.0, 10.0)))
    (around,) = envelope_boundary(condition).polygons
    longest = {piece.limits: piece for piece in sorted(around, key=lambda piece: len(piece.tas_kt))}
    assert longest["alpha.upper",].tas_kt.min() == pytest.approx(condition.envelope().v_min_kt, abs=0.01)
    assert longest["throttle.upper",].tas_kt.max() == pytest.approx(condition.envelope().v_max_kt, abs=0.01)
    assert longest["phi.lower",].turn_rate_deg_s.max() < longest["phi.upper",].turn_rate_deg_s.min()


def test_jammed_elevator_keeps_every_turn_at_which_a_free_one_passes_its_position():
    """Trims with the elevator free over 2 deg of rudder: where it passes the jam between two of them, a trim exists."""
    jam, free = 0.0, Failure()
    condition = FlightCondition(10000.0, 0.0, free.with_limits("elevator_deg", (jam, jam)))
    grid = envelope_grid(condition, 4.0, 2.0)
    lower, upper = manoeuvre.bounds(free)
    passed, before = np.zeros(grid.feasible.shape, dtype=bool), None
    for deflection in np.arange(-30.0, 31.0, 2.0):
        at = condition.altitude_ft, grid.tas_kt[:, None], condition.gamma_deg, grid.turn_rate_deg_s
        found = steady.trims(*at, free, rudder_deg=(deflection, deflection))
        inside = (found.status != solver.NO_TRIM) & ((found.y >= lower) & (found.y <= upper)).all(axis=1)
        off = found.y[:, ELEVATOR] - jam
        if before is not None:
            passed |= (inside & before[0] & (off * before[1] <= 0)).reshape(passed.shape)
        before = inside, off
    assert passed.sum() > 30
    assert (passed & ~grid.feasible).sum() <= 1  # a cell at a horn's tip may be cut off from the others
    np.testing.assert_allclose(grid.y[grid.feasible][:, ELEVATOR], jam, atol=1e-9)


@pytest.mark.parametrize("name", ["no failure", "left engine out, left elevator off"])
def test_unstable_trims_are_controllable_in_all_their_modes(name):
    """The paper's rule asks for the full rank of its eq. 35: the stable modes of an unstable trim, too."""
    grid = envelope_grid(FlightCondition(*brute_force.CASES[name]), 6.0, 4.0)
    cells = grid.feasible & ~grid.stable
    assert cells.sum() > 10
    for y in grid.y[cells][::3]:
        trim = Trim.of_unknowns(y, grid.altitude_ft, grid.gamma_deg, True, (), grid.failure)
        model = linearization.linearize(trim)
        A = model.A * linearization.STATE_SCALE / linearization.STATE_SCALE[:, None]
        B = model.B * linearization.input_scale(model.inputs) / linearization.STATE_SCALE[:, None]
        pencils = [np.hstack([root * np.eye(len(A)) - A, B]) for root in model.eigenvalues]
        assert min(np.linalg.svd(pencil, compute_uv=False)[-1] for pencil in pencils) > 0.1


def test_without_an_envelope_there_are_no_cells():
    grid = solved((30000.0, 5.0, (30.0, 30.0)))
    assert grid.tas_kt.size == 0
    assert not grid.feasible.any()
    assert grid.to_dataset().sizes["tas"] == 0


def test_data_set_carries_units_and_trims():
    grid = solved(CASES[2])
    data = grid.to_dataset()
    assert data.rudder.attrs["units"] == "deg"
    rudder = data.rudder.values[grid.feasible]
    np.testing.assert_allclose(rudder, 20.0, atol=1e-9)
    assert np.isnan(data.throttle.values[~grid.feasible]).all()


@pytest.mark.parametrize("steps", [(0.0, 1.0), (1.0, -2.0), (float("nan"), 1.0)])
def test_bad_steps_are_refused(steps):
    with pytest.raises(InputError, match=r"step in .* is outside 0\.01 \.\. 50"):
        envelope_grid(FlightCondition(10000.0, 0.0), *steps)
