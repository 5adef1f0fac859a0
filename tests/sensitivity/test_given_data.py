"""Indices from tables nobody designed, against exact values and SALib."""

import numpy as np
import pytest

from sensitivity import given_data_indices, pawn_indices
from sensitivity import test_functions as functions

N = 20000


def table(function, n=N, seed=0):
    X = function.distribution.sample(np.random.default_rng(seed).random((n, len(function.distribution.names))))
    return X, function(X)


@pytest.mark.parametrize(
    "function",
    [
        functions.ISHIGAMI,
        functions.TRIANGLE_PRODUCT,
        functions.STEP,
        functions.linear_gaussian([1, 1], [[1, 0.7], [0.7, 1]]),
    ],
    ids=lambda f: f.name,
)
def test_first_order(function):
    found = given_data_indices(*table(function))
    np.testing.assert_allclose(found.first.value[:, 0], function.first, atol=0.015)
    inside = (found.first.lower[:, 0] - 0.01 < function.first) & (function.first < found.first.upper[:, 0] + 0.01)
    assert inside.all()


def test_noise_has_no_index():
    """eta^2 of noise in B bins is (B - 1) / (n - 1) in the mean (Kelley 1935); epsilon^2 is 0."""
    rng = np.random.default_rng(1)
    raw, corrected = [], []
    for _ in range(60):
        found = given_data_indices(rng.random((500, 1)), rng.random(500), bins=20, n_bootstrap=2)
        raw.append(found.raw[0, 0])
        corrected.append(found.first.value[0, 0])
    assert np.mean(raw) == pytest.approx(19 / 499, rel=0.1)
    assert abs(np.mean(corrected)) < 0.004


def test_hidden_inside_the_bins():
    """x on [0, 1] in B bins: the variance 1/12 less (1 / B)^2 / 12 within, so S = 1 - 1 / B^2."""
    x = np.random.default_rng(2).random((N, 1))
    found = given_data_indices(x, x[:, 0], bins=10, n_bootstrap=2)
    assert found.first.value[0, 0] == pytest.approx(0.99, abs=1e-3)
    assert found.bias_within[0, 0] == pytest.approx(0.01, abs=2e-3)


def test_pawn_equal_to_salib():
    """Medians, maxima and means of the distances, with slices of equal counts, on continuous data."""
    from SALib.analyze import pawn

    X, y = table(functions.ISHIGAMI, 2000)
    found = pawn_indices(X, y, n_bootstrap=2)
    theirs = pawn.analyze({"num_vars": 3, "names": ["a", "b", "c"]}, X, y, S=10, seed=1)
    for ours, name in ((found.median, "median"), (found.largest, "maximum"), (found.mean, "mean")):
        np.testing.assert_allclose(ours.value[:, 0], theirs[name], atol=0.02)


def test_pawn_sees_what_the_variance_misses():
    """An input that only sets the spread has S = 0, and yet moves the distribution; another one does nothing."""
    rng = np.random.default_rng(3)
    X = rng.random((5000, 2))
    y = X[:, 0] * rng.standard_normal(5000)
    assert abs(given_data_indices(X, y, n_bootstrap=2).first.value[0, 0]) < 0.02
    found = pawn_indices(X, y, n_bootstrap=10)
    assert found.mean.value[0, 0] > 2 * found.dummy[0] > 0
    assert found.mean.value[1, 0] < 1.2 * found.dummy[0]


@pytest.mark.parametrize("call", [given_data_indices, pawn_indices])
@pytest.mark.parametrize(
    ("X", "y", "message"),
    [
        (np.ones((50, 1)), np.arange(50.0), "x1 does not vary"),
        (np.arange(50.0)[:, None], np.ones(50), "y0 does not vary"),
        (np.arange(50.0), np.arange(50.0), "one row for each run"),
        (np.arange(50.0)[:, None], np.arange(49.0), "give one row of outputs"),
        (np.arange(6.0)[:, None], np.arange(6.0), "rows in"),
        (np.append(np.arange(49.0), np.nan)[:, None], np.arange(50.0), "first row 49"),
    ],
)
def test_refused(call, X, y, message):
    with pytest.raises(ValueError, match=message):
        call(X, y)
