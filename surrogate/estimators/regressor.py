"""What all estimators share: samples in and out as scikit-learn has them, and a progress bar."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from sklearn.base import BaseEstimator, RegressorMixin
from sklearn.utils.validation import _check_sample_weight, check_is_fitted, validate_data

from surrogate.models.local_models import LocalModelNetwork
from surrogate.models.network import Network
from surrogate.scaling import Array
from surrogate.training import train as training
from surrogate.training.settings import Allowed, Number, check
from surrogate.training.train import distinct_samples

Rows = tuple[np.ndarray, np.ndarray | None]
"""For training, and for validation if any are set apart."""
Variables = list[tuple[str, str]]

ALLOWED: dict[str, Allowed] = {
    "restarts": training.ALLOWED["restarts"],
    "hidden_layer_sizes": training.ALLOWED["hidden"],
    "validation_fraction": Number(0.0, 1.0, above=True),
}
"""Settings of the estimators that no trainer checks."""


class SurrogateRegressor(RegressorMixin, BaseEstimator):
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

    def _split(self, n: int, fraction: float | None, rng: np.random.RandomState) -> Rows:
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


@contextmanager
def progress_bar(name: str, shown: bool) -> Iterator[Callable[[int, int], None] | None]:
    """A progress bar on standard error."""
    if not shown:
        yield None
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True)) as bars:
        task = bars.add_task(name, total=None)
        yield lambda done, total: bars.update(task, completed=done, total=total)
