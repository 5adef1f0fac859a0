"""Levenberg-Marquardt for a batch of least-squares problems at once, with or without Bayesian regularisation.

Each problem minimises F(w) = beta e'e + alpha w'w over its parameters w (P,). An epoch is one step d that lowers F,

    (beta J'J + (alpha + mu) I) d = -(beta J'e + alpha w),

where mu falls after a step that does and rises after one that does not. Plain Levenberg-Marquardt has alpha = 0 and
beta = 1; with Bayesian regularisation both are estimated anew after each epoch (`bayesian_regularization`).
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import FIRST_EXCEPTION, CancelledError, ThreadPoolExecutor, wait
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING

from surrogate.scaling import Array
from surrogate.training.bayesian_regularization import (
    effective_parameters,
    evidence_parameters,
    log_evidence,
    posterior_factor,
    shifted,
)
from surrogate.training.least_squares import RECORDED, Fit, History, Problems, Schedule

if TYPE_CHECKING:
    from torch import Tensor

LEAST_GROUP = 4
"""Fewer problems than this are not worth a thread of their own, as Python's share of the time grows."""

MU_MIN = 1e-20
"""Least damping, so that mu can rise again after many good steps."""

Progress = Callable[[int, int], None]
"""Called with the number of finished steps and of all."""


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
    validation_sse: Tensor
    best_w: Tensor
    best_validation_sse: Tensor
    best_epoch: Tensor

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


@dataclass(frozen=True)
class _Trainer:
    """What is minimised, and on what."""

    schedule: Schedule
    evidence: bool


