"""Surveys of exact envelopes: their numbers are those of single solutions."""

import numpy as np
import pytest

from gtm_fmu.envelope import FlightCondition, envelope
from gtm_fmu.failures import ControlLimits
from study import survey_figures, surveys


def nothing(done: int, total: int) -> None:
    assert done <= total


@pytest.fixture(scope="module")
def surface():
    return surveys.limit_surface(10000.0, 0.0, nothing, step_deg=5.0)


def test_highest_speed_over_limits_is_that_of_single_envelopes(surface):
    limits = surface.limits_deg.tolist()
    for low, high in ((-30.0, -20.0), (-10.0, 20.0), (15.0, 25.0), (20.0, 20.0)):
        exact = envelope(10000.0, 0.0, ControlLimits(rudder_deg=(low, high))).v_max_kt
        found = surface.v_max_kt[limits.index(low), limits.index(high)]
        assert found == pytest.approx(exact, abs=0.1)  # the best deflection may lie between two jams
        assert found <= exact + 1e-3  # a jam is never better than its range
    assert np.isnan(surface.v_max_kt[limits.index(5.0), limits.index(0.0)])  # limits reversed


def test_feasibility_map_agrees_with_envelopes(monkeypatch):
    monkeypatch.setattr(surveys, "ALTITUDES_FT", (0.0, 30000.0))
    monkeypatch.setattr(surveys, "GAMMAS_DEG", (-5.0, 5.0))
    monkeypatch.setattr(surveys, "JAMS_DEG", (-20.0, 0.0, 20.0))
    found = surveys.feasibility_map(nothing)
    for i, altitude_ft in enumerate(found.altitudes_ft):
        for j, gamma_deg in enumerate(found.gammas_deg):
            for k, jam_deg in enumerate(found.jams_deg):
                exact = FlightCondition(altitude_ft, gamma_deg).envelope((jam_deg, jam_deg))
                assert (found.t_min_pct[i, j, k] <= 100.0) == exact.feasible
    assert survey_figures.plot_feasibility(found).axes


def test_volume_has_a_boundary_at_every_flight_path(monkeypatch):
    monkeypatch.setattr(surveys, "GAMMAS_DEG", (-5.0, 5.0))
    volume = surveys.envelope_volume(0.0, (10.0, 10.0), nothing)
    for gamma_deg, boundary in zip(volume.gammas_deg, volume.boundaries, strict=True):
        exact = FlightCondition(0.0, gamma_deg).envelope((10.0, 10.0))
        assert (boundary.tas_kt[0], boundary.tas_kt[-1]) == (exact.v_min_kt, exact.v_max_kt)
    page = survey_figures.volume_page(volume)
    assert page.count("scatter3d") >= 2
    assert len(survey_figures.plot_volume(volume).axes[0].lines) == 2


def test_surface_figure_marks_the_jams(surface):
    (jams,) = survey_figures.plot_limit_surface(surface).axes[0].lines
    assert jams.get_label() == "jams"
