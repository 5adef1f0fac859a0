"""What every fitted model shares: named variables, and evaluation of checked inputs in blocks."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from surrogate.scaling import Array

BLOCK = 4096
"""Samples that are evaluated at once, so that they stay in the processor's cache."""


class Variable(NamedTuple):
    """Name and unit of an input or output."""

    name: str
    unit: str


IN_DOMAIN = "in_domain"
"""What a result is called that says whether all inputs lie in the ranges of the training data."""


def std_name(output: str) -> str:
    """What the standard deviation of an output is called."""
    return f"{output}_std"


def safe_name(output: str) -> str:
    """What the safe value of an output is called."""
    return f"{output}_safe"


def check_names(*groups: Iterable[Variable]) -> None:
    """ValueError unless names and units are text that a file can hold: no halves of characters (surrogates)."""
    for word in (word for group in groups for variable in group for word in variable):
        if not isinstance(word, str) or any("\ud800" <= c <= "\udfff" for c in word):
            raise ValueError(f"{word!r} is the name or unit of a variable, but is no text: give another one.")


def check_result_names(inputs: Sequence[Variable], outputs: Sequence[Variable], safe: Iterable[str] = ()) -> None:
    """ValueError where two results of a model would have one name: its outputs, their deviations, `IN_DOMAIN`.

    So would the safe values of some outputs, given by name.
    """
    names = {variable.name for group in (inputs, outputs) for variable in group}
    kept = {IN_DOMAIN: "whether a case lies in the training data"}
    kept |= {std_name(v.name): f"the standard deviation of '{v.name}'" for v in outputs}
    kept |= {safe_name(output): f"the safe value of '{output}'" for output in safe}
    for name, meaning in kept.items():
        if name in names:
            raise ValueError(f"'{name}' is what a model calls {meaning}: rename that column.")


def evaluate_by_blocks(
    evaluate: Callable[[Array], Array], X: ArrayLike, inputs: Sequence[Variable], block: int = BLOCK
) -> Array:
    """A function of inputs (n, d) at X (..., d), `block` samples at a time.

    Raises:
        ValueError: X is not finite, lacks an input, or lies so far out that the results are no numbers.
    """
    X = np.asarray(X, dtype=float)
    if X.ndim == 0 or X.shape[-1] != len(inputs):
        names = ", ".join(variable.name for variable in inputs)
        raise ValueError(f"the inputs have the shape {X.shape}, but the last axis must hold {names}.")
    if not np.isfinite(X).all():
        raise ValueError("the inputs hold values that are not finite: leave those samples out.")
    samples = X.reshape(-1, len(inputs))
    starts = range(0, max(len(samples), 1), block)
    with np.errstate(over="ignore", invalid="ignore"):
        blocks = [evaluate(samples[start : start + block]) for start in starts]
    if not all(np.isfinite(block).all() for block in blocks):
        raise ValueError("the inputs lie so far from the training data that the outputs are no numbers: go nearer.")
    values = blocks[0] if len(blocks) == 1 else np.concatenate(blocks)
    return values.reshape(*X.shape[:-1], *blocks[0].shape[1:])


def in_range(X: ArrayLike, ranges: Array) -> np.ndarray[Any, np.dtype[np.bool_]]:
    """Whether each of the inputs X (..., d) lies inside the ranges (d, 2), ends included (...,)."""
    least, greatest = ranges.T
    return ((least <= np.asarray(X)) & (np.asarray(X) <= greatest)).all(axis=-1)


def frozen_ranges(value: ArrayLike, n: int, name: str) -> Array:
    """An unchangeable copy of least and greatest values (n, 2); ValueError unless each range is wider than 0."""
    ranges = frozen_array(value, (n, 2), name)
    if not (ranges[:, 0] < ranges[:, 1]).all():
        raise ValueError(f"{name} must hold the least value of each variable, then a greater one.")
    return ranges


def frozen_array(value: ArrayLike, shape: tuple[int, ...], name: str) -> Array:
    """An unchangeable copy; ValueError unless its numbers are finite and it has the shape."""
    copy = np.array(value, dtype=float)
    if copy.shape != shape or not np.isfinite(copy).all():
        raise ValueError(f"{name} must hold finite numbers in the shape {shape}.")
    copy.setflags(write=False)
    return copy