def train(
    problems: Problems,
    w: Array,
    schedule: Schedule,
    *,
    evidence: bool = True,
    validation: Problems | None = None,
    device: str = "cpu",
    progress: Progress | None = None,
) -> list[Fit]:
    """Train every problem from its initial parameters w (B, P).

    `evidence` estimates alpha and beta; otherwise they stay 0 and 1. With `validation`, the same problems on other
    samples, a training stops early and keeps the parameters of the least error there.

    On the processor the batch is divided among as many Python threads as torch has, and torch itself held to one thread
    in each: its operations are too small to be divided. No problem's result depends on this division or on the other
    problems. Another device trains the whole batch at once. `progress(epochs done, all epochs)` follows the slowest
    problem, in calls that do not overlap.
    """
    import torch

    check_device(device)
    torch_threads = torch.get_num_threads()
    n_groups = min(torch_threads, -(-len(w) // LEAST_GROUP)) if torch.device(device).type == "cpu" else 1
    trainer = _Trainer(schedule, evidence)
    done, lock, cancelled = [0] * n_groups, threading.Lock(), threading.Event()

    def train_group(group: int) -> list[Fit]:
        def report(epochs: int) -> None:
            if cancelled.is_set():
                raise CancelledError
            with lock:
                done[group] = epochs
                if progress:
                    progress(min(done), schedule.epochs)

        numbers = torch.arange(group, len(w), n_groups, device="cpu")
        own, own_validation = (part and part.take(numbers).to(device) for part in (problems, validation))
        assert own is not None
        return _train_group(own, own_validation, torch.from_numpy(w)[numbers].to(device), trainer, report)

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


def check_device(device: str) -> None:
    """Refuse a device that does not compute.

    Raises:
        ValueError: torch's reason.
    """
    import torch

    try:
        torch.zeros(1, device=torch.device(device)).item()
    except Exception as error:  # of many kinds, one for each way in which a device is missing
        reason = (str(error).splitlines() or [""])[0][:120]
        raise ValueError(f"torch cannot use the device {device!r} ({reason}): take cpu.") from None


def _train_group(
    problems: Problems, validation: Problems | None, w: Tensor, trainer: _Trainer, report: Callable[[int], None]
) -> list[Fit]:
    """Train a group as one batch, which a problem leaves when it stops; `report(epochs)` follows the slowest."""
    import torch

    schedule = trainer.schedule
    state = _start(problems, validation, w, trainer)
    history = w.new_empty(len(w), schedule.epochs + 1, len(RECORDED))
    changed = torch.ones_like(state.number, dtype=torch.bool)
    fits: dict[int, Fit] = {}
    while True:
        row = torch.stack([getattr(state, name) for name in RECORDED], dim=1)
        history[state.number[changed], state.epoch[changed]] = row[changed]
        going = torch.ones_like(state.number, dtype=torch.bool)
        for stop, reached in _stops(state, schedule).items():
            ended = reached & going
            if ended.any():
                for fit, number in _fits(problems.take(ended), state.take(ended), history, stop, trainer):
                    fits[number] = fit
            going &= ~reached
        if not going.any():
            break
        if not going.all():
            state, problems = state.take(going), problems.take(going)
            validation = validation and validation.take(going)
        epoch = state.epoch
        state = _step(problems, validation, state, trainer)
        changed = state.epoch > epoch
        report(int(state.epoch.min()))
    report(schedule.epochs)
    return [fits[i] for i in range(len(w))]


def _start(problems: Problems, validation: Problems | None, w: Tensor, trainer: _Trainer) -> _State:
    """The initial state: all P parameters effective."""
    import torch

    sse, JtJ, Jte = problems.normal_equations(w)
    gamma = torch.full_like(sse, w.shape[1])
    alpha, beta = _weights_of_the_objective(gamma, sse, w, trainer, problems)
    number = torch.arange(len(w), device=w.device)
    mu = torch.full_like(sse, trainer.schedule.mu)
    validation_sse = validation.sum_squared_errors(w) if validation else torch.zeros_like(sse)
    epoch = torch.zeros_like(number)
    return _State(
        number, epoch, w, sse, JtJ, Jte, gamma, alpha, beta, mu, validation_sse, w, validation_sse, epoch.clone()
    )


def _weights_of_the_objective(
    gamma: Tensor, sse: Tensor, w: Tensor, trainer: _Trainer, problems: Problems
) -> tuple[Tensor, Tensor]:
    """Alpha and beta (B,)."""
    import torch

    if not trainer.evidence:
        return torch.zeros_like(sse), torch.ones_like(sse)
    return evidence_parameters(gamma, sse, (w * w).sum(1), problems.n_errors)


def _stops(state: _State, schedule: Schedule) -> dict[str, Tensor]:
    """Which problems (B,) have reached each of the ends, the first of them first."""
    return {
        "min_grad": 2 * state.half_gradient.norm(dim=1) <= schedule.min_grad,
        "epochs": state.epoch >= schedule.epochs,
        "mu_max": state.mu > schedule.mu_max,
        "validation": state.epoch - state.best_epoch >= schedule.max_fail,
    }


def _step(problems: Problems, validation: Problems | None, state: _State, trainer: _Trainer) -> _State:
    """Try a step in each problem: where it lowers F, take it and re-estimate alpha and beta; elsewhere raise mu."""
    import torch

    schedule = trainer.schedule
    L, breakdown = torch.linalg.cholesky_ex(shifted(state.JtJ, state.beta, state.alpha + state.mu))
    w = state.w - torch.cholesky_solve(state.half_gradient[:, :, None], L)[:, :, 0]
    F = state.beta * problems.sum_squared_errors(w) + state.alpha * (w * w).sum(1)
    lower = (breakdown == 0) & (state.objective > F)

    refused = replace(state, mu=state.mu * schedule.mu_increase)
    if not lower.any():
        return refused
    before, w, problems = state.take(lower), w[lower], problems.take(lower)
    sse, JtJ, Jte = problems.normal_equations(w)
    gamma = effective_parameters(JtJ, before.alpha, before.beta) if trainer.evidence else before.gamma
    alpha, beta = _weights_of_the_objective(gamma, sse, w, trainer, problems)
    mu = (before.mu * schedule.mu_decrease).clamp(min=MU_MIN)
    epoch = before.epoch + 1
    validation_sse = validation.take(lower).sum_squared_errors(w) if validation else before.validation_sse
    better = validation_sse <= before.best_validation_sse
    taken = _State(
        before.number,
        epoch,
        w,
        sse,
        JtJ,
        Jte,
        gamma,
        alpha,
        beta,
        mu,
        validation_sse,
        torch.where(better[:, None], w, before.best_w),
        torch.where(better, validation_sse, before.best_validation_sse),
        torch.where(better, epoch, before.best_epoch),
    )
    return refused.updated(lower, taken)


def _fits(problems: Problems, state: _State, history: Tensor, stop: str, trainer: _Trainer) -> list[tuple[Fit, int]]:
    """The ended problems with their numbers, at the best of their parameters."""
    import torch

    JtJ = state.JtJ
    if (state.best_epoch != state.epoch).any():
        _, JtJ, _ = problems.normal_equations(state.best_w)
    n_errors = torch.as_tensor(problems.n_errors).expand(len(state.number))
    found = []
    for i, number in enumerate(state.number.tolist()):
        best, last = int(state.best_epoch[i]), int(state.epoch[i])
        columns = dict(zip(RECORDED, history[number, : last + 1].T.cpu().numpy().copy(), strict=True))
        record = History(**columns, stop=stop, best_epoch=best)
        alpha, beta, gamma = (float(values[best]) for values in (record.alpha, record.beta, record.gamma))
        evidence, factor = None, None
        if trainer.evidence:
            matrix = JtJ[i].cpu().numpy()
            F = beta * record.sse[best] + alpha * record.ssw[best]
            evidence = log_evidence(matrix, alpha, beta, F, float(n_errors[i]))
            factor = posterior_factor(matrix, alpha, beta)
        w = state.best_w[i].cpu().numpy().copy()
        found.append((Fit(w, alpha, beta, gamma, record, evidence, factor), number))
    return found
