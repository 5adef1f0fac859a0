"""How many cases of the paper's lattice have an envelope, beside the counts that the paper prints."""

from pathlib import Path
from typing import Any

import numpy as np

from gtm_fmu.datasets import paper
from gtm_fmu.datasets.lattice import lattice
from gtm_fmu.datasets.store import slices
from gtm_study.paper import published


def members(data_set: int, gamma: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """Which cases (n), by flight path and rudder limits in deg (n), belong to one of the paper's six data sets."""
    fewer = paper.DATA_SETS[data_set]
    inside = np.isin(gamma, fewer.get("gamma_deg", paper.GAMMAS_DEG))
    for limit in (lower, upper):
        inside &= np.isin(limit, fewer.get("rudder_deg", paper.RUDDERS_DEG))
    return inside


def counts(store: str | Path) -> list[dict[str, Any]]:
    """Cases and feasible ones of the paper's six data sets in a store of its lattice, beside the paper's samples."""
    parts = list(slices(store, ["gamma", "rudder_lower", "rudder_upper", "feasible"]))
    gamma, lower, upper, feasible = (
        np.concatenate([part[name].values for part in parts])
        for name in ("gamma", "rudder_lower", "rudder_upper", "feasible")
    )
    return [
        {
            "data_set": number,
            "cases": int(inside.sum()),
            "feasible": int(feasible[inside].sum()),
            "paper": published.TRAINING_SAMPLES[number],
        }
        for number in paper.DATA_SETS
        for inside in [members(number, gamma, lower, upper)]
    ]


def contradiction() -> str:
    """Why no aircraft gives the paper's six counts.

    Data sets 2 and 3 have no level of the rudder in common. A pair with one limit of each is in data set 6, and at
    three flight-path angles in data set 1; taking 2 and 3 from 6, and 4 and 5 from 1, leaves these pairs.
    """
    gamma, lower, upper = lattice().rows(0, len(lattice()))[:, [1, 6, 7]].T
    left_out = {k: int(members(k, gamma, lower, upper).sum()) - published.TRAINING_SAMPLES[k] for k in paper.DATA_SETS}
    everywhere, at_three = left_out[6] - left_out[2] - left_out[3], left_out[1] - left_out[4] - left_out[5]
    return (
        "The paper's six counts contradict each other: of the pairs with one limit from data set 2 and one from data "
        f"set 3 they leave out {everywhere} at all flight-path angles (6 - 2 - 3), but {at_three} at three of these "
        "angles alone (1 - 4 - 5)."
    )
