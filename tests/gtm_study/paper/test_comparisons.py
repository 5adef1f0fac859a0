"""Scores of the study: zero where two methods agree, the right size where one is off by a known amount."""

import io
from types import SimpleNamespace

import pytest
from rich.console import Console

from gtm_fmu.envelopes.envelope import FlightCondition
from gtm_fmu.envelopes.thrust_map import ThrustMap
from gtm_study.paper import comparisons
from gtm_study.progress import stages

pytestmark = pytest.mark.slow


def test_surrogate_fmu_with_another_map(fmus):
    """The FMU agrees with what it carries, and is told from anything else."""
    carried = ThrustMap.load()

    def biased(*case):
        found = carried.predict_one(*case)
        return found | ({"v_max_kt": found["v_max_kt"] + 0.25} if found["feasible"] else {})

    same = comparisons.compare_surrogate_fmu(fmus["surrogate"], carried, 0)
    assert same["largest_difference_kt"] < 1e-9
    assert same["same_verdict"] == same["cases"]
    other = comparisons.compare_surrogate_fmu(fmus["surrogate"], SimpleNamespace(predict_one=biased), 0)
    assert other["largest_difference_kt"] == pytest.approx(0.25)


def test_jams_of_the_paper():
    steps = []
    family = comparisons.jam_family((20.0, 30.0), lambda *step: steps.append(step))
    assert steps[-1] == (2, 2)
    found = FlightCondition(10000, -5).envelope((20, 20))  # paper Fig. 3
    jam_20, jam_30 = family.members
    assert (jam_20.envelope.v_min_kt, jam_20.envelope.v_max_kt) == (found.v_min_kt, found.v_max_kt)
    assert len(jam_20.boundary.polygons) == 1
    assert not jam_30.envelope.feasible
    assert jam_30.boundary.polygons == ()


class TestProgress:
    def test_lines_where_there_is_no_terminal(self):
        shown = io.StringIO()
        with stages(Console(file=shown)) as stage:
            with stage("Envelopes") as advance:
                advance(1, 3)
                assert shown.getvalue() == ""
            assert shown.getvalue() == "Envelopes: done\n"
            with pytest.raises(ValueError, match="broken"), stage("Networks"):
                raise ValueError("broken")
        assert shown.getvalue() == "Envelopes: done\n"

    def test_bar_with_the_time_left(self):
        shown = io.StringIO()
        with (
            stages(Console(file=shown, force_terminal=True, width=100, _environ={})) as stage,
            stage("Envelopes") as advance,
        ):
            advance(1, 4)
        assert "Envelopes" in shown.getvalue()
        assert "0:00:00" in shown.getvalue()
        assert "done" not in shown.getvalue()
