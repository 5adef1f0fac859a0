"""From samples in their own units to trained networks."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from surrogate.bayesian_regularization import Fit, History, Schedule, train
from surrogate.evaluation import Variable
from surrogate.network import Network
from surrogate.perceptron import PerceptronBatch, nguyen_widrow, split_parameters
from surrogate.scaling import Array, column_ranges, to_symmetric


def train_networks(
    X: ArrayLike,
    Y: ArrayLike,
    *,
    inputs: Sequence[tuple[str, str]],
    outputs: Sequence[tuple[str, str]],
    rows: ArrayLike,
    seed: int,
    hidden: int = 10,
    schedule: Schedule | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> list[tuple[Network, History]]:
    """Train a batch of networks with Bayesian regularisation, each from its own initial weights and on its own samples.

    X (N, d) and Y (N, m) are all samples in their units; `inputs` and `outputs` give (name, unit) of their columns.
    Row j of `rows` (B, n) numbers the samples that network j is trained on. The ranges of all N samples map to [-1, 1]
    (paper eq. 43), so that the networks share one scale. `progress(epochs done, all epochs)` follows the slowest one.

    Needs torch. The same seed gives the same bits on the same machine, whatever the number of its cores in use.
    """
    X, Y = checked_samples(X, inputs, "X"), checked_samples(Y, outputs, "Y")
    if len(X) != len(Y):
        raise ValueError(f"X has {len(X)} samples and Y has {len(Y)}, but each sample needs both.")
    if hidden < 1:
        raise ValueError(f"{hidden} hidden neurons were asked for, but at least 1 is needed.")
    rows = np.asarray(rows)
    if rows.ndim != 2 or rows.size == 0 or rows.min() < 0 or rows.max() >= len(X):
        raise ValueError(f"rows must number samples from 0 to {len(X) - 1}, one row of numbers for each network.")
    input_ranges = column_ranges(X, [name for name, _ in inputs])
    target_ranges = column_ranges(Y, [name for name, _ in outputs])

    sizes = X.shape[1], hidden, Y.shape[1]
    weights = np.stack([nguyen_widrow(generator(seed, "weights", j), sizes) for j in range(len(rows))])
    batch = PerceptronBatch.from_samples(to_symmetric(X, input_ranges), to_symmetric(Y, target_ranges), rows, hidden)
    fits = train(batch, weights, schedule or Schedule(), progress)

    def network(j: int, fit: Fit) -> Network:
        return Network(
            *split_parameters(fit.w, sizes),
            input_ranges,
            target_ranges,
            tuple(Variable(*v) for v in inputs),
            tuple(Variable(*v) for v in outputs),
            fit.beta,
            fit.posterior_factor,
            provenance={
                "training": "Levenberg-Marquardt with Bayesian regularisation",
                "seed": seed,
                "restart": j,
                "samples": rows.shape[1],
                "epochs": len(fit.history.sse) - 1,
                "stop": fit.history.stop,
                "effective_parameters": fit.gamma,
            },
        )

    return [(network(j, fit), fit.history) for j, fit in enumerate(fits)]


def generator(seed: int, purpose: str, number: int = 0) -> np.random.Generator:
    """Random numbers for a purpose ('independent', 'rounds' or 'weights') and number, unlike those for any other."""
    key = ("independent", "rounds", "weights").index(purpose), number
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=key))


def checked_samples(values: ArrayLike, variables: Sequence[tuple[str, str]], name: str) -> Array:
    """The samples `values` (N, d) as float64; ValueError unless finite and with a column for each variable."""
    values = np.asarray(values, dtype=float)
    if values.ndim != 2 or values.shape[1] != len(variables) or len(values) == 0:
        raise ValueError(f"{name} has the shape {values.shape}, but must be (samples, {len(variables)}).")
    if not np.isfinite(values).all():
        raise ValueError(f"{name} holds values that are not finite: leave those samples out.")
    return values
