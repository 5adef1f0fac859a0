"""Local model networks: LOLIMOT and HILOMOT."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike
from sklearn.utils import check_random_state
from sklearn.utils.validation import check_is_fitted

from surrogate.estimators.regressor import SurrogateRegressor, progress_bar
from surrogate.models.local_models import LocalModel, LocalModelNetwork
from surrogate.scaling import Array
from surrogate.training.local_training import Criterion, LocalSettings
from surrogate.training.train import Algorithm, train_local_models


class _LocalModelRegressor(SurrogateRegressor):
    """Local polynomials, blended by validity functions that add up to one; grown model by model."""

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
        with progress_bar(type(self).__name__, self.verbose) as progress:
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
    """LOLIMOT: cells are halved along axes, normalised Gaussians blend them (Nelles).

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

    _algorithm = "lolimot"


class HilomotRegressor(_LocalModelRegressor):
    """HILOMOT: cells are split along any direction, a hierarchy of sigmoids blends them (Nelles, Hartmann).

    Arguments and attributes are those of `LolimotRegressor`.
    """

    _algorithm = "hilomot"
