"""The normal equations of a batch of networks, against differences and against networks of torch's own layers."""

from itertools import pairwise

import numpy as np
import pytest

from tests.conftest import WITHOUT_TORCH

torch = pytest.importorskip("torch", reason=WITHOUT_TORCH)

from surrogate.training.perceptron import PerceptronBatch, nguyen_widrow, split_parameters

pytestmark = pytest.mark.slow

D, M = 3, 2
"""Inputs and outputs."""
B, N = 4, 30


@pytest.fixture(params=[(5,), (4, 3), (3, 4, 2)], ids=str)
def batch(request):
    rng = np.random.default_rng(3)
    X, T = rng.uniform(-1, 1, (50, D)), rng.uniform(-1, 1, (50, M))
    rows = np.stack([rng.permutation(50)[:N] for _ in range(B)])
    sizes = (D, *request.param, M)
    w = np.stack([nguyen_widrow(np.random.default_rng(j), sizes) for j in range(B)])
    problems = PerceptronBatch.from_samples(X, T, rows, request.param)
    return X, T, rows, w, problems, lambda w, X, T: torch_errors(w, X, T, sizes)


def torch_errors(w: torch.Tensor, X: np.ndarray, T: np.ndarray, sizes: tuple[int, ...]) -> torch.Tensor:
    """Errors (n m,) of one network by torch.nn.functional."""
    a, first = torch.as_tensor(X), 0
    for before, size in pairwise(sizes):
        last = first + size * (before + 1)
        layer = w[first:last].view(size, before + 1)
        y, first = torch.nn.functional.linear(a, layer[:, :-1], layer[:, -1]), last
        a = torch.tanh(y)
    return (y - torch.as_tensor(T)).ravel()


def test_sums_of_squares_are_those_of_torch_layers(batch):
    X, T, rows, w, problems, torch_errors = batch
    expected = [float((torch_errors(torch.as_tensor(w[j]), X[rows[j]], T[rows[j]]) ** 2).sum()) for j in range(B)]
    np.testing.assert_allclose(problems.sum_squared_errors(torch.as_tensor(w)), expected, rtol=1e-13)
    np.testing.assert_allclose(problems.normal_equations(torch.as_tensor(w))[0], expected, rtol=1e-13)
    assert problems.n_errors == N * M


def test_normal_equations_agree_with_central_differences(batch):
    X, T, rows, w, problems, torch_errors = batch
    _, JtJ, Jte = problems.normal_equations(torch.as_tensor(w))
    step = 1e-5
    for j in range(B):

        def errors(w_j, j=j):
            return torch_errors(torch.as_tensor(w_j), X[rows[j]], T[rows[j]]).numpy()

        shifts = step * np.eye(w.shape[1])
        J = np.column_stack([(errors(w[j] + h) - errors(w[j] - h)) / (2 * step) for h in shifts])
        np.testing.assert_allclose(JtJ[j], J.T @ J, atol=1e-8)
        np.testing.assert_allclose(Jte[j], J.T @ errors(w[j]), atol=1e-8)


def test_normal_equations_agree_with_automatic_differentiation(batch):
    X, T, rows, w, problems, torch_errors = batch
    _, JtJ, Jte = problems.normal_equations(torch.as_tensor(w))
    for j in range(B):
        w_j = torch.as_tensor(w[j])
        J = torch.autograd.functional.jacobian(lambda p, j=j: torch_errors(p, X[rows[j]], T[rows[j]]), w_j)
        e = torch_errors(w_j, X[rows[j]], T[rows[j]])
        torch.testing.assert_close(JtJ[j], J.T @ J, rtol=1e-12, atol=1e-12)
        torch.testing.assert_close(Jte[j], J.T @ e, rtol=1e-12, atol=1e-12)


def test_taken_networks_keep_their_own_samples(batch):
    *_, w, problems, _ = batch
    index = torch.tensor([False, True, False, True])
    everything = problems.sum_squared_errors(torch.as_tensor(w))
    some = problems.take(index).sum_squared_errors(torch.as_tensor(w)[index])
    torch.testing.assert_close(some, everything[index], rtol=0, atol=0)


def test_a_jacobian_in_parts_gives_the_same_normal_equations(batch, monkeypatch):
    *_, w, problems, _ = batch
    whole = problems.normal_equations(torch.as_tensor(w))
    monkeypatch.setattr("surrogate.training.perceptron.MEMORY", 8 * B * M * w.shape[1] * 7)  # 7 samples at a time
    for part, all_at_once in zip(problems.normal_equations(torch.as_tensor(w)), whole, strict=True):
        torch.testing.assert_close(part, all_at_once, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize(("d", "s"), [(4, 10), (2, 7), (1, 1)])
def test_initial_weights_are_those_of_nguyen_and_widrow(d, s):
    w = nguyen_widrow(np.random.default_rng(5), (d, s, 2))
    (IW, LW), (b1, b2) = split_parameters(w, (d, s, 2))
    assert (IW.shape, b1.shape, LW.shape, b2.shape) == ((s, d), (s,), (2, s), (2,))
    length = 0.7 * s ** (1 / d)
    np.testing.assert_allclose(np.linalg.norm(IW, axis=1), length)
    # Evenly spread centres: b = length x (-1 ... 1) x the sign of the first weight.
    expected = [0.0] if s == 1 else [length * (2 * k / (s - 1) - 1) for k in range(s)]
    np.testing.assert_allclose(b1 * np.sign(IW[:, 0]), expected, atol=1e-15)
    assert np.abs(np.concatenate([LW.ravel(), b2])).max() <= 1.0
