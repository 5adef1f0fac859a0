"""The paper's figures and tables beside ours: none is missing, and verdicts follow from the numbers."""

import pytest

from gtm_study.paper import envelope_findings, network_findings, published, sensitivity_findings
from gtm_study.paper.counterpart import Counterpart, Finding
from gtm_study.paper.registry import COUNTERPARTS, ours, verdict, why
from gtm_study.paper.stages import STAGES

FIGURES, TABLES = 41, 15  # of the paper
WITHOUT = {"Figure 4", "Figure 5", "Figure 6", "Figure 7", "Figure 9"}
"""Drawings and a screenshot."""


def test_none_is_missing():
    numbers = [each.number for each in COUNTERPARTS]
    assert numbers == [f"Figure {k + 1}" for k in range(FIGURES)] + [f"Table {k + 1}" for k in range(TABLES)]
    assert {each.number for each in COUNTERPARTS if each.stage is None} == WITHOUT


@pytest.mark.parametrize("each", COUNTERPARTS, ids=lambda each: each.number)
def test_each_tells(each):
    """What is shown, what the paper says, and where ours comes from or why there is none."""
    assert each.shows
    assert each.published
    if each.stage is None:
        assert each.reason
        assert (ours(each, {}), verdict(each, {}), why(each, {})) == ("", "none", each.reason)
    else:
        assert each.stage in {stage.name for stage in STAGES}
        assert each.stage not in {stage.name for stage in STAGES if stage.level == "full"}
        assert each.find is not None
        assert each.figure or each.table or each.number == "Figure 8"
        assert each.stage in why(each, {})


def test_a_finding_is_that_of_the_results():
    counterpart = Counterpart("Figure 1", "a", "b", "jams", lambda results: Finding(str(results["jams"]), "same", "c"))
    assert (ours(counterpart, {"jams": {"x": 1}}), verdict(counterpart, {"jams": {}})) == ("{'x': 1}", "same")
    assert verdict(counterpart, {"lattice": {}}) == "none"


class TestVerdictsFollowFromNumbers:
    @pytest.mark.parametrize(("best", "expected"), [(5e-5, "better"), (1.5e-4, "same"), (1e-3, "different")])
    def test_errors(self, best, expected):
        """The published error is 9.4251e-5."""
        parts = {"networks": [best, 2 * best], "levenberg-marquardt": [3 * best, 4 * best]}
        results = {name: {"part": {"mse_independent": errors}} for name, errors in parts.items()}
        assert network_findings.trainings(results).verdict == expected

    @pytest.mark.parametrize(("local", "expected"), [([2e-4, 2e-4], "same"), ([2e-4, 5e-5], "different")])
    def test_rounds(self, local, expected):
        """The paper: networks ahead in all rounds."""
        off = {"all": {"mse": 1e-3}}
        results = {
            name: {"part": {"mse_independent": errors, "off_lattice": off}}
            for name, errors in (("networks", [1e-4, 1e-4]), ("local-models", local))
        }
        assert network_findings.against_local_models(results).verdict == expected

    @pytest.mark.parametrize(("at_30", "expected"), [([75.0, 140.0], "same"), ([65.0, 140.0], "different")])
    def test_jams(self, at_30, expected):
        """The paper: the larger the jam, the smaller the envelope, on either side."""
        members = [[-30.0, None, None], [0.0, 67.6, 190.0], [10.0, 68.4, 178.4], [30.0, *at_30]]
        results = {"jams": {"healthy_kt": [67.3, 190.0], "members": members}}
        found = envelope_findings.jams(results)
        assert found.verdict == expected
        assert "V_min by +0.30 kn and V_max by +0.00 kn" in found.ours

    def test_samples(self):
        rows = [{"data_set": 2, "cases": 264, "feasible": 234, "paper": 261}]
        results = {"lattice": {"counts_of": rows, "contradiction": ""}}
        found = envelope_findings.samples(2)(results)
        assert found.verdict == "different"
        assert "at least 27 of them have no steady manoeuvre" in found.why
        rows[0]["feasible"] = 261
        assert envelope_findings.samples(2)(results).verdict == "same"


def test_table_15_contradicts_itself():
    """The sums that no model lets exceed 1: 1.147 and 1.074, by hand from the table."""
    sums = {
        output: sensitivity_findings.bound(known, published.SECOND_ORDER_INDICES[output]["altitude_ft,gamma_deg"])
        for output, known in published.VARIANCE_INDICES.items()
    }
    by_hand = {"v_max_kt": 0.1411 + 0.2840 + 0.1687 + 0.4558 + 0.0973, "v_min_kt": 0.1385 + 0.2501 + 0.6809 + 0.0042}
    assert sums == pytest.approx(by_hand)
    assert sums == pytest.approx({"v_max_kt": 1.147, "v_min_kt": 1.074}, abs=5e-4)
