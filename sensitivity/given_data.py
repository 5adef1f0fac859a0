"""Indices from a table of runs that nobody designed: inputs and outputs, row by row.

Rows are sorted by one input and cut into bins of equal counts. The variance of the bin means over that of all outputs
is the correlation ratio eta^2 (Pearson 1905; Strong, Oakley 2013). With pure noise it is about (B - 1) / (n - 1), not
0; epsilon^2 takes that off (Kelley 1935). What is left is a bias to zero: a bin is not a point, so changes inside it do
not count. `bias_within` tells how much, from bins of twice the width.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .distributions import Array
from .outputs import ROUNDING, checked_outputs
from .redraw_ratios import Estimate, check_interval
from .result import Result

LEAST_PER_BIN = 5


@dataclass(frozen=True, eq=False)
class GivenDataIndices(Result):
    """First-order indices (inputs, outputs) of a table, S = V[E(f | x_i)] / V(f).

    Attributes:
        first: epsilon^2, with bootstrap intervals.
        raw: eta^2, not corrected.
        bias_corrected: what the correction for chance took off.
        bias_within: about what the width of the bins still hides.
    """

    input_names: tuple[str, ...]
    output_names: tuple[str, ...]
    rows: int
    bins: int
    first: Estimate
    raw: Array
    bias_corrected: Array
    bias_within: Array
    confidence: float

    kinds = ("first",)

    def to_dict(self) -> dict[str, Any]:
        """Plain dictionaries and numbers, ready for JSON."""
        return {
            "definition": "S = V[E(f | x)] / V(f) by bins of equal counts, corrected for chance (epsilon^2)",
            "rows": self.rows,
            "bins": self.bins,
            "confidence": self.confidence,
            "outputs": {
                output: {
                    name: self.first.to_dict(i, j)
                    | {
                        "raw": float(self.raw[i, j]),
                        "bias_corrected": float(self.bias_corrected[i, j]),
                        "bias_within": float(self.bias_within[i, j]),
                    }
                    for i, name in enumerate(self.input_names)
                }
                for j, output in enumerate(self.output_names)
            },
        }


def given_data_indices(
    points: ArrayLike,
    outputs: ArrayLike,
    *,
    input_names: Sequence[str] | None = None,
    output_names: Sequence[str] | None = None,
    bins: int | None = None,
    confidence: float = 0.95,
    n_bootstrap: int = 200,
    seed: int = 0,
) -> GivenDataIndices:
    """First-order indices from inputs (n, M) and outputs (n,) or (n, outputs), whatever the inputs' dependence.

    Args:
        points: inputs (n, M): an array, or a table whose columns have names.
        outputs: (n,) or (n, outputs), row by row as the points.
        input_names: default those of the columns, or x0, x1, ...
        output_names: default y0, y1, ...
        bins: of each input; default: the cube root of n, times 2.
        confidence: of the intervals.
        n_bootstrap: resamples of the rows, for the intervals.
        seed: of the resamples.

    Raises:
        ValueError: shapes that do not fit, an input that does not vary, or too few rows for the bins.
    """
    check_interval(confidence, n_bootstrap)
    X, input_names, names, Y = checked_table(points, outputs, input_names, output_names)
    n = len(X)
    count = round(2.0 * n ** (1 / 3)) if bins is None else int(bins)
    if not 2 <= count <= n // LEAST_PER_BIN:
        raise ValueError(f"{n} rows in {count} bins: give at least 2 bins, and {LEAST_PER_BIN} rows for each.")
    raw, corrected = _correlation_ratios(X, Y, count)
    coarse = _correlation_ratios(X, Y, max(count // 2, 2))[1]
    half = _correlation_ratios(X[: n // 2], Y[: n // 2], max(count // 2, 2))[1]
    rng = np.random.default_rng(seed)
    spread = np.array(
        [_correlation_ratios(X[rows], Y[rows], count)[1] for rows in rng.integers(n, size=(n_bootstrap, n))]
    )
    # a resample holds rows twice, which looks like less noise inside a bin: its centre is moved to the estimate
    spread += corrected - spread.mean(axis=0)
    lower, upper = np.quantile(spread, (0.5 - confidence / 2, 0.5 + confidence / 2), axis=0)
    first = Estimate(corrected, lower, upper, spread.std(axis=0, ddof=1), corrected - half)
    # what a smooth function hides falls with the square of the width: bins twice as wide hide three times as much more
    within = np.maximum(corrected - coarse, 0.0) / 3.0
    return GivenDataIndices(input_names, names, n, count, first, raw, raw - corrected, within, confidence)


def checked_table(
    points: ArrayLike, outputs: ArrayLike, input_names: Sequence[str] | None, output_names: Sequence[str] | None
) -> tuple[Array, tuple[str, ...], tuple[str, ...], Array]:
    """Inputs (n, M) and their names, names of the outputs and outputs (n, outputs).

    Raises:
        ValueError: shapes that do not fit, or an input or output that is not finite or does not vary.
    """
    X = np.asarray(points, dtype=float)
    if X.ndim != 2:
        raise ValueError(f"Inputs have shape {X.shape}: give one row for each run, one column for each input.")
    inputs = tuple(input_names) if input_names else tuple(f"x{i + 1}" for i in range(X.shape[1]))
    if len(inputs) != X.shape[1]:
        raise ValueError(f"Input names are {inputs} for {X.shape[1]} inputs: give each one.")
    bad = np.flatnonzero(~np.isfinite(X).all(axis=1))
    if bad.size:
        raise ValueError(
            f"The inputs of {bad.size} of {len(X)} runs are not finite, first row {bad[0]}: leave them out."
        )
    for name, varies in zip(inputs, np.ptp(X, axis=0) > ROUNDING * np.abs(X).max(axis=0), strict=True):
        if not varies:
            raise ValueError(f"The input {name} does not vary but for rounding: leave it out.")
    names, Y = checked_outputs(outputs, X, output_names)
    return X, inputs, names, Y


def bin_edges(n: int, bins: int) -> np.ndarray:
    """Starts of bins of (almost) equal counts."""
    return np.linspace(0, n, bins, endpoint=False).astype(int)


def _correlation_ratios(X: Array, Y: Array, bins: int) -> tuple[Array, Array]:
    """eta^2 and epsilon^2 (inputs, outputs)."""
    n = len(X)
    starts = bin_edges(n, bins)
    counts = np.diff(starts, append=n)[:, np.newaxis]
    centred = Y - Y.mean(axis=0)
    whole = (centred**2).sum(axis=0)
    sums = np.array([np.add.reduceat(centred[np.argsort(x, kind="stable")], starts, axis=0) for x in X.T])
    eta = (sums**2 / counts).sum(axis=1) / whole
    return eta, 1.0 - (1.0 - eta) * (n - 1) / (n - bins)
