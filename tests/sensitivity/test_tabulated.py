"""Indices of a table of levels, whose values are known."""

import numpy as np
import pytest

from sensitivity import tabulated_indices
from sensitivity.test_functions import STEP, TRIANGLE_DIFFERENCE, TRIANGLE_PRODUCT, TRIANGLE_SUM


def middles(count: int) -> np.ndarray:
    return (np.arange(count) + 0.5) / count


def test_two_dependent_switches():
    """x y where y = 0 if x = 0, else either alike: the mean is 1/4, the variance 3/16.

    E(f | x) is 0 or 1/2, so S_x = (1/16) / (3/16); y = 1 tells all, and x = 1 too, so S_y = 1 and ST_x = 0.
    """
    weights = [[4.0, 0.0], [2.0, 2.0]]  # any scale
    outputs = [[[0.0], [np.nan]], [[0.0], [1.0]]]  # what does not occur has no value
    found = tabulated_indices(["x", "y"], weights, outputs, ["f"])
    np.testing.assert_allclose(found.first.value[:, 0], [1 / 3, 1], atol=1e-15)
    np.testing.assert_allclose(found.total.value[:, 0], [0, 2 / 3], atol=1e-15)
    assert found.output_mean == pytest.approx([1 / 4])
    assert found.output_variance == pytest.approx([3 / 16])
    assert found.to_dict()["f"]["indices"]["y"] == {"first": pytest.approx(1.0), "total": pytest.approx(2 / 3)}


def test_a_step_whose_edges_are_those_of_cells():
    """Four cells an axis hold STEP without an error."""
    x = np.stack(np.meshgrid(middles(4), middles(4), indexing="ij"), axis=-1)
    found = tabulated_indices(["x1", "x2"], np.ones((4, 4)), STEP(x.reshape(-1, 2)).reshape(4, 4, 1), ["step"])
    np.testing.assert_allclose(found.first.value[:, 0], STEP.first, atol=1e-15)
    np.testing.assert_allclose(found.total.value[:, 0], STEP.total, atol=1e-15)


@pytest.mark.parametrize("model", [TRIANGLE_SUM, TRIANGLE_DIFFERENCE, TRIANGLE_PRODUCT], ids=lambda model: model.name)
def test_finer_cells_come_nearer_to_the_triangle(model):
    """Half of a cell on the diagonal lies in the triangle."""

    def error(cells: int) -> float:
        x = np.stack(np.meshgrid(middles(cells), middles(cells), indexing="ij"), axis=-1)
        weights = np.triu(np.ones((cells, cells)), 1) + 0.5 * np.eye(cells)
        found = tabulated_indices(["low", "high"], weights, model(x.reshape(-1, 2)).reshape(cells, cells, 1), ["f"])
        return max(abs(found.first.value[:, 0] - model.first).max(), abs(found.total.value[:, 0] - model.total).max())

    assert error(64) < 0.3 * error(16) < 0.01


def test_a_group():
    """x + y + z, each 0 or 1: a third each; two together two thirds."""
    sums = np.indices((2, 2, 2)).sum(axis=0)[..., np.newaxis]
    found = tabulated_indices(["x", "y", "z"], np.ones((2, 2, 2)), sums, ["sum"], groups=[["z", "x"]])
    assert found.row_names == ("x", "y", "z", "x,z")
    np.testing.assert_allclose(found.first.value[:, 0], [1 / 3, 1 / 3, 1 / 3, 2 / 3], atol=1e-15)
    np.testing.assert_allclose(found.total.value[:, 0], [1 / 3, 1 / 3, 1 / 3, 2 / 3], atol=1e-15)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"names": ["x"]}, "give an axis for each of at least two inputs"),
        ({"weights": np.ones((2, 3))}, "give an axis for each"),
        ({"weights": [[1.0, -1.0], [1.0, 1.0]]}, "give numbers that are not negative"),
        ({"weights": np.zeros((2, 2))}, "some above zero"),
        ({"outputs": np.ones((2, 2, 1))}, "does not vary"),
        ({"outputs": [[[0.0], [np.nan]], [[0.0], [1.0]]]}, "not finite"),
        ({"groups": [["x", "y"]]}, "must hold some, but not all"),
        ({"groups": [["q"]]}, "must hold some, but not all"),
    ],
)
def test_what_is_no_table(changed, message):
    given = {
        "names": ["x", "y"],
        "weights": np.ones((2, 2)),
        "outputs": np.eye(2)[..., np.newaxis],
        "output_names": "f",
    }
    with pytest.raises(ValueError, match=message):
        tabulated_indices(**given | changed)
