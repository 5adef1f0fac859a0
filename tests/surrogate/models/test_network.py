"""Closed-form evaluation of a network, against the equations written out, torch and differences."""

import subprocess
import sys
from dataclasses import replace
from itertools import pairwise
from math import exp, tanh

import numpy as np
import pytest

from surrogate import Network, Schedule, Variable, train_networks
from surrogate.core import PackedNetwork, library
from tests.surrogate.conftest import INPUTS, OUTPUTS, random_inputs, smooth_function


@pytest.fixture(params=[(3, 4, 2), (3, 5, 4, 2)], ids=["one hidden layer", "two"])
def network(request) -> Network:
    """Random weights."""
    return random_network(request.param)


@pytest.fixture
def shallow() -> Network:
    """3 inputs, 4 neurons, 2 outputs; P = 26 parameters."""
    return random_network((3, 4, 2))


def random_network(sizes) -> Network:
    rng = np.random.default_rng(21)
    layers = list(pairwise(sizes))
    P = sum(size * (before + 1) for before, size in layers)
    return Network(
        weights=tuple(rng.normal(size=(size, before)) for before, size in layers),
        biases=tuple(rng.normal(size=size) for _, size in layers),
        input_ranges=np.array([[0.0, 9000.0], [-5.0, 5.0], [-1.0, 1.0]]),
        target_ranges=np.array([[40.0, 140.0], [0.01, 0.03]]),
        inputs=tuple(Variable(*v) for v in INPUTS),
        outputs=tuple(Variable(*v) for v in OUTPUTS),
        beta=50.0,
        posterior_factor=np.triu(rng.normal(scale=0.05, size=(P, P))),
    )


def test_prediction_is_the_papers_regression_equation(shallow):
    """Equations 43-45 in plain Python, with the paper's exponential form of tansig."""
    x = [6500.0, -1.25, 0.3]
    (IW, LW), (b1, b2) = shallow.weights, shallow.biases
    I_p = [(i - low) * 2 / (high - low) - 1 for i, (low, high) in zip(x, shallow.input_ranges, strict=True)]
    a = [
        2 / (1 + exp(-2 * (sum(w * i for w, i in zip(row, I_p, strict=True)) + b))) - 1
        for row, b in zip(IW, b1, strict=True)
    ]
    y_p = [sum(w * s for w, s in zip(row, a, strict=True)) + b for row, b in zip(LW, b2, strict=True)]
    y = [low + (y + 1) / 2 * (high - low) for y, (low, high) in zip(y_p, shallow.target_ranges, strict=True)]
    np.testing.assert_allclose(shallow.predict(x), y, rtol=1e-13)


def test_prediction_agrees_with_torch_layers(network, torch):
    a = torch.tensor(random_inputs(200, seed=3) / [4500.0, 5.0, 1.0] - [1.0, 0.0, 0.0])
    for W, b in zip(network.weights, network.biases, strict=True):
        y_p = torch.nn.functional.linear(a, torch.tensor(W), torch.tensor(b))
        a = torch.tanh(y_p)
    expected = np.column_stack([90.0 + 50.0 * y_p[:, 0], 0.02 + 0.01 * y_p[:, 1]])
    np.testing.assert_allclose(network.predict(random_inputs(200, seed=3)), expected, rtol=1e-12)


def test_any_leading_shape_is_evaluated_sample_by_sample(network):
    X = random_inputs(6, seed=4).reshape(2, 3, 3)
    for evaluate in (network.predict, network.gradient, network.predict_std, network.parameter_gradient):
        values = evaluate(X)
        for i in np.ndindex(2, 3):
            np.testing.assert_allclose(values[i], evaluate(X[i]), rtol=1e-12)


def test_many_samples_are_each_evaluated_as_if_alone(network):
    X = random_inputs(10_000, seed=12)
    for i in (0, 4095, 4096, 9999):
        np.testing.assert_allclose(network.predict(X)[i], network.predict(X[i]), rtol=1e-12)
        np.testing.assert_allclose(network.predict_std(X)[i], network.predict_std(X[i]), rtol=1e-12)
    assert network.predict(np.empty((0, 3))).shape == (0, 2)
    assert network.gradient(np.empty((0, 3))).shape == (0, 2, 3)
    assert network.predict_std(np.empty((0, 3))).shape == (0, 2)


