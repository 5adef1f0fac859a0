"""Levenberg-Marquardt with Bayesian regularisation, for a batch of least-squares problems at once.

Each problem minimises F(w) = beta e'e + alpha w'w over its parameters w (P,). An epoch is one step d that lowers F,

    (beta J'J + (alpha + mu) I) d = -(beta J'e + alpha w),

followed by MacKay's re-estimation of the evidence parameters (Foresee and Hagan, ICNN 1997; the paper's section II-D,
with sums where its eq. 15 has means) from the number n of errors:

    gamma = P - alpha tr[(beta J'J + alpha I)^-1],      alpha = gamma / (2 w'w),      beta = (n - gamma) / (2 e'e).

Up to a constant, exp(-F) is the posterior density of w. So the noise has the variance 1 / (2 beta), and w the posterior
covariance [2 beta J'J + 2 alpha I]^-1.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import FIRST_EXCEPTION, CancelledError, ThreadPoolExecutor, wait
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Protocol

import numpy as np

from surrogate.scaling import Array

if TYPE_CHECKING:
    from torch import Tensor

LEAST_GROUP = 4
"""Fewer problems than this are not worth a thread of their own, as Python's share of the time grows."""

MU_MIN = 1e-20
"""Least damping, so that mu can rise again after many good steps."""


ROUNDING = 1e-14
"""Share of a matrix's trace that rounding in its Cholesky factor may reach."""

FEW_PARAMETERS = 1e-6
"""A gamma below this is a difference of numbers too nearly equal."""


