"""The published numbers against what the notes on them say, and against the paper's own text."""

import re

import pytest

from gtm_study.paper import published


def test_table_15_breaks_the_identity():
    """SENSITIVITY.md: S_LL + ST_UL + S_closed{h, gamma} is 1.147 for V_max and 1.074 for V_min."""
    for output, expected in (("v_max_kt", 1.147), ("v_min_kt", 1.074)):
        index, second = published.VARIANCE_INDICES[output], published.SECOND_ORDER_INDICES[output]
        closed = index["altitude_ft"]["first"] + index["gamma_deg"]["first"] + second["altitude_ft,gamma_deg"]
        total = index["rudder_lower_deg"]["first"] + index["rudder_upper_deg"]["total"] + closed
        assert total == pytest.approx(expected, abs=5e-4)


def test_table_15_interaction_is_a_difference():
    for output, second in published.SECOND_ORDER_INDICES.items():
        lower = published.VARIANCE_INDICES[output]["rudder_lower_deg"]
        difference = lower["total"] - lower["first"]
        assert second["rudder_lower_deg,rudder_upper_deg"] == pytest.approx(difference, abs=1e-9)


def test_lattice_has_1232_cases():
    """Four altitudes, eleven gammas and 28 pairs of limits with LL <= UL, jams among them."""
    levels = published.LATTICE_LEVELS
    pairs = [(lo, up) for lo in levels["rudder_lower_deg"] for up in levels["rudder_upper_deg"] if lo <= up]
    assert len(levels["altitude_ft"]) * len(pairs) == published.ENVELOPES_3D
    assert published.ENVELOPES_3D * len(levels["gamma_deg"]) == 1232


def test_every_number_is_in_the_paper(shared_folder):
    text = (shared_folder / "paper" / "impaired-aircraft-surrogates.txt").read_text()
    rows = re.findall(r"#(\d)\s+([\d.]+E ?-?\d+)\s+([\d.]+E[ -]\d+)\s+(\d+)", text)
    assert len(rows) == 6
    for number, ann, lmn, samples in rows:
        # The text lost some minus signs of the exponents.
        ann, lmn = (float(re.sub(r"E[ -](\d+)", r"E-\1", value)) for value in (ann, lmn))
        assert published.MSE_ANN[int(number)] == ann
        assert published.MSE_LMN[int(number)] == lmn
        assert published.TRAINING_SAMPLES[int(number)] == int(samples)
    table_15 = text[text.index("TABLE 15.") : text.index("As can be seen in Fig. 37")]
    printed = sorted(float(value) for value in re.findall(r"0\.\d{4}", table_15))
    ours = [
        value for output in published.VARIANCE_INDICES.values() for row in output.values() for value in row.values()
    ]
    second = [value for output in published.SECOND_ORDER_INDICES.values() for value in output.values() if value]
    assert printed == sorted(ours + second)
    assert f"totally {published.FEASIBLE_CASES} 2D MFEs" in text
    assert f"{published.INDEPENDENT_TEST_CASES} failure cases of the independent test data" in text
    assert "total of 3 million model evaluations" in text
