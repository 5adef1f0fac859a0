"""The paper's selection of local model networks (Algorithm 2): six a round and output, the best by validation data."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import ArrayLike

from surrogate.models.local_models import LocalModel, LocalModelNetwork
from surrogate.scaling import Array
from surrogate.training.local_training import Growth, LocalSettings
from surrogate.training.selection import Rounds, Split, mse_by_part, split_samples, squared_errors
from surrogate.training.train import Algorithm, checked_samples, train_local_models

ALGORITHMS: tuple[Algorithm, ...] = ("lolimot", "hilomot")
LOCAL_MODELS: tuple[LocalModel, ...] = ("linear", "sparse_quadratic", "quadratic")


@dataclass(frozen=True, eq=False)
class Candidate:
    """One of the six networks of a round and output."""

    algorithm: Algorithm
    local_model: LocalModel
    network: LocalModelNetwork
    growth: Growth

    @property
    def validation_mse(self) -> float:
        """Least error on the round's validation data."""
        return float(self.growth.validation_mse[self.growth.best - 1])


@dataclass(frozen=True, eq=False)
class LocalSelection(Rounds):
    """Six networks a round and output (Algorithm 2); the errors are the best one's."""

    candidates: tuple[tuple[tuple[Candidate, ...], ...], ...]
    """By round, output, and the six pairs of algorithm and kind of local model."""

    def best(self, j: int) -> tuple[Candidate, ...]:
        """Of each output the candidate of round j with the least error on the validation data, the test part."""
        return _best(self.candidates[j])

    def predict(self, X: ArrayLike) -> Array:
        """Outputs (..., m) of the selected round's networks."""
        return np.concatenate([candidate.network.predict(X) for candidate in self.best(self.selected)], axis=-1)


def select_local_models(
    X: ArrayLike,
    Y: ArrayLike,
    *,
    inputs: Sequence[tuple[str, str]],
    outputs: Sequence[tuple[str, str]],
    seed: int,
    rounds: int = 20,
    test_fraction: float = 0.1,
    split: Split | None = None,
    jobs: int = 1,
    max_models: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> LocalSelection:
    """Run Algorithm 2 on the inputs X (N, d) and targets Y (N, m), in `jobs` processes.

    The split is that of Algorithm 1 with the same seed. No network grows beyond `max_models` local models (None: those
    of `LocalSettings`). `progress(rounds x outputs done, all)`.
    """
    from joblib import Parallel, delayed

    X, Y = checked_samples(X, inputs, "X"), checked_samples(Y, outputs, "Y")
    split = split or split_samples(len(X), rounds, test_fraction, seed)
    rounds, m = len(split.training), len(outputs)
    tasks = list(product(range(rounds), range(m)))
    most = LocalSettings.max_models if max_models is None else max_models

    def calls() -> Iterator:
        for j, o in tasks:
            yield delayed(_six)(X, Y[:, [o]], list(inputs), [outputs[o]], split.training[j], split.test[j], most)

    found = []
    for six in Parallel(n_jobs=jobs, return_as="generator")(calls()):
        found.append(six)
        if progress:
            progress(len(found), len(tasks))
    candidates = tuple(tuple(found[j * m : (j + 1) * m]) for j in range(rounds))
    squares = np.stack(
        [
            np.hstack([squared_errors(c.network, X, Y[:, [o]]) for o, c in enumerate(_best(sixes))])
            for sixes in candidates
        ]
    )
    return LocalSelection(X, Y, split, mse_by_part(squares, split), candidates)


def _best(sixes: tuple[tuple[Candidate, ...], ...]) -> tuple[Candidate, ...]:
    return tuple(min(six, key=lambda candidate: candidate.validation_mse) for six in sixes)


def _six(
    X: Array,
    Y: Array,
    inputs: Sequence[tuple[str, str]],
    outputs: Sequence[tuple[str, str]],
    rows: np.ndarray,
    validation_rows: np.ndarray,
    max_models: int,
) -> tuple[Candidate, ...]:
    candidates = []
    for algorithm, local_model in product(ALGORITHMS, LOCAL_MODELS):
        network, growth = train_local_models(
            X,
            Y,
            inputs=inputs,
            outputs=outputs,
            rows=rows,
            algorithm=algorithm,
            validation_rows=validation_rows,
            settings=LocalSettings(local_model, max_models=max_models),
        )
        candidates.append(Candidate(algorithm, local_model, network, growth))
    return tuple(candidates)
