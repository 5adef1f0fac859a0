"""Full and independent indices (Mara, Tarantola 2012): four numbers for an input that depends on others.

What depends on an input may be counted as its own, or not. Let xi be the independent numbers behind the inputs, once
with x_i drawn first (so that the others follow it), once with x_i drawn last (what the others leave of it):

    full         x_i first    S of xi_i = V[E(f | x_i)] / D, Kucherenko's first index    ST of xi_i
    independent  x_i last     S of xi_i    ST of xi_i = E[V(f | others)] / D, Kucherenko's total index

An input with ST full of 0 can be left out; one with ST independent of 0 acts only through the others. For independent
inputs both pairs are Sobol's indices. The others are drawn given x_i by the distribution's own conditional draws.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .design import Sampling, unit_numbers
from .distributions import Array, Distribution
from .outputs import checked_outputs, evaluate_in_chunks
from .redraw_ratios import Estimate, PairRatios
from .result import Result

KINDS = ("full_first", "full_total", "independent_first", "independent_total")


@dataclass(frozen=True, eq=False)
class FullIndependentIndices(Result):
    """The four indices, each (inputs, outputs)."""

    input_names: tuple[str, ...]
    output_names: tuple[str, ...]
    n_base: int
    n_evaluations: int
    full_first: Estimate
    full_total: Estimate
    independent_first: Estimate
    independent_total: Estimate
    confidence: float

    kinds = KINDS

    def to_dict(self) -> dict[str, Any]:
        """Plain dictionaries and numbers, ready for JSON."""
        return {
            "definition": "full: with what the others owe to the input; independent: without (Mara, Tarantola 2012)",
            "n_base": self.n_base,
            "n_evaluations": self.n_evaluations,
            "confidence": self.confidence,
            "outputs": self.by_output(),
        }


def full_independent_indices(
    distribution: Distribution,
    model: Callable[[Array], ArrayLike],
    n: int,
    *,
    output_names: Sequence[str] | None = None,
    sampling: Sampling = "sobol",
    replicates: int = 8,
    confidence: float = 0.95,
    n_bootstrap: int = 1000,
    seed: int = 0,
) -> FullIndependentIndices:
    """The indices of a model of points (rows, M), by 6 M + 2 evaluations for each of n base rows.

    Args:
        distribution: of the inputs.
        model: maps points (rows, M) to outputs (rows,) or (rows, outputs).
        n: base rows.
        output_names: default y0, y1, ...
        sampling: "sobol", "latin" or "random", as of `variance_design`.
        replicates: independent samples that the rows are divided into, for the intervals.
        confidence: of the intervals.
        n_bootstrap: resamples of the rows, for the intervals.
        seed: of the random numbers.

    Raises:
        ValueError: fewer than two inputs, or as `variance_design` and `checked_outputs`.
    """
    names, m = distribution.names, len(distribution.names)
    if m < 2:
        raise ValueError(f"Indices share the variance out among at least two inputs, got {names}: add an input.")
    replicates = 1 if sampling == "random" else replicates
    u = unit_numbers(n, 4 * m, sampling, replicates, seed)
    base, other = distribution.sample(u[:, :m]), distribution.sample(u[:, m : 2 * m])
    own, anew = u[:, 2 * m : 3 * m], u[:, 3 * m :]

    # pairs of points that share what the index is about
    blocks, pairs = [base, other], [(0, 1)]
    for name in names:
        rest = distribution.complement((name,))
        following, followed_by_other = (distribution.conditional(x, rest, own) for x in (base, other))
        last, last_of_other = (distribution.conditional(x, (name,), own) for x in (base, other))
        others_anew = distribution.conditional(following, rest, anew)
        last_anew = distribution.conditional(last, (name,), anew)
        start = len(blocks)
        blocks += [following, others_anew, followed_by_other, last, last_of_other, last_anew]
        pairs += [(start, start + 1), (start, start + 2), (start + 3, start + 4), (start + 3, start + 5)]
    points = np.concatenate(blocks)
    outputs_named, outputs = checked_outputs(evaluate_in_chunks(model, points), points, output_names)
    samples = outputs.reshape(len(blocks), n, -1)
    ratios = PairRatios(samples, pairs, replicates, confidence, n_bootstrap, seed)

    def estimate(kind: int, closed: bool) -> Estimate:
        weights = np.zeros((m, len(pairs)))
        weights[np.arange(m), 1 + 4 * np.arange(m) + kind] = -1.0 if closed else 1.0
        return ratios.estimate(np.full((m, 1), float(closed)), weights)

    return FullIndependentIndices(
        names,
        outputs_named,
        n,
        len(points),
        full_first=estimate(0, closed=True),
        full_total=estimate(1, closed=False),
        independent_first=estimate(2, closed=True),
        independent_total=estimate(3, closed=False),
        confidence=confidence,
    )
