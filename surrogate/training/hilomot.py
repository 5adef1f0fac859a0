"""HILOMOT, the hierarchical local model tree: cells are split along any direction by sigmoids.

A split divides the validity of a model between two, psi to the second and 1 - psi to the first, with

    psi = sigmoid(kappa (v'z - c)),      kappa = 20 / (smoothness |c_1 - c_2|),

for a unit direction v and the validity-weighted centres c_1, c_2 of the two. The direction and offset are those of the
least training error, both models being estimated anew for each: nested least squares with an analytic gradient
(Hartmann's thesis; Nelles, Nonlinear System Identification).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from surrogate.models.partitions import ObliquePartition, SplitTree
from surrogate.scaling import Array
from surrogate.training.local_training import Grown, ScaledSamples, replaced
from surrogate.training.lolimot import with_split

STEEPNESS = 20.0
"""Kappa times the distance of the centres, at smoothness 1."""

OWN_SHARE = 0.8
"""Least validity that a centre should have in its own half of the split."""

SHARPENING = 4.0
"""Ratio of successive steepnesses on the way to a split sharper than that of smoothness 1."""

RAISES = 3
"""How often kappa is doubled for it."""

NEGLIGIBLE = 1e-8
"""Samples of less validity do not matter to a split."""


@dataclass(frozen=True)
class _Hierarchy(Grown):
    tree: SplitTree
    steepness: Array

    @property
    def partition(self) -> ObliquePartition:
        return ObliquePartition(self.tree, self.steepness)


@dataclass(frozen=True)
class NestedSplit:
    """The training error as a function of one split, with all samples that it moves.

    Args of the samples (n, ...): `parent` is the validity (n,) that is divided, `rest` (n, m) the targets less the
    outputs of all other models.
    """

    samples: ScaledSamples
    parent: Array
    rest: Array

    def shares(self, direction: Array, offset: float, kappa: float) -> Array:
        """Validities (n, 2) of the two halves."""
        half = np.tanh(0.5 * kappa * (self.samples.z @ direction - offset))
        return self.parent[:, None] * np.column_stack([0.5 * (1.0 - half), 0.5 * (1.0 + half)])

    def loss(self, q: Array) -> float:
        """Sum of squared errors with the halves' validities q (n, 2), both models estimated anew."""
        outputs = self.samples.outputs(self.samples.fit(q))
        return self.samples.squared(self.rest - (q[:, :, None] * outputs).sum(1))

    def loss_and_gradient(self, theta: Array, kappa: float) -> tuple[float, Array]:
        """Loss at theta = (v, c), where v need not have length 1, and its gradient (d + 1,).

        The coefficients w_i of a half follow from its validities q_i, d w_i = (A'Q_i A)^-1 A' dQ_i (y - A w_i). With
        e the errors and l_i = (A'Q_i A)^-1 A'Q_i e, that adds (A l_i)(y - A w_i) to the slope e (A w_i) of q_i alone;
        every sample by its weight.
        """
        data, v, c = self.samples, theta[:-1], theta[-1]
        length = float(np.linalg.norm(v))
        t = (data.z @ v - c) / length
        q = self.shares(v / length, c / length, kappa)
        G = data.normal_matrices(q)
        p = data.outputs(data.solve(G, data.moments(q, data.y)))
        e = self.rest - (q[:, :, None] * p).sum(1)
        adjoint = data.outputs(data.solve(G, data.moments(q, e)))
        slopes = -2.0 * data.v[:, None] * (e[:, None] * p + adjoint * (data.y[:, None] - p)).sum(2)
        by_t = kappa * q[:, 0] * q[:, 1] / np.maximum(self.parent, NEGLIGIBLE) * (slopes[:, 1] - slopes[:, 0])
        by_v = (by_t @ data.z - (by_t @ t) * v / length) / length
        return data.squared(e), np.append(by_v, -by_t.sum() / length)

    def centres(self, q: Array) -> Array:
        """Centres (2, d) of the halves, weighted by their validities q (n, 2)."""
        q = q * self.samples.v[:, None]
        return (q.T @ self.samples.z) / np.maximum(q.sum(0), np.finfo(float).tiny)[:, None]


@dataclass(frozen=True)
class _Cut:
    direction: Array
    offset: float
    steepness: float
    loss: float


