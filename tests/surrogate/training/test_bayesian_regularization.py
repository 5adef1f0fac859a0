"""The step and the evidence parameters, against closed forms of the linear model."""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.stats import multivariate_normal

from tests.conftest import WITHOUT_TORCH

torch = pytest.importorskip("torch", reason=WITHOUT_TORCH)

from surrogate.training.bayesian_regularization import effective_parameters
from surrogate.training.least_squares import Schedule
from surrogate.training.levenberg_marquardt import train
from surrogate.training.perceptron import PerceptronBatch, nguyen_widrow

pytestmark = pytest.mark.slow


@dataclass
class LinearProblems:
    """Errors A w - t, with A (B, n, P) and t (B, n)."""

    A: torch.Tensor
    t: torch.Tensor

    @property
    def n_errors(self):
        return self.A.shape[1]

    def errors(self, w):
        return (self.A @ w[:, :, None])[:, :, 0] - self.t

    def sum_squared_errors(self, w):
        return (self.errors(w) ** 2).sum(1)

    def normal_equations(self, w):
        return self.sum_squared_errors(w), self.A.mT @ self.A, (self.A.mT @ self.errors(w)[:, :, None])[:, :, 0]

    def take(self, index):
        return LinearProblems(self.A[index], self.t[index])

    def to(self, device):
        return LinearProblems(self.A.to(device), self.t.to(device))


@pytest.fixture
def linear():
    """Three noisy linear problems whose last columns matter little, so that gamma is well below P."""
    rng = np.random.default_rng(11)
    A = rng.normal(size=(3, 60, 12)) * np.geomspace(1.0, 0.03, 12)
    t = (A @ rng.normal(size=(3, 12, 1)))[..., 0] + rng.normal(scale=[[0.1], [0.3], [0.5]], size=(3, 60))
    return A, t, LinearProblems(torch.as_tensor(A), torch.as_tensor(t)), rng.normal(size=(3, 12))


def perceptrons(n_networks: int, seed: int = 0):
    rng = np.random.default_rng(seed)
    X = rng.uniform(-1, 1, (120, 2))
    T = np.column_stack([np.sin(3 * X[:, 0]) * X[:, 1], np.tanh(2 * X.sum(axis=1))])
    T += rng.normal(scale=0.02, size=T.shape)
    rows = np.stack([np.random.default_rng(j).permutation(120)[:100] for j in range(n_networks)])
    w = np.stack([nguyen_widrow(np.random.default_rng(100 + j), (2, 6, 2)) for j in range(n_networks)])
    return PerceptronBatch.from_samples(X, T, rows, [6]), w


def test_one_epoch_is_the_step_and_the_updates_of_the_source(linear):
    A, t, problems, w = linear
    fits = train(problems, w, Schedule(epochs=1))
    for j, fit in enumerate(fits):
        (n, P), e = A[j].shape, A[j] @ w[j] - t[j]
        alpha, beta = P / (2 * w[j] @ w[j]), (n - P) / (2 * e @ e)
        H = beta * A[j].T @ A[j] + (alpha + 0.005) * np.eye(P)
        stepped = w[j] - np.linalg.solve(H, beta * A[j].T @ e + alpha * w[j])
        np.testing.assert_allclose(fit.w, stepped, rtol=1e-9)

        gamma = P - alpha * np.trace(np.linalg.inv(beta * A[j].T @ A[j] + alpha * np.eye(P)))
        e = A[j] @ stepped - t[j]
        np.testing.assert_allclose(fit.gamma, gamma, rtol=1e-10)
        np.testing.assert_allclose(fit.alpha, gamma / (2 * stepped @ stepped), rtol=1e-9)
        np.testing.assert_allclose(fit.beta, (n - gamma) / (2 * e @ e), rtol=1e-9)
        np.testing.assert_allclose(fit.history.mu, [0.005, 0.0005])
        np.testing.assert_allclose(fit.history.sse[-1], e @ e, rtol=1e-9)
        assert fit.history.gamma[0] == P
        assert fit.history.stop == "epochs"


