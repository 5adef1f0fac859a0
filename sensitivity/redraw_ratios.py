"""The one estimator behind all variance-based indices: how much the output changes when some inputs are redrawn.

Read from pairs of the base output a = f(y, z) and an output c with one subset w of the inputs redrawn given the
others. Both have the same distribution, and half their mean squared difference estimates E[V(f | others)]. With D_w
the variance of the pooled values of the pair,

    r_w = 1/2 mean (a - c)^2 / D_w,     R_w = r_w / r_all,     ST_w = R_w,     S_others = 1 - R_w

r_w is Jansen's estimator of the total index ST_w, and 1 - r_w = [mean(a c) - f0^2] / D_w with the pooled mean f0 is
Janon's of the closed index of the others. Where all inputs are redrawn, r_all is 1 but for the sampling error, which
r_w shares when the others matter little: the division brings the error of a small index from order N^(-1/2) down to
that of Saltelli's estimator of 2010, and hardly changes that of a large one. A constant added to f changes nothing, so
nothing is lost to a large mean.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student_t

from .design import EvaluatedDesign, Factor
from .distributions import Array

MAX_BLOCKS = 2000
"""Rows of a random design are summed into at most this many blocks, and blocks are resampled: exact up to 2000 rows."""


@dataclass(frozen=True, eq=False)
class Estimate:
    """Estimates with their uncertainty, all of shape (rows, outputs).

    `change_on_doubling` is the value less that of the first half of the sample.
    """

    value: Array
    lower: Array
    upper: Array
    standard_error: Array
    change_on_doubling: Array

    def to_dict(self, *index: int) -> dict[str, float | None]:
        """The entry at ``index`` as plain numbers; None where a number is undefined."""
        entries = {name: float(getattr(self, name)[index]) for name in self.__dataclass_fields__}
        return {name: entry if np.isfinite(entry) else None for name, entry in entries.items()}


@dataclass(frozen=True)
class Combination:
    """constant + sum of weight R_w over subsets w: every index is one."""

    constant: float
    weights: Mapping[Factor, float]

    def __add__(self, other: "Combination") -> "Combination":
        """Their sum."""
        both = {*self.weights, *other.weights}
        weights = {w: self.weights.get(w, 0.0) + other.weights.get(w, 0.0) for w in both}
        return Combination(self.constant + other.constant, weights)

    def __rmul__(self, factor: float) -> "Combination":
        """A multiple."""
        return Combination(factor * self.constant, {w: factor * weight for w, weight in self.weights.items()})

    def __sub__(self, other: "Combination") -> "Combination":
        """Their difference."""
        return self + -1.0 * other


class PairRatios:
    """R of pairs of samples, for the whole sample, its first half, and its resamples or replicates."""

    def __init__(
        self,
        samples: Array,
        pairs: Sequence[tuple[int, int]],
        replicates: int,
        confidence: float,
        n_bootstrap: int,
        seed: int,
    ) -> None:
        """Ratios of the pairs (a, c) of samples (blocks, n, outputs), each to the first pair, in which all is redrawn.

        Intervals of this confidence: percentiles of bootstrap samples of the rows, or Student's t over replicates.

        Raises:
            ValueError: a confidence outside 0 .. 1, or fewer than 2 bootstrap samples.
        """
        check_interval(confidence, n_bootstrap)
        moments = _block_moments(samples, pairs, replicates)
        n_blocks = moments.shape[1]
        self.confidence = confidence
        self.whole = _redraw_ratio(moments.sum(axis=(0, 1)))
        self.half = _redraw_ratio(moments[:, : n_blocks // 2].sum(axis=(0, 1)))
        self.replicated = replicates > 1
        if self.replicated:
            self.spread = _redraw_ratio(moments.sum(axis=1))
        else:
            rng = np.random.default_rng(seed)
            weights = rng.multinomial(n_blocks, np.full(n_blocks, 1.0 / n_blocks), size=n_bootstrap)
            self.spread = _redraw_ratio(np.tensordot(weights.astype(float), moments[0], axes=1))

    def estimate(self, constant: Array, weights: Array) -> Estimate:
        """Estimates of constant (rows, 1) + weights (rows, pairs) @ R, all of shape (rows, outputs)."""

        def combine(ratio: Array) -> Array:
            return constant + weights @ ratio

        value, half, spread = map(combine, (self.whole, self.half, self.spread))
        error = spread.std(axis=0, ddof=1)
        tail = (1.0 - self.confidence) / 2.0
        if self.replicated:
            error = error / np.sqrt(len(spread))
            half_width = student_t.ppf(1.0 - tail, len(spread) - 1) * error
            lower, upper = value - half_width, value + half_width
        else:
            lower, upper = np.quantile(spread, [tail, 1.0 - tail], axis=0)
        return Estimate(value, lower, upper, error, value - half)


class RedrawRatios:
    """R_w of every subset w that a design redraws, and the indices that are made of them."""

    def __init__(self, evaluated: EvaluatedDesign, confidence: float, n_bootstrap: int, seed: int) -> None:
        """Intervals and errors as `PairRatios`."""
        design = evaluated.design
        self.complement = design.distribution.complement
        self.subsets = (design.redrawn[-1], *design.redrawn[1:-1])
        blocks = len(design.redrawn)
        samples = evaluated.outputs.reshape(blocks, design.n_base, -1)
        pairs = [(0, blocks - 1), *((0, block) for block in range(1, blocks - 1))]
        self.ratios = PairRatios(samples, pairs, design.replicates, confidence, n_bootstrap, seed)

    def closed(self, factor: Factor) -> Combination:
        """Closed index of some inputs, V[E(f | factor)] / D = 1 - R of all others; 0 of none, 1 of all."""
        others = self.complement(factor)
        return Combination(1.0, {others: -1.0} if others else {})

    def total(self, factor: Factor) -> Combination:
        """Total index of some inputs, E[V(f | all others)] / D; 0 of none, 1 of all."""
        return Combination(0.0, {factor: 1.0} if factor else {})

    def estimate(self, combinations: Sequence[Combination]) -> Estimate:
        """Estimates of the combinations, all of shape (combinations, outputs)."""
        constant = np.array([combination.constant for combination in combinations])[:, np.newaxis]
        weights = np.zeros((len(combinations), len(self.subsets)))
        for row, combination in enumerate(combinations):
            for subset, weight in combination.weights.items():
                weights[row, self.subsets.index(subset)] += weight
        return self.ratios.estimate(constant, weights)


def check_interval(confidence: float, n_bootstrap: int) -> None:
    """Refuse what makes no interval.

    Raises:
        ValueError: a confidence outside 0 .. 1, or fewer than 2 bootstrap samples.
    """
    if not 0.0 < confidence < 1.0:
        raise ValueError(f"Confidence is {confidence:g}: give a number between 0 and 1, for instance 0.95.")
    if n_bootstrap < 2:
        raise ValueError(f"The bootstrap has {n_bootstrap} samples: give at least 2, and 1000 for a good interval.")


def _block_moments(samples: Array, pairs: Sequence[tuple[int, int]], replicates: int) -> Array:
    """Sums over blocks of rows of 1, (a + c) / 2, (a^2 + c^2) / 2 and (a - c)^2 / 2.

    Shape (replicates, blocks, 4, pairs, outputs). Two blocks suffice for a replicate.
    """
    rows = samples.shape[1] // replicates
    n_blocks = 2 if replicates > 1 else min(rows, MAX_BLOCKS)
    starts = np.linspace(0, rows, n_blocks, endpoint=False).astype(int)
    samples = samples.reshape(len(samples), replicates, rows, -1)
    centre = samples[0].mean(axis=(0, 1))
    moments = np.empty((replicates, n_blocks, 4, len(pairs), samples.shape[-1]))
    moments[:, :, 0] = np.diff(starts, append=rows)[:, np.newaxis, np.newaxis]
    for k, (first, second) in enumerate(pairs):
        a, c = samples[first] - centre, samples[second] - centre
        for m, term in enumerate([(a + c) / 2, (a * a + c * c) / 2, (a - c) ** 2 / 2], start=1):
            moments[:, :, m, k] = np.add.reduceat(term, starts, axis=1)
    return moments


def _redraw_ratio(moments: Array) -> Array:
    """R of each pair from sums (..., 4, pairs, outputs), the first redrawing all; NaN if a resample does not vary."""
    count, total, squares, half_squared_difference = np.moveaxis(moments, -3, 0)
    variance = squares / count - (total / count) ** 2
    with np.errstate(divide="ignore", invalid="ignore"):
        r = half_squared_difference / count / variance
        return r / r[..., :1, :]
