"""Adaptive sampling: it goes where the truth bends or jumps, and counts what it solves."""

from dataclasses import replace

import numpy as np
import pytest

from gtm_fmu.datasets.off_lattice import OffLattice
from gtm_fmu.envelopes.thrust_map import ThrustMap
from gtm_study.research.adaptive_sampling import FIRST_JAMS, PROBES, chosen_jams, refinements

pytestmark = pytest.mark.slow


def test_refinements_end_at_the_whole_map_and_count_its_solutions():
    exact = ThrustMap.load()
    steps = list(refinements(exact))
    searches = [count for count, _ in steps]
    assert searches[0] == 1 * 2 * 7 * 9
    assert searches == sorted(set(searches))
    solutions = exact.table[..., 2:].size
    assert solutions < searches[-1] < solutions + 4 * PROBES * len(steps)
    assert np.array_equal(steps[-1][1].table, exact.table)
    speeds = exact.table.shape[3] - 2
    assert all((speeds - 1) % (part.table.shape[3] - 3) == 0 for _, part in steps)  # their roots stay even


def test_the_axis_that_bends_is_refined_first():
    exact = ThrustMap.load()
    shape = exact.table.shape
    bent = np.sin(exact.deflection_deg)[None, None, :, None] + np.arange(shape[3] - 2)
    table = np.concatenate([exact.table[..., :2], np.broadcast_to(bent, (*shape[:3], shape[3] - 2))], axis=3)
    sizes = [part.table.shape for _, part in refinements(replace(exact, table=table))]
    assert [size[2] for size in sizes[:5]] == [7, 13, 25, 49, 97]
    assert {size[:2] + size[3:] for size in sizes[:5]} == {(1, 2, 11)}


def test_jams_are_chosen_at_the_jump():
    """V_max falls by 20 kn at a deflection of 10 deg: there the choice is denser than by chance."""
    rng, count = np.random.default_rng(0), 500
    jam = rng.uniform(-30, 30, count)
    X = np.column_stack([rng.uniform(0, 30000, count), rng.uniform(-5, 5, count), jam, jam])
    speeds = np.column_stack([60 + 0.1 * abs(jam), 120 - 20 * (jam > 10) + 0.1 * jam])
    pool = OffLattice(X, speeds, 50.0 + 0.1 * abs(jam))
    order = chosen_jams(pool, 192)
    assert len(set(order.tolist())) == 192
    at_jump = abs(jam - 10) < 3
    assert at_jump[order[FIRST_JAMS:]].mean() > 1.5 * at_jump.mean()
