"""The paper's selection of a network (Algorithm 1): many trainings, the least error on data that none of them saw."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surrogate.models.local_models import LocalModelNetwork
from surrogate.models.network import Network
from surrogate.scaling import Array, to_unit
from surrogate.training.least_squares import History, Schedule
from surrogate.training.train import Method, checked_samples, generator, train_networks

Rows = NDArray[np.int64]
Part = Literal["training", "test", "all", "independent"]
"""Parts of the data: those of one round's training and test, both together, and what every network is judged by."""
PARTS: tuple[Part, ...] = ("training", "test", "all", "independent")


@dataclass(frozen=True)
class Split:
    """Row numbers of the samples in each part of the data, in rising order."""

    independent: Rows
    """(N_i,): judges the networks, never used in training."""
    training: Rows
    """(rounds, n): what each network is fitted to."""
    test: Rows
    """(rounds, m): the rest of the design part in each round."""

    def rows(self, part: Part, j: int) -> Rows:
        """Rows of a part in round j."""
        if part == "independent":
            return self.independent
        if part == "all":
            return np.sort(np.concatenate([self.training[j], self.test[j]]))
        return self.training[j] if part == "training" else self.test[j]


def split_samples(
    n: int, rounds: int, test_fraction: float, seed: int, members: NDArray[np.bool_] | None = None
) -> Split:
    """Set a fraction of n samples apart as independent; in each round divide the rest, the design part, by it again.

    Each division rounds to the nearest whole number of samples. With `members` (n,) only those samples stay in the
    design part, and the independent part is as without: the paper's diminished data sets.

    Args:
        n: number of samples.
        rounds: divisions.
        test_fraction: share set apart, 0 .. 1.
        seed: of the random numbers.
        members: (n,) whether a sample stays in the design part; None: all.
    """
    rng = generator(seed, "independent")
    design, independent = _divide(np.arange(n), test_fraction, rng)
    if members is not None:
        design = design[members[design]]
    pairs = [_divide(design, test_fraction, generator(seed, "rounds", j)) for j in range(rounds)]
    return Split(independent, np.stack([training for training, _ in pairs]), np.stack([test for _, test in pairs]))


def _divide(rows: Rows, fraction: float, rng: np.random.Generator) -> tuple[Rows, Rows]:
    size = round(fraction * len(rows))
    if not 0 < size < len(rows):
        raise ValueError(f"a fraction of {fraction:g} of {len(rows)} samples leaves a part empty: give more samples.")
    shuffled = rng.permutation(rows)
    return np.sort(shuffled[size:]), np.sort(shuffled[:size])


@dataclass(frozen=True, eq=False)
class Rounds:
    """What all rounds of a protocol led to.

    Errors are mean squares over samples and outputs, of targets mapped to [0, 1] (paper eq. 11).
    """

    X: Array
    """All inputs (N, d)."""
    Y: Array
    """All targets (N, m)."""
    split: Split
    mse_by_output: dict[Part, Array]
    """Mean squared error of each round and output (rounds, m) by part of the data."""

    @property
    def mse(self) -> dict[Part, Array]:
        """The same over all outputs (rounds,); 'independent' is the paper's Table 6."""
        return {part: mse.mean(axis=1) for part, mse in self.mse_by_output.items()}

    @property
    def selected(self) -> int:
        """Number, from 0, of the round with the least error on the independent part."""
        return int(np.argmin(self.mse["independent"]))


@dataclass(frozen=True, eq=False)
class Selection(Rounds):
    """A network a round (Algorithm 1)."""

    networks: tuple[Network, ...]
    histories: tuple[History, ...]

    @property
    def network(self) -> Network:
        """The selected network, its scores among its metrics."""
        network = self.networks[self.selected]
        scores = {f"mse_{part}": float(mse[self.selected]) for part, mse in self.mse.items()}
        correlations = {f"r_{part}": self.correlation(part) for part in self.mse}
        return replace(network, metrics=scores | correlations)

    def targets_and_outputs(self, part: Part) -> tuple[Array, Array]:
        """Targets and the selected network's outputs, both (n, m) on [0, 1], in a part of the data."""
        network, rows = self.networks[self.selected], self.split.rows(part, self.selected)
        targets, outputs = self.Y[rows], network.predict(self.X[rows])
        return to_unit(targets, network.target_ranges), to_unit(outputs, network.target_ranges)

    def correlation(self, part: Part) -> float:
        """The paper's R value (Fig. 12) of a ``part``: correlation of targets with outputs, all outputs pooled."""
        targets, outputs = self.targets_and_outputs(part)
        return float(np.corrcoef(targets.ravel(), outputs.ravel())[0, 1])


def select_network(
    X: ArrayLike,
    Y: ArrayLike,
    *,
    inputs: Sequence[tuple[str, str]],
    outputs: Sequence[tuple[str, str]],
    seed: int,
    rounds: int = 20,
    test_fraction: float = 0.1,
    hidden: int | Sequence[int] = 10,
    method: Method = "bayesian_regularization",
    split: Split | None = None,
    schedule: Schedule | None = None,
    device: str = "cpu",
    progress: Callable[[int, int], None] | None = None,
) -> Selection:
    """Run Algorithm 1 on the inputs X (N, d) and targets Y (N, m); see `train_networks` for the arguments.

    The test part of a round stops a training by Levenberg-Marquardt early, which the paper leaves open. `split` takes
    the place of the one that rounds, fraction and seed give.

    Args:
        X: inputs (N, d) of all samples, in their units.
        Y: targets (N, m), in their units.
        inputs: (name, unit) of each column of X.
        outputs: (name, unit) of each column of Y.
        seed: of the divisions and the initial weights.
        rounds: trainings, of which the best on the independent part is kept.
        test_fraction: share of the samples set apart, 0 .. 1, and of the rest in each round.
        hidden: neurons, one number for each hidden layer.
        method: ``bayesian_regularization`` or ``levenberg_marquardt``.
        split: takes the place of the one that rounds, fraction and seed give.
        schedule: when to stop, and how to move mu; None: the reference trainer's.
        device: torch's, as ``cpu`` or ``cuda``.
        progress: called with the epochs done and all epochs.
    """
    X, Y = checked_samples(X, inputs, "X"), checked_samples(Y, outputs, "Y")
    split = split or split_samples(len(X), rounds, test_fraction, seed)
    trained = train_networks(
        X,
        Y,
        inputs=inputs,
        outputs=outputs,
        rows=split.training,
        seed=seed,
        hidden=hidden,
        method=method,
        validation_rows=split.test if method == "levenberg_marquardt" else None,
        schedule=schedule,
        device=device,
        progress=progress,
    )
    networks, histories = zip(*trained, strict=True)
    squares = np.stack([squared_errors(network, X, Y) for network in networks])
    return Selection(X, Y, split, mse_by_part(squares, split), networks, histories)


def squared_errors(network: Network | LocalModelNetwork, X: Array, Y: Array) -> Array:
    """Squared errors (N, m) on targets mapped to [0, 1]."""
    ranges = network.target_ranges
    return np.asarray((to_unit(network.predict(X), ranges) - to_unit(Y, ranges)) ** 2)


def mse_by_part(squares: Array, split: Split) -> dict[Part, Array]:
    """Means (rounds, m) over each part of the data, of squared errors (rounds, N, m)."""
    return {part: np.stack([e[split.rows(part, j)].mean(axis=0) for j, e in enumerate(squares)]) for part in PARTS}
