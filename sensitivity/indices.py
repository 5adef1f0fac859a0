"""First-order and total variance-based indices of independent or dependent inputs.

For a factor y, the rest z and the output f with variance D (Kucherenko, Tarantola, Annoni 2012; paper eqs 52-53):

    S_y  = V[E(f | y)] / D          first-order index; of a group, its closed index
    ST_y = E[V(f | z)] / D          total index

Both are read from pairs of the base output a = f(y, z) and an output c with one subset w of the inputs redrawn given
the others. Both have the same distribution, and half their mean squared difference estimates E[V(f | others)]. With D_w
the variance of the pooled values of the pair,

    r_w = 1/2 mean (a - c)^2 / D_w,     R_w = r_w / r_all,     ST_y = R_y,     S_y = 1 - R_z

r_y is Jansen's estimator of ST_y, and 1 - r_z = [mean(a c) - f0^2] / D_z with the pooled mean f0 is Janon's of S_y.
Where all inputs are redrawn, r_all is 1 but for the sampling error, which r_z shares when y matters little: the
division brings the error of a small S_y from order N^(-1/2) down to that of Saltelli's estimator of 2010, and hardly
changes that of a large one. A constant added to f changes nothing, so nothing is lost to a large mean, as it is in the
paper's eqs (57)-(59); eq. (60) as printed is identically 1, because its second factor lacks the redrawn output.

With dependent inputs S_y <= ST_y need not hold, and no estimate is clipped or reordered.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student_t

from .design import Design, EvaluatedDesign, Factor
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
        """One entry as plain numbers; None where a number is undefined."""
        entries = {name: float(getattr(self, name)[index]) for name in self.__dataclass_fields__}
        return {name: entry if np.isfinite(entry) else None for name, entry in entries.items()}


@dataclass(frozen=True)
class Identity:
    """S_first + ST_total + S_rest <= 1 for a dependent block split into `first` and `total`, and all other inputs.

    The rest is independent of the block, so S_first + S_rest <= S_{first, rest} = 1 - ST_total.
    """

    first: Factor
    total: Factor
    rest: Factor


@dataclass(frozen=True, eq=False)
class VarianceIndices:
    """Indices of every factor (rows) for every output (columns), with what is needed to judge them.

    `identity_sums` (identities, outputs) holds the left sides of `identities`.
    """

    design: Design
    output_names: tuple[str, ...]
    first: Estimate
    total: Estimate
    identities: tuple[Identity, ...]
    identity_sums: Estimate
    output_mean: Array
    output_variance: Array
    confidence: float

    @property
    def factors(self) -> tuple[Factor, ...]:
        """Inputs and groups in the order of the rows."""
        return self.design.factors

    @property
    def identities_hold(self) -> NDArray[np.bool_]:
        """Whether each sum is at most 1 within its error: the lower end of its interval is; (identities, outputs)."""
        return self.identity_sums.lower <= 1.0

    def to_dict(self) -> dict[str, Any]:
        """Plain dictionaries, lists and numbers, ready for JSON; a factor is keyed by its names joined with commas."""
        return {
            "distribution": repr(self.design.distribution),
            "definition": "S = V[E(f | y)] / V(f), closed for a group; ST = E[V(f | all but y)] / V(f)",
            "sampling": self.design.sampling,
            "replicates": self.design.replicates,
            "seed": self.design.seed,
            "n_base": self.design.n_base,
            "n_evaluations": self.design.n_evaluations,
            "n_outside": self.design.n_outside,
            "confidence": self.confidence,
            "outputs": {name: self._output_to_dict(j) for j, name in enumerate(self.output_names)},
        }

    def _output_to_dict(self, j: int) -> dict[str, Any]:
        return {
            "mean": float(self.output_mean[j]),
            "variance": float(self.output_variance[j]),
            "indices": {
                ",".join(factor): {"first": self.first.to_dict(i, j), "total": self.total.to_dict(i, j)}
                for i, factor in enumerate(self.factors)
            },
            "identities": [
                {**asdict(identity), "sum": self.identity_sums.to_dict(i, j), "holds": bool(self.identities_hold[i, j])}
                for i, identity in enumerate(self.identities)
            ],
        }


def variance_indices(
    evaluated: EvaluatedDesign, *, confidence: float = 0.95, n_bootstrap: int = 1000, seed: int = 0
) -> VarianceIndices:
    """Estimate the indices of all factors of an evaluated design.

    Intervals: percentiles of n_bootstrap bootstrap samples of the rows for a random design; Student's t over the
    replicates for a Sobol design, whose rows are not independent. `seed` starts the bootstrap's generator.
    """
    if not 0.0 < confidence < 1.0:
        raise ValueError(f"Confidence is {confidence:g}: give a number between 0 and 1, for instance 0.95.")
    if n_bootstrap < 2:
        raise ValueError(f"The bootstrap has {n_bootstrap} samples: give at least 2, and 1000 for a good interval.")
    design = evaluated.design
    ratios = _RedrawRatios(evaluated, confidence, n_bootstrap, np.random.default_rng(seed))
    factors, identities, complement = design.factors, _identities(design), design.distribution.complement
    base = evaluated.outputs[: design.n_base]
    return VarianceIndices(
        design=design,
        output_names=evaluated.output_names,
        first=ratios.estimate(1.0, (-1, [complement(factor) for factor in factors])),
        total=ratios.estimate(0.0, (+1, factors)),
        identities=identities,
        identity_sums=ratios.estimate(
            2.0,
            (-1, [complement(identity.first) for identity in identities]),
            (+1, [identity.total for identity in identities]),
            (-1, [complement(identity.rest) for identity in identities]),
        ),
        output_mean=base.mean(axis=0),
        output_variance=base.var(axis=0, ddof=1),
        confidence=confidence,
    )


class _RedrawRatios:
    """R_w of every redrawn subset w, for the whole sample, its first half, and its resamples or replicates."""

    def __init__(
        self, evaluated: EvaluatedDesign, confidence: float, n_bootstrap: int, rng: np.random.Generator
    ) -> None:
        design = evaluated.design
        moments = _block_moments(evaluated)
        n_blocks = moments.shape[1]
        self.subsets = design.redrawn[1:]
        self.confidence = confidence
        self.whole = _redraw_ratio(moments.sum(axis=(0, 1)))
        self.half = _redraw_ratio(moments[:, : n_blocks // 2].sum(axis=(0, 1)))
        self.replicated = design.sampling == "sobol"
        if self.replicated:
            self.spread = _redraw_ratio(moments.sum(axis=1))
        else:
            weights = rng.multinomial(n_blocks, np.full(n_blocks, 1.0 / n_blocks), size=n_bootstrap)
            self.spread = _redraw_ratio(np.tensordot(weights.astype(float), moments[0], axes=1))

    def estimate(self, constant: float, *terms: tuple[int, Sequence[Factor]]) -> Estimate:
        """Estimate of constant + sum of sign R_w over the terms (sign, [w, ...]), shape (len of the lists, outputs)."""
        rows = [[self.subsets.index(subset) for subset in subsets] for _, subsets in terms]
        signs = [sign for sign, _ in terms]

        def combine(ratio: Array) -> Array:
            return constant + np.tensordot(signs, [ratio[..., row, :] for row in rows], axes=1)

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


def _block_moments(evaluated: EvaluatedDesign) -> Array:
    """Sums over blocks of rows of 1, (a + c) / 2, (a^2 + c^2) / 2 and (a - c)^2 / 2.

    Shape (replicates, blocks, 4, subsets, outputs). Two blocks a replicate suffice for a Sobol design.
    """
    design = evaluated.design
    rows = design.n_base // design.replicates
    n_blocks = 2 if design.sampling == "sobol" else min(rows, MAX_BLOCKS)
    starts = np.linspace(0, rows, n_blocks, endpoint=False).astype(int)
    n_outputs = len(evaluated.output_names)
    samples = evaluated.outputs.reshape(len(design.redrawn), design.replicates, rows, n_outputs)
    centre = samples[0].mean(axis=(0, 1))
    a = samples[0] - centre
    moments = np.empty((design.replicates, n_blocks, 4, len(design.redrawn) - 1, n_outputs))
    moments[:, :, 0] = np.diff(starts, append=rows)[:, np.newaxis, np.newaxis]
    for k, sample in enumerate(samples[1:]):
        c = sample - centre
        for m, term in enumerate([(a + c) / 2, (a * a + c * c) / 2, (a - c) ** 2 / 2], start=1):
            moments[:, :, m, k] = np.add.reduceat(term, starts, axis=1)
    return moments


def _redraw_ratio(moments: Array) -> Array:
    """R_w of each subset from sums (..., 4, subsets, outputs), all inputs last; NaN where a resample does not vary."""
    count, total, squares, half_squared_difference = np.moveaxis(moments, -3, 0)
    variance = squares / count - (total / count) ** 2
    with np.errstate(divide="ignore", invalid="ignore"):
        r = half_squared_difference / count / variance
        return r / r[..., -1:, :]


def _identities(design: Design) -> tuple[Identity, ...]:
    """One for each input of each dependent block, where the block's remaining inputs are a factor too."""
    return tuple(
        Identity(first, (name,), design.distribution.complement(block))
        for block in design.distribution.dependent
        for name in block
        for first in [tuple(other for other in block if other != name)]
        if first in design.factors and block in design.factors
    )
