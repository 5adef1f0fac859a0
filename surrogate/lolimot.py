"""LOLIMOT, the local linear model tree: cells are halved along an axis, and Gaussians blend them (paper eqs. 19, 20).

The worst model is halved along every axis in turn; only the two new models are estimated anew, and the axis that leaves
the least error is kept (Nelles, Nonlinear System Identification).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from surrogate.local_training import Grown, Samples
from surrogate.partitions import AxisPartition, SplitTree
from surrogate.scaling import Array

SIGMA_DIVISOR = 2.5
"""A Gaussian's standard deviation is smoothness x width of its cell / this."""


@dataclass(frozen=True)
class _Cells(Grown):
    """Cells of z in [0, 1]^d, each between its corners."""

    lower: Array
    upper: Array
    sigma_per_width: float
    tree: SplitTree

    @property
    def partition(self) -> AxisPartition:
        return AxisPartition(self.tree, (self.lower + self.upper) / 2, (self.upper - self.lower) * self.sigma_per_width)


@dataclass(frozen=True)
class Lolimot:
    """Axis-orthogonal halving."""

    smoothness: float = 1.0
    divisor: float = SIGMA_DIVISOR
    split_parameters: int = 0

    def start(self, samples: Samples) -> Grown:
        """One cell."""
        d, phi = samples.z.shape[1], np.ones((len(samples.z), 1))
        tree = SplitTree(np.empty((0, d)), np.empty(0), np.empty((0, 2), dtype=np.int64))
        sigma_per_width = self.smoothness / self.divisor
        return _Cells(phi, samples.fit(phi), np.zeros((1, d)), np.ones((1, d)), sigma_per_width, tree)

    def split(self, grown: Grown, model: int, samples: Samples) -> Grown | None:
        """The best of the halvings of a model."""
        assert isinstance(grown, _Cells)
        best, least = None, np.inf
        for axis in range(samples.z.shape[1]):
            candidate = _halved(grown, model, axis, samples)
            if candidate is not None and (loss := float((candidate.errors(samples) ** 2).sum())) < least:
                best, least = candidate, loss
        return best


def _halved(cells: _Cells, model: int, axis: int, samples: Samples) -> _Cells | None:
    """The model's lower half in its place, the upper half as the last model."""
    middle = (cells.lower[model, axis] + cells.upper[model, axis]) / 2
    lower, upper = np.vstack([cells.lower, cells.lower[model]]), np.vstack([cells.upper, cells.upper[model]])
    upper[model, axis] = lower[-1, axis] = middle
    tree = with_split(cells.tree, model, np.eye(samples.z.shape[1])[axis], middle)
    outline = _Cells(cells.phi, cells.coefficients, lower, upper, cells.sigma_per_width, tree)
    phi = outline.partition.validity(samples.z)
    new = [model, len(phi[0]) - 1]
    if (phi[:, new].sum(0) < samples.terms_count).any():
        return None
    coefficients = np.concatenate([cells.coefficients, cells.coefficients[:1]])
    coefficients[new] = samples.fit(phi[:, new])
    return _Cells(phi, coefficients, lower, upper, cells.sigma_per_width, tree)


def with_split(tree: SplitTree, model: int, direction: Array, offset: float) -> SplitTree:
    """The tree with a model divided: what is below the offset keeps its number, the rest becomes the last model."""
    splits = tree.models - 1
    children = np.where(tree.children == -1 - model, splits, tree.children)
    return SplitTree(
        np.vstack([tree.directions.reshape(splits, len(direction)), direction]),
        np.append(tree.offsets, offset),
        np.vstack([children, [-1 - model, -2 - splits]]),
    )
