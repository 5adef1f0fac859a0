"""From samples in their own units to trained networks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from surrogate.models.evaluation import Variable
from surrogate.models.local_models import LocalModelNetwork
from surrogate.models.network import Network, parameter_count
from surrogate.scaling import Array, column_ranges, to_symmetric, to_unit
from surrogate.training.hilomot import Hilomot
from surrogate.training.least_squares import PLAIN_SCHEDULE, Fit, History, Schedule
from surrogate.training.levenberg_marquardt import train
from surrogate.training.local_training import Growth, LocalSettings, ScaledSamples, Splitter, grow
from surrogate.training.lolimot import Lolimot
from surrogate.training.perceptron import PerceptronBatch, nguyen_widrow, split_parameters
from surrogate.training.settings import Allowed, Choice, Layers, Whole, check

Method = Literal["bayesian_regularization", "levenberg_marquardt"]
Algorithm = Literal["lolimot", "hilomot"]

ALLOWED: dict[str, Allowed] = {
    "hidden": Layers(Whole(1, 10_000), 20),
    "seed": Whole(0, 2**63 - 1),
    "splits": Whole(1, 10_000),
    "restarts": Whole(1, 10_000),
    "method": Choice(get_args(Method)),
    "algorithm": Choice(get_args(Algorithm)),
}
"""Settings of a training."""

PURPOSES = ("independent", "rounds", "weights", "calibration")
"""What random numbers are drawn for."""
MOST_MEMORY = 16 * 1024**3
"""Bytes of the normal matrices of a batch."""

METHODS: dict[Method, tuple[str, Schedule]] = {
    "bayesian_regularization": ("Levenberg-Marquardt with Bayesian regularisation", Schedule()),
    "levenberg_marquardt": ("Levenberg-Marquardt", PLAIN_SCHEDULE),
}


def train_networks(
    X: ArrayLike,
    Y: ArrayLike,
    *,
    inputs: Sequence[tuple[str, str]],
    outputs: Sequence[tuple[str, str]],
    rows: ArrayLike,
    seed: int,
    hidden: int | Sequence[int] = 10,
    method: Method = "bayesian_regularization",
    validation_rows: ArrayLike | None = None,
    schedule: Schedule | None = None,
    sample_weight: ArrayLike | None = None,
    device: str = "cpu",
    progress: Callable[[int, int], None] | None = None,
) -> list[tuple[Network, History]]:
    """Train a batch of networks, each from its own initial weights and on its own samples.

    The ranges of all N samples map to [-1, 1] (paper eq. 43), so that the networks share one scale.

    Needs torch. On the processor the same seed gives the same bits on the same machine, whatever the number of its
    cores in use.

    Args:
        X: inputs (N, d) of all samples, in their units.
        Y: targets (N, m), in their units.
        inputs: (name, unit) of each column of X.
        outputs: (name, unit) of each column of Y.
        rows: (B, n) numbers of the samples that each of B networks is trained on.
        seed: of the initial weights.
        hidden: neurons, one number for each hidden layer.
        method: ``bayesian_regularization`` or ``levenberg_marquardt``.
        validation_rows: (B, v) numbers of the samples that stop each network early; None: none.
        schedule: when to stop, and how to move mu; None: the reference trainer's.
        sample_weight: (N,) how often the squared errors of each sample count; None: once.
        device: torch's, as ``cpu`` or ``cuda``.
        progress: called with the epochs done and all epochs, of the slowest network.

    Returns:
        Each network with the history of its training.

    Raises:
        ValueError: shapes that do not fit, values that are not finite, or rows that number no samples.
    """
    X, Y = checked_samples(X, inputs, "X"), checked_samples(Y, outputs, "Y")
    if len(X) != len(Y):
        raise ValueError(f"X has {len(X)} samples and Y has {len(Y)}, but each sample needs both.")
    check({"method": method, "hidden": hidden, "seed": seed}, ALLOWED)
    layers = (int(hidden),) if isinstance(hidden, int | np.integer) else tuple(map(int, hidden))
    rows = _checked_rows(rows, len(X), "rows", least=2)
    weights = _checked_weights(sample_weight, len(X))
    _check_size((X.shape[1], *layers, Y.shape[1]), len(rows))
    input_ranges = column_ranges(X, [name for name, _ in inputs])
    target_ranges = column_ranges(Y, [name for name, _ in outputs])
    X_p, T_p = to_symmetric(X, input_ranges), to_symmetric(Y, target_ranges)

    def problems(rows: Array) -> PerceptronBatch:
        return PerceptronBatch.from_samples(X_p, T_p, rows, layers, weights)

    validation = None
    if validation_rows is not None:
        validation = problems(_checked_rows(validation_rows, len(X), "validation_rows", len(rows)))
    sizes = X.shape[1], *layers, Y.shape[1]
    name, defaults = METHODS[method]
    fits = train(
        problems(rows),
        np.stack([nguyen_widrow(generator(seed, "weights", j), sizes) for j in range(len(rows))]),
        schedule or defaults,
        evidence=method == "bayesian_regularization",
        validation=validation,
        device=device,
        progress=progress,
    )

    def network(j: int, fit: Fit) -> Network:
        evidence = {} if fit.log_evidence is None else {"log_evidence": fit.log_evidence}
        return Network(
            *split_parameters(fit.w, sizes),
            input_ranges,
            target_ranges,
            tuple(Variable(*v) for v in inputs),
            tuple(Variable(*v) for v in outputs),
            fit.beta if fit.posterior_factor is not None else None,
            fit.posterior_factor,
            provenance={
                "training": name,
                "seed": seed,
                "restart": j,
                "samples": rows.shape[1],
                "epochs": len(fit.history.sse) - 1,
                "stop": fit.history.stop,
                "effective_parameters": fit.gamma,
                **evidence,
            },
        )

    return [(network(j, fit), fit.history) for j, fit in enumerate(fits)]


def train_local_models(
    X: ArrayLike,
    Y: ArrayLike,
    *,
    inputs: Sequence[tuple[str, str]],
    outputs: Sequence[tuple[str, str]],
    rows: ArrayLike,
    algorithm: Algorithm,
    validation_rows: ArrayLike | None = None,
    settings: LocalSettings | None = None,
    sample_weight: ArrayLike | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> tuple[LocalModelNetwork, Growth]:
    """Grow a local model network; its outputs share the cells (the paper trains one network for each output).

    Args:
        X: inputs (N, d) of all samples, in their units.
        Y: targets (N, m), in their units.
        inputs: (name, unit) of each column of X.
        outputs: (name, unit) of each column of Y.
        rows: (n,) numbers of the training samples.
        algorithm: ``lolimot`` or ``hilomot``.
        validation_rows: (v,) numbers of the samples that end the growth; None: a criterion of `settings` does.
        settings: of the growth; None: the defaults.
        sample_weight: (N,) how often each sample counts; None: once.
        progress: called with the models there are and the most there may be.

    Raises:
        ValueError: shapes that do not fit, values that are not finite, or rows that number no samples.
    """
    from threadpoolctl import threadpool_limits

    X, Y = checked_samples(X, inputs, "X"), checked_samples(Y, outputs, "Y")
    if len(X) != len(Y):
        raise ValueError(f"X has {len(X)} samples and Y has {len(Y)}, but each sample needs both.")
    settings = settings or LocalSettings()
    check({"algorithm": algorithm}, ALLOWED)
    weights = _checked_weights(sample_weight, len(X))
    input_ranges = column_ranges(X, [name for name, _ in inputs])
    target_ranges = column_ranges(Y, [name for name, _ in outputs])
    z, y = to_unit(X, input_ranges), to_unit(Y, target_ranges)

    def samples(rows: Array) -> ScaledSamples:
        return ScaledSamples(z[rows], y[rows], settings.local_model, None if weights is None else weights[rows])

    training = samples(_checked_rows(np.atleast_2d(rows), len(X), "rows", least=2)[0])
    validation = None
    if validation_rows is not None:
        validation = samples(_checked_rows(np.atleast_2d(validation_rows), len(X), "validation_rows")[0])
    splitter: Splitter = (
        Lolimot(settings.smoothness) if algorithm == "lolimot" else Hilomot(X.shape[1], settings.smoothness)
    )
    with threadpool_limits(1, "blas"):  # the matrices are too small to be divided among cores
        grown, growth = grow(training, validation, splitter, settings, progress)
    coefficients = grown.coefficients * np.ptp(target_ranges, axis=1)
    coefficients[:, 0] += target_ranges[:, 0]  # the first term is the constant, and the validities add up to one
    network = LocalModelNetwork(
        training.terms,
        coefficients,
        grown.partition,
        input_ranges,
        target_ranges,
        tuple(Variable(*v) for v in inputs),
        tuple(Variable(*v) for v in outputs),
        provenance={
            "training": algorithm.upper(),
            "local_model": settings.local_model,
            "smoothness": settings.smoothness,
            "criterion": settings.criterion,
            "samples": len(training.z),
            "parameters": int(growth.parameters[growth.best - 1]),
            "stop": growth.stop,
        },
    )
    return network, growth


def generator(seed: int, purpose: str, number: int = 0) -> np.random.Generator:
    """Random numbers for one of the `PURPOSES` and a number, unlike those for any other."""
    key = PURPOSES.index(purpose), number
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=key))


def checked_samples(values: ArrayLike, variables: Sequence[tuple[str, str]], name: str) -> Array:
    """The samples `values` (N, d) as float64; ValueError unless finite and with a column for each variable."""
    values = np.asarray(values, dtype=float)
    if values.ndim != 2 or values.shape[1] != len(variables) or len(values) == 0:
        raise ValueError(f"{name} has the shape {values.shape}, but must be (samples, {len(variables)}).")
    if not np.isfinite(values).all():
        raise ValueError(f"{name} holds values that are not finite: leave those samples out.")
    return values


def distinct_samples(X: Array, Y: Array, weights: Array | None = None) -> tuple[Array, Array, Array | None]:
    """Samples X (n, d), Y (n, m) once each, and weights (n,), which count those that stood there several times.

    Where a part is set apart afterwards, no copy of a sample in it is left for training. Without weights and without
    copies there are no weights.
    """
    _, first, place = np.unique(np.column_stack([X, Y]), axis=0, return_index=True, return_inverse=True)
    if weights is None and len(first) == len(X):
        return X, Y, None
    totals, order = np.bincount(place.ravel(), weights).astype(float), np.argsort(first)
    return X[first[order]], Y[first[order]], totals[order]


def _checked_rows(rows: ArrayLike, samples: int, name: str, networks: int | None = None, least: int = 1) -> np.ndarray:
    rows = np.asarray(rows)
    if rows.ndim != 2 or rows.size == 0 or rows.min() < 0 or rows.max() >= samples:
        raise ValueError(f"{name} must number samples from 0 to {samples - 1}, one row of numbers for each network.")
    if rows.shape[1] < least:
        raise ValueError(
            f"{rows.shape[1]} sample is left for training, but at least {least} are needed: give more rows."
        )
    if networks is not None and len(rows) != networks:
        raise ValueError(f"{name} has {len(rows)} rows of numbers, but there are {networks} networks.")
    return rows


def _checked_weights(weights: ArrayLike | None, samples: int) -> Array | None:
    if weights is None:
        return None
    weights = np.asarray(weights, dtype=float)
    if weights.shape != (samples,) or not np.isfinite(weights).all() or (weights <= 0).any():
        raise ValueError(f"sample_weight has the shape {weights.shape}, but must be {samples} finite numbers above 0.")
    return weights


def _check_size(sizes: tuple[int, ...], networks: int) -> None:
    """Refuse normal matrices that no machine holds, before they are asked for."""
    parameters = parameter_count(sizes)
    needed = 8 * networks * parameters**2
    if needed > MOST_MEMORY:
        raise ValueError(
            f"{networks} networks of {parameters} parameters need {needed / 1024**3:.3g} GiB for normal matrices, "
            f"and {MOST_MEMORY / 1024**3:g} GiB are allowed: take fewer neurons or fewer networks."
        )