def test_linear_model_ends_where_the_evidence_is_greatest(linear):
    """Its targets are Gaussian with the covariance I / (2 beta) + A A' / (2 alpha): maximise that density."""
    A, t, problems, w = linear
    for j, fit in enumerate(train(problems, w, Schedule())):
        identity = np.eye(60)

        def minus_log_evidence(log_parameters, j=j, identity=identity):
            alpha, beta = np.exp(log_parameters)
            return -multivariate_normal.logpdf(t[j], cov=identity / (2 * beta) + A[j] @ A[j].T / (2 * alpha))

        best = minimize(minus_log_evidence, [0.0, 1.0], method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-12})
        alpha, beta = np.exp(best.x)
        np.testing.assert_allclose([fit.alpha, fit.beta], [alpha, beta], rtol=1e-5)
        assert fit.log_evidence == pytest.approx(-best.fun, abs=1e-6)

        precision = 2 * beta * A[j].T @ A[j] + 2 * alpha * np.eye(12)
        posterior_mean = np.linalg.solve(precision, 2 * beta * A[j].T @ t[j])
        np.testing.assert_allclose(fit.w, posterior_mean, rtol=1e-4, atol=1e-6)
        gamma = 12 - 2 * alpha * np.trace(np.linalg.inv(precision))
        np.testing.assert_allclose(fit.gamma, gamma, rtol=1e-5)
        assert 6 < gamma < 11.5
        np.testing.assert_allclose(fit.posterior_factor.T @ fit.posterior_factor, np.linalg.inv(precision), rtol=1e-4)
        assert (np.tril(fit.posterior_factor, -1) == 0).all()


def test_each_epoch_lowers_the_objective_and_moves_mu_by_factors_of_ten():
    problems, w = perceptrons(3)
    for fit in train(problems, w, Schedule(epochs=80)):
        h = fit.history
        before = h.beta[:-1] * h.sse[:-1] + h.alpha[:-1] * h.ssw[:-1]
        after = h.beta[:-1] * h.sse[1:] + h.alpha[:-1] * h.ssw[1:]
        assert (after < before).all()
        exponents = np.log10(h.mu[1:] / h.mu[:-1])
        np.testing.assert_allclose(exponents, np.round(exponents), atol=1e-9)
        assert exponents.min() == pytest.approx(-1.0)
        assert exponents.max() > 0.5, "no step was ever refused, so the rise of mu was not tested"
        assert len(h.sse) == len(h.gamma) == 81


def test_training_stops_at_each_of_its_ends(linear):
    *_, problems, w = linear
    short = train(problems, w, Schedule(epochs=3))
    assert [(fit.history.stop, len(fit.history.sse)) for fit in short] == [("epochs", 4)] * 3
    loose = train(problems, w, Schedule(min_grad=1e-3))
    for j, fit in enumerate(loose):
        _, _, Jte = problems.normal_equations(torch.as_tensor(np.stack([f.w for f in loose])))
        gradient = 2 * np.linalg.norm(fit.beta * Jte[j].numpy() + fit.alpha * fit.w)
        assert (fit.history.stop, gradient <= 1e-3) == ("min_grad", True)
    perceptron, w = perceptrons(2)
    stuck = train(perceptron, w, Schedule(min_grad=0.0, epochs=5000))
    assert [fit.history.stop for fit in stuck] == ["mu_max"] * 2
    assert max(fit.history.mu.max() for fit in stuck) <= 1e10


def test_result_does_not_depend_on_the_batch_or_the_threads():
    problems, w = perceptrons(9)
    together = train(problems, w, Schedule(epochs=60))
    threads = torch.get_num_threads()
    try:
        torch.set_num_threads(1)
        one_thread = train(problems, w, Schedule(epochs=60))
    finally:
        torch.set_num_threads(threads)
    for j, fit in enumerate(together):
        [alone] = train(problems.take(torch.tensor([j])), w[[j]], Schedule(epochs=60))
        assert fit.w.tobytes() == alone.w.tobytes() == one_thread[j].w.tobytes()
        assert fit.posterior_factor.tobytes() == one_thread[j].posterior_factor.tobytes()


