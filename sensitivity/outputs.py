"""Outputs of a model at the points of a design: evaluated in chunks, and checked before anything is read from them."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from .distributions import Array

ROUNDING = 8 * np.finfo(float).eps
"""Outputs that differ by less than this part of their size are one output with rounding errors."""


def evaluate_in_chunks(model: Callable[[Array], ArrayLike], points: Array, chunk_size: int = 65536) -> Array:
    """Outputs (n,) or (n, outputs) of a model that maps points (rows, inputs) to them.

    Raises:
        ValueError: a chunk size below 1, or a model that returns another number of rows.
    """
    if chunk_size < 1:
        raise ValueError(f"Chunk size is {chunk_size}: give at least 1 row a chunk.")
    outputs = None
    for start in range(0, len(points), chunk_size):
        chunk = points[start : start + chunk_size]
        output = np.asarray(model(chunk), dtype=float)
        if outputs is None:
            outputs = np.empty((len(points), *output.shape[1:]))
        if output.ndim not in (1, 2) or len(output) != len(chunk) or output.shape[1:] != outputs.shape[1:]:
            raise ValueError(
                f"The model returned shape {output.shape} for {len(chunk)} points: return a row of outputs a point."
            )
        outputs[start : start + chunk_size] = output
    return np.empty(0) if outputs is None else outputs


def checked_outputs(
    outputs: ArrayLike, points: Array, output_names: Sequence[str] | None = None
) -> tuple[tuple[str, ...], Array]:
    """Names, and outputs (n, outputs) that vary and are finite.

    Raises:
        ValueError: another shape, names that do not fit, or an output that is not finite (the first such point is
            named), constant but for rounding, or too small or too large for its squares.
    """
    outputs = np.asarray(outputs, dtype=float)
    if outputs.ndim == 1:
        outputs = outputs[:, np.newaxis]
    if outputs.ndim != 2 or len(outputs) != len(points):
        raise ValueError(
            f"Outputs have shape {outputs.shape} for {len(points)} points: give one row of outputs a point."
        )
    names = tuple(output_names) if output_names else tuple(f"y{j}" for j in range(outputs.shape[1]))
    if len(names) != outputs.shape[1] or len(set(names)) != len(names):
        raise ValueError(f"Output names are {names} for {outputs.shape[1]} outputs: give each a name of its own.")
    least, greatest = (np.array([getattr(column, end)() for column in outputs.T]) for end in ("min", "max"))
    if not (np.isfinite(least).all() and np.isfinite(greatest).all()):  # NaN goes through both
        bad = np.flatnonzero(~np.isfinite(outputs).all(axis=1))
        raise ValueError(
            f"The outputs at {bad.size} of {len(points)} points are not finite, first at row {bad[0]}, inputs "
            f"{points[bad[0]].tolist()}: restrict the distribution to where the model has values (`conditioned`)."
        )
    with np.errstate(over="ignore"):
        range_ = greatest - least
    size = np.maximum(np.abs(least), np.abs(greatest))
    for name, varies in zip(names, range_ > ROUNDING * size, strict=True):
        if not varies:
            raise ValueError(f"The output {name} does not vary but for rounding, so has no indices: leave it out.")
    with np.errstate(over="ignore"):
        squares = range_**2
        sums = len(outputs) * squares
    for name, squared, summed in zip(names, squares, sums, strict=True):
        if squared < np.finfo(float).tiny / np.finfo(float).eps:
            raise ValueError(f"The output {name} is too small for its squares: give it in a smaller unit.")
        if not np.isfinite(summed):
            raise ValueError(f"The output {name} is too large for its squares: give it in a larger unit.")
    return names, outputs
