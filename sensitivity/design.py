"""Designs for variance-based indices: points, the role of each block of rows, and the outputs that belong to them."""

import json
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.stats import qmc

from .distributions import Array, Distribution
from .outputs import checked_outputs, evaluate_in_chunks

Factor = tuple[str, ...]
"""Names of the inputs whose joint influence is one index; a single input is a factor of one name."""


def factor_key(factor: Factor) -> str:
    """The names joined with commas; one that holds a comma itself stands in quotation marks."""
    return ",".join(json.dumps(name) if "," in name or '"' in name else name for name in factor)


Sampling = Literal["sobol", "latin", "random"]

SEQUENCES = {"sobol": "Sobol sequences", "latin": "Latin hypercubes"}
MIN_ROWS = 16
TEXT_ROUNDING, COARSE_ROUNDING = 2e-6, 1e-3
"""Of an input's size: what ``%.6f`` of numbers around one or ``%.6g`` may take from a point on its way through a file,
and what looks like coarser rounding, not like another point."""


@dataclass(frozen=True, eq=False)
class Design:
    """Points at which a model is to be evaluated, with all that is needed to read indices from its outputs.

    The rows of `points` (n_evaluations, inputs) form blocks of n_base rows. Block 0 is the base sample; in block k the
    inputs named in `redrawn[k]` are drawn anew given the others, which keep the values of the base row. Inside a
    block the `replicates` independent samples of n_base / replicates rows follow each other.
    """

    distribution: Distribution
    factors: tuple[Factor, ...]
    redrawn: tuple[Factor, ...]
    points: Array
    sampling: Sampling
    replicates: int
    seed: int

    @property
    def n_evaluations(self) -> int:
        """Number of model evaluations."""
        return len(self.points)

    @property
    def n_base(self) -> int:
        """Rows of the base sample, N."""
        return self.n_evaluations // len(self.redrawn)

    @property
    def n_outside(self) -> int:
        """Number of points outside the support of the distribution; 0 unless a user's own block draws wrongly."""
        return int(np.count_nonzero(~self.distribution.contains(self.points)))

    def evaluate(
        self,
        model: Callable[[Array], ArrayLike],
        output_names: Sequence[str] | None = None,
        chunk_size: int = 65536,
    ) -> "EvaluatedDesign":
        """Evaluate a model that maps points (rows, inputs) to outputs (rows,) or (rows, outputs), in chunks of rows.

        Args:
            model: maps points to outputs.
            output_names: default y0, y1, ...
            chunk_size: rows at a time.

        Raises:
            ValueError: outputs that `checked_outputs` refuses.
        """
        outputs = evaluate_in_chunks(model, self.points, chunk_size)
        return EvaluatedDesign(self, *checked_outputs(outputs, self.points, output_names))

    def attach(
        self, points: ArrayLike, outputs: ArrayLike, output_names: Sequence[str] | None = None
    ) -> "EvaluatedDesign":
        """Join outputs computed elsewhere, (rows,) or (rows, outputs), with the design.

        `points` are those at which they were computed, row by row as the outputs; they must be the design's own, in its
        own order, so that a shuffled, filtered or foreign result is refused. Points that a text file rounded to six
        digits or more are the design's own. `output_names` are y0, y1, ... by default.

        Raises:
            ValueError: other points, or outputs that `checked_outputs` refuses.
        """
        points = np.asarray(points, dtype=float)
        if points.shape != self.points.shape:
            raise ValueError(
                f"Outputs were computed at points of shape {points.shape}, the design has {self.points.shape}: "
                "evaluate every point of this design."
            )
        away = np.abs(points - self.points) / np.maximum(np.ptp(self.points, axis=0), np.abs(self.points).max(axis=0))
        misplaced = np.flatnonzero(~(away <= TEXT_ROUNDING).all(axis=1))
        if misplaced.size and np.nanmax(away) < COARSE_ROUNDING:
            raise ValueError(
                f"The points are the design's but for rounding by up to {np.nanmax(away):.1g} of an input's size: "
                "write them with more digits, as with %.17g."
            )
        if misplaced.size:
            raise ValueError(
                f"Outputs do not belong to this design: {misplaced.size} points differ, first at row {misplaced[0]}; "
                "keep the order of design.points."
            )
        return EvaluatedDesign(self, *checked_outputs(outputs, self.points, output_names))


@dataclass(frozen=True, eq=False)
class EvaluatedDesign:
    """A design with the outputs (n_evaluations, outputs) at its points; made by `Design.evaluate` or `.attach`."""

    design: Design
    output_names: tuple[str, ...]
    outputs: Array

    def head(self, n: int) -> "EvaluatedDesign":
        """The first n base rows by themselves, of each replicate its first part: what a smaller design would have been.

        Raises:
            ValueError: more rows than there are, or a number that the replicates do not share evenly.
        """
        design = self.design
        rows, kept = design.n_base // design.replicates, n // design.replicates
        if not 2 <= kept <= rows or kept * design.replicates != n:
            raise ValueError(f"The first {n} of {design.n_base} rows in {design.replicates} replicates: give a part.")
        shape = (len(design.redrawn), design.replicates, rows, -1)
        points, outputs = (
            array.reshape(shape)[:, :, :kept].reshape(-1, array.shape[1]) for array in (design.points, self.outputs)
        )
        return EvaluatedDesign(replace(design, points=points), self.output_names, outputs)


