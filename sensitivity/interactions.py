"""Interactions of independent inputs: the share of every subset in the variance (Hoeffding, Sobol), to any order.

    S_u = sum over v in u of (-1)^(|u| - |v|) S^closed_v

The shares of all subsets sum to one. They need independent inputs: of dependent ones the sum means nothing.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

from .design import Design, EvaluatedDesign, Factor, Sampling, factor_key, redrawn_design
from .distributions import Distribution
from .redraw_ratios import Combination, Estimate, RedrawRatios
from .result import Result

MOST_INPUTS_OF_ALL_ORDERS = 6


@dataclass(frozen=True, eq=False)
class Interactions(Result):
    """Shares (subsets, outputs) of subsets of the inputs in the variance, those of single inputs first."""

    design: Design
    output_names: tuple[str, ...]
    shares: Estimate
    confidence: float

    kinds = ("shares",)

    @property
    def row_names(self) -> tuple[str, ...]:
        """Subsets, each by its key."""
        return tuple(map(factor_key, self.subsets))

    @property
    def subsets(self) -> tuple[Factor, ...]:
        """In the order of the rows."""
        return self.design.factors

    def to_dict(self) -> dict[str, Any]:
        """Plain dictionaries and numbers, ready for JSON."""
        return {
            "definition": "S_u: the share of V(f) that the inputs u have together and no part of them alone",
            "n_base": self.design.n_base,
            "n_evaluations": self.design.n_evaluations,
            "confidence": self.confidence,
            "outputs": {
                name: {factor_key(subset): self.shares.to_dict(i, j) for i, subset in enumerate(self.subsets)}
                for j, name in enumerate(self.output_names)
            },
        }


def interaction_design(
    distribution: Distribution,
    n: int,
    order: int = 2,
    *,
    sampling: Sampling = "sobol",
    replicates: int = 8,
    seed: int = 0,
) -> Design:
    """Design for the shares of all subsets of up to `order` inputs; `order` = M gives all of them (the HDMR table).

    Args:
        distribution: of the inputs, which are independent.
        n: base rows.
        order: largest number of inputs that share an effect.
        sampling: "sobol", "latin" or "random", as of `variance_design`.
        replicates: independent samples that the rows are divided into, for the intervals.
        seed: of the random numbers.

    Raises:
        ValueError: dependent inputs, an order outside 1 .. M, all of more than 6, or as `variance_design`.
    """
    names, m = distribution.names, len(distribution.names)
    if distribution.dependent:
        group = ", ".join(distribution.dependent[0])
        raise ValueError(f"{group} depend on each other, and have no interactions in this sense: use Shapley effects.")
    if not 1 <= order <= m or (order > 3 and m > MOST_INPUTS_OF_ALL_ORDERS):
        raise ValueError(
            f"Interactions of order {order} among {m} inputs: give 1 to {m}, and at most 3 beyond "
            f"{MOST_INPUTS_OF_ALL_ORDERS} inputs."
        )
    subsets = [subset for size in range(1, order + 1) for subset in combinations(names, size)]
    redrawn = [rest for subset in subsets if (rest := distribution.complement(subset))]
    return redrawn_design(distribution, subsets, redrawn, n, sampling, replicates, seed)


def interactions(
    evaluated: EvaluatedDesign, *, confidence: float = 0.95, n_bootstrap: int = 1000, seed: int = 0
) -> Interactions:
    """The shares from an evaluated `interaction_design`; intervals as `variance_indices`.

    Args:
        evaluated: the design with its outputs.
        confidence: of the intervals.
        n_bootstrap: resamples of the rows, for the intervals.
        seed: of the resamples.
    """
    design, ratios = evaluated.design, RedrawRatios(evaluated, confidence, n_bootstrap, seed)
    shares = [_share(ratios, subset) for subset in design.factors]
    return Interactions(design, evaluated.output_names, ratios.estimate(shares), confidence)


def _share(ratios: RedrawRatios, subset: Sequence[str]) -> Combination:
    found = Combination(0.0, {})
    for size in range(1, len(subset) + 1):
        for part in combinations(subset, size):
            found += (-1.0) ** (len(subset) - size) * ratios.closed(part)
    return found
