"""Everything that may fail at once: the kept envelopes, and what their indices say."""

import re
from pathlib import Path

import numpy as np
import pytest

from gtm_fmu import envelope
from gtm_fmu.aircraft.inputs import failure
from gtm_study.paper import every_failure
from gtm_study.paper.every_failure import FILE, SCENARIOS


@pytest.fixture(scope="module")
def kept() -> dict[str, np.ndarray]:
    with np.load(FILE) as content:
        return {name: content[name] for name in content.files}


@pytest.mark.parametrize("name", SCENARIOS)
def test_kept_envelopes_are_those_of_the_solver(kept, name):
    scenario = SCENARIOS[name]
    points = scenario.design().points
    assert kept[name].shape == (len(points), 3)
    for k in np.random.default_rng(3).choice(len(points), 12, replace=False):
        case = {column.name: value for column, value in zip(scenario.columns, points[k].tolist(), strict=True)}
        found = envelope(case["altitude"], case["gamma"], failure(case))
        assert found.feasible == np.isfinite(kept[name][k, 0])
        if found.feasible:
            np.testing.assert_allclose(kept[name][k, :2], [found.v_min_kt, found.v_max_kt], atol=0.002)


def test_each_control_is_redrawn_with_both_limits():
    design = SCENARIOS["controls"].design(64)
    assert [len(factor) for factor in design.factors] == [1, 1, 2, 2, 2, 2]
    assert design.n_evaluations == 64 * (2 * 6 + 2)
    assert design.n_outside == 0


@pytest.mark.parametrize("name", SCENARIOS)
def test_the_aileron_matters_least(kept, name):
    """By its total index for both outputs, and by a count that needs no index.

    That is how much more often there is an envelope with more than half of a control's range than with a tenth of it.
    """
    least = every_failure.results()[name]["least_surfaces"]
    assert list(least) == ["has_envelope", "width_kt"]
    told_apart = ["aileron"] if name == every_failure.CONTROLS_ONLY else ["aileron", "rudder"]
    assert list(least.values()) == [told_apart, told_apart]
    has_envelope, points = np.isfinite(kept[name][:, 0]), SCENARIOS[name].design().points
    columns = [column.name for column in SCENARIOS[name].columns]
    gain = {}
    for control in ("elevator", "aileron", "rudder"):
        lower, upper = (points[:, columns.index(f"{control}_{side}")] for side in ("lower", "upper"))
        share = (upper - lower) / (upper.max() - lower.min())
        gain[control] = has_envelope[share > 0.5].mean() - has_envelope[share < 0.1].mean()
    assert gain["elevator"] > max(gain["aileron"], gain["rudder"])


def test_the_table_of_the_page():
    """docs/sensitivity.md: total indices and intervals of both scenarios."""
    page = (Path(__file__).parents[3] / "docs/sensitivity.md").read_text()
    table = page.split("| S^T | four controls: has an envelope |")[1].split("\n\n")[0].splitlines()[2:]
    rows = {cells[0].split()[0]: cells[1:] for line in table for cells in [line.strip("| ").split(" | ")]}
    column = 0
    for name in every_failure.SCENARIOS:
        found = every_failure.indices(name)
        for j in range(2):
            for i, factor in enumerate(found.factors):
                written = rows[{"gamma": "flight"}.get(key := factor[0].split("_")[0], key)][column]
                numbers = [float(number) for number in re.findall(r"[\d.]*\d", written)]
                total = found.total
                assert numbers == pytest.approx([total.value[i, j], total.lower[i, j], total.upper[i, j]], abs=0.0051)
            column += 1
