"""LOLIMOT and HILOMOT: recovery of functions that they hold exactly, the gradient of a split, the published counts."""

import numpy as np
import pytest
from scipy.special import expit

from surrogate import LocalSettings, train_local_models
from surrogate.estimators import HilomotRegressor, LolimotRegressor
from surrogate.training.hilomot import Hilomot, NestedSplit
from surrogate.training.local_training import ScaledSamples, grow
from surrogate.training.lolimot import Lolimot

pytestmark = pytest.mark.slow


def unit_square(n: int, seed: int = 0) -> np.ndarray:
    """Random samples, with the corners, so that the inputs are scaled as they are."""
    X = np.random.default_rng(seed).uniform(0, 1, (n, 2))
    X[:4] = [[0, 0], [0, 1], [1, 0], [1, 1]]
    return X


@pytest.mark.parametrize("local_model", ["linear", "sparse_quadratic", "quadratic"])
@pytest.mark.parametrize("regressor", [LolimotRegressor, HilomotRegressor])
def test_one_model_is_a_polynomial_fit(regressor, local_model):
    X = unit_square(60)
    x, y = X.T
    columns = [np.ones(60), x, y]
    columns += {"linear": [], "sparse_quadratic": [x * x, y * y], "quadratic": [x * x, x * y, y * y]}[local_model]
    target = np.exp(x + 0.3 * y)
    expected = np.column_stack(columns) @ np.linalg.lstsq(np.column_stack(columns), target, rcond=None)[0]
    model = regressor(local_model, criterion="size", max_models=1).fit(X, target)
    np.testing.assert_allclose(model.predict(X), expected, atol=1e-8)


def test_lolimot_recovers_a_kink_at_half_of_an_axis():
    X = unit_square(500)
    target = 1 + X[:, 1] + 3 * np.abs(X[:, 0] - 0.5)
    model = LolimotRegressor(smoothness=1e-4, criterion="size", max_models=2).fit(X, target)
    np.testing.assert_allclose(model.predict(X), target, atol=1e-7)
    assert model.tree().splitlines() == [
        "if x1 < 0.5:",
        "    model 1: y = 2.5 - 3 x1 + 1 x2",
        "else:",
        "    model 2: y = -0.5 + 3 x1 + 1 x2",
    ]


def test_lolimot_halves_to_a_kink_at_a_quarter():
    X = unit_square(800)
    target = np.maximum(X[:, 1], 0.25)
    model = LolimotRegressor(smoothness=1e-4, criterion="size", max_models=3).fit(X, target)
    np.testing.assert_allclose(model.predict(X), target, atol=1e-7)
    assert "x2 < 0.5" in model.tree()
    assert "x2 < 0.25" in model.tree()


def test_hilomot_recovers_an_oblique_kink():
    """Up to the width over which the split is smooth, 1 % of the inputs' ranges here."""
    X, direction = unit_square(3000), np.array([0.6, -0.8])
    target = 1 + X[:, 0] + 3 * np.maximum(0, X @ direction + 0.05)
    model = HilomotRegressor(smoothness=0.01, criterion="size", max_models=2).fit(X, target)
    tree = model.network_.partition.tree
    sign = np.sign(tree.directions[0] @ direction)
    np.testing.assert_allclose(sign * tree.directions[0], direction, atol=1e-3)
    np.testing.assert_allclose(sign * tree.offsets[0], -0.05, atol=1e-3)
    new = unit_square(2000, seed=1)
    expected = 1 + new[:, 0] + 3 * np.maximum(0, new @ direction + 0.05)
    assert np.sqrt(np.mean((model.predict(new) - expected) ** 2)) < 1e-5


def test_an_oblique_hyperbola_takes_hilomot_a_third_of_the_models():
    """Nelles' example 1 / (0.1 + (1 - u1) / 2 + (1 - u2) / 2), to 5 % of its deviation, all splits diagonal."""
    u = np.linspace(0, 1, 15)
    X = np.stack(np.meshgrid(u, u), axis=-1).reshape(-1, 2)
    y = 1 / (0.1 + 0.5 * (1 - X[:, 0]) + 0.5 * (1 - X[:, 1]))
    needed = {}
    for regressor in (LolimotRegressor, HilomotRegressor):
        growth = regressor(criterion="size", max_models=20).fit(X, y).growth_
        needed[regressor] = int(np.argmax(np.sqrt(growth.training_mse) * np.ptp(y) / y.std() < 0.05)) + 1
    assert 1 < needed[HilomotRegressor] <= 5
    assert needed[LolimotRegressor] >= 3 * needed[HilomotRegressor]
    tree = HilomotRegressor(criterion="size", max_models=5).fit(X, y).network_.partition.tree
    np.testing.assert_allclose(np.abs(tree.directions), np.sqrt(0.5), atol=1e-4)


def test_gradient_of_a_split_agrees_with_central_differences():
    rng = np.random.default_rng(0)
    z, y = rng.uniform(size=(200, 3)), rng.normal(size=(200, 2))
    split = NestedSplit(ScaledSamples(z, y, "quadratic"), rng.uniform(0.1, 1, 200), rng.normal(size=(200, 2)))
    theta, kappa, step = np.array([0.9, -1.3, 0.4, 0.2]), 6.0, 1e-6
    _, gradient = split.loss_and_gradient(theta, kappa)
    for i, h in enumerate(step * np.eye(4)):
        difference = (split.loss_and_gradient(theta + h, kappa)[0] - split.loss_and_gradient(theta - h, kappa)[0]) / (
            2 * step
        )
        assert gradient[i] == pytest.approx(difference, rel=1e-6, abs=1e-6)


