"""Neural networks and local model networks as estimators in scikit-learn's convention, for any regression problem."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike
from sklearn.base import BaseEstimator, RegressorMixin
from sklearn.utils import check_random_state
from sklearn.utils.validation import _check_sample_weight, check_is_fitted, validate_data

from surrogate.models.local_models import LocalModel, LocalModelNetwork
from surrogate.models.network import Network
from surrogate.scaling import Array
from surrogate.training import train as training
from surrogate.training.levenberg_marquardt import Schedule
from surrogate.training.local_training import Criterion, LocalSettings
from surrogate.training.settings import Allowed, Number, check
from surrogate.training.train import METHODS, Algorithm, Method, distinct_samples, train_local_models, train_networks

Split = tuple[np.ndarray, np.ndarray | None]
Variables = list[tuple[str, str]]


ALLOWED: dict[str, Allowed] = {
    "restarts": training.ALLOWED["restarts"],
    "hidden_layer_sizes": training.ALLOWED["hidden"],
    "validation_fraction": Number(0.0, 1.0, above=True),
}
"""Settings of the estimators that no trainer checks."""


class _SurrogateRegressor(RegressorMixin, BaseEstimator):
    """What the four estimators share; `network_` predicts without torch and can be saved as a file."""

    network_: Network | LocalModelNetwork

    def predict(self, X: ArrayLike) -> Array:
        """Outputs (n,) or (n, m), as y was, at X (n, d)."""
        X = self._checked(X)
        return self._like_y(self.network_.predict(X))

    def _checked(self, X: ArrayLike) -> Array:
        check_is_fitted(self)
        return np.asarray(validate_data(self, X, reset=False, dtype=np.float64))

    def _like_y(self, Y: Array) -> Array:
        return Y[:, 0] if self._y_is_1d else Y

    def _samples(
        self, X: ArrayLike, y: ArrayLike, sample_weight: ArrayLike | None
    ) -> tuple[Array, Array, Array | None, Variables, Variables]:
        """Distinct samples X (n, d), Y (n, m) and weights (n,), and names for their columns.

        Samples of weight 0 are left out, and copies of a sample are one that weighs as much as all of them. All are
        put in order, so that the one in which they were given makes no difference.
        """
        names = list(getattr(y, "columns", [])) or [name for name in [getattr(y, "name", None)] if name is not None]
        checked = validate_data(self, X, y, dtype=np.float64, multi_output=True, y_numeric=True, ensure_min_samples=2)
        X, Y = (np.asarray(values, dtype=float) for values in checked)
        self._y_is_1d = Y.ndim == 1
        Y = Y.reshape(len(Y), -1)
        weights = None
        if sample_weight is not None:
            weights = np.asarray(_check_sample_weight(sample_weight, X, dtype=np.float64, ensure_non_negative=True))
            counted = weights > 0
            if counted.sum() < 2:
                raise ValueError(f"sample_weight leaves {counted.sum()} samples, but at least 2 are needed.")
            X, Y, weights = X[counted], Y[counted], weights[counted]
        order = np.lexsort(np.column_stack([Y, X]).T)
        X, Y, weights = distinct_samples(X[order], Y[order], None if weights is None else weights[order])
        given = getattr(self, "feature_names_in_", [f"x{j + 1}" for j in range(X.shape[1])])
        names = names or ["y" if Y.shape[1] == 1 else f"y{o + 1}" for o in range(Y.shape[1])]
        return X, Y, weights, [(str(name), "") for name in given], [(str(name), "") for name in names]

    def _split(self, n: int, fraction: float | None, rng: np.random.RandomState) -> Split:
        """Rows for training, and for validation where a fraction of the samples is set apart."""
        if fraction is None or fraction == 0:
            return np.arange(n), None
        check({"validation_fraction": fraction}, ALLOWED)
        size, order = max(1, round(fraction * n)), rng.permutation(n)
        if size == n:
            raise ValueError(f"validation_fraction {fraction:g} of {n} samples leaves none for training: lower it.")
        return np.sort(order[size:]), np.sort(order[:size])

    def __sklearn_tags__(self) -> Any:
        tags = super().__sklearn_tags__()
        tags.target_tags.multi_output = True
        return tags


class _NetworkRegressor(_SurrogateRegressor):
    """Networks of tansig neurons with linear outputs, trained from several initial weights at once."""

    network_: Network
    _method: ClassVar[Method]

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
        validation_fraction: float | None = None,
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
        rows, validation_rows = self._split(len(X), self.validation_fraction, rng)
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
        with _bar(type(self).__name__, self.verbose) as progress:
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

    def _losses(self) -> list[float]:
        """What decides among the restarts: the error on the validation data, or else on the training data."""
        if self.validation_fraction:
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
        validation_fraction: share of the samples that is set apart to stop early; None uses all for training.
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
        validation_fraction: float | None = 0.1,
        max_fail: int = 6,
        device: str = "cpu",
        random_state: int | np.random.RandomState | None = None,
        verbose: bool = False,
    ):
        super().__init__(
            hidden_layer_sizes,
            restarts=restarts,
            epochs=epochs,
            mu=mu,
            mu_decrease=mu_decrease,
            mu_increase=mu_increase,
            mu_max=mu_max,
            min_grad=min_grad,
            validation_fraction=validation_fraction,
            max_fail=max_fail,
            device=device,
            random_state=random_state,
            verbose=verbose,
        )


class BayesianRegularizationRegressor(_NetworkRegressor):
    """Tansig network trained by Levenberg-Marquardt with Bayesian regularisation (MacKay; Foresee and Hagan).

    The arguments are those of `LevenbergMarquardtRegressor`, with other defaults: mu None is 0.005, and there is no
    validation split, as the regularisation itself holds back. The restart with the greatest evidence is kept (with a
    validation split, the one with the least error there).

    Attributes:
        network_, history_, networks_, histories_, best_restart_, n_iter_: as of `LevenbergMarquardtRegressor`.
        alpha_, beta_: evidence parameters of F = beta e'e + alpha w'w, on targets mapped to [-1, 1].
        effective_parameters_: gamma, of all P.
        log_evidence_: ln p(targets | alpha, beta) of the mapped targets.
    """

    _method = "bayesian_regularization"

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
        if self.validation_fraction:
            return super()._losses()
        return [-network.provenance["log_evidence"] for network in self.networks_]

    def predict(self, X: ArrayLike, return_std: bool = False) -> Any:
        """Outputs (n,) or (n, m) at X (n, d); with `return_std` also their standard deviations, noise included."""
        mean = super().predict(X)
        if not return_std:
            return mean
        return mean, self._like_y(self.network_.predict_std(self._checked(X)))


class _LocalModelRegressor(_SurrogateRegressor):
    """Local polynomials, blended by validity functions that add up to one; grown model by model.

    Args:
        local_model: 'linear', 'sparse_quadratic' or 'quadratic' polynomials.
        criterion: what ends the growth and chooses the network: 'validation' (error on a part of the samples that is
            set apart), 'aicc' (corrected Akaike criterion, all samples are used) or 'size' (`max_models`).
        validation_fraction: that part's share.
        smoothness: larger values blend neighbours over a wider zone.
        max_models: greatest number of local models.
        patience: stop after this many successive deteriorations of the criterion.
        random_state: seed of the validation split.
        verbose: show a progress bar.

    Attributes:
        network_: predicts, and can be saved; several outputs share its cells.
        growth_: parameters, errors and criterion by number of models.
        n_models_: local models.
    """

    network_: LocalModelNetwork
    _algorithm: ClassVar[Algorithm]

    def __init__(
        self,
        local_model: LocalModel = "linear",
        *,
        criterion: Criterion = "validation",
        validation_fraction: float = 0.1,
        smoothness: float = 1.0,
        max_models: int = 50,
        patience: int = 2,
        random_state: int | np.random.RandomState | None = None,
        verbose: bool = False,
    ):
        self.local_model = local_model
        self.criterion = criterion
        self.validation_fraction = validation_fraction
        self.smoothness = smoothness
        self.max_models = max_models
        self.patience = patience
        self.random_state = random_state
        self.verbose = verbose

    def fit(self, X: ArrayLike, y: ArrayLike, sample_weight: ArrayLike | None = None) -> _LocalModelRegressor:
        """Grow on X (n, d) and y (n,) or (n, m); a sample counts as often as its weight (n,) says."""
        X, Y, weights, inputs, outputs = self._samples(X, y, sample_weight)
        fraction = self.validation_fraction if self.criterion == "validation" else None
        rows, validation_rows = self._split(len(X), fraction, check_random_state(self.random_state))
        settings = LocalSettings(self.local_model, self.criterion, self.smoothness, self.max_models, self.patience)
        with _bar(type(self).__name__, self.verbose) as progress:
            self.network_, self.growth_ = train_local_models(
                X,
                Y,
                inputs=inputs,
                outputs=outputs,
                rows=rows,
                validation_rows=validation_rows,
                algorithm=self._algorithm,
                settings=settings,
                sample_weight=weights,
                progress=progress,
            )
        self.n_models_ = self.network_.models
        return self

    def validity(self, X: ArrayLike) -> Array:
        """Validity (n, M) of every local model at X (n, d)."""
        X = self._checked(X)
        return self.network_.validity(X)

    def tree(self) -> str:
        """The splits and local models as text."""
        check_is_fitted(self)
        return self.network_.tree()


class LolimotRegressor(_LocalModelRegressor):
    """LOLIMOT: cells are halved along axes, normalised Gaussians blend them (Nelles)."""

    __doc__ += str(_LocalModelRegressor.__doc__).split("\n", 1)[1]
    _algorithm = "lolimot"


class HilomotRegressor(_LocalModelRegressor):
    """HILOMOT: cells are split along any direction, a hierarchy of sigmoids blends them (Nelles, Hartmann)."""

    __doc__ += str(_LocalModelRegressor.__doc__).split("\n", 1)[1]
    _algorithm = "hilomot"


@contextmanager
def _bar(name: str, shown: bool) -> Iterator[Callable[[int, int], None] | None]:
    """A progress bar on standard error."""
    if not shown:
        yield None
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True)) as bars:
        task = bars.add_task(name, total=None)
        yield lambda done, total: bars.update(task, completed=done, total=total)