def variance_design(
    distribution: Distribution,
    n: int,
    *,
    groups: Sequence[Collection[str]] = (),
    factors: Sequence[Collection[str]] | None = None,
    sampling: Sampling = "sobol",
    replicates: int = 8,
    seed: int = 0,
) -> Design:
    """Design for first-order and total indices of every input and every group, with dependent inputs.

    Every block of dependent inputs is a group without being asked for. M factors cost
    at most N (2 M + 2) evaluations: the base sample, for each factor one block with it redrawn (total index) and one
    with everything else redrawn (first-order index), and one block with all inputs redrawn, which removes most of the
    error of small first-order indices. A block that serves two factors is evaluated once.

    Args:
        distribution: of the inputs.
        n: base rows, N above.
        groups: of inputs, for their closed and total indices.
        factors: inputs and groups to take in the place of all of them.
        sampling: "sobol": independently scrambled Sobol sequences of n / replicates points, a power of two. "latin":
            independent Latin hypercubes of n / replicates points. "random": n independent rows.
        replicates: sequences or hypercubes; of no effect for "random".
        seed: of the scrambles, hypercubes or rows.

    Raises:
        ValueError: fewer than two inputs, a group of none or all of them, a number of rows that is too small or does
            not divide, or a sampling that is not known.
    """
    names = _at_least_two(distribution)
    for group in (*groups, *(factors or ())):
        distribution.check_names(group)
        if not 1 <= len(set(group)) < len(names):
            raise ValueError(f"Group {tuple(group)} must hold some, but not all, inputs of {', '.join(names)}.")
    asked = [*((name,) for name in names), *distribution.dependent, *groups] if factors is None else factors
    in_order = [tuple(name for name in names if name in group) for group in asked]
    chosen = tuple(dict.fromkeys(factor for factor in in_order if len(factor) < len(names)))
    rest = [distribution.complement(factor) for factor in chosen]
    return redrawn_design(distribution, chosen, [*chosen, *rest], n, sampling, replicates, seed)


def redrawn_design(
    distribution: Distribution,
    factors: Sequence[Factor],
    subsets: Sequence[Factor],
    n: int,
    sampling: Sampling,
    replicates: int,
    seed: int,
) -> Design:
    """The design whose blocks redraw the given subsets, and all inputs."""
    names = distribution.names
    redrawn = tuple(dict.fromkeys([(), *subsets, names]))
    replicates = 1 if sampling == "random" else replicates
    u = unit_numbers(n, 2 * len(names), sampling, replicates, seed)
    base = distribution.sample(u[:, : len(names)])
    points = np.empty((len(redrawn) * n, len(names)))
    for block, role in zip(points.reshape(len(redrawn), n, -1), redrawn, strict=True):
        block[:] = distribution.conditional(base, role, u[:, len(names) :]) if role else base
    points.flags.writeable = False
    return Design(distribution, tuple(factors), redrawn, points, sampling, replicates, seed)


def _at_least_two(distribution: Distribution) -> tuple[str, ...]:
    names = distribution.names
    if len(names) < 2:
        raise ValueError(f"Indices share the variance out among at least two inputs, got {names}: add an input.")
    return names


def unit_numbers(n: int, columns: int, sampling: str, replicates: int, seed: int) -> NDArray[np.float64]:
    """Numbers in [0, 1), shape (n, columns), one replicate after the other."""
    if n < MIN_ROWS:
        raise ValueError(f"The base sample has {n} rows: give at least {MIN_ROWS}.")
    rng = np.random.default_rng(seed)
    if sampling == "random":
        return rng.random((n, columns))
    if sampling not in ("sobol", "latin"):
        raise ValueError(f"Sampling is {sampling!r}: choose 'sobol', 'latin' or 'random'.")
    rows = n // replicates if replicates > 1 else 0
    if rows < 2 or rows * replicates != n or (sampling == "sobol" and rows & (rows - 1)):
        raise ValueError(
            f"{n} rows in {replicates} replicates do not make {SEQUENCES[sampling]}: give at least 2 replicates, and "
            f"for n their number times a {'power of two' if sampling == 'sobol' else 'whole number above 1'}."
        )
    make = qmc.Sobol if sampling == "sobol" else qmc.LatinHypercube
    sequences = [make(columns, scramble=True, rng=child) for child in rng.spawn(replicates)]
    return np.concatenate([sequence.random(rows) for sequence in sequences]).clip(0.0, 1.0 - 2.0**-53)
