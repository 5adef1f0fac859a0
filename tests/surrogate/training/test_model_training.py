"""Training on rows that stand several times in a table, as they do where arrays were multiplied out before."""

import numpy as np
import pytest

from surrogate import Variable
from surrogate.training.model_training import train_model
from surrogate.training.samples import Samples

pytestmark = pytest.mark.slow

ROWS, COPIES = 60, 8


def noise(copies: int) -> Samples:
    """White noise over a lattice of 3 x 4 x 5 points, on which nothing can be learnt; its range is 1."""
    X = np.stack(np.meshgrid(*(np.arange(n) for n in (3.0, 4.0, 5.0)), indexing="ij"), axis=-1).reshape(ROWS, 3)
    Y = np.random.default_rng(0).normal(size=(ROWS, 1))
    order = np.random.default_rng(1).permutation(ROWS * copies)
    X, Y = (np.repeat(values, copies, axis=0)[order] for values in (X, Y / np.ptp(Y)))
    return Samples(tuple(Variable(name, "") for name in "abc"), (Variable("y", ""),), X, Y, 0)


@pytest.mark.parametrize("method", ["br", "lolimot"])
def test_copies_of_a_row_are_in_one_part_only(method):
    """The error is that of noise, of variance 0.044, not of copies that the training has seen (5e-29 for br)."""
    model = train_model(noise(COPIES), method, splits=3, hidden=(10,), seed=0)
    assert model.provenance["rows_repeated"] == ROWS * (COPIES - 1)
    assert model.metrics["mse_independent"] > 0.01
    assert model.metrics["r2_independent y"] < 0.5