@dataclass(frozen=True)
class Hilomot:
    """Axis-oblique splitting; `iterations` bound the search for a direction."""

    n_inputs: int
    smoothness: float = 1.0
    iterations: int = 30

    @property
    def split_parameters(self) -> int:
        """A direction of length 1 and an offset: as many as there are inputs."""
        return self.n_inputs

    def start(self, samples: ScaledSamples) -> Grown:
        """One model."""
        phi, d = np.ones((len(samples.z), 1)), samples.z.shape[1]
        tree = SplitTree(np.empty((0, d)), np.empty(0), np.empty((0, 2), dtype=np.int64))
        coefficients = samples.fit(phi)
        return _Hierarchy(phi, coefficients, samples.outputs(coefficients), tree, np.empty(0))

    def split(self, grown: Grown, model: int, samples: ScaledSamples) -> Grown | None:
        """From the best start, the direction and offset of the least error."""
        assert isinstance(grown, _Hierarchy)
        own = grown.phi[:, model, None] * grown.outputs[:, model]
        rows = grown.phi[:, model] > NEGLIGIBLE
        problem = NestedSplit(samples.subset(rows), grown.phi[rows, model], (grown.errors(samples) + own)[rows])
        cut = self._best_cut(problem, grown.tree, model)
        if cut is None:
            return None
        direction, offset, steepness = cut.direction, cut.offset, cut.steepness
        q = NestedSplit(samples, grown.phi[:, model], samples.y).shares(direction, offset, steepness)
        coefficients = samples.fit(q)
        return _Hierarchy(
            replaced(grown.phi, model, q, 1),
            replaced(grown.coefficients, model, coefficients, 0),
            replaced(grown.outputs, model, samples.outputs(coefficients), 1),
            with_split(grown.tree, model, direction, offset),
            np.append(grown.steepness, steepness),
        )

    def _sharpening(self) -> list[float]:
        """Factors of kappa, up to 1: few samples feel a sharp split, so that it is found by way of smoother ones."""
        factors = [1.0]
        while self.smoothness * SHARPENING <= factors[0]:
            factors.insert(0, factors[0] / SHARPENING)
        return factors

    def _best_cut(self, problem: NestedSplit, tree: SplitTree, model: int) -> _Cut | None:
        """The cut of the least loss: from the best start, the last of the search that leaves enough to both halves."""
        from scipy.optimize import minimize  # slow to import, and not needed to evaluate

        start = self._start(problem, tree, model)
        if start is None:
            return None
        theta, path = np.append(start.direction, start.offset), []
        for sharper in self._sharpening():
            theta = minimize(
                problem.loss_and_gradient,
                theta,
                (start.steepness * sharper,),
                "BFGS",
                jac=True,
                options={"maxiter": self.iterations},
                callback=lambda theta: path.append(theta.copy()),
            ).x
        cuts = (self._cut(problem, theta[:-1], float(theta[-1])) for theta in reversed(path))
        found = next((cut for cut in cuts if cut is not None), start)
        return min(start, found, key=lambda cut: cut.loss)

    def _start(self, problem: NestedSplit, tree: SplitTree, model: int) -> _Cut | None:
        """The best cut through the centre of the model along an axis or its parent's direction."""
        own = problem.parent * problem.samples.v
        centre = own @ problem.samples.z / own.sum()
        directions = [*np.eye(len(centre)), *tree.directions[(tree.children == -1 - model).any(axis=1)]]
        cuts = (self._cut(problem, direction, float(direction @ centre)) for direction in directions)
        return min((cut for cut in cuts if cut is not None), key=lambda cut: cut.loss, default=None)

    def _cut(self, problem: NestedSplit, direction: Array, offset: float) -> _Cut | None:
        """A cut, the direction of any length; None where a half has less of the data than it has parameters."""
        length = float(np.linalg.norm(direction))
        direction, offset = direction / length, offset / length
        steepness = self._steepness(problem, direction, offset)
        if steepness is None:
            return None
        q = problem.shares(direction, offset, steepness)
        if (problem.samples.share(q) < problem.samples.terms_count).any():
            return None
        return _Cut(direction, offset, steepness, problem.loss(q))

    def _steepness(self, problem: NestedSplit, direction: Array, offset: float) -> float | None:
        """Steepness of a split; None where one side is empty."""
        below = problem.samples.z @ direction < offset
        halves = problem.parent[:, None] * np.column_stack([below, ~below])
        if (halves.sum(0) <= 0).any():
            return None
        centres = problem.centres(halves)
        distance = float(np.linalg.norm(centres[1] - centres[0]))
        if distance == 0.0:
            return None
        kappa = STEEPNESS / (self.smoothness * distance)
        for _ in range(RAISES):
            t = centres @ direction - offset
            if (1.0 / (1.0 + np.exp(kappa * t * [1.0, -1.0])) >= OWN_SHARE).all():
                break
            kappa *= 2.0
        return kappa