@pytest.mark.parametrize(
    ("eigenvalues", "alpha", "beta", "expected"),
    [
        ([4.0, 1.0, 0.25], 0.5, 2.0, 16 / 17 + 4 / 5 + 1 / 2),
        # Far below rounding, alpha leaves the rank.
        ([3.0, 1e-3, 0.0], 1e-30, 1e6, 2.0),
        # Far above, gamma is beta tr(J'J) / alpha.
        ([3.0, 2.0, 1.0], 1e20, 1.0, 6e-20),
    ],
)
def test_effective_parameters_of_known_eigenvalues(eigenvalues, alpha, beta, expected):
    rotation = np.linalg.qr(np.random.default_rng(8).normal(size=(3, 3)))[0]
    JtJ = torch.as_tensor(rotation @ np.diag(eigenvalues) @ rotation.T)[None]
    gamma = effective_parameters(JtJ, torch.tensor([alpha]).double(), torch.tensor([beta]).double())
    assert float(gamma) == pytest.approx(expected, rel=1e-9)


def test_more_parameters_than_errors_make_beta_one():
    rng = np.random.default_rng(2)
    A, t = rng.normal(size=(1, 5, 8)), rng.normal(size=(1, 5))
    [fit] = train(LinearProblems(torch.as_tensor(A), torch.as_tensor(t)), rng.normal(size=(1, 8)), Schedule())
    assert fit.history.beta[0] == 1.0
    assert 0 < fit.gamma <= 5
    assert_finite(fit)


def test_targets_without_noise_and_a_redundant_column_leave_nothing_undefined():
    rng = np.random.default_rng(4)
    A = rng.normal(size=(1, 40, 3))
    A = np.concatenate([A, A[..., :1]], axis=2)
    t = A @ np.array([1.0, -2.0, 0.5, 0.0])
    [fit] = train(LinearProblems(torch.as_tensor(A), torch.as_tensor(t)), rng.normal(size=(1, 4)), Schedule())
    np.testing.assert_allclose(A[0] @ fit.w, t[0], atol=1e-9)
    assert fit.gamma == pytest.approx(3, abs=1e-6)
    assert_finite(fit)


def test_targets_that_the_model_cannot_explain_shrink_every_parameter():
    rng = np.random.default_rng(6)
    A = np.linalg.qr(rng.normal(size=(40, 3)))[0]
    t = rng.normal(size=40)
    t -= 0.999 * A @ (A.T @ t)
    problems = LinearProblems(torch.as_tensor(A[None]), torch.as_tensor(t[None]))
    [fit] = train(problems, rng.normal(size=(1, 3)), Schedule())
    np.testing.assert_allclose(fit.w, 0.0, atol=1e-5)
    assert 0 <= fit.gamma < 1e-3
    assert fit.beta == pytest.approx(40 / (2 * t @ t), rel=1e-4)
    assert_finite(fit)


def assert_finite(fit):
    assert np.isfinite([fit.alpha, fit.beta, fit.gamma, *fit.posterior_factor.ravel(), *fit.history.mu]).all()


def test_progress_rises_to_the_end():
    problems, w = perceptrons(8)
    calls = []
    train(problems, w, Schedule(epochs=40), progress=lambda done, all_epochs: calls.append((done, all_epochs)))
    done = [epochs for epochs, _ in calls]
    assert done == sorted(done)
    assert calls[-1] == (40, 40)


@pytest.mark.parametrize("at_call", [1, 2, 15])
def test_an_interrupted_training_ends_in_every_thread_and_gives_the_threads_back(at_call):
    problems, w = perceptrons(8)
    threads, calls = torch.get_num_threads(), []

    def interrupt(done, all_epochs):
        calls.append(done)
        if len(calls) == at_call:
            raise KeyboardInterrupt

    torch.set_num_threads(2)
    try:
        with pytest.raises(KeyboardInterrupt):
            train(problems, w, Schedule(), progress=interrupt)
        assert torch.get_num_threads() == 2
    finally:
        torch.set_num_threads(threads)
    # A whole training takes hundreds of passes in each of the two threads.
    assert len(calls) < at_call + 50
