"""Networks of tansig neurons: trained by Levenberg-Marquardt, alone or with Bayesian regularisation."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike
from sklearn.utils import check_random_state

from surrogate.estimators.regressor import ALLOWED, SurrogateRegressor, progress_bar
from surrogate.models.network import Network
from surrogate.training.least_squares import Schedule
from surrogate.training.settings import check
from surrogate.training.train import METHODS, Method, train_networks


class _NetworkRegressor(SurrogateRegressor):
    """Networks of tansig neurons with linear outputs, trained from several initial weights at once."""

    network_: Network
    _method: ClassVar[Method]
    _usual_validation_fraction: ClassVar[float | None]

    def __init__(
        self,
        hidden_layer_sizes: int | Sequence[int] = 10,
        *,
        restarts: int = 5,
        epochs: int = 1000,
        mu: float | None = None,
        mu_decrease: float = 0.1,
        mu_increase: float = 10.0,
        mu_max: float = 1e10,
        min_grad: float = 1e-7,
        validation_fraction: float | Literal["auto"] | None = "auto",
        max_fail: int = 6,
        device: str = "cpu",
        random_state: int | np.random.RandomState | None = None,
        verbose: bool = False,
    ):
        self.hidden_layer_sizes = hidden_layer_sizes
        self.restarts = restarts
        self.epochs = epochs
        self.mu = mu
        self.mu_decrease = mu_decrease
        self.mu_increase = mu_increase
        self.mu_max = mu_max
        self.min_grad = min_grad
        self.validation_fraction = validation_fraction
        self.max_fail = max_fail
        self.device = device
        self.random_state = random_state
        self.verbose = verbose

    def fit(self, X: ArrayLike, y: ArrayLike, sample_weight: ArrayLike | None = None) -> _NetworkRegressor:
        """Train on X (n, d) and y (n,) or (n, m); a sample counts as often as its weight (n,) says."""
        X, Y, weights, inputs, outputs = self._samples(X, y, sample_weight)
        check({"restarts": self.restarts, "hidden_layer_sizes": self.hidden_layer_sizes}, ALLOWED)
        rng = check_random_state(self.random_state)
        seed = int(rng.randint(2**31 - 1))
        rows, validation_rows = self._split(len(X), self._validation_fraction, rng)
        default = METHODS[self._method][1]
        schedule = Schedule(
            self.epochs,
            default.mu if self.mu is None else self.mu,
            self.mu_decrease,
            self.mu_increase,
            self.mu_max,
            self.min_grad,
            self.max_fail,
        )
        with progress_bar(type(self).__name__, self.verbose) as progress:
            trained = train_networks(
                X,
                Y,
                inputs=inputs,
                outputs=outputs,
                rows=np.tile(rows, (self.restarts, 1)),
                validation_rows=None if validation_rows is None else np.tile(validation_rows, (self.restarts, 1)),
                seed=seed,
                hidden=self.hidden_layer_sizes,
                method=self._method,
                schedule=schedule,
                sample_weight=weights,
                device=self.device,
                progress=progress,
            )
        self.networks_ = [network for network, _ in trained]
        self.histories_ = [history for _, history in trained]
        self.best_restart_ = int(np.argmin(self._losses()))
        self.network_, self.history_ = trained[self.best_restart_]
        self.n_iter_ = len(self.history_.sse) - 1
        return self

    @property
    def _validation_fraction(self) -> float | None:
        return self._usual_validation_fraction if self.validation_fraction == "auto" else self.validation_fraction

    def _losses(self) -> list[float]:
        """What decides among the restarts: the error on the validation data, or else on the training data."""
        if self._validation_fraction:
            return [float(history.validation_sse[history.best_epoch]) for history in self.histories_]
        return [float(history.sse[-1]) for history in self.histories_]

    def _at_best(self, name: str) -> float:
        return float(getattr(self.history_, name)[self.history_.best_epoch])


class LevenbergMarquardtRegressor(_NetworkRegressor):
    """Tansig network trained by Levenberg-Marquardt, stopped early by validation data.

    Args:
        hidden_layer_sizes: neurons in the hidden layer, or in each of several.
        restarts: initial weights (Nguyen-Widrow) from which networks are trained, as one batch; the one with the least
            error on the validation data (without any, on the training data) is kept.
        epochs: greatest number of steps.
        mu: initial damping; None is 0.001. It falls by `mu_decrease` after a step that lowers the error and rises by
            `mu_increase` after one that does not; a training ends where it passes `mu_max`.
        min_grad: a training ends where the gradient is no longer than this.
        validation_fraction: share of the samples that is set apart to stop early; None uses all for training, and
            'auto' is 0.1 here.
        max_fail: a training ends after this many epochs without a lower error there.
        device: torch's, 'cpu' or 'cuda'.
        random_state: seed of the weights and of the validation split.
        verbose: show a progress bar.

    Attributes:
        network_: the network that was kept: predicts without torch, and can be saved.
        history_: its training by epoch.
        networks_, histories_, best_restart_: all restarts, and which one was kept.
        n_iter_: its epochs.
    """

    _method = "levenberg_marquardt"
    _usual_validation_fraction = 0.1


class BayesianRegularizationRegressor(_NetworkRegressor):
    """Tansig network trained by Levenberg-Marquardt with Bayesian regularisation (MacKay; Foresee and Hagan).

    The arguments are those of `LevenbergMarquardtRegressor`, with other meanings of two: mu None is 0.005, and 'auto'
    is no validation split, as the regularisation itself holds back. The restart with the greatest evidence is kept
    (with a validation split, the one with the least error there).

    Attributes:
        network_, history_, networks_, histories_, best_restart_, n_iter_: as of `LevenbergMarquardtRegressor`.
        alpha_, beta_: evidence parameters of F = beta e'e + alpha w'w, on targets mapped to [-1, 1].
        effective_parameters_: gamma, of all P.
        log_evidence_: ln p(targets | alpha, beta) of the mapped targets.
    """

    _method = "bayesian_regularization"
    _usual_validation_fraction = None

    @property
    def alpha_(self) -> float:
        """Evidence parameter of the weights."""
        return self._at_best("alpha")

    @property
    def beta_(self) -> float:
        """Evidence parameter of the errors; their variance on [-1, 1] is 1 / (2 beta)."""
        return self._at_best("beta")

    @property
    def effective_parameters_(self) -> float:
        """Gamma."""
        return self._at_best("gamma")

    @property
    def log_evidence_(self) -> float:
        """Evidence of the network that was kept."""
        return float(self.network_.provenance["log_evidence"])

    def _losses(self) -> list[float]:
        if self._validation_fraction:
            return super()._losses()
        return [-network.provenance["log_evidence"] for network in self.networks_]

    def predict(self, X: ArrayLike, return_std: bool = False) -> Any:
        """Outputs (n,) or (n, m) at X (n, d); with `return_std` also their standard deviations, noise included."""
        mean = super().predict(X)
        if not return_std:
            return mean
        return mean, self._like_y(self.network_.predict_std(self._checked(X)))
