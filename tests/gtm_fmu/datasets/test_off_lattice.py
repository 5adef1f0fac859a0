"""The off-lattice test set: its cases, its scores by hand, its stores."""

import numpy as np
import pytest

from gtm_fmu.datasets import off_lattice
from gtm_fmu.datasets.cases import Sampling
from gtm_fmu.datasets.off_lattice import OffLattice
from gtm_fmu.envelopes.envelope import FlightCondition
from gtm_fmu.errors import InputError

NAN = np.nan
X = np.array([[0.0, 0.0, -10.0, 10.0], [0.0, 1.0, 5.0, 5.0], [0.0, 2.0, -1.0, 1.0], [0.0, 3.0, 7.0, 7.0]])
TRUTH = OffLattice(X, np.array([[60.0, 100.0], [70.0, 90.0], [NAN, NAN], [64.0, 120.0]]), np.array([40, 50, 110, 60.0]))


def test_cases_follow_from_the_seed_and_cover_the_domain():
    packaged = off_lattice.load()
    assert packaged.X.shape == (4096, 4)
    assert np.array_equal(packaged.X, off_lattice.inputs(off_lattice.case_table()))
    low, high = packaged.X.min(axis=0), packaged.X.max(axis=0)
    assert low == pytest.approx([0.0, -5.0, -30.0, -30.0], abs=20.0)
    assert high == pytest.approx([30000.0, 5.0, 30.0, 30.0], abs=20.0)
    assert (packaged.X[:, 2] <= packaged.X[:, 3]).all()


def test_feasible_where_the_least_throttle_is_at_most_full():
    packaged = off_lattice.load()
    assert np.array_equal(packaged.feasible, packaged.t_min_pct <= 100.0)


def test_scores_by_hand():
    """Ranges of the exact speeds are 10 and 30 kn; of four cases two are compared, and two verdicts are wrong."""
    speeds = np.array([[61.0, 103.0], [70.0, 84.0], [50.0, 60.0], [NAN, NAN]])
    found = off_lattice.scores(TRUTH, speeds, np.array([True, True, True, False]))
    assert found["restrictions"]["mse"] == pytest.approx((0.1**2 + 0.1**2) / 2)
    assert found["jams"]["mse"] == pytest.approx((0.0 + 0.2**2) / 2)
    assert found["all"]["mse"] == pytest.approx((0.1**2 + 0.1**2 + 0.2**2) / 4)
    assert found["all"]["largest_kt"] == pytest.approx(6.0)
    assert found["all"]["median_kt"] == pytest.approx(2.0)
    assert (found["all"]["wrong_verdicts"], found["all"]["same_verdict"]) == (2, 0.5)
    assert [found[part]["wrong_verdicts"] for part in ("restrictions", "jams")] == [1, 1]


def test_scores_want_a_prediction_for_each_case():
    with pytest.raises(InputError, match="2 predictions were given for 4 cases"):
        off_lattice.scores(TRUTH, TRUTH.speeds_kt[:2], TRUTH.feasible[:2])


def test_parts_without_an_envelope_are_left_out():
    jams_fail = np.array([True, False, False, False])
    found = off_lattice.scores(TRUTH, TRUTH.speeds_kt, jams_fail)
    assert set(found) == {"restrictions", "all"}
    assert (found["all"]["compared"], found["all"]["wrong_verdicts"], found["all"]["largest_kt"]) == (1, 2, 0.0)
    with pytest.raises(InputError, match="nothing to compare"):
        off_lattice.scores(TRUTH, TRUTH.speeds_kt, np.zeros(4, dtype=bool))


def test_several_controls():
    table = off_lattice.case_table(("rudder", "aileron"), 64, 1, 1 / 3, Sampling.SOBOL)
    cases = off_lattice.inputs(table)
    assert cases.shape == (64, 6)
    assert [column.name for column in table.columns][4:6] == ["aileron_lower", "aileron_upper"]
    assert (np.abs(cases[:, 2:4]) <= 20.0).all()  # the aileron's, before the rudder's
    jammed = cases[:, 2::2] == cases[:, 3::2]
    assert 10 < jammed[:, 0].sum() < 32
    assert OffLattice(cases, np.empty((64, 2)), np.empty(64)).jammed.sum() == jammed.all(axis=1).sum()


def test_a_store_gives_what_was_asked(tmp_path):
    table = off_lattice.case_table(cases=3, seed=3)
    found = off_lattice.solve(tmp_path / "cases.zarr", table, workers=1)
    assert np.array_equal(found.X, off_lattice.inputs(table))
    assert np.array_equal(found.feasible, found.t_min_pct <= 100.0)
    for (altitude_ft, gamma_deg, *limits), speeds in zip(found.X.tolist(), found.speeds_kt, strict=True):
        exact = FlightCondition(altitude_ft, gamma_deg).envelope((limits[0], limits[1]))
        assert speeds == pytest.approx(np.array([exact.v_min_kt, exact.v_max_kt], dtype=float), nan_ok=True)
