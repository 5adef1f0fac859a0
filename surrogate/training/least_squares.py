"""Least-squares problems for training: what is minimised, when to stop, and what is kept of a training."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from surrogate.scaling import Array
from surrogate.training.settings import Allowed, Number, Whole, check

if TYPE_CHECKING:
    from torch import Tensor


class Problems(Protocol):
    """A batch of B least-squares problems with P parameters each."""

    @property
    def n_errors(self) -> Tensor | float:
        """Number of errors of each problem (B,), or one for all; with weights, their sum."""

    def sum_squared_errors(self, w: Tensor) -> Tensor:
        """e'e (B,) at w (B, P), in float64."""

    def normal_equations(self, w: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """e'e (B,), J'J (B, P, P) and J'e (B, P) at w (B, P), in float64."""

    def take(self, index: Tensor) -> Problems:
        """The problems that `index` selects."""

    def to(self, device: str) -> Problems:
        """The same on a device of torch."""


ALLOWED: dict[str, Allowed] = {
    "epochs": Whole(0, 1_000_000),
    "mu": Number(1e-20, 1e20),
    "mu_decrease": Number(1e-10, 1.0),
    "mu_increase": Number(1.0, 1e10, above=True),
    "mu_max": Number(1e-20, 1e20),
    "min_grad": Number(0.0, 1e20),
    "max_fail": Whole(1, 1_000_000),
}
"""Settings of a `Schedule`."""


@dataclass(frozen=True)
class Schedule:
    """When to stop, and how to move the damping mu; the defaults are those of the reference trainer."""

    epochs: int = 1000
    mu: float = 0.005
    mu_decrease: float = 0.1
    mu_increase: float = 10.0
    mu_max: float = 1e10
    """Stop where no smaller damping gives a step that lowers F: the normal end of Bayesian regularisation."""
    min_grad: float = 1e-7
    """Stop where the gradient of F is no longer than this."""
    max_fail: int = 6
    """Stop where this many epochs in a row have not lowered the error on the validation data, where there are any."""

    def __post_init__(self) -> None:
        """Refuse what would never end."""
        check(vars(self), ALLOWED)


PLAIN_SCHEDULE = Schedule(mu=0.001)
"""The reference trainer's defaults without regularisation."""


@dataclass(frozen=True)
class History:
    """A training by epoch, from the initial weights on: arrays (epochs done + 1,)."""

    sse: Array
    """Sum of squared errors e'e on the scaled targets."""
    ssw: Array
    """Sum of squared parameters w'w."""
    gamma: Array
    """Effective number of parameters; all of them without regularisation."""
    alpha: Array
    beta: Array
    mu: Array
    validation_sse: Array
    """The sum of squared errors on the validation data; 0 without any."""
    stop: str
    """What ended it: 'epochs', 'mu_max', 'min_grad' or 'validation'."""
    best_epoch: int
    """Epoch of the weights that were kept: the last one, or that with the least validation error."""


RECORDED = ("sse", "ssw", "gamma", "alpha", "beta", "mu", "validation_sse")


@dataclass(frozen=True)
class Fit:
    """A trained problem: parameters w (P,) and, with Bayesian regularisation, what is known of their posterior.

    Without it alpha is 0, beta 1, gamma P, and the last two are None.
    """

    w: Array
    alpha: float
    beta: float
    gamma: float
    history: History
    log_evidence: float | None
    """ln p(targets | alpha, beta) of the scaled targets, in the quadratic approximation of F at w."""
    posterior_factor: Array | None
    """Upper triangular K (P, P) of the posterior covariance K'K."""
