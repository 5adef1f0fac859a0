"""The study of surrogates: what is done once is kept, and told as it was measured."""

import json
from functools import partial

import numpy as np
import pytest
from matplotlib.figure import Figure

from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.datasets import off_lattice
from gtm_fmu.datasets.cases import Sampling
from gtm_fmu.envelopes import thrust_survey
from gtm_fmu.envelopes.envelope import FlightCondition
from gtm_fmu.envelopes.thrust_map import ThrustMap
from gtm_fmu.errors import InputError
from study.research import surrogate_figures, surrogate_study
from study.research.surrogate_report import surrogates_report
from surrogate.rudder import networks as rudder_networks
from surrogate.rudder.emulator import RudderEmulator

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """Folder and results of the thrust map alone, which needs no further exact cases."""
    folder = tmp_path_factory.mktemp("surrogates")
    return folder, surrogate_study.run(folder, "thrust map")


def test_the_thrust_map_meets_the_goals(kept):
    found = kept[1]["models"]["thrust map"]
    for part in ("restrictions", "jams"):
        assert found[part]["mse"] < surrogate_figures.GOAL_MSE / 50
        assert found[part] == ThrustMap.load().provenance["off_lattice"][part]
    assert 0.93 < found["inside_95"] < 0.97
    assert found["searches"] == ThrustMap.load().provenance["solves"]


def test_a_part_of_the_lattice_s_searches_reaches_the_goal(kept):
    """The paper's lattice takes 1232 x 3 searches; the refined map needs fewer for the goal, and errors fall."""
    points = kept[1]["curves"]["thrust map, refined"]
    enough = min(point["searches"] for point in points if point["all"]["mse"] < surrogate_figures.GOAL_MSE)
    assert enough < 1232 * surrogate_study.SEARCHES_A_CASE / 2
    assert points[-1]["all"]["mse"] < points[0]["all"]["mse"] / 1000


def test_a_second_run_goes_on(kept, monkeypatch):
    folder, first = kept
    monkeypatch.setattr(surrogate_study, "measured", lambda *_: pytest.fail("measured again"))
    assert surrogate_study.run(folder, "thrust map") == first
    assert json.loads((folder / surrogate_study.RESULTS_FILE).read_text()) == first


def test_a_model_that_is_not_there(kept):
    with pytest.raises(InputError, match="No model is named like 'oracle'"):
        surrogate_study.run(kept[0], "oracle")


def test_warnings_are_counted_by_hand():
    """A map of one wrong end: the count inside the intervals is that of the errors below 1.96 deviations."""
    exact, truth = ThrustMap.load(), off_lattice.load().take(slice(None, 400))
    found = exact.predict(truth.X)
    known = truth.feasible & found.feasible
    errors = [abs(found.v_min_kt - truth.speeds_kt[:, 0]) / found.v_min_std_kt]
    errors.append(abs(found.v_max_kt - truth.speeds_kt[:, 1]) / found.v_max_std_kt)
    inside = np.mean([error[known] < 1.96 for error in errors])
    assert off_lattice.measured(exact, truth)["inside_95"] == pytest.approx(inside)


def test_table_and_figures(kept):
    text = surrogates_report(kept[1])
    found = kept[1]["models"]["thrust map"]
    assert f"| thrust map | {found['searches']} | {found['restrictions']['mse']:.2g} |" in text
    assert f"hold {found['inside_95']:.1%} of the speeds" in text
    assert text.count("| thrust map, refined |") == len(kept[1]["curves"]["thrust map, refined"])
    figure = surrogate_figures.plot_errors(kept[1])
    assert isinstance(figure, Figure)
    (line, goal) = figure.axes[0].lines
    assert line.get_ydata().tolist() == [p["all"]["mse"] for p in kept[1]["curves"]["thrust map, refined"]]
    assert goal.get_ydata()[0] == surrogate_figures.GOAL_MSE


def test_those_of_the_package(tmp_path):
    """Goals: networks with a mean square of 5e-5, 99.8 % of the verdicts, and intervals that hold what they say."""
    found = surrogate_study.run(tmp_path, "package network")["package"]["network"]
    assert found["all"]["mse"] < 5e-5
    assert found["all"]["same_verdict"] >= 0.998
    assert 0.93 < found["inside_95"] < 0.97
    text = surrogates_report({"package": {"network": found}, "package, further cases": {"network": found}})
    assert f"{found['all']['largest_kt']:.2f} | {found['all']['same_verdict']:.2%} | {found['inside_95']:.1%} |" in text


