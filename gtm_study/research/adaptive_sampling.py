"""Where to solve next: jams, and thrusts, chosen by what the model itself does not know yet.

A jam is worth solving where a Gaussian process is unsure, and where its prediction differs most from the nearest known
value, as at a fold (expected improvement for a global fit, Lam and Notz 2008). A thrust map is refined along the axis
on which a few probes, solved between its nodes, differ most from what it interpolates.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree
from sklearn.gaussian_process.kernels import Matern
from sklearn.preprocessing import MinMaxScaler

from gtm_fmu.datasets.off_lattice import OffLattice
from gtm_fmu.envelopes.feasibility import FULL_THROTTLE_PCT
from gtm_fmu.envelopes.thrust_map import ThrustMap
from gtm_study.research.envelope_models import GaussianProcess

FIRST_JAMS, JAM_BATCH = 64, 64
PROBES = 8
FIRST_STRIDES = (2, 2, 16, 12)
"""Of density, flight path, deflection and speed through a map of 2, 3, 97 and 97 nodes."""
_THROTTLE_BAND_PCT = 10.0  # about full throttle, where t_min decides feasibility


def chosen_jams(pool: OffLattice, most: int, seed: int = 0) -> np.ndarray:
    """Numbers (most) of the pool's jams in the order in which they should be solved; the first ones are by chance."""
    rng = np.random.default_rng(seed)
    X = MinMaxScaler((-1.0, 1.0)).fit_transform(pool.X[:, :3])
    targets = np.column_stack([pool.speeds_kt, pool.t_min_pct])
    chosen = list(rng.permutation(len(X))[:FIRST_JAMS])
    kernels: list = [None] * targets.shape[1]
    choose_kernels_at = FIRST_JAMS
    while len(chosen) < most:
        choose = len(chosen) >= choose_kernels_at
        if choose:
            choose_kernels_at *= 2
        score = np.zeros(len(X))
        for k, values in enumerate(targets.T):
            known = np.array([i for i in chosen if np.isfinite(values[i])])
            process = GaussianProcess(None if choose else kernels[k]).fit(X[known], values[known])
            kernels[k] = process.kernel_
            mean, std = process.predict(X, return_std=True)
            nearest = values[known][cKDTree(X[known]).query(X)[1]]
            gain = (std**2 + (mean - nearest) ** 2) / np.ptp(values[known]) ** 2
            if k == 2:  # t_min matters near full throttle; speeds only where there is an envelope
                score *= mean < FULL_THROTTLE_PCT + _THROTTLE_BAND_PCT
                gain *= np.exp(-(((mean - FULL_THROTTLE_PCT) / _THROTTLE_BAND_PCT) ** 2))
            score += gain
        score[chosen] = 0.0
        apart = Matern(2.0 * len(chosen) ** (-1 / X.shape[1]), nu=2.5)  # a typical distance of those known
        for _ in range(min(JAM_BATCH, most - len(chosen))):
            best = int(np.argmax(score))
            chosen.append(best)
            near = apart(X, X[best : best + 1])[:, 0]
            score *= 1.0 - near**2
            score[best] = 0.0
    return np.array(chosen[:most])


def part_of(exact: ThrustMap, nodes: Sequence[np.ndarray]) -> ThrustMap:
    """The map of some of the nodes of a finer one: numbers of densities, flight paths, deflections and speeds."""
    density, gamma, deflection, speed = nodes
    columns = np.concatenate([[0, 1], 2 + speed])
    return replace(
        exact,
        density_ratio=exact.density_ratio[density],
        gamma_deg=exact.gamma_deg[gamma],
        deflection_deg=exact.deflection_deg[deflection],
        table=exact.table[np.ix_(density, gamma, deflection, columns)],
        provenance={},
    )


def refinements(exact: ThrustMap, seed: int = 0) -> Iterator[tuple[int, ThrustMap]]:
    """Ever finer parts of a map with the number of their solutions, probes included, which are all that is looked at.

    The first has one altitude, two flight paths, 7 deflections and 9 speeds.
    """
    rng = np.random.default_rng(seed)
    sizes = (*exact.table.shape[:3], exact.table.shape[3] - 2)
    strides, probes = list(FIRST_STRIDES), 0
    while True:
        nodes = [np.arange(0, size, stride) for size, stride in zip(sizes, strides, strict=True)]
        yield math.prod(map(len, nodes)) + probes, part_of(exact, nodes)
        open_axes = [axis for axis, stride in enumerate(strides) if stride > 1]
        if not open_axes:
            return
        differences = [_difference(exact, nodes, axis, _finer(strides[axis]), rng) for axis in open_axes]
        probes += PROBES * len(open_axes)
        axis = open_axes[int(np.argmax(differences))]
        strides[axis] = _finer(strides[axis])


def _finer(stride: int) -> int:
    return 1 if stride % 2 else stride // 2


def _difference(
    exact: ThrustMap, nodes: Sequence[np.ndarray], axis: int, stride: int, rng: np.random.Generator
) -> float:
    """Root mean square in lbf of what some new nodes of an axis differ by from the line through the old ones."""
    thrusts = np.moveaxis(exact.table[..., 2:], axis, 0)
    others = [old for k, old in enumerate(nodes) if k != axis]
    old, new = nodes[axis], np.setdiff1d(np.arange(0, len(thrusts), stride), nodes[axis])
    errors = []
    for here in rng.choice(new, PROBES):
        curve = thrusts[(slice(None), *(rng.choice(axis_nodes) for axis_nodes in others))]
        errors.append(curve[here] - np.interp(here, old, curve[old]))
    return float(np.sqrt(np.mean(np.square(errors))))
