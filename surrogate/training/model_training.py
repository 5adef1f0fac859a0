"""Training a model on any samples: many random splits, the least error on rows that no training saw."""

from __future__ import annotations

import platform
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from importlib.metadata import version
from importlib.util import find_spec
from typing import Any, NamedTuple

import numpy as np

from gtm_fmu.conformal import EPSILON, least_cases
from gtm_fmu.errors import InputError
from gtm_fmu.extras import check_installed
from surrogate.models.evaluation import check_result_names
from surrogate.models.local_models import LocalModelNetwork
from surrogate.models.network import Network
from surrogate.models.safety import Never, safety
from surrogate.scaling import to_unit
from surrogate.training.samples import Samples
from surrogate.training.selection import Split, split_samples
from surrogate.training.settings import check
from surrogate.training.train import ALLOWED, distinct_samples, generator

Model = Network | LocalModelNetwork
Progress = Callable[[int, int], None]

NETWORKS: dict[str, Any] = {"br": "bayesian_regularization", "lm": "levenberg_marquardt"}
TEST_FRACTION = 0.1
"""Share of the rows in the independent part, and of the rest in each split's test part (paper, Algorithm 1)."""


MOST_ROWS = 1e9
"""Of a calibration; more is no table's."""


class Calibration(NamedTuple):
    """Rows that are held back to make outputs safe.

    Attributes:
        rows: their share of all different rows if below 1, else their number.
        never: by output, what its safe value must never be: low or high.
        epsilon: probability with which each may be wrong.
    """

    rows: float
    never: Mapping[str, Never]
    epsilon: float = EPSILON

    def count(self, different: int) -> int:
        """How many of different rows are held back.

        Raises:
            InputError: fewer than epsilon needs, or so many that none is left.
        """
        if not 0 < self.rows <= MOST_ROWS:
            raise InputError(f"--calibrate {self.rows:g} is no share or number of rows: give as 0.2, or 2000.")
        count = round(self.rows * different) if self.rows < 1 else round(self.rows)
        needed = least_cases(self.epsilon)
        if count < needed:
            raise InputError(
                f"--calibrate {self.rows:g} holds {count} of {different} different rows back, but epsilon = "
                f"{self.epsilon:g} needs {needed}: hold more back, give more rows, or an epsilon of at least "
                f"{1 / (max(count, 1) + 1):.3g}."
            )
        if count >= different:
            raise InputError(f"--calibrate {self.rows:g} leaves none of {different} different rows to train on.")
        return count


def train_calibrated(samples: Samples, method: str, calibration: Calibration, *, seed: int, **options: Any) -> Model:
    """A model of `train_model` with margins that make outputs safe, by rows that were held back from it.

    A row that stands several times in the table is held back or left as a whole, and sets the margins once.

    Raises:
        InputError: as `train_model`; fewer rows than epsilon needs, or an output that is not learnt.
    """
    unknown = calibration.never.keys() - {variable.name for variable in samples.outputs}
    if unknown or not calibration.never:
        names = ", ".join(variable.name for variable in samples.outputs)
        given = f"'{min(unknown)}' is no output" if unknown else "No output was named that must be safe"
        raise InputError(f"{given}: name some of {names} with --never-low or --never-high.")
    try:
        check_result_names(samples.inputs, samples.outputs, calibration.never)
    except ValueError as error:
        raise InputError(str(error)) from None
    _, first, place = np.unique(np.column_stack([samples.X, samples.Y]), axis=0, return_index=True, return_inverse=True)
    count = calibration.count(len(first))
    held = generator(seed, "calibration").permutation(len(first))[:count]
    rest = ~np.isin(place.ravel(), held)
    model = train_model(replace(samples, X=samples.X[rest], Y=samples.Y[rest]), method, seed=seed, **options)
    rows = first[held]
    errors = model.predict(samples.X[rows]) - samples.Y[rows]
    safe = safety(errors, samples.outputs, calibration.never, calibration.epsilon)
    labels = (_labels(samples)[k] for k in safe.places(samples.outputs))
    told = {f"safe_shift {label}": shift for label, shift in zip(labels, safe.shifts.tolist(), strict=True)}
    facts = {"calibration_rows": count, "epsilon": calibration.epsilon}
    return replace(model, safe=safe, metrics=model.metrics | told, provenance=model.provenance | facts)


