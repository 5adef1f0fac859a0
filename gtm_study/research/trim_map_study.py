"""The trim map on exact cases of one, two and three failed controls: errors by the number of trims it is made of."""

import time
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from gtm_fmu.airframe.names import CONTROLS
from gtm_fmu.datasets import off_lattice
from gtm_fmu.datasets.off_lattice import OffLattice
from gtm_fmu.envelopes.trim_map import TrimMap, TrimNodes
from gtm_fmu.progress import Advance


def _nodes(alpha_step: float, banks: int, rudders: int) -> TrimNodes:
    """Evenly spaced nodes, closer below 1 deg of alpha, where the speed changes most."""
    alphas = np.arange(1.0, 10.5, alpha_step).tolist()
    slow = np.arange(-1.0, 1.0, alpha_step / 2).tolist()
    return TrimNodes(
        alphas_deg=(*slow, *alphas, 10.5),
        banks_deg=tuple(np.linspace(-30.0, 30.0, banks).tolist()),
        rudders_deg=tuple(np.linspace(-30.0, 30.0, rudders).tolist()),
    )


SIZES: Mapping[str, TrimNodes] = {
    "coarse": _nodes(2.0, 3, 7),
    "medium": _nodes(1.0, 5, 13),
    "default": TrimNodes(),
    "fine": _nodes(0.25, 7, 49),
}
"""Maps by what they are called in the results."""


def measured(found: TrimMap, controls: Sequence[str], truth: OffLattice) -> dict[str, Any]:
    """Scores of a map on cases of some failed controls, with the processor time of a case in us."""
    ordered = [name for name in CONTROLS if name in controls]
    started = time.process_time()
    envelopes = found.predict(truth.X, ordered)
    seconds = time.process_time() - started
    speeds = np.column_stack([envelopes.v_min_kt, envelopes.v_max_kt])
    scores = off_lattice.scores(truth, speeds, envelopes.feasible)["all"]
    return scores | {"us": 1e6 * seconds / len(truth.X)}


def curve(controls: Sequence[str], truth: OffLattice, advance: Advance) -> list[dict[str, Any]]:
    """Scores of the maps of all `SIZES`."""
    points = []
    for name, nodes in SIZES.items():
        started = time.process_time()
        found = TrimMap.solve(nodes)
        seconds = time.process_time() - started
        scores = measured(found, controls, truth)
        points.append(scores | {"size": name, "trims": nodes.trims, "bytes": found.table.nbytes, "fit_s": seconds})
        advance(len(points), len(SIZES))
    return points
