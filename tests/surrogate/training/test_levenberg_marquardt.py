"""Levenberg-Marquardt without regularisation, against SciPy's; early stopping; other devices than the processor."""

import numpy as np
import pytest
from scipy.optimize import least_squares

from tests.conftest import WITHOUT_TORCH

torch = pytest.importorskip("torch", reason=WITHOUT_TORCH)

from surrogate import Schedule, train_networks
from surrogate.training.least_squares import PLAIN_SCHEDULE
from surrogate.training.levenberg_marquardt import train
from surrogate.training.perceptron import PerceptronBatch, nguyen_widrow, split_parameters
from tests.surrogate.conftest import INPUTS, OUTPUTS, random_inputs, smooth_function

pytestmark = pytest.mark.slow

SIZES = (2, 4, 2)


def samples(n: int, seed: int = 0, noise: float = 0.0):
    rng = np.random.default_rng(seed)
    X = rng.uniform(-1, 1, (n, 2))
    T = np.column_stack([np.sin(2 * X[:, 0]) * X[:, 1], np.tanh(2 * X.sum(axis=1))])
    return X, T + rng.normal(scale=noise, size=T.shape) if noise else T


def starts(n: int, sizes=SIZES) -> np.ndarray:
    return np.stack([nguyen_widrow(np.random.default_rng(100 + j), sizes) for j in range(n)])


def batch(X, T, networks: int, hidden=(4,)) -> PerceptronBatch:
    return PerceptronBatch.from_samples(X, T, np.tile(np.arange(len(X)), (networks, 1)), hidden)


def errors(w, X, T, sizes=SIZES):
    (IW, LW), (b1, b2) = split_parameters(w, sizes)
    return (np.tanh(X @ IW.T + b1) @ LW.T + b2 - T).ravel()


def test_ends_in_the_minimum_that_scipy_finds_from_the_same_start():
    """Targets of a network of the same size, with noise; one start of six may lead to another local minimum."""
    sizes, rng = (2, 2, 2), np.random.default_rng(0)
    X, true = rng.uniform(-1, 1, (100, 2)), 2 * np.random.default_rng(5).normal(size=12)
    T = errors(true, X, 0.0, sizes).reshape(100, 2) + rng.normal(scale=0.1, size=(100, 2))
    w, ratios = starts(6, sizes), []
    fits = train(batch(X, T, 6, (2,)), w, Schedule(epochs=300, mu=0.001), evidence=False)
    for fit, start in zip(fits, w, strict=True):
        sse = fit.history.sse[-1]
        assert sse == pytest.approx(float((errors(fit.w, X, T, sizes) ** 2).sum()), rel=1e-9)
        ratios.append(sse / (2 * least_squares(errors, start, args=(X, T, sizes), method="lm", max_nfev=5000).cost))
    assert np.sum(np.abs(np.array(ratios) - 1) < 1e-8) >= 5, f"few minima in common: {ratios}"


def test_one_epoch_is_the_damped_gauss_newton_step():
    X, T = samples(40)
    [w] = starts(1)
    [fit] = train(batch(X, T, 1), w[None], Schedule(epochs=1, mu=0.001), evidence=False)
    J = np.column_stack([(errors(w + h, X, T) - errors(w - h, X, T)) / 2e-6 for h in 1e-6 * np.eye(len(w))])
    e = errors(w, X, T)
    mu = 0.001
    while ((errors(stepped := w - np.linalg.solve(J.T @ J + mu * np.eye(len(w)), J.T @ e), X, T) ** 2).sum()) >= e @ e:
        mu *= 10
    np.testing.assert_allclose(fit.w, stepped, rtol=1e-5)
    assert fit.history.mu[1] == pytest.approx(mu * 0.1)
    assert (fit.alpha, fit.beta, fit.log_evidence, fit.posterior_factor) == (0.0, 1.0, None, None)


@pytest.mark.parametrize("evidence", [False, True])
def test_validation_keeps_the_best_and_stops_after_six_failures(evidence):
    X, T = samples(40, noise=0.3)
    X_v, T_v = samples(40, seed=1, noise=0.3)
    hidden, w = (12,), starts(5, (2, 12, 2))
    validation = batch(X_v, T_v, 5, hidden)
    fits = train(batch(X, T, 5, hidden), w, PLAIN_SCHEDULE, evidence=evidence, validation=validation)
    at_end = validation.sum_squared_errors(torch.as_tensor(np.stack([fit.w for fit in fits]))).numpy()
    for fit, sse in zip(fits, at_end, strict=True):
        h = fit.history
        assert h.validation_sse[h.best_epoch] == h.validation_sse.min() == pytest.approx(sse, rel=1e-9)
        if h.stop == "validation":
            assert len(h.validation_sse) - 1 - h.best_epoch == 6
            assert (h.validation_sse[h.best_epoch + 1 :] > h.validation_sse[h.best_epoch]).all()
    assert any(fit.history.stop == "validation" for fit in fits)


@pytest.mark.parametrize("hidden", [(4,), (4, 3)])
@pytest.mark.parametrize("evidence", [False, True])
def test_every_tensor_is_made_on_the_device_of_the_data(hidden, evidence):
    """With another default device, a tensor that is made without naming the data's fails at the first use."""
    X, T = samples(30)
    sizes = (2, *hidden, 2)
    arguments = (batch(X, T, 3, hidden), starts(3, sizes), Schedule(epochs=12))
    options = {"evidence": evidence, "validation": batch(*samples(20, seed=1), 3, hidden)}
    expected = train(*arguments, **options)
    with torch.device("meta"):
        fits = train(*arguments, **options)
    for fit, usual in zip(fits, expected, strict=True):
        np.testing.assert_array_equal(fit.w, usual.w)


def test_a_deep_network_learns_a_known_function():
    """Two hidden layers; an error of 1 % of the range at new points."""
    X = random_inputs(300, seed=1)
    rows = np.tile(np.arange(300), (2, 1))
    trained = train_networks(
        X,
        smooth_function(X),
        inputs=INPUTS,
        outputs=OUTPUTS,
        rows=rows,
        seed=1,
        hidden=(6, 5),
        schedule=Schedule(epochs=100),
    )
    new = random_inputs(2000, seed=2)
    for network, _ in trained:
        assert network.sizes == (3, 6, 5, 2)
        error = (network.predict(new) - smooth_function(new)) / np.ptp(network.target_ranges, axis=1)
        assert np.sqrt(np.mean(error**2)) < 0.01
        assert (network.predict_std(new) > 0).all()


def test_wrong_methods_and_rows_are_refused():
    X = random_inputs(60, seed=2)
    arguments = {"inputs": INPUTS, "outputs": OUTPUTS, "rows": [[0, 1, 2]], "seed": 0}
    for change, message in (
        ({"method": "adam"}, "method is 'adam', but must be one of bayesian_regularization, levenberg_marquardt"),
        ({"validation_rows": [[3], [4]]}, "validation_rows has 2 rows of numbers, but there are 1 networks"),
        ({"hidden": ()}, r"hidden is \(\), but must be"),
    ):
        with pytest.raises(ValueError, match=message):
            train_networks(X, smooth_function(X), **(arguments | change))
