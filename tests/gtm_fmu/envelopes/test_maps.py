"""Surveys of exact envelopes: their numbers are those of single solutions."""

import numpy as np
import pytest

from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.core.configuration import Configuration
from gtm_fmu.envelopes import maps as surveys
from gtm_fmu.envelopes.boundary import envelope_boundary
from gtm_fmu.envelopes.envelope import FlightCondition, envelope
from gtm_fmu.envelopes.family import envelope_family
from gtm_fmu.errors import InputError
from gtm_study.figures import families as family_figures
from gtm_study.figures import maps as survey_figures


@pytest.fixture(scope="module")
def surface():
    return surveys.limit_surface(FlightCondition(10000.0, 0.0), step=10.0)


@pytest.fixture(scope="module")
def volume():
    condition = FlightCondition(0.0, 0.0, ControlLimits(rudder_deg=(10.0, 10.0)))
    return envelope_family(condition, "gamma", (-5.0, 0.0, 5.0), 4.0, 2.0)


@pytest.fixture(scope="module")
def jams():
    return envelope_family(FlightCondition(10000.0, -5.0), "rudder", (-20.0, 0.0, 30.0), 4.0, 2.0)


def test_highest_speed_over_limits_is_that_of_single_envelopes(surface):
    limits = surface.limits.tolist()
    for low, high in ((-30.0, -20.0), (-10.0, 20.0), (10.0, 30.0), (20.0, 20.0)):
        exact = envelope(10000.0, 0.0, ControlLimits(rudder_deg=(low, high))).v_max_kt
        assert surface.v_max_kt[limits.index(low), limits.index(high)] == pytest.approx(exact, abs=1e-3)
    assert np.isnan(surface.v_max_kt[limits.index(10.0), limits.index(0.0)])  # limits reversed
    assert np.isnan(surface.v_max_kt[0, 0])  # no envelope


def test_surface_of_another_control_beside_a_failure():
    condition = FlightCondition(5000.0, 0.0, Failure(configuration=Configuration(engine_running=(False, True))))
    found = surveys.limit_surface(condition, "aileron", 20.0)
    assert found.limits.tolist() == [-20.0, 0.0, 20.0]
    assert found.v_max_kt[0, 2] == pytest.approx(condition.envelope().v_max_kt, abs=1e-3)


def test_feasibility_map_agrees_with_envelopes():
    failure = Failure(ControlLimits(throttle_pct=(0, 80)))
    found = surveys.feasibility_map(failure, "rudder", 20.0, (0.0, 30000.0), (-5.0, 5.0))
    assert found.jams == [-30.0, -10.0, 10.0, 30.0]
    for i, altitude_ft in enumerate(found.altitudes_ft):
        for j, gamma_deg in enumerate(found.gammas_deg):
            for k, jam_deg in enumerate(found.jams):
                limits = failure.with_limits("rudder_deg", (jam_deg, jam_deg))
                assert found.feasible[i, j, k] == FlightCondition(altitude_ft, gamma_deg, limits).envelope().feasible
    assert 0 < found.feasible.sum() < found.feasible.size
    assert found.largest(1)[0, 0] == found.largest(-1)[0, 0] == 10.0
    assert np.isnan(found.largest(1)[1, 1])
    assert "largest jam" in survey_figures.feasibility_page(found)
    assert survey_figures.plot_feasibility(found).axes


def test_two_throttles_decide_by_their_envelope():
    failure = Failure(throttle_left_pct=(0, 100))
    found = surveys.feasibility_map(failure, "rudder", 30.0, (25000.0,), (3.0,))
    single = [failure.with_limits("rudder_deg", (jam, jam)) for jam in found.jams]
    assert found.feasible[0, 0].tolist() == [FlightCondition(25000.0, 3.0, one).envelope().feasible for one in single]
    assert found.feasible[0, 0].tolist() == [False, True, False]


def test_members_of_a_family_are_single_envelopes(volume, jams):
    for family, changed in ((volume, "gamma_deg"), (jams, "rudder_deg")):
        for member in family.members:
            single = FlightCondition(
                member.envelope.altitude_ft,
                member.value if changed == "gamma_deg" else -5.0,
                ControlLimits(rudder_deg=(10.0, 10.0) if changed == "gamma_deg" else (member.value, member.value)),
            )
            assert member.envelope.v_max_kt == single.envelope().v_max_kt
            for ours, alone in zip(member.boundary.outlines, envelope_boundary(single).outlines, strict=True):
                np.testing.assert_array_equal(ours, alone)
    assert [bool(member.boundary.polygons) for member in jams.members] == [True, True, False]


def test_family_as_data_set(volume, jams):
    data = volume.to_dataset()
    assert dict(data.sizes) == {"gamma": 3, "tas": data.sizes["tas"], "turn_rate": data.sizes["turn_rate"]}
    assert (data.gamma.attrs["units"], data.attrs) == ("deg", {"altitude_ft": 0.0})
    assert data.feasible.dtype == bool
    for member in volume.members:
        assert int(data.accepted.sel(gamma=member.value).sum()) == member.grid.accepted.sum()
        assert np.isnan(data.alpha.sel(gamma=member.value).values[~data.feasible.sel(gamma=member.value).values]).all()
    assert jams.to_dataset().rudder_jam.values.tolist() == [-20.0, 0.0, 30.0]


def test_wrong_axes_are_refused():
    condition = FlightCondition(0.0, 0.0)
    for over, values, sentence in (
        ("speed", [1.0], "do not vary over 'speed'; choose one of altitude, gamma"),
        ("gamma", [], "There is no value of gamma"),
        ("gamma", [0.0, 50.0], "gamma in deg 50 is outside"),
        ("rudder", [31.0], "rudder in deg: limits 31 31 are outside"),
    ):
        with pytest.raises(InputError, match=sentence):
            envelope_family(condition, over, values)
    with pytest.raises(InputError, match="There is no control 'flaps'"):
        surveys.limit_surface(condition, "flaps")
    with pytest.raises(InputError, match=r"step in deg 0 is outside 0\.1 \.\. 30"):
        surveys.limit_surface(condition, step=0.0)


def test_figures_of_families(volume, jams):
    drawn = family_figures.plot_family(volume).axes[0]
    assert len(drawn.lines) >= 3 * 4  # each member's outline in the colours of its limits
    assert drawn.get_zlabel() == "$\N{GREEK SMALL LETTER GAMMA}$, deg"
    page = family_figures.family_page(volume)
    assert page.count('"type":"scatter3d"') >= 3
    labels = [text.get_text() for text in family_figures.plot_family(jams).legends[0].get_texts()]
    assert labels == ["-20\N{DEGREE SIGN}", "0\N{DEGREE SIGN}", "30\N{DEGREE SIGN}: none left"]
    assert "none left" in family_figures.family_page(jams)


def test_surface_figure_marks_the_jams(surface):
    (jams,) = survey_figures.plot_limit_surface(surface).axes[0].lines
    assert jams.get_label() == "jams"
    assert '"name":"jams"' in survey_figures.surface_page(surface)
