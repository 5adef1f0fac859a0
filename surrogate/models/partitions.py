"""How a local model network divides its inputs: validity functions that add up to one everywhere.

All of them see the inputs z (n, d) mapped from their ranges to [0, 1].
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from surrogate.models.evaluation import frozen_array
from surrogate.scaling import Array

Children = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class SplitTree:
    """The M - 1 splits that divide the inputs among M local models; split 0 is the root, and parents come first.

    Split k sends z to its first child where directions[k] z < offsets[k], to its second elsewhere. A child c >= 0 is
    the split c, a child c < 0 the local model -1 - c.
    """

    directions: Array
    """Unit normals of the splits (M - 1, d)."""
    offsets: Array
    """(M - 1,)."""
    children: Children
    """(M - 1, 2)."""

    def __post_init__(self) -> None:
        """Check that every split but the root, and every model, is the child of exactly one earlier split."""
        offsets, n = np.array(self.offsets, dtype=float), len(self.offsets)
        d = np.shape(self.directions)[1] if n else 0
        children = np.array(self.children, dtype=np.int64).reshape(n, 2)
        if n and sorted(children.ravel().tolist()) != [*range(-1 - n, 0), *range(1, n)]:
            raise ValueError("the children of the split tree must be each other split and each local model once.")
        if any(0 <= child <= k for k, pair in enumerate(children.tolist()) for child in pair):
            raise ValueError("a split of the split tree comes before the split that it divides.")
        children.setflags(write=False)
        object.__setattr__(self, "directions", frozen_array(np.reshape(self.directions, (n, d)), (n, d), "directions"))
        object.__setattr__(self, "offsets", frozen_array(offsets, (n,), "offsets"))
        object.__setattr__(self, "children", children)

    @property
    def models(self) -> int:
        """Number M of local models."""
        return len(self.offsets) + 1


def gaussian_exponents(z: Array, centres: Array, sigmas: Array) -> Array:
    """ln mu (n, M) of Gaussians (paper eq. 20)."""
    return -0.5 * (((z[:, None] - centres) / sigmas) ** 2).sum(2)


def normalised(exponents: Array) -> Array:
    """phi = mu / sum mu (n, M) of ln mu (paper eq. 19)."""
    # Far from all centres every mu would be 0; a common factor leaves phi as it is.
    mu = np.exp(exponents - exponents.max(axis=1, keepdims=True))
    return mu / mu.sum(axis=1, keepdims=True)


@dataclass(frozen=True, eq=False)
class AxisPartition:
    """Normalised axis-orthogonal Gaussians, as LOLIMOT makes them (paper eqs. 19, 20).

    phi_i = mu_i / sum_j mu_j with mu_i = exp(-1/2 sum_k ((z_k - c_ik) / sigma_ik)^2).
    """

    KIND: ClassVar[str] = "axis"
    tree: SplitTree
    """How the cells came about; the Gaussians follow from it."""
    centres: Array
    """Centres c of the cells (M, d)."""
    sigmas: Array
    """Standard deviations (M, d), in proportion to the widths of the cells."""

    def __post_init__(self) -> None:
        """Check the shapes."""
        shape = (self.tree.models, np.shape(self.centres)[-1])
        object.__setattr__(self, "centres", frozen_array(self.centres, shape, "centres of the partition"))
        object.__setattr__(self, "sigmas", frozen_array(self.sigmas, shape, "sigmas of the partition"))
        if (self.sigmas <= 0).any():
            raise ValueError("sigmas of the partition must be positive.")

    def validity(self, z: Array) -> Array:
        """Validity phi (n, M) of every model."""
        return normalised(gaussian_exponents(z, self.centres, self.sigmas))

    def validity_gradient(self, z: Array) -> Array:
        """Slopes d phi / d z (n, M, d)."""
        phi = self.validity(z)
        slope = (self.centres - z[:, None]) / self.sigmas**2
        return phi[..., None] * (slope - (phi[..., None] * slope).sum(1, keepdims=True))


@dataclass(frozen=True, eq=False)
class ObliquePartition:
    """A hierarchy of sigmoid splits, as HILOMOT makes them.

    Split k gives the share psi_k = 1 / (1 + exp(-steepness_k (directions_k z - offsets_k))) of what reaches it to its
    second child and the rest to its first.
    """

    KIND: ClassVar[str] = "oblique"
    tree: SplitTree
    steepness: Array
    """(M - 1,)."""

    def __post_init__(self) -> None:
        """Check the shape."""
        shape = (self.tree.models - 1,)
        object.__setattr__(self, "steepness", frozen_array(self.steepness, shape, "steepness of the partition"))

    def shares(self, z: Array) -> Array:
        """Shares 1 - psi and psi of the two children of every split (n, M - 1, 2)."""
        if not len(self.steepness):
            return np.empty((len(z), 0, 2))
        # tanh, which cannot overflow: sigmoid(t) = (1 + tanh(t / 2)) / 2
        half = np.tanh(0.5 * self.steepness * (z @ self.tree.directions.T - self.tree.offsets))
        return np.stack([0.5 * (1.0 - half), 0.5 * (1.0 + half)], axis=2)

    def validity(self, z: Array) -> Array:
        """Validity phi (n, M) of every model: the product of the shares on its way from the root."""
        shares = self.shares(z)
        phi = np.ones((len(z), self.tree.models))
        reaching = np.ones((len(z), max(len(self.steepness), 1)))
        for k, pair in enumerate(self.tree.children.tolist()):
            for side, child in enumerate(pair):
                share = reaching[:, k] * shares[:, k, side]
                if child < 0:
                    phi[:, -1 - child] = share
                else:
                    reaching[:, child] = share
        return phi

    def validity_gradient(self, z: Array) -> Array:
        """Slopes d phi / d z (n, M, d)."""
        n, d = z.shape
        shares = self.shares(z)
        psi_slope = (self.steepness * shares[:, :, 0] * shares[:, :, 1])[..., None] * self.tree.directions
        phi_slope = np.zeros((n, self.tree.models, d))
        splits = max(len(self.steepness), 1)
        reaching, reaching_slope = np.ones((n, splits)), np.zeros((n, splits, d))
        for k, pair in enumerate(self.tree.children.tolist()):
            for side, child in enumerate(pair):
                slope = reaching_slope[:, k] * shares[:, k, side, None]
                slope += (2 * side - 1) * reaching[:, k, None] * psi_slope[:, k]
                if child < 0:
                    phi_slope[:, -1 - child] = slope
                else:
                    reaching[:, child], reaching_slope[:, child] = reaching[:, k] * shares[:, k, side], slope
        return phi_slope


Partition = AxisPartition | ObliquePartition


def partition_from_plain(content: dict[str, Any]) -> Partition:
    """The partition of these fields, as JSON has them; ``kind`` is one of the classes' `KIND`."""
    kind = {kind.KIND: kind for kind in (AxisPartition, ObliquePartition)}[content["kind"]]
    own = {name: value for name, value in content.items() if name != "kind"}
    return kind(**own | {"tree": SplitTree(**content["tree"])})
