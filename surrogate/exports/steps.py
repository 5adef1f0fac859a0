"""The kinds of vector operations that a program is made of; ``x`` and ``y`` are numbers of earlier vectors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from surrogate.scaling import Array

Function = Literal["tanh", "exp", "softplus", "square", "sqrt"]
Indices = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Constant:
    """Numbers that depend on nothing."""

    values: Array


@dataclass(frozen=True, eq=False)
class Scale:
    """(x - shift) factor + offset, element by element."""

    x: int
    shift: Array
    factor: Array
    offset: Array


@dataclass(frozen=True, eq=False)
class Affine:
    """W x + b."""

    x: int
    W: Array
    b: Array


@dataclass(frozen=True, eq=False)
class Apply:
    """A function of each element; softplus(x) is log(1 + e^x)."""

    x: int
    function: Function


@dataclass(frozen=True, eq=False)
class Take:
    """Elements x_i, in the order of `i`."""

    x: int
    i: Indices


@dataclass(frozen=True, eq=False)
class Products:
    """Products x_i y_j of pairs of elements."""

    x: int
    y: int
    i: Indices
    j: Indices


@dataclass(frozen=True, eq=False)
class GroupSum:
    """Sums of `size` elements that follow each other."""

    x: int
    size: int


@dataclass(frozen=True, eq=False)
class Softmax:
    """Shares e^x_i / sum_j e^x_j."""

    x: int


@dataclass(frozen=True, eq=False)
class Join:
    """The elements of several vectors, one after the other."""

    parts: tuple[int, ...]


Step = Constant | Scale | Affine | Apply | Take | Products | GroupSum | Softmax | Join