def test_a_split_estimates_both_halves_by_weighted_least_squares():
    rng = np.random.default_rng(1)
    z, y, parent = rng.uniform(size=(80, 2)), rng.normal(size=(80, 1)), rng.uniform(0.1, 1, 80)
    samples = ScaledSamples(z, y, "linear")
    psi = expit(7.0 * (z @ [0.6, 0.8] - 0.5))
    q = NestedSplit(samples, parent, y).shares(np.array([0.6, 0.8]), 0.5, 7.0)
    np.testing.assert_allclose(q, parent[:, None] * np.column_stack([1 - psi, psi]), rtol=1e-12)
    A = np.column_stack([np.ones(80), z])
    for weights, coefficients in zip(q.T, samples.fit(q), strict=True):
        root = np.sqrt(weights)[:, None]
        expected = np.linalg.lstsq(root * A, root * y, rcond=None)[0]
        np.testing.assert_allclose(coefficients, expected, rtol=1e-6, atol=1e-9)


def growth_of(splitter, criterion, n=300, **settings):
    z = np.random.default_rng(3).uniform(size=(n, 2))
    y = np.sin(5 * z[:, :1]) * z[:, 1:] + np.random.default_rng(4).normal(scale=0.05, size=(n, 1))
    validation = ScaledSamples(z[:100], y[:100], "linear") if criterion == "validation" else None
    training = ScaledSamples(z[100:], y[100:], "linear")
    return grow(training, validation, splitter, LocalSettings("linear", criterion, **settings))


@pytest.mark.parametrize("splitter", [Lolimot(), Hilomot(2)])
def test_growth_lowers_the_training_error_and_keeps_the_best(splitter):
    grown, growth = growth_of(splitter, "validation")
    assert (np.diff(growth.training_mse) < 0).all()
    assert growth.best == np.argmin(growth.validation_mse) + 1 == grown.phi.shape[1]
    assert growth.stop == "validation"
    later = growth.validation_mse[-3:]
    assert later[0] <= later[1] <= later[2], "two successive deteriorations end the growth"
    np.testing.assert_allclose(grown.phi.sum(axis=1), 1.0, rtol=1e-12)
    assert (grown.phi.sum(axis=0) >= 3).all(), "a model owns at least as much of the data as it has parameters"


def test_aicc_of_one_linear_model_is_the_textbooks():
    """k = 3 coefficients and the variance: N ln MSE + 2 k + 2 k (k + 1) / (N - 1 - k)."""
    _, growth = growth_of(Lolimot(), "aicc")
    N, k = 200, 4
    expected = N * np.log(growth.training_mse[0]) + 2 * k + 2 * k * (k + 1) / (N - 1 - k)
    assert growth.aicc[0] == pytest.approx(expected, rel=1e-9)
    assert growth.best == np.argmin(growth.aicc) + 1 > 1
    assert growth.stop == "aicc"


def test_parameters_are_counted_as_in_the_paper():
    """Section III-D: 24 quadratic models of four inputs, split obliquely, have 452 parameters."""
    rng = np.random.default_rng(0)
    X = rng.uniform(size=(1500, 4))
    Y = np.sin(9 * X.sum(axis=1, keepdims=True)) * X[:, :1]
    settings = LocalSettings("quadratic", "size", max_models=24)
    names = [(f"x{j}", "") for j in range(4)]
    network, growth = train_local_models(
        X, Y, inputs=names, outputs=[("y", "")], rows=np.arange(1500), algorithm="hilomot", settings=settings
    )
    assert (network.models, growth.parameters[-1]) == (24, 452)
    assert network.provenance["parameters"] == 452
    assert growth.stop == "max_models"


def test_several_outputs_share_the_cells():
    X = unit_square(400)
    Y = np.column_stack([np.abs(X[:, 0] - 0.5), 5 - 100 * np.abs(X[:, 0] - 0.5)])
    model = LolimotRegressor(smoothness=1e-4, criterion="size", max_models=2).fit(X, Y)
    np.testing.assert_allclose(model.predict(X), Y, atol=1e-6)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"algorithm": "cart"}, "algorithm is 'cart', but must be one of lolimot, hilomot"),
        ({"rows": [0, 100]}, "from 0 to 99"),
        ({"Y": np.zeros((99, 1))}, "X has 100 samples and Y has 99"),
        ({"rows": [0]}, "1 sample is left for training, but at least 2 are needed"),
        ({}, "to stop by validation data, but there are none"),
    ],
)
def test_wrong_arguments_are_refused(change, message):
    X = unit_square(100)
    arguments = {"X": X, "Y": X[:, :1] ** 2, "inputs": [("a", ""), ("b", "")], "outputs": [("y", "")]}
    arguments |= {"rows": np.arange(100), "algorithm": "lolimot"}
    with pytest.raises(ValueError, match=message):
        train_local_models(**(arguments | change))
