"""Scores of the study: zero where two methods agree, the right size where one is off by a known amount."""

import io
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from rich.console import Console

from gtm_fmu.envelopes.envelope import FlightCondition
from gtm_fmu.envelopes.thrust_map import ThrustMap
from study.paper import comparisons
from study.progress import stages

pytestmark = pytest.mark.slow

CASES = 8
V_MIN_RANGE, V_MAX_RANGE = 50.0, 80.0
DATA = xr.Dataset(
    {"v_min": ("altitude", [60.0, 60.0 + V_MIN_RANGE]), "v_max": ("altitude", [100.0, 100.0 + V_MAX_RANGE])},
    coords={"altitude": [0.0, 15000.0], "gamma": [-4.0, 1.0]},
)


def no_progress(*_) -> None:
    pass


class Biased:
    """Exact envelopes with errors put on top; one verdict in `wrong_every` is wrong."""

    def __init__(self, v_min_error_kt=0.0, v_max_error_kt=0.0, wrong_every=0):
        self.errors, self.wrong_every, self.cases = (v_min_error_kt, v_max_error_kt), wrong_every, []

    def predict_one(self, altitude_ft, gamma_deg, rudder_deg):
        self.cases.append((altitude_ft, gamma_deg, *rudder_deg))
        exact = FlightCondition(altitude_ft, gamma_deg).envelope(rudder_deg)
        if not exact.feasible or (self.wrong_every and len(self.cases) % self.wrong_every == 0):
            return {"feasible": False, "v_min_kt": None, "v_max_kt": None}
        v_min, v_max = exact.v_min_kt + self.errors[0], exact.v_max_kt + self.errors[1]
        return {"feasible": True, "v_min_kt": v_min, "v_max_kt": v_max}


@pytest.fixture(autouse=True)
def few(monkeypatch):
    monkeypatch.setattr(comparisons, "OFF_LATTICE_CASES", CASES)
    monkeypatch.setattr(comparisons, "_speeds_over_jams", lambda emulator: None)


class TestEmulator:
    def test_without_error(self):
        exact = Biased()
        scores = comparisons.compare_emulator(exact, DATA, 0, no_progress).scores
        assert scores["cases"] == scores["same_verdict"] == CASES
        assert scores["compared"] == scores["feasible"] > 0
        assert scores["mse"] == 0
        assert scores["largest_error_kt"] == [0, 0]
        altitude, gamma, lower, upper = np.transpose(exact.cases)
        assert (altitude.min() >= 0) & (altitude.max() <= 15000) & (np.ptp(altitude) > 5000)
        assert (gamma.min() >= -4) & (gamma.max() <= 1)
        assert (lower == upper).sum() == CASES / 2
        assert (np.abs([lower, upper]) <= 30).all() & (lower <= upper).all()

    def test_known_error(self):
        scores = comparisons.compare_emulator(Biased(-1.0, 4.0), DATA, 0, no_progress).scores
        for kind in ("median", "percentile_95", "largest"):
            assert scores[f"{kind}_error_kt"] == pytest.approx([1, 4])
        assert scores["mse"] == pytest.approx(((1 / V_MIN_RANGE) ** 2 + (4 / V_MAX_RANGE) ** 2) / 2)

    def test_wrong_verdicts_are_counted_and_not_compared(self):
        right = comparisons.compare_emulator(Biased(), DATA, 0, no_progress).scores
        scores = comparisons.compare_emulator(Biased(1.0, 1.0, wrong_every=4), DATA, 0, no_progress).scores
        missed = CASES - scores["same_verdict"]
        assert missed > 0
        assert scores["feasible"] == right["feasible"]
        assert scores["compared"] == right["compared"] - missed
        assert scores["largest_error_kt"] == pytest.approx([1, 1])

    def test_seed(self):
        first, again, other = (Biased() for _ in range(3))
        for emulator, seed in ((first, 0), (again, 0), (other, 1)):
            comparisons.compare_emulator(emulator, DATA, seed, no_progress)
        assert first.cases == again.cases
        assert not set(first.cases) & set(other.cases)


def test_surrogate_fmu_with_another_map(fmus):
    """The FMU agrees with what it carries, and is told from anything else."""
    carried = ThrustMap.load()

    def biased(*case):
        found = carried.predict_one(*case)
        return found | ({"v_max_kt": found["v_max_kt"] + 0.25} if found["feasible"] else {})

    same = comparisons.compare_surrogate_fmu(fmus["surrogate"], carried, 0)
    assert same["largest_difference_kt"] < 1e-9
    assert same["same_verdict"] == same["cases"]
    other = comparisons.compare_surrogate_fmu(fmus["surrogate"], SimpleNamespace(predict_one=biased), 0)
    assert other["largest_difference_kt"] == pytest.approx(0.25)


def test_jams_of_the_paper(monkeypatch):
    monkeypatch.setattr(comparisons, "FIG_3_JAMS_DEG", (20.0, 30.0))
    steps = []
    family = comparisons.jam_family(lambda *step: steps.append(step))
    assert steps[-1] == (2, 2)
    found = FlightCondition(10000, -5).envelope((20, 20))  # paper Fig. 3
    jam_20, jam_30 = family.members
    assert (jam_20.envelope.v_min_kt, jam_20.envelope.v_max_kt) == (found.v_min_kt, found.v_max_kt)
    assert len(jam_20.boundary.polygons) == 1
    assert not jam_30.envelope.feasible
    assert jam_30.boundary.polygons == ()


class TestProgress:
    def test_lines_where_there_is_no_terminal(self):
        shown = io.StringIO()
        with stages(Console(file=shown)) as stage:
            with stage("Envelopes") as advance:
                advance(1, 3)
                assert shown.getvalue() == ""
            assert shown.getvalue() == "Envelopes: done\n"
            with pytest.raises(ValueError, match="broken"), stage("Networks"):
                raise ValueError("broken")
        assert shown.getvalue() == "Envelopes: done\n"

    def test_bar_with_the_time_left(self):
        shown = io.StringIO()
        with (
            stages(Console(file=shown, force_terminal=True, width=100, _environ={})) as stage,
            stage("Envelopes") as advance,
        ):
            advance(1, 4)
        assert "Envelopes" in shown.getvalue()
        assert "0:00:00" in shown.getvalue()
        assert "done" not in shown.getvalue()