def test_networks_command(ask, tmp_path, monkeypatch):
    """Exact cases, both networks and their deviations, at a small size; the same seed gives the same networks."""
    tables = {
        "training_cases": off_lattice.case_table(cases=40, seed=1, sampling=Sampling.SOBOL),
        "calibration_cases": off_lattice.case_table(cases=20, seed=2),
    }
    monkeypatch.setattr(rudder_networks, "tables", lambda: tables)
    small = partial(rudder_networks.train_emulator, hidden=(3, 3), rounds=2, epochs=5)
    monkeypatch.setattr(rudder_networks, "train_emulator", small)
    for name in ("one", "other"):
        answer = ask("networks", "--output", tmp_path / name, "--data", tmp_path / "cases", "--json")
        assert answer.code == 0
    emulator = RudderEmulator.load(tmp_path / "one")
    assert emulator.speeds.sizes == (4, 3, 3, 2)
    assert emulator.speeds.log_std is not None
    assert emulator.speeds.provenance["off_lattice"]["all"] == json.loads(answer.out)["all"]
    for file in ("rudder_speeds.json", "rudder_throttle.json"):
        assert (tmp_path / "one" / file).read_bytes() == (tmp_path / "other" / file).read_bytes()
    assert ask("predict", "--altitude-ft", "9000", "--model", tmp_path / "one", "--json").code == 0


def test_the_jump_of_v_max_comes_out_right(monkeypatch):
    """At 28398 ft with a jam of 2.1 deg V_max falls from 128 to 113 kn between 1.8 and 1.9 deg of flight path."""
    monkeypatch.setattr(surrogate_figures, "FOLD_GAMMAS_DEG", (1.8, 1.9))
    cut = surrogate_figures.fold_cut(lambda *_: None)
    assert cut.exact_kt == pytest.approx([128.0, 113.0], abs=0.5)
    assert cut.mapped.v_max_kt == pytest.approx(cut.exact_kt, abs=0.1)
    assert abs(cut.network_kt - cut.exact_kt).max() > 3.0
    assert len(surrogate_figures.plot_fold(cut).axes[0].lines) >= 3


def test_command(ask, kept):
    """On results that are kept already: one JSON object, three figures and a table."""
    folder, results = kept
    answer = ask("surrogates", "--only", "thrust map", "--output", str(folder), "--json")
    assert answer.code == 0
    assert json.loads(answer.out) == results
    names = {path.name for path in folder.iterdir()}
    assert names == {
        "parts",
        "surrogates.json",
        "surrogates.md",
        "surrogate_surface.png",
        "surrogate_fold.png",
        "surrogate_errors.png",
    }
    refused = ask("surrogates", "--only", "oracle", "--output", str(folder))
    assert (refused.code, refused.out) == (2, "")
    assert "No model is named like 'oracle'" in refused.err


def test_an_aileron_has_a_map_too():
    """Two deflections at sea level serve jams between them at another altitude."""
    X = np.array([[12000.0, 0.0, 4.5, 4.5], [20000.0, 0.0, 4.0, 5.0], [3000.0, 0.0, 5.0, 5.0]])
    exact = [
        FlightCondition(altitude, gamma, ControlLimits(aileron_deg=(lower, upper))).envelope()
        for altitude, gamma, lower, upper in X.tolist()
    ]
    speeds = np.array([[found.v_min_kt, found.v_max_kt] for found in exact])
    truth = off_lattice.OffLattice(X, speeds, np.array([found.t_min_pct for found in exact]))
    nodes = thrust_survey.Nodes((0.0,), (0.0,), (4.0, 5.0), 25)
    scores = surrogate_study.surveyed_aileron(nodes, truth, lambda *_: None)
    assert (scores["compared"], scores["same_verdict"], scores["searches"]) == (3, 1.0, 50)
    assert scores["largest_kt"] < 1.0


def test_predict_by_the_map(ask):
    """Nearer to the exact solver than a tenth of a knot, where the networks are off by more."""
    exact = FlightCondition(10000.0, 0.0).envelope((-10.0, 20.0))
    case = ["predict", "--altitude-ft", "10000", "--rudder-deg", "-10", "20", "--json"]
    by_map = ask(*case).json
    assert (by_map["feasible"], by_map["in_domain"], by_map["fold"]) == (True, True, False)
    assert by_map["v_min_kt"] == pytest.approx(exact.v_min_kt, abs=0.1)
    assert by_map["v_max_kt"] == pytest.approx(exact.v_max_kt, abs=0.1)
    by_paper = ask(*case, "--model", "paper").json
    assert abs(by_paper["v_max_kt"] - exact.v_max_kt) > abs(by_map["v_max_kt"] - exact.v_max_kt)


def test_thrust_map_command(ask, tmp_path, monkeypatch):
    nodes = thrust_survey.Nodes((0.0, 20000.0), (0.0,), (-10.0, 10.0), 8)
    monkeypatch.setattr(thrust_survey, "Nodes", lambda: nodes)
    answer = ask("thrust-map", "--output", str(tmp_path / "map.npz"), "--json")
    assert answer.code == 0
    written = ThrustMap.load(tmp_path / "map.npz")
    assert written.table.shape == (2, 1, 2, 10)
    assert written.provenance["off_lattice"]["all"] == json.loads(answer.out)["all"]