@pytest.mark.parametrize("sizes", [(3, 1, 2), (3, 4, 2), (3, 17, 5, 2), (3, 9, 8, 7, 2)])
def test_compiled_and_numpy_evaluation_agree(sizes, monkeypatch):
    """To 1e-14 of the targets' ranges, in whole and broken blocks, and far outside, where tanh is 1 or its slope."""
    assert library() is not None
    network = random_network(sizes)
    X = np.concatenate([random_inputs(1000, seed=13), 1e6 * random_inputs(129, seed=14), [[4500.0, 0.0, 0.0]]])
    compiled = network.predict(X)
    monkeypatch.setattr("surrogate.models.network.library", lambda: None)
    off = np.abs(compiled - network.predict(X)) / np.ptp(network.target_ranges, axis=1)
    assert off[:1000].max() < 1e-14
    assert off.max() < 1e-13


def test_compiled_evaluation_does_not_depend_on_a_samples_place():
    network, X = random_network((3, 10, 2)), random_inputs(300, seed=15)
    alone = np.array([network.predict(x) for x in X])
    assert (network.predict(X) == alone).all()
    assert (network.predict(X[::-1]) == alone[::-1]).all()


@pytest.mark.parametrize("size", [1e-300, 1e-9, 1e-3, 0.17, 1.0, 18.0, 25.0, 1e300])
def test_compiled_tanh_is_right_to_4_units_in_the_last_place(size):
    """Against the C library's; a network of one neuron whose scales are 1 gives tanh itself."""
    X = np.random.default_rng(16).uniform(-size, size, (2000, 1))
    one, unit = np.ones((1, 1)), np.array([[-1.0, 1.0]])
    packed = PackedNetwork((one, one), (np.zeros(1), np.zeros(1)), unit, np.array([[-1.0, 1.0]]))
    found = packed.outputs(library(), X)[:, 0]
    expected = np.array([tanh(x - (-1.0) - 1.0) for x in X[:, 0]])
    np.testing.assert_allclose(found + 0.0, expected, rtol=1e-15, atol=2e-16)


def test_gradient_agrees_with_central_differences(network):
    X = random_inputs(50, seed=5)
    for i, step in enumerate([1e-1, 1e-4, 1e-5]):
        h = step * np.eye(3)[i]
        difference = (network.predict(X + h) - network.predict(X - h)) / (2 * step)
        np.testing.assert_allclose(network.gradient(X)[..., i], difference, rtol=1e-6, atol=1e-8 / step * 1e-3)


def test_parameter_gradient_agrees_with_central_differences(network):
    """Parameters in the order of the rows of [W_1, b_1], then of [W_2, b_2] ...; outputs on [-1, 1]."""
    X, step = random_inputs(10, seed=6), 1e-6
    layers = [np.column_stack(layer) for layer in zip(network.weights, network.biases, strict=True)]
    w, ends = np.concatenate([layer.ravel() for layer in layers]), np.cumsum([layer.size for layer in layers])

    def predicted(w):
        parts = [part.reshape(layer.shape) for part, layer in zip(np.split(w, ends[:-1]), layers, strict=True)]
        moved = replace(network, weights=tuple(p[:, :-1] for p in parts), biases=tuple(p[:, -1] for p in parts))
        return moved.predict(X) / [50.0, 0.01]

    gradient = network.parameter_gradient(X)
    assert gradient.shape == (10, 2, len(w))
    for p, h in enumerate(step * np.eye(len(w))):
        difference = (predicted(w + h) - predicted(w - h)) / (2 * step)
        np.testing.assert_allclose(gradient[..., p], difference, atol=1e-8)


def test_standard_deviation_of_a_linear_model_has_its_closed_form(shallow):
    """With the hidden layer certain, the output layer is Bayesian linear regression on the features z = [a, 1]."""
    alpha, beta, X = 0.2, 40.0, random_inputs(30, seed=7)

    def features(X):
        a = np.tanh((X / [4500.0, 5.0, 1.0] - [1.0, 0.0, 0.0]) @ shallow.weights[0].T + shallow.biases[0])
        return np.column_stack([a, np.ones(len(X))])

    covariance = np.linalg.inv(2 * beta * features(X).T @ features(X) + 2 * alpha * np.eye(5))
    K = np.zeros((26, 26))
    for first in (16, 21):
        K[first : first + 5, first : first + 5] = np.linalg.cholesky(covariance).T
    fitted = replace(shallow, beta=beta, posterior_factor=K)

    z = features(new := random_inputs(40, seed=8))
    variance = 1 / (2 * beta) + np.einsum("ni,ij,nj->n", z, covariance, z)
    np.testing.assert_allclose(fitted.predict_std(new), np.sqrt(variance)[:, None] * [50.0, 0.01], rtol=1e-12)