def train_model(
    samples: Samples,
    method: str,
    *,
    splits: int,
    hidden: tuple[int, ...],
    seed: int,
    device: str = "cpu",
    progress: Progress | None = None,
) -> Model:
    """The best of a model a split, with its scores and where it comes from.

    A tenth of the rows judges the models. Each split divides the rest into nine tenths to fit and a tenth that ends the
    training (lm, lolimot, hilomot) or is only looked at (br). Errors are mean squares of outputs mapped to 0 .. 1. A
    row that stands several times in the table belongs to one part only, and counts as often as it stands.

    Args:
        samples: what to learn.
        method: networks by Levenberg-Marquardt with Bayesian regularisation (br) or early stopping (lm); local model
            networks (lolimot, hilomot).
        splits: number of models.
        hidden: neurons in each hidden layer of a network.
        seed: start of all random numbers; the same gives the same model.
        device: torch's, for networks.

    Raises:
        InputError: torch is missing, or the samples cannot be learnt from.
    """
    if method in NETWORKS:
        check_installed("torch", "Networks are trained with")
    try:
        check({"splits": splits, "hidden": hidden, "seed": seed}, ALLOWED)
        X, Y, weights = distinct_samples(samples.X, samples.Y)
        distinct = replace(samples, X=X, Y=Y)
        split = split_samples(len(X), splits, TEST_FRACTION, seed)
        train = _networks if method in NETWORKS else _local_models
        models = train(distinct, weights, split, method, hidden, seed, device, progress)
    except ValueError as error:
        raise InputError(str(error)) from None
    except (MemoryError, RuntimeError) as error:
        if "memory" not in str(error):
            raise
        size = ",".join(map(str, hidden))
        raise InputError(f"{splits} networks with {size} hidden neurons need too much memory: take fewer.") from None

    def mean(values: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """Over rows, each as often as it stands in the table."""
        return np.average(values[rows], axis=0, weights=None if weights is None else weights[rows])

    errors = [_squared_errors(model, distinct) for model in models]
    best = int(np.argmin([mean(error, split.independent).mean() for error in errors]))
    scores = {
        f"mse_{part}": float(mean(errors[best], split.rows(part, best)).mean())
        for part in ("training", "test", "independent")
    }
    scores["rmse_independent"] = float(np.sqrt(scores["mse_independent"]))
    scores |= _by_output(models[best], distinct, partial(mean, rows=split.independent))
    origin = _origin(samples, seed, splits, best) | {"rows_repeated": len(samples.X) - len(X)}
    return replace(models[best], metrics=scores, provenance=models[best].provenance | origin)


def _by_output(model: Model, samples: Samples, mean: Callable[[np.ndarray], np.ndarray]) -> dict[str, float]:
    """Root mean squared error of each output in its unit, and R2, the share of its variance that is explained."""
    squares = mean((model.predict(samples.X) - samples.Y) ** 2)
    variance = mean((samples.Y - mean(samples.Y)) ** 2)
    scores = {f"rmse_independent {v}": float(np.sqrt(s)) for v, s in zip(_labels(samples), squares, strict=True)}
    known = zip(samples.outputs, squares, variance, strict=True)
    return scores | {f"r2_independent {v.name}": float(1.0 - s / d) for v, s, d in known if d > 0.0}


def _labels(samples: Samples) -> list[str]:
    return [f"{v.name} [{v.unit}]" if v.unit else v.name for v in samples.outputs]


def _networks(
    samples: Samples,
    weights: np.ndarray | None,
    split: Split,
    method: str,
    hidden: tuple[int, ...],
    seed: int,
    device: str,
    progress: Progress | None,
) -> list[Network]:
    from surrogate.training.train import train_networks

    trained = train_networks(
        samples.X,
        samples.Y,
        inputs=samples.inputs,
        outputs=samples.outputs,
        rows=split.training,
        validation_rows=split.test if method == "lm" else None,
        method=NETWORKS[method],
        seed=seed,
        hidden=hidden,
        sample_weight=weights,
        device=device,
        progress=progress,
    )
    return [network for network, _ in trained]


def _local_models(
    samples: Samples, weights: np.ndarray | None, split: Split, method: Any, _h: Any, _s: int, _d: str, progress: Any
) -> list[LocalModelNetwork]:
    from surrogate.training.train import train_local_models

    models = []
    for training, test in zip(split.training, split.test, strict=True):
        model, _ = train_local_models(
            samples.X,
            samples.Y,
            inputs=samples.inputs,
            outputs=samples.outputs,
            rows=training,
            validation_rows=test,
            algorithm=method,
            sample_weight=weights,
        )
        models.append(model)
        if progress:
            progress(len(models), len(split.training))
    return models


def _squared_errors(model: Model, samples: Samples) -> np.ndarray:
    """Of outputs mapped to 0 .. 1 (n, m)."""
    found, given = (to_unit(Y, model.target_ranges) for Y in (model.predict(samples.X), samples.Y))
    return (found - given) ** 2


def _origin(samples: Samples, seed: int, splits: int, best: int) -> dict[str, Any]:
    libraries = ("gtm-fmu", "numpy", *(("torch",) if find_spec("torch") else ()))
    return {
        "data_sha256": samples.sha256(),
        "rows": len(samples.X),
        "rows_left_out": samples.left_out,
        "seed": seed,
        "splits": splits,
        "split": best,
        "versions": {name: version(name) for name in libraries} | {"python": platform.python_version()},
    }
