"""Models that learn from cases, with estimators whose answers are known."""

import numpy as np
import pytest
from sklearn.linear_model import LinearRegression
from sklearn.neighbors import KNeighborsRegressor

from gtm_fmu.datasets.off_lattice import OffLattice
from gtm_fmu.envelopes.thrust_map import ThrustMap
from gtm_study.research.envelope_models import CaseModel, GaussianProcess, JamModel, surface_map

pytestmark = pytest.mark.slow


def linear_jams(count=60) -> OffLattice:
    """V_min = 60 + d, V_max = 120 + 2 d, t_min = 90 + d %: no envelope from 10 deg on."""
    rng = np.random.default_rng(0)
    jam = rng.uniform(-30, 30, count)
    X = np.column_stack([rng.uniform(0, 30000, count), rng.uniform(-5, 5, count), jam, jam])
    t_min = 90 + jam
    speeds = np.where((t_min <= 100)[:, None], np.column_stack([60 + jam, 120 + 2 * jam]), np.nan)
    return OffLattice(X, speeds, t_min)


@pytest.mark.parametrize(
    ("limits", "expected"),
    [
        ((-20.5, 4.25), (39.5, 128.5)),
        ((3.3, 3.3), (63.3, 126.6)),
        ((-5.0, 25.0), (55.0, 140.0)),  # from 10 deg on there is nothing
        ((9.5, 9.75), (69.5, 139.5)),
    ],
)
def test_extremes_over_the_jams_inside_the_limits(limits, expected):
    speeds, feasible = JamModel(LinearRegression).fit(linear_jams()).predict(np.array([[1000.0, 1.0, *limits]]))
    assert feasible.all()
    assert speeds[0] == pytest.approx(expected, abs=1e-6)


def test_no_jam_inside_the_limits():
    speeds, feasible = JamModel(LinearRegression).fit(linear_jams()).predict(np.array([[0.0, 0.0, 11.0, 30.0]]))
    assert not feasible.any()
    assert np.isnan(speeds).all()


def test_full_throttle_decides():
    data = linear_jams()
    model = CaseModel(LinearRegression).fit(data)
    speeds, feasible = model.predict(data.X)
    assert np.array_equal(feasible, data.feasible)
    assert speeds[feasible] == pytest.approx(data.speeds_kt[feasible], abs=1e-6)


def test_gaussian_process_learns_a_smooth_function_and_tells_what_it_does_not_know():
    rng = np.random.default_rng(1)
    X = rng.uniform(-1, 0.5, (120, 2))
    y = np.sin(3 * X[:, 0]) + X[:, 1] ** 2
    process = GaussianProcess(samples=60).fit(X, y)
    inside = rng.uniform(-0.9, 0.4, (50, 2))
    mean, std = process.predict(inside, return_std=True)
    assert mean == pytest.approx(np.sin(3 * inside[:, 0]) + inside[:, 1] ** 2, abs=0.02)
    assert process.predict(np.array([[1.5, 1.5]]), return_std=True)[1][0] > 5 * std.max()


def test_a_surface_learnt_by_heart_is_the_surface():
    exact = ThrustMap.load()
    solutions = exact.table[..., 2:].size
    learnt = surface_map(exact, lambda: KNeighborsRegressor(1), 20 * solutions)
    assert np.array_equal(learnt.table, exact.table)
    assert learnt.provenance == {}
