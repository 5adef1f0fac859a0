"""First-order and total indices of a table over every combination of levels: no sampling, no interval.

Each input has some levels, and each combination of levels a weight, its share of the probability. Where weights are no
products the inputs depend on each other; zero weights are combinations that do not occur. Then

    S_y = V[E(f | y)] / V(f),     ST_y = E[V(f | z)] / V(f) = 1 - V[E(f | z)] / V(f)

are sums over the table. For continuous inputs the levels are the middles of cells; how far the indices then are from
those of the continuous inputs, a table of finer cells tells.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .design import Factor, factor_key
from .distributions import Array
from .outputs import checked_outputs
from .redraw_ratios import Estimate
from .result import Result


@dataclass(frozen=True, eq=False)
class TabulatedIndices(Result):
    """Indices of every input and group (rows) for every output (columns); their intervals have no width."""

    factors: tuple[Factor, ...]
    output_names: tuple[str, ...]
    first: Estimate
    total: Estimate
    output_mean: Array
    output_variance: Array

    kinds = ("first", "total")
    confidence = None

    @property
    def row_names(self) -> tuple[str, ...]:
        """Inputs and groups, each by its key."""
        return tuple(map(factor_key, self.factors))

    def to_dict(self) -> dict[str, Any]:
        """Plain dictionaries and numbers, ready for JSON: output, factor, kind."""
        return {
            output: {
                "mean": float(self.output_mean[j]),
                "variance": float(self.output_variance[j]),
                "indices": {
                    row: {kind: float(estimate.value[i, j]) for kind, estimate in self.estimates.items()}
                    for i, row in enumerate(self.row_names)
                },
            }
            for j, output in enumerate(self.output_names)
        }


def tabulated_indices(
    names: Sequence[str],
    weights: ArrayLike,
    outputs: ArrayLike,
    output_names: Sequence[str],
    *,
    groups: Sequence[Collection[str]] = (),
) -> TabulatedIndices:
    """Indices of every input and group of a table.

    Args:
        names: of the inputs, one for each axis of the table.
        weights: (l_1, .., l_d) for the levels of each input, not negative; they need not sum to one.
        outputs: (l_1, .., l_d, m) of m outputs; where a weight is zero they may be anything.
        output_names: one for each output.
        groups: of inputs, for their closed and total indices.

    Raises:
        ValueError: shapes that do not fit, weights that are none, a group of none or all inputs, or outputs that are
            not finite or do not vary.
    """
    names = tuple(names)
    given, table = np.asarray(weights, dtype=float), np.asarray(outputs, dtype=float)
    if len(names) < 2 or given.ndim != len(names) or table.shape[:-1] != given.shape:
        raise ValueError(
            f"Weights have shape {given.shape} and outputs {table.shape} for the inputs {', '.join(names)}: give an "
            "axis for each of at least two inputs, and outputs a last one of their own."
        )
    if not (np.isfinite(given).all() and (given >= 0.0).all() and given.any()):
        raise ValueError("Weights are shares of the probability: give numbers that are not negative, some above zero.")
    for group in groups:
        if isinstance(group, str) or not set(group) < set(names) or not group:
            raise ValueError(f"Group {group!r} must hold some, but not all, inputs of {', '.join(names)}.")
    p = given / given.sum()
    occurs = p > 0.0
    checked_names, values = checked_outputs(table[occurs], np.argwhere(occurs).astype(float), output_names)
    mean = p[occurs] @ values
    centred = np.zeros(table.shape)
    centred[occurs] = values - mean
    weighted = p[..., np.newaxis] * centred
    variance = (weighted * centred).reshape(-1, len(mean)).sum(axis=0)
    singles = [(name,) for name in names]
    in_order = [tuple(name for name in names if name in group) for group in groups]
    factors = tuple(dict.fromkeys([*singles, *in_order]))

    def explained(factor: Collection[str]) -> Array:
        """V[E(f | factor)] / V(f) of each output."""
        others = tuple(axis for axis, name in enumerate(names) if name not in factor)
        share, total = p.sum(axis=others)[..., np.newaxis], weighted.sum(axis=others)
        squares = np.divide(total**2, share, out=np.zeros_like(total), where=share > 0.0)
        return squares.reshape(-1, len(mean)).sum(axis=0) / variance

    first = [explained(factor) for factor in factors]
    total = [1.0 - explained([name for name in names if name not in factor]) for factor in factors]
    return TabulatedIndices(factors, checked_names, _without_error(first), _without_error(total), mean, variance)


def _without_error(rows: Sequence[Array]) -> Estimate:
    value = np.array(rows)
    return Estimate(value, value, value, np.zeros_like(value), np.full_like(value, np.nan))
