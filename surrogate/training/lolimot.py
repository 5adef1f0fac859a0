"""LOLIMOT, the local linear model tree: cells are halved along an axis, and Gaussians blend them (paper eqs. 19, 20).

The worst model is halved along every axis in turn; only the two new models are estimated anew, and the axis that leaves
the least error is kept (Nelles, Nonlinear System Identification).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from surrogate.models.partitions import AxisPartition, SplitTree, gaussian_exponents, normalised
from surrogate.scaling import Array
from surrogate.training.local_training import Grown, ScaledSamples, replaced

SIGMA_DIVISOR = 2.5
"""A Gaussian's standard deviation is smoothness x width of its cell / this."""


@dataclass(frozen=True)
class _Cells(Grown):
    """Cells of z in [0, 1]^d, each between its corners."""

    exponents: Array
    """ln mu (n, M)."""
    lower: Array
    upper: Array
    sigma_per_width: float
    tree: SplitTree

    @property
    def partition(self) -> AxisPartition:
        return AxisPartition(self.tree, *_gaussians(self.lower, self.upper, self.sigma_per_width))


@dataclass(frozen=True)
class Lolimot:
    """Axis-orthogonal halving."""

    smoothness: float = 1.0
    divisor: float = SIGMA_DIVISOR
    split_parameters: int = 0

    def start(self, samples: ScaledSamples) -> Grown:
        """One cell."""
        d, phi = samples.z.shape[1], np.ones((len(samples.z), 1))
        tree = SplitTree(np.empty((0, d)), np.empty(0), np.empty((0, 2), dtype=np.int64))
        sigma_per_width, lower, upper = self.smoothness / self.divisor, np.zeros((1, d)), np.ones((1, d))
        exponents = gaussian_exponents(samples.z, *_gaussians(lower, upper, sigma_per_width))
        coefficients = samples.fit(phi)
        outputs = samples.outputs(coefficients)
        return _Cells(phi, coefficients, outputs, exponents, lower, upper, sigma_per_width, tree)

    def split(self, grown: Grown, model: int, samples: ScaledSamples) -> Grown | None:
        """The best of the halvings of a model."""
        assert isinstance(grown, _Cells)
        best, least = None, np.inf
        for axis in range(samples.z.shape[1]):
            candidate = _halved(grown, model, axis, samples)
            if candidate is not None and (loss := samples.squared(candidate.errors(samples))) < least:
                best, least = candidate, loss
        return best


def _halved(cells: _Cells, model: int, axis: int, samples: ScaledSamples) -> _Cells | None:
    """The model's lower half in its place, the upper half as the last model."""
    middle = (cells.lower[model, axis] + cells.upper[model, axis]) / 2
    corners = np.stack([cells.lower[[model, model]], cells.upper[[model, model]]])
    corners[1, 0, axis] = corners[0, 1, axis] = middle
    pair = gaussian_exponents(samples.z, *_gaussians(corners[0], corners[1], cells.sigma_per_width))
    exponents = replaced(cells.exponents, model, pair, 1)
    phi, new = normalised(exponents), [model, len(cells.lower)]
    if (samples.share(phi[:, new]) < samples.terms_count).any():
        return None
    coefficients = samples.fit(phi[:, new])
    return _Cells(
        phi,
        replaced(cells.coefficients, model, coefficients, 0),
        replaced(cells.outputs, model, samples.outputs(coefficients), 1),
        exponents,
        replaced(cells.lower, model, corners[0], 0),
        replaced(cells.upper, model, corners[1], 0),
        cells.sigma_per_width,
        with_split(cells.tree, model, np.eye(samples.z.shape[1])[axis], middle),
    )


def _gaussians(lower: Array, upper: Array, sigma_per_width: float) -> tuple[Array, Array]:
    """Centres and standard deviations of cells between their corners."""
    return (lower + upper) / 2, (upper - lower) * sigma_per_width


def with_split(tree: SplitTree, model: int, direction: Array, offset: float) -> SplitTree:
    """The tree with a model divided: what is below the offset keeps its number, the rest becomes the last model."""
    splits = tree.models - 1
    children = np.where(tree.children == -1 - model, splits, tree.children)
    return SplitTree(
        np.vstack([tree.directions.reshape(splits, len(direction)), direction]),
        np.append(tree.offsets, offset),
        np.vstack([children, [-1 - model, -2 - splits]]),
    )
