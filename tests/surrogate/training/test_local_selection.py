"""The paper's Algorithm 2: six candidates, chosen by validation data, judged by independent ones."""

import numpy as np
import pytest

from surrogate import Schedule, select_network, split_samples
from surrogate.training.local_selection import select_local_models
from tests.surrogate.conftest import INPUTS, OUTPUTS, random_inputs, smooth_function

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def selection():
    X = random_inputs(120, seed=3)
    return select_local_models(X, smooth_function(X), inputs=INPUTS, outputs=OUTPUTS, seed=4, rounds=2)


def test_six_candidates_a_round_and_output(selection):
    assert [len(round_) for round_ in selection.candidates] == [2, 2]
    for six in (six for round_ in selection.candidates for six in round_):
        assert len({(c.algorithm, c.local_model) for c in six}) == len(six) == 6


def test_the_least_validation_error_is_chosen(selection):
    for j, round_ in enumerate(selection.candidates):
        for o, (six, chosen) in enumerate(zip(round_, selection.best(j), strict=True)):
            rows, least, greatest = selection.split.test[j], selection.Y[:, o].min(), selection.Y[:, o].max()
            errors = [
                np.mean(((c.network.predict(selection.X[rows])[:, 0] - selection.Y[rows, o]) / (greatest - least)) ** 2)
                for c in six
            ]
            assert six[int(np.argmin(errors))] is chosen
            assert chosen.validation_mse == pytest.approx(min(errors), rel=1e-6)


def test_independent_errors_are_those_of_the_chosen_networks(selection):
    rows, span = selection.split.independent, np.ptp(selection.Y, axis=0)
    for j in range(2):
        outputs = np.hstack([c.network.predict(selection.X[rows]) for c in selection.best(j)])
        expected = (((outputs - selection.Y[rows]) / span) ** 2).mean()
        assert selection.mse["independent"][j] == pytest.approx(expected, rel=1e-9)
    assert selection.mse["independent"][selection.selected] == selection.mse["independent"].min()
    chosen = selection.best(selection.selected)
    np.testing.assert_array_equal(selection.predict(selection.X)[:, 1], chosen[1].network.predict(selection.X)[:, 0])


def test_the_split_is_that_of_algorithm_1(selection):
    names = {"inputs": INPUTS, "outputs": OUTPUTS, "schedule": Schedule(epochs=3)}
    networks = select_network(selection.X, selection.Y, seed=4, rounds=2, hidden=2, **names)
    np.testing.assert_array_equal(networks.split.independent, selection.split.independent)
    np.testing.assert_array_equal(networks.split.test, selection.split.test)


def test_members_shrink_the_design_part_only():
    members = np.arange(200) % 3 == 0
    whole, part = split_samples(200, 3, 0.1, 1), split_samples(200, 3, 0.1, 1, members)
    np.testing.assert_array_equal(part.independent, whole.independent)
    expected = sorted(set(np.flatnonzero(members)) - set(whole.independent))
    for j in range(3):
        assert part.rows("all", j).tolist() == expected


def test_two_processes_give_the_same_networks(selection):
    again = select_local_models(
        selection.X, selection.Y, inputs=INPUTS, outputs=OUTPUTS, seed=4, split=selection.split, jobs=2
    )
    np.testing.assert_allclose(again.mse["independent"], selection.mse["independent"], rtol=1e-6)
