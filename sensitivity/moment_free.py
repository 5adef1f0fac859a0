"""Moment-free indices: how far the whole distribution of an output moves when an input is known.

For outputs whose variance says little, since they jump or have heavy tails. They are read from a table of runs.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy import stats

from .distributions import Array
from .given_data import LEAST_PER_BIN, bin_edges, checked_table
from .redraw_ratios import Estimate, check_interval
from .result import Result


@dataclass(frozen=True, eq=False)
class PawnIndices(Result):
    """Moment-free indices (inputs, outputs): how far the distribution of the output moves when one input is known.

    Attributes:
        median, largest, mean: of the Kolmogorov-Smirnov distances between all outputs and those of each slice.
        dummy: largest mean distance (outputs) of inputs that do nothing: below it, influence is chance.
    """

    input_names: tuple[str, ...]
    output_names: tuple[str, ...]
    slices: int
    median: Estimate
    largest: Estimate
    mean: Estimate
    dummy: Array
    confidence: float

    kinds = ("median", "largest", "mean")

    def to_dict(self) -> dict[str, Any]:
        """Plain dictionaries and numbers, ready for JSON."""
        outputs = self.by_output()
        for j, output in enumerate(self.output_names):
            outputs[output]["dummy"] = float(self.dummy[j])
        return {
            "definition": "PAWN: Kolmogorov-Smirnov distance of the outputs of a slice to all (Pianosi, Wagener 2015)",
            "slices": self.slices,
            "confidence": self.confidence,
            "outputs": outputs,
        }


def pawn_indices(
    points: ArrayLike,
    outputs: ArrayLike,
    *,
    input_names: Sequence[str] | None = None,
    output_names: Sequence[str] | None = None,
    slices: int = 10,
    confidence: float = 0.95,
    n_bootstrap: int = 100,
    seed: int = 0,
) -> PawnIndices:
    """PAWN (Pianosi, Wagener 2015, 2018) from inputs (n, M) and outputs (n,) or (n, outputs).

    No variance enters, so jumps and heavy tails are welcome.

    Args:
        points: inputs (n, M): an array, or a table whose columns have names.
        outputs: (n,) or (n, outputs), row by row as the points.
        input_names: default those of the columns, or x0, x1, ...
        output_names: default y0, y1, ...
        slices: parts of each input's range that are compared with the whole.
        confidence: of the intervals.
        n_bootstrap: resamples of the rows, for the intervals.
        seed: of the random numbers.

    Raises:
        ValueError: as `given_data_indices`.
    """
    check_interval(confidence, n_bootstrap)
    X, input_names, names, Y = checked_table(points, outputs, input_names, output_names)
    n = len(X)
    if not 2 <= slices <= n // LEAST_PER_BIN:
        raise ValueError(f"{n} rows in {slices} slices: give at least 2 slices, and {LEAST_PER_BIN} rows for each.")
    rng = np.random.default_rng(seed)
    whole = _distances(X, Y, slices)
    half = _distances(X[: n // 2], Y[: n // 2], slices)
    spread = [_distances(X[rows], Y[rows], slices) for rows in rng.integers(n, size=(n_bootstrap, n))]
    tails = (0.5 - confidence / 2, 0.5 + confidence / 2)

    def estimate(statistic: Callable[[Array], Array]) -> Estimate:
        value, resampled = statistic(whole), np.array([statistic(one) for one in spread])
        lower, upper = np.quantile(resampled, tails, axis=0)
        return Estimate(value, lower, upper, resampled.std(axis=0, ddof=1), value - statistic(half))

    dummies = _distances(rng.random((n, 20)), Y, slices).mean(axis=0)
    return PawnIndices(
        input_names,
        names,
        slices,
        median=estimate(lambda d: np.median(d, axis=0)),
        largest=estimate(lambda d: d.max(axis=0)),
        mean=estimate(lambda d: d.mean(axis=0)),
        dummy=dummies.max(axis=0),
        confidence=confidence,
    )


def _distances(X: Array, Y: Array, slices: int) -> Array:
    """Kolmogorov-Smirnov distances (slices, inputs, outputs) of each slice of an input to all outputs."""
    n = len(X)
    starts = bin_edges(n, slices)
    ranks = stats.rankdata(Y, method="max", axis=0).astype(int)
    found = np.empty((slices, X.shape[1], Y.shape[1]))
    for i, x in enumerate(X.T):
        slice_of = np.searchsorted(starts, np.argsort(np.argsort(x, kind="stable"), kind="stable"), side="right") - 1
        for j in range(Y.shape[1]):
            order = np.argsort(ranks[:, j], kind="stable")
            last = np.append(np.diff(ranks[order, j]) > 0, True)  # equal outputs step together
            member = slice_of[order][np.newaxis, :] == np.arange(slices)[:, np.newaxis]
            within = np.cumsum(member, axis=1)[:, last] / member.sum(axis=1, keepdims=True)
            overall = ranks[order, j][last] / n
            found[:, i, j] = np.abs(within - overall).max(axis=1)
    return found
