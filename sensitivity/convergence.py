"""How indices settle as the sample grows, and a sample that grows until they are narrow enough."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from .design import Design, EvaluatedDesign, variance_design
from .distributions import Array, Distribution
from .indices import VarianceIndices, variance_indices
from .outputs import checked_outputs, evaluate_in_chunks

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Convergence:
    """Indices of ever larger parts of one sample, the whole last (paper Figs 39-40)."""

    steps: tuple[VarianceIndices, ...]

    @property
    def n_base(self) -> tuple[int, ...]:
        """Rows of each part."""
        return tuple(step.design.n_base for step in self.steps)

    def to_dict(self) -> dict[str, Any]:
        """The results of each part by its number of rows."""
        return {str(n): step.to_dict() for n, step in zip(self.n_base, self.steps, strict=True)}

    def plot(self, **options: Any) -> "Figure":
        """Indices over the number of evaluations; options as `plots.plot_convergence` (needs matplotlib)."""
        from .plots import plot_convergence

        return plot_convergence(self, **options)


def convergence(evaluated: EvaluatedDesign, least: int = 256, **options: Any) -> Convergence:
    """Indices of the first `least` rows or more, then of twice as many, and so on; options as `variance_indices`.

    Args:
        evaluated: a design with its outputs.
        least: rows of the first indices, at least.
        options: of `variance_indices`.

    Raises:
        ValueError: fewer than 2 * `least` rows.
    """
    n = evaluated.design.n_base
    if n < 2 * least:
        raise ValueError(f"{n} rows do not grow from {least}: give a larger sample, or a smaller start.")
    sizes = [n]
    while sizes[0] // 2 >= least and sizes[0] % (2 * evaluated.design.replicates) == 0:
        sizes.insert(0, sizes[0] // 2)
    return Convergence(tuple(variance_indices(evaluated.head(size), **options) for size in sizes))


def variance_indices_until(
    model: Callable[[Array], ArrayLike],
    distribution: Distribution,
    half_width: float,
    *,
    output_names: Sequence[str] | None = None,
    least: int = 1024,
    most: int = 2**22,
    sampling: str = "sobol",
    confidence: float = 0.95,
    progress: Callable[[int, float], None] | None = None,
    **design_options: Any,
) -> VarianceIndices:
    """First-order and total indices, N doubled until no interval is wider than twice `half_width`.

    What was evaluated is kept: a doubling evaluates the new rows only.

    Args:
        model: maps points (rows, M) to outputs (rows,) or (rows, outputs).
        distribution: of the inputs.
        half_width: as 0.005.
        output_names: default y0, y1, ...
        least: first N.
        most: greatest N.
        sampling: "sobol" or "random".
        confidence: of the intervals.
        progress: called after each step with N and the half width reached.
        design_options: of `variance_design`.

    Returns:
        Indices; `half_width` of them is more than asked for if `most` rows did not suffice.

    Raises:
        ValueError: a width that is not above 0, Latin hypercubes, which cannot grow, or as `variance_design`.
    """
    if not half_width > 0.0:
        raise ValueError(f"The half width is {half_width:g}: give a number above 0, as 0.005.")
    if sampling == "latin":
        raise ValueError("A Latin hypercube cannot grow: choose 'sobol' or 'random'.")
    n, known = least, None
    while True:
        design = variance_design(distribution, n, sampling=sampling, **design_options)  # type: ignore[arg-type]
        known = _grown(design, model, output_names, known)
        found = variance_indices(known, confidence=confidence)
        if progress:
            progress(n, found.half_width)
        if found.half_width <= half_width or 2 * n > most:
            return found
        n *= 2


def _grown(
    design: Design,
    model: Callable[[Array], ArrayLike],
    output_names: Sequence[str] | None,
    known: EvaluatedDesign | None,
) -> EvaluatedDesign:
    """The design with its outputs, those of its first rows taken from a smaller one."""
    if known is None:
        return design.evaluate(model, output_names)
    shape = (len(design.redrawn), design.replicates, design.n_base // design.replicates, -1)
    points = design.points.reshape(shape)
    kept = known.design.n_base // known.design.replicates
    old = known.outputs.reshape(*shape[:2], kept, -1)
    fresh = points[:, :, kept:]
    new = evaluate_in_chunks(model, fresh.reshape(-1, fresh.shape[-1])).reshape(*fresh.shape[:3], -1)
    outputs = np.concatenate([old, new], axis=2).reshape(design.n_evaluations, -1)
    return EvaluatedDesign(design, *checked_outputs(outputs, design.points, output_names))
