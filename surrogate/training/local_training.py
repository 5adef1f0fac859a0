"""What LOLIMOT and HILOMOT share: local least squares, and the growth of a network model by model.

Both start with one model for all inputs and split the worst, that with the largest sqrt(sum(phi e^2)), as long as a
criterion asks for more (Nelles, Nonlinear System Identification; Hartmann's thesis; the paper's section II-F).
"""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from dataclasses import dataclass
from typing import Literal, Protocol, get_args

import numpy as np

from surrogate.models.local_models import LocalModel, polynomial_basis, polynomial_terms
from surrogate.models.partitions import Partition
from surrogate.scaling import Array
from surrogate.training.settings import Allowed, Choice, Number, Whole, check

RIDGE = 1e-10
"""Added to the diagonal of a normal matrix, as a share of that of all samples: cells of a lattice may hold too few
levels of an input for a quadratic model, and the least parameters are as good as any then."""

Criterion = Literal["validation", "aicc", "size"]
"""What ends the growth and chooses the network: the error on validation data, the corrected Akaike criterion, or
nothing but the greatest number of models."""


ALLOWED: dict[str, Allowed] = {
    "local_model": Choice(get_args(LocalModel)),
    "criterion": Choice(get_args(Criterion)),
    "smoothness": Number(1e-6, 1e3),
    "max_models": Whole(1, 10_000),
    "patience": Whole(1, 10_000),
}
"""Settings of a growth."""


@dataclass(frozen=True)
class LocalSettings:
    """How a local model network grows."""

    local_model: LocalModel = "linear"
    criterion: Criterion = "validation"
    smoothness: float = 1.0
    """Larger values blend neighbours over a wider zone."""
    max_models: int = 50
    patience: int = 2
    """Stop after this many successive deteriorations of the criterion; the best network is kept (paper III-D)."""

    def __post_init__(self) -> None:
        """Refuse what would never end."""
        check(vars(self), ALLOWED)


class ScaledSamples:
    """Scaled inputs z (n, d), targets y (n, m) and weights v (n,), with what all least-squares problems of them share.

    A sample counts as often as its weight says; without weights once.
    """

    def __init__(self, z: Array, y: Array, local_model: LocalModel, weights: Array | None = None):
        self.z, self.y = z, y
        self.v = np.ones(len(z)) if weights is None else weights
        self.terms = polynomial_terms(local_model, z.shape[1])
        self.A = polynomial_basis(z, self.terms)
        i, j = np.triu_indices(len(self.terms))
        self._products = self.A[:, i] * self.A[:, j]
        self._place = np.zeros((len(self.terms),) * 2, dtype=int)
        self._place[i, j] = self._place[j, i] = np.arange(len(i))
        squares = (self.v[:, None] * self.A**2).sum(0)
        squares[squares == 0.0] = squares.max()  # of an input that is 0 in all samples
        self._ridge = np.diag(RIDGE * squares)

    @property
    def terms_count(self) -> int:
        """Number K of parameters of a local model and output."""
        return len(self.terms)

    def subset(self, rows: np.ndarray) -> ScaledSamples:
        """The samples that `rows` selects, regularised as all of them."""
        part = copy(self)
        for name in ("z", "y", "v", "A", "_products"):
            setattr(part, name, getattr(self, name)[rows])
        return part

    def normal_matrices(self, q: Array) -> Array:
        """A'QVA (c, K, K) for each column of the validities q (n, c), with the ridge."""
        products: Array = (q * self.v[:, None]).T @ self._products
        return products[:, self._place] + self._ridge

    def moments(self, q: Array, y: Array) -> Array:
        """A'QVy (c, K, m) for each column of q (n, c), of values y (n, m) or (n, c, m)."""
        weighted = (q * self.v[:, None])[:, :, None] * (y[:, None] if y.ndim == 2 else y)
        return (self.A.T @ weighted.reshape(len(q), -1)).reshape(-1, *weighted.shape[1:]).swapaxes(0, 1)

    def share(self, q: Array) -> Array:
        """How many samples, by weight, belong to each column of the validities q (n, c)."""
        return np.asarray((q * self.v[:, None]).sum(0))

    def squared(self, errors: Array) -> float:
        """Sum of the squares of errors (n, m), each as often as its sample counts."""
        return float((self.v[:, None] * errors**2).sum())

    def fit(self, q: Array) -> Array:
        """Coefficients (c, K, m) of the weighted least squares for each column of q (n, c)."""
        return self.solve(self.normal_matrices(q), self.moments(q, self.y))

    @staticmethod
    def solve(G: Array, moments: Array) -> Array:
        """Coefficients (c, K, m) of normal matrices G (c, K, K)."""
        return np.asarray(np.linalg.solve(G, moments), dtype=float)

    def outputs(self, coefficients: Array) -> Array:
        """Outputs (n, c, m) of the polynomials (c, K, m)."""
        c, K, m = coefficients.shape
        return (self.A @ coefficients.swapaxes(0, 1).reshape(K, c * m)).reshape(-1, c, m)


def replaced(values: Array, model: int, pair: Array, axis: int) -> Array:
    """Values of M models along an axis with those of one replaced by a pair: in its place, and as the last."""
    values = np.concatenate([values, pair.take([1], axis)], axis)
    np.moveaxis(values, axis, 0)[model] = pair.take(0, axis)
    return values