@pytest.mark.usefixtures("torch")
def test_standard_deviation_of_a_trained_network_is_that_of_its_errors():
    """Noise of a known size: the network finds it, and its intervals hold the share of new samples that they say."""
    rng = np.random.default_rng(9)
    X, new = random_inputs(600, seed=10), random_inputs(4000, seed=11)
    Y, truth = smooth_function(X), smooth_function(new)
    noise = 0.03 * np.ptp(Y, axis=0)
    Y += rng.normal(size=Y.shape) * noise
    Y_new = truth + rng.normal(size=truth.shape) * noise
    rows = np.tile(np.arange(600), (4, 1))
    trained = train_networks(X, Y, inputs=INPUTS, outputs=OUTPUTS, rows=rows, seed=1, schedule=Schedule(epochs=200))
    for network, _ in trained:
        noise_found = np.ptp(network.target_ranges, axis=1) / 2 / np.sqrt(2 * network.beta)
        np.testing.assert_allclose(noise_found, noise, rtol=0.08)
        std = network.predict_std(new)
        assert (std > noise_found).all()
        of_the_weights = np.sqrt(np.mean(std**2 - noise_found**2, axis=0))
        np.testing.assert_allclose(
            of_the_weights, np.sqrt(np.mean((network.predict(new) - truth) ** 2, axis=0)), rtol=0.3
        )
        z = (Y_new - network.predict(new)) / std
        assert np.mean(z**2) == pytest.approx(1.0, abs=0.1)
        assert np.mean(np.abs(z) < 1.96) == pytest.approx(0.95, abs=0.02)


def test_in_range_holds_up_to_and_with_the_ends(network):
    inside = network.in_range([[0.0, 5.0, 1.0], [4000.0, 0.0, 0.0], [9000.1, 0.0, 0.0], [1.0, -5.1, 0.0]])
    assert inside.tolist() == [True, True, False, False]


def test_arrays_cannot_be_changed(network):
    with pytest.raises(ValueError, match="read-only"):
        network.weights[0][0, 0] = 1.0


@pytest.mark.parametrize(
    ("X", "message"),
    [([1.0, 2.0], "last axis must hold height, angle, width"), ([1.0, np.nan, 2.0], "not finite"), (3.0, "last axis")],
)
def test_wrong_inputs_are_refused(network, X, message):
    with pytest.raises(ValueError, match=message):
        network.predict(X)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"biases": (np.zeros(4), np.zeros(3))}, r"biases\[1\] .* shape \(2,\)"),
        ({"weights": (np.full((4, 3), np.inf), np.zeros((2, 4)))}, r"weights\[0\] .* finite"),
        ({"posterior_factor": np.eye(4)}, r"posterior_factor .* \(26, 26\)"),
        ({"beta": 0.0}, "beta .* positive"),
        ({"input_ranges": [[0.0, 1.0], [1.0, 1.0], [0.0, 1.0]]}, "input_ranges .* then a greater one"),
    ],
)
def test_a_network_that_does_not_fit_together_is_refused(shallow, change, message):
    with pytest.raises(ValueError, match=message):
        replace(shallow, **change)


def test_evaluation_needs_neither_torch_nor_scikit_learn(network, tmp_path):
    network.save(tmp_path / "network.json")
    code = """
import sys
for name in ("torch", "sklearn"):
    sys.modules[name] = None
from surrogate import Network
network = Network.load(sys.argv[1])
print(network.predict([6500.0, -1.25, 0.3]).tolist(), network.predict_std([6500.0, -1.25, 0.3]).tolist())
"""
    command = [sys.executable, "-c", code, str(tmp_path / "network.json")]
    run = subprocess.run(command, capture_output=True, text=True, check=True)
    x = [6500.0, -1.25, 0.3]
    assert run.stdout.strip() == f"{network.predict(x).tolist()} {network.predict_std(x).tolist()}"


def test_loading_a_model_imports_nothing_of_training(network, tmp_path):
    """So that it takes little longer than NumPy's own import."""
    network.save(tmp_path / "network.json")
    code = """
import sys
import numpy
from surrogate import load_model
load_model(sys.argv[1]).predict([6500.0, -1.25, 0.3])
print(sorted(name for name in sys.modules if name.startswith("surrogate.")))
print([name for name in ("torch", "sklearn", "scipy", "casadi", "xarray", "pandas", "rich") if name in sys.modules])
"""
    command = [sys.executable, "-c", code, str(tmp_path / "network.json")]
    own, others = subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()
    kinds = ("evaluation", "load", "local_models", "network", "partitions", "safety", "storage")
    names = ("core", "models", *(f"models.{kind}" for kind in kinds), "scaling")
    assert own == str([f"surrogate.{name}" for name in names])
    assert others == "[]"
