"""The paper's lattice: its six data sets, their counts in the paper's text, and why they cannot all be right."""

import re
from itertools import product

import numpy as np
import pytest

from gtm_fmu.datasets import paper, results
from gtm_fmu.datasets.lattice import lattice
from gtm_fmu.datasets.store import CaseStore
from gtm_study.paper import lattice as paper_lattice
from gtm_study.paper import published

ALL_CASES = {1: 336, 2: 264, 3: 440, 4: 72, 5: 120, 6: 1232}
"""Altitudes x flight-path angles x pairs of n levels, n (n + 1) / 2 of them: 4 x 3 x 28, 4 x 11 x 6, 4 x 11 x 10 ..."""


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    """A store of the lattice in which the envelopes are made up: a case has one unless its limits are both above 0."""
    path = tmp_path_factory.mktemp("paper") / "a.zarr"
    table = lattice()
    store = CaseStore(path, table, {"alpha_deg": [-5.0, 10.5], "phi_deg": [-30.0, 30.0]})
    for cases in store.unfinished():
        columns = {name: np.zeros(len(cases), dtype) for name, (dtype, _) in results.schema().items()}
        columns["feasible"] = table.rows(cases.start, cases.stop)[:, 6] <= 0
        store.write(cases, columns)
    return path


def test_lattice_is_that_of_table_7():
    expected = set(product(*published.LATTICE_LEVELS.values()))
    rows = lattice().rows(0, 10**6)[:, [0, 1, 6, 7]]
    assert {tuple(row) for row in rows} == {case for case in expected if case[2] <= case[3]}


def test_counts(store):
    """Pairs of n levels whose lower one is 0 or less: all but those of the positive levels."""
    positive = {1: 3, 2: 1, 3: 2, 4: 1, 5: 2, 6: 3}
    angles = {1: 3, 2: 11, 3: 11, 4: 3, 5: 3, 6: 11}
    counts = paper_lattice.counts(store)
    assert {row["data_set"]: row["cases"] for row in counts} == ALL_CASES
    for row in counts:
        k, n = row["data_set"], positive[row["data_set"]]
        assert row["feasible"] == ALL_CASES[k] - 4 * angles[k] * n * (n + 1) // 2
        assert row["paper"] == published.TRAINING_SAMPLES[k] <= ALL_CASES[k]


def test_contradiction():
    """Counted by hand: 1232 - 1102 - 3 - 96 = 31 left out at all angles, but 336 - 260 - 1 - 32 = 43 at three."""
    sentence = paper_lattice.contradiction()
    assert "they leave out 31 at all flight-path angles" in sentence
    assert "but 43 at three of these angles" in sentence


def test_levels_are_in_the_paper(shared_folder):
    text = (shared_folder / "paper" / "impaired-aircraft-surrogates.txt").read_text()

    def printed(levels) -> str:
        return re.escape(", ".join(f"{level:g}" for level in levels))

    levels = paper.DATA_SETS
    for table, number in ((9, 2), (10, 3)):
        rows = text[text.index(f"TABLE {table}. Input") :][:400]
        assert len(re.findall(rf"\[{printed(levels[number]['rudder_deg'])}\]", rows)) == 2
    assert "the beginning, the ending, and the middle values of the flight path angle" in text
    assert levels[1]["gamma_deg"] == tuple(published.LATTICE_LEVELS["gamma_deg"][k] for k in (0, 5, 10))
    assert "combinations of the three aforementioned datasets" in text
    assert levels[4] == levels[1] | levels[2]
    assert levels[5] == levels[1] | levels[3]