@dataclass(frozen=True)
class Grown:
    """A network in growth, on the training samples; subclasses add how its cells are described."""

    phi: Array
    """Validities (n, M)."""
    coefficients: Array
    """(M, K, m)."""
    outputs: Array
    """Outputs (n, M, m) of the models, before they are weighted."""

    @property
    def partition(self) -> Partition:
        """Its cells."""
        raise NotImplementedError

    def errors(self, samples: ScaledSamples) -> Array:
        """Targets less outputs (n, m)."""
        return samples.y - np.einsum("ni,nio->no", self.phi, self.outputs)


class Splitter(Protocol):
    """An algorithm: how a network starts, and how one of its models is split in two."""

    @property
    def split_parameters(self) -> int:
        """Parameters that a split adds beside those of its models."""

    def start(self, samples: ScaledSamples) -> Grown:
        """One model for all samples."""

    def split(self, grown: Grown, model: int, samples: ScaledSamples) -> Grown | None:
        """The network with the model split as well as it can be; None where too little of the data belongs to it."""


@dataclass(frozen=True)
class Growth:
    """A growth by number of models, from one on: arrays of equal length."""

    parameters: np.ndarray
    """Parameters of all models and splits."""
    training_mse: Array
    """Mean squared error on the training data, of targets mapped to [0, 1]."""
    validation_mse: Array
    """The same on the validation data; NaN without any."""
    aicc: Array
    """The corrected Akaike criterion."""
    best: int
    """Number of models of the network that was kept."""
    stop: str
    """What ended it: 'validation', 'aicc', 'max_models' or 'no split'."""


def grow(
    samples: ScaledSamples,
    validation: ScaledSamples | None,
    splitter: Splitter,
    settings: LocalSettings,
    progress: Callable[[int, int], None] | None = None,
) -> tuple[Grown, Growth]:
    """Grow a network on samples scaled to [0, 1]; `progress(models, most models)`."""
    if settings.criterion == "validation" and validation is None:
        raise ValueError("the growth is to stop by validation data, but there are none: give some or choose 'aicc'.")
    grown: Grown | None = splitter.start(samples)
    best, records, worse, stop = grown, [], 0, "max_models"
    while grown is not None:
        records.append(_record(grown, samples, validation, splitter))
        scores = [_score(record, settings.criterion) for record in records]
        if scores[-1] == min(scores):
            best = grown
        worse = worse + 1 if len(scores) > 1 and scores[-1] >= scores[-2] else 0
        if worse >= settings.patience:
            stop = settings.criterion
            break
        if progress:
            progress(len(records), settings.max_models)
        if len(records) == settings.max_models:
            break
        grown = _split_the_worst(grown, samples, splitter)
        if grown is None:
            stop = "no split"
    assert best is not None
    parameters, training, validated, aicc = (np.array(column) for column in zip(*records, strict=True))
    return best, Growth(parameters.astype(int), training, validated, aicc, best.phi.shape[1], stop)


def _split_the_worst(grown: Grown, samples: ScaledSamples, splitter: Splitter) -> Grown | None:
    """The network with its worst model split, or the next worst where that would not lower the training error."""
    squares = (samples.v[:, None] * grown.errors(samples) ** 2).sum(1)
    for model in np.argsort(-(grown.phi.T @ squares), kind="stable"):
        candidate = splitter.split(grown, int(model), samples)
        if candidate is not None and samples.squared(candidate.errors(samples)) < squares.sum():
            return candidate
    return None


def _record(
    grown: Grown, samples: ScaledSamples, validation: ScaledSamples | None, splitter: Splitter
) -> tuple[float, float, float, float]:
    """Parameters, training error, validation error and AICc."""
    N, M = samples.v.sum(), grown.phi.shape[1]
    training = _mean_square(grown, samples)
    split_parameters = splitter.split_parameters * (M - 1)
    k = _effective_parameters(grown.phi, samples) + split_parameters + 1
    few = N - 1 - k
    aicc = N * np.log(max(training, np.finfo(float).tiny)) + 2 * k + 2 * k * (k + 1) / few if few > 0 else np.inf
    validated = np.nan
    if validation is not None:
        outputs = validation.outputs(grown.coefficients)
        there = Grown(grown.partition.validity(validation.z), grown.coefficients, outputs)
        validated = _mean_square(there, validation)
    return M * samples.terms_count * samples.y.shape[1] + split_parameters, training, validated, float(aicc)


def _mean_square(grown: Grown, samples: ScaledSamples) -> float:
    return samples.squared(grown.errors(samples)) / float(samples.v.sum() * samples.y.shape[1])


def _score(record: tuple[float, float, float, float], criterion: Criterion) -> float:
    _, training, validated, aicc = record
    return {"validation": validated, "aicc": aicc, "size": training}[criterion]


def _effective_parameters(phi: Array, samples: ScaledSamples) -> float:
    """Trace of the matrix S that maps targets to outputs: sum_i tr[(A'Q_i A)^-1 A'Q_i^2 A]."""
    ratio = np.linalg.solve(samples.normal_matrices(phi), samples.normal_matrices(phi**2))
    return float(np.trace(ratio, axis1=1, axis2=2).sum())