class Problems(Protocol):
    """A batch of B least-squares problems with P parameters each."""

    @property
    def n_errors(self) -> int:
        """Number of errors of one problem."""

    def sum_squared_errors(self, w: Tensor) -> Tensor:
        """e'e (B,) at w (B, P), in float64."""

    def normal_equations(self, w: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """e'e (B,), J'J (B, P, P) and J'e (B, P) at w (B, P), in float64."""

    def take(self, index: Tensor) -> Problems:
        """The problems that `index` selects."""


@dataclass(frozen=True)
class Schedule:
    """When to stop, and how to move the damping mu; the defaults are those of the reference trainer."""

    epochs: int = 1000
    mu: float = 0.005
    mu_decrease: float = 0.1
    mu_increase: float = 10.0
    mu_max: float = 1e10
    """Stop where no smaller damping gives a step that lowers F: the normal end."""
    min_grad: float = 1e-7
    """Stop where the gradient of F is no longer than this."""


@dataclass(frozen=True)
class History:
    """A training by epoch, from the initial weights on: arrays (epochs done + 1,)."""

    sse: Array
    """Sum of squared errors e'e on the scaled targets."""
    ssw: Array
    """Sum of squared parameters w'w."""
    gamma: Array
    """Effective number of parameters."""
    alpha: Array
    beta: Array
    mu: Array
    stop: str
    """What ended it: 'epochs', 'mu_max' or 'min_grad'."""


RECORDED = ("sse", "ssw", "gamma", "alpha", "beta", "mu")


@dataclass(frozen=True)
class Fit:
    """A trained problem: parameters w (P,), evidence parameters, factor K (P, P) of the posterior covariance K'K."""

    w: Array
    alpha: float
    beta: float
    gamma: float
    posterior_factor: Array
    history: History


@dataclass(frozen=True)
class _State:
    """The problems still in training; the first axis of every tensor is the batch."""

    number: Tensor
    epoch: Tensor
    w: Tensor
    sse: Tensor
    JtJ: Tensor
    Jte: Tensor
    gamma: Tensor
    alpha: Tensor
    beta: Tensor
    mu: Tensor

    @property
    def ssw(self) -> Tensor:
        return (self.w * self.w).sum(1)

    @property
    def objective(self) -> Tensor:
        return self.beta * self.sse + self.alpha * self.ssw

    @property
    def half_gradient(self) -> Tensor:
        """Half the gradient of F, beta J'e + alpha w (B, P)."""
        return self.beta[:, None] * self.Jte + self.alpha[:, None] * self.w

    def take(self, index: Tensor) -> _State:
        return _State(*(getattr(self, field.name)[index] for field in fields(self)))

    def updated(self, index: Tensor, rows: _State) -> _State:
        """This state with `rows` in the place of the problems that `index` selects."""
        return _State(
            *(getattr(self, f.name).clone().index_put_((index,), getattr(rows, f.name)) for f in fields(self))
        )


def train(
    problems: Problems, w: Array, schedule: Schedule, progress: Callable[[int, int], None] | None = None
) -> list[Fit]:
    """Train every problem from its initial parameters w (B, P).

    The batch is divided among as many Python threads as torch has, and torch itself held to one thread in each: its
    operations are too small to be divided. No problem's result depends on this division or on the other problems.
    `progress(epochs done, all epochs)` follows the slowest problem, in calls that do not overlap.
    """
    import torch

    torch_threads = torch.get_num_threads()
    n_groups = min(torch_threads, -(-len(w) // LEAST_GROUP))
    done, lock, cancelled = [0] * n_groups, threading.Lock(), threading.Event()

    def train_group(group: int) -> list[Fit]:
        def report(epochs: int) -> None:
            if cancelled.is_set():
                raise CancelledError
            with lock:
                done[group] = epochs
                if progress:
                    progress(min(done), schedule.epochs)

        numbers = torch.arange(group, len(w), n_groups)
        return _train_group(problems.take(numbers), torch.from_numpy(w)[numbers], schedule, report)

    torch.set_num_threads(1)
    try:
        with ThreadPoolExecutor(n_groups) as pool:
            futures = [pool.submit(train_group, group) for group in range(n_groups)]
            try:
                finished, _ = wait(futures, return_when=FIRST_EXCEPTION)
            finally:
                cancelled.set()
            fits = {future: future.result() for future in finished}
    finally:
        torch.set_num_threads(torch_threads)
    return [fits[futures[j % n_groups]][j // n_groups] for j in range(len(w))]


def _train_group(problems: Problems, w: Tensor, schedule: Schedule, report: Callable[[int], None]) -> list[Fit]:
    """Train a group as one batch, which a problem leaves when it stops; `report(epochs)` follows the slowest."""
    import torch

    state = _start(problems, w, schedule.mu)
    history = torch.empty(len(w), schedule.epochs + 1, len(RECORDED), dtype=torch.float64)
    changed = torch.ones(len(w), dtype=torch.bool)
    fits: dict[int, Fit] = {}
    while True:
        row = torch.stack([getattr(state, name) for name in RECORDED], dim=1)
        history[state.number[changed], state.epoch[changed]] = row[changed]
        going = torch.ones(len(state.number), dtype=torch.bool)
        for stop, reached in _stops(state, schedule).items():
            for i in (reached & going).nonzero().ravel().tolist():
                fits[int(state.number[i])] = _fit(state, i, history, stop)
            going &= ~reached
        if not going.any():
            break
        if not going.all():
            state, problems = state.take(going), problems.take(going)
        epoch = state.epoch
        state = _step(problems, state, schedule)
        changed = state.epoch > epoch
        report(int(state.epoch.min()))
    report(schedule.epochs)
    return [fits[i] for i in range(len(w))]


def _start(problems: Problems, w: Tensor, mu: float) -> _State:
    """The initial state: all P parameters effective."""
    import torch

    sse, JtJ, Jte = problems.normal_equations(w)
    gamma = torch.full_like(sse, w.shape[1])
    alpha, beta = evidence_parameters(gamma, sse, (w * w).sum(1), problems.n_errors)
    number = torch.arange(len(w))
    return _State(number, 0 * number, w, sse, JtJ, Jte, gamma, alpha, beta, torch.full_like(sse, mu))


def _stops(state: _State, schedule: Schedule) -> dict[str, Tensor]:
    """Which problems (B,) have reached each of the ends, the first of them first."""
    return {
        "min_grad": 2 * state.half_gradient.norm(dim=1) <= schedule.min_grad,
        "epochs": state.epoch >= schedule.epochs,
        "mu_max": state.mu > schedule.mu_max,
    }


def _step(problems: Problems, state: _State, schedule: Schedule) -> _State:
    """Try a step in each problem: where it lowers F, take it and re-estimate alpha and beta; elsewhere raise mu."""
    import torch

    L, breakdown = torch.linalg.cholesky_ex(_shifted(state.JtJ, state.beta, state.alpha + state.mu))
    w = state.w - torch.cholesky_solve(state.half_gradient[:, :, None], L)[:, :, 0]
    F = state.beta * problems.sum_squared_errors(w) + state.alpha * (w * w).sum(1)
    lower = (breakdown == 0) & (state.objective > F)

    refused = replace(state, mu=state.mu * schedule.mu_increase)
    if not lower.any():
        return refused
    before, w = state.take(lower), w[lower]
    sse, JtJ, Jte = problems.take(lower).normal_equations(w)
    gamma = effective_parameters(JtJ, before.alpha, before.beta)
    alpha, beta = evidence_parameters(gamma, sse, (w * w).sum(1), problems.n_errors)
    mu = (before.mu * schedule.mu_decrease).clamp(min=MU_MIN)
    return refused.updated(lower, _State(before.number, before.epoch + 1, w, sse, JtJ, Jte, gamma, alpha, beta, mu))


def _shifted(JtJ: Tensor, beta: Tensor, shift: Tensor) -> Tensor:
    """Beta J'J + shift I (B, P, P)."""
    H = beta[:, None, None] * JtJ
    H.diagonal(dim1=1, dim2=2).add_(shift[:, None])
    return H


def effective_parameters(JtJ: Tensor, alpha: Tensor, beta: Tensor) -> Tensor:
    """Gamma = P - alpha tr[(beta J'J + alpha I)^-1] (B,).

    The difference is lost in rounding where alpha is far below or far above beta J'J. There the eigenvalues of J'J give
    the same number as sum beta lambda / (beta lambda + alpha), at a higher price.
    """
    import torch

    P = JtJ.shape[1]
    H = _shifted(JtJ, beta, alpha)
    L, breakdown = torch.linalg.cholesky_ex(H)
    # With H = L L', tr(H^-1) is the sum of the squares of L^-1.
    L_inverse = torch.linalg.solve_triangular(L, torch.eye(P, dtype=L.dtype).expand_as(L), upper=False)
    gamma = P - alpha * (L_inverse * L_inverse).sum((1, 2))
    trace = H.diagonal(dim1=1, dim2=2).sum(1)
    lost = (breakdown != 0) | (alpha < ROUNDING * trace) | (gamma < FEW_PARAMETERS)
    if lost.any():
        eigenvalues = torch.linalg.eigvalsh(JtJ[lost])
        numerical_zero = eigenvalues < P * torch.finfo(L.dtype).eps * eigenvalues[:, -1:]
        determined = beta[lost, None] * eigenvalues.masked_fill(numerical_zero, 0.0)
        gamma[lost] = (determined / (determined + alpha[lost, None])).sum(1)
    return gamma


def evidence_parameters(gamma: Tensor, sse: Tensor, ssw: Tensor, n_errors: int) -> tuple[Tensor, Tensor]:
    """Alpha and beta (B,) for gamma effective parameters (B,); a beta that is not positive and finite becomes 1."""
    import torch

    beta = (n_errors - gamma) / (2 * sse)
    return gamma / (2 * ssw), torch.where((beta > 0) & beta.isfinite(), beta, 1.0)


def posterior_factor(JtJ: Array, alpha: float, beta: float) -> Array:
    """Upper triangular K (P, P) with K'K = [2 beta J'J + 2 alpha I]^-1.

    By eigenvalues, which stay exact where alpha is lost in the rounding of beta J'J.
    """
    eigenvalues, V = np.linalg.eigh(JtJ)
    variances = 1.0 / (2.0 * beta * eigenvalues.clip(min=0.0) + 2.0 * alpha)
    return np.asarray(np.linalg.qr(np.sqrt(variances)[:, None] * V.T, mode="r"))


def _fit(state: _State, i: int, history: Tensor, stop: str) -> Fit:
    w, JtJ = state.w[i].numpy().copy(), state.JtJ[i].numpy()
    alpha, beta, gamma = (float(value[i]) for value in (state.alpha, state.beta, state.gamma))
    columns = dict(zip(RECORDED, history[state.number[i], : int(state.epoch[i]) + 1].T.numpy().copy(), strict=True))
    return Fit(w, alpha, beta, gamma, posterior_factor(JtJ, alpha, beta), History(**columns, stop=stop))
