"""First-order and total variance-based indices of independent or dependent inputs.

For a factor y, the rest z and the output f with variance D (Kucherenko, Tarantola, Annoni 2012; paper eqs 52-53):

    S_y  = V[E(f | y)] / D          first-order index; of a group, its closed index
    ST_y = E[V(f | z)] / D          total index

`redraw_ratios` estimates both. A constant added to f changes nothing, so nothing is lost to a large mean, as it is in
the paper's eqs (57)-(59); eq. (60) as printed is identically 1, because its second factor lacks the redrawn output.

With dependent inputs S_y <= ST_y need not hold, and no estimate is clipped or reordered.
"""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .design import Design, EvaluatedDesign, Factor, factor_key
from .distributions import Array
from .redraw_ratios import Estimate, RedrawRatios
from .result import Result


@dataclass(frozen=True)
class Identity:
    """S_first + ST_total + S_rest <= 1 for a dependent block split into `first` and `total`, and all other inputs.

    The rest is independent of the block, so S_first + S_rest <= S_{first, rest} = 1 - ST_total.
    """

    first: Factor
    total: Factor
    rest: Factor


@dataclass(frozen=True, eq=False)
class VarianceIndices(Result):
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

    kinds = ("first", "total")

    @property
    def row_names(self) -> tuple[str, ...]:
        """Inputs and groups, each by its key."""
        return tuple(map(factor_key, self.factors))

    @property
    def factors(self) -> tuple[Factor, ...]:
        """Inputs and groups in the order of the rows."""
        return self.design.factors

    @property
    def identities_hold(self) -> NDArray[np.bool_]:
        """Whether each sum is at most 1 within its error: the lower end of its interval is; (identities, outputs)."""
        return self.identity_sums.lower <= 1.0

    def to_dict(self) -> dict[str, Any]:
        """Plain dictionaries, lists and numbers, ready for JSON; a factor is keyed by `factor_key`."""
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
                factor_key(factor): {"first": self.first.to_dict(i, j), "total": self.total.to_dict(i, j)}
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

    Args:
        evaluated: a design with its outputs.
        confidence: of the intervals.
        n_bootstrap: resamples of the rows, for the intervals.
        seed: of the resamples.
    """
    design, ratios = evaluated.design, RedrawRatios(evaluated, confidence, n_bootstrap, seed)
    identities = _identities(design)
    base = evaluated.outputs[: design.n_base]
    return VarianceIndices(
        design=design,
        output_names=evaluated.output_names,
        first=ratios.estimate([ratios.closed(factor) for factor in design.factors]),
        total=ratios.estimate([ratios.total(factor) for factor in design.factors]),
        identities=identities,
        identity_sums=ratios.estimate(
            [ratios.closed(each.first) + ratios.total(each.total) + ratios.closed(each.rest) for each in identities]
        ),
        output_mean=base.mean(axis=0),
        output_variance=base.var(axis=0, ddof=1),
        confidence=confidence,
    )


def _identities(design: Design) -> tuple[Identity, ...]:
    """One for each input of each dependent block, where the block's remaining inputs are a factor too."""
    return tuple(
        Identity(first, (name,), design.distribution.complement(block))
        for block in design.distribution.dependent
        for name in block
        for first in [tuple(other for other in block if other != name)]
        if first in design.factors and block in design.factors
    )
