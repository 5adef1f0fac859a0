"""Designs for variance-based indices: points, the role of each block of rows, and the outputs that belong to them."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.stats import qmc

from .distributions import Array, Distribution

Factor = tuple[str, ...]
"""Names of the inputs whose joint influence is one index; a single input is a factor of one name."""

Sampling = Literal["sobol", "random"]

MIN_ROWS = 16


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
        """Evaluate a model that maps points (rows, inputs) to outputs (rows,) or (rows, outputs), in chunks of rows."""
        if chunk_size < 1:
            raise ValueError(f"Chunk size is {chunk_size}: give at least 1 row a chunk.")
        chunks = [self.points[start : start + chunk_size] for start in range(0, self.n_evaluations, chunk_size)]
        outputs = []
        for chunk in chunks:
            output = np.asarray(model(chunk), dtype=float)
            if output.ndim not in (1, 2) or len(output) != len(chunk):
                raise ValueError(
                    f"The model returned shape {output.shape} for {len(chunk)} points: return a row of outputs a point."
                )
            outputs.append(output)
        return self.attach(self.points, np.concatenate(outputs), output_names)

    def attach(
        self, points: ArrayLike, outputs: ArrayLike, output_names: Sequence[str] | None = None
    ) -> "EvaluatedDesign":
        """Join outputs computed elsewhere, (rows,) or (rows, outputs), with the design.

        `points` are those at which they were computed, row by row as the outputs; they must be the design's own, in its
        own order, so that a shuffled, filtered or foreign result is refused.
        """
        points, outputs = np.asarray(points, dtype=float), np.asarray(outputs, dtype=float)
        if points.shape != self.points.shape:
            raise ValueError(
                f"Outputs were computed at points of shape {points.shape}, the design has {self.points.shape}: "
                "evaluate every point of this design."
            )
        misplaced = np.flatnonzero((points != self.points).any(axis=1))
        if misplaced.size:
            raise ValueError(
                f"Outputs do not belong to this design: {misplaced.size} points differ, first at row {misplaced[0]}; "
                "keep the order of design.points."
            )
        if outputs.ndim == 1:
            outputs = outputs[:, np.newaxis]
        if outputs.ndim != 2 or len(outputs) != self.n_evaluations:
            raise ValueError(
                f"Outputs have shape {outputs.shape} for {self.n_evaluations} points: give one row of outputs a point."
            )
        bad = np.count_nonzero(~np.isfinite(outputs).all(axis=1))
        if bad:
            raise ValueError(
                f"The outputs at {bad} of {self.n_evaluations} points are not finite: "
                "restrict the distribution to where the model has values."
            )
        names = tuple(output_names) if output_names else tuple(f"y{j}" for j in range(outputs.shape[1]))
        if len(set(names)) != outputs.shape[1]:
            raise ValueError(f"Output names are {names} for {outputs.shape[1]} outputs: give each a name of its own.")
        constant = [name for name, column in zip(names, outputs.T, strict=True) if np.ptp(column) == 0.0]
        if constant:
            raise ValueError(f"Outputs {constant} do not vary over the design, so have no indices: leave them out.")
        return EvaluatedDesign(self, names, outputs)


@dataclass(frozen=True, eq=False)
class EvaluatedDesign:
    """A design with the outputs (n_evaluations, outputs) at its points; made by `Design.evaluate` or `.attach`."""

    design: Design
    output_names: tuple[str, ...]
    outputs: Array


def variance_design(
    distribution: Distribution,
    n: int,
    *,
    groups: Sequence[Collection[str]] = (),
    sampling: Sampling = "sobol",
    replicates: int = 8,
    seed: int = 0,
) -> Design:
    """Design for first-order and total indices of every input and every group, with dependent inputs.

    n is the number N of base rows. Every block of dependent inputs is a group without being asked for. M factors cost
    at most N (2 M + 2) evaluations: the base sample, for each factor one block with it redrawn (total index) and one
    with everything else redrawn (first-order index), and one block with all inputs redrawn, which removes most of the
    error of small first-order indices. A block that serves two factors is evaluated once.

    sampling "sobol": `replicates` independently scrambled Sobol sequences of n / replicates points, a power of two.
    sampling "random": n independent rows; `replicates` is not used.
    """
    names = distribution.names
    if len(names) < 2:
        raise ValueError(f"Indices share the variance out among at least two inputs, got {names}: add an input.")
    for group in groups:
        distribution.check_names(group)
        if not 1 <= len(set(group)) < len(names):
            raise ValueError(f"Group {tuple(group)} must hold some, but not all, inputs of {', '.join(names)}.")
    in_order = [tuple(name for name in names if name in group) for group in (*distribution.dependent, *groups)]
    singles = [(name,) for name in names]
    factors = tuple(dict.fromkeys(factor for factor in (*singles, *in_order) if len(factor) < len(names)))
    rest = [distribution.complement(factor) for factor in factors]
    redrawn = ((), *dict.fromkeys([*factors, *rest]), names)

    if sampling == "random":
        replicates = 1
    u = _unit_numbers(n, 2 * len(names), sampling, replicates, seed)
    base = distribution.sample(u[:, : len(names)])
    points = np.concatenate([distribution.conditional(base, role, u[:, len(names) :]) for role in redrawn])
    points.flags.writeable = False
    return Design(distribution, factors, redrawn, points, sampling, replicates, seed)


def _unit_numbers(n: int, columns: int, sampling: str, replicates: int, seed: int) -> NDArray[np.float64]:
    """Numbers in [0, 1), shape (n, columns), one replicate after the other."""
    if n < MIN_ROWS:
        raise ValueError(f"The base sample has {n} rows: give at least {MIN_ROWS}.")
    rng = np.random.default_rng(seed)
    if sampling == "random":
        return rng.random((n, columns))
    if sampling != "sobol":
        raise ValueError(f"Sampling is {sampling!r}: choose 'sobol' or 'random'.")
    rows = n // replicates if replicates > 1 else 0
    if rows < 2 or rows & (rows - 1) or rows * replicates != n:
        raise ValueError(
            f"{n} rows in {replicates} replicates do not make Sobol sequences: "
            "give at least 2 replicates, and for n their number times a power of two."
        )
    sequences = [qmc.Sobol(columns, scramble=True, rng=child) for child in rng.spawn(replicates)]
    return np.concatenate([sequence.random(rows) for sequence in sequences])
