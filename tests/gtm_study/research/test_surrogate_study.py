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
from gtm_study.research import surrogate_figures, surrogate_study, trim_map_study
from gtm_study.research.surrogate_report import surrogates_report
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


def test_trim_maps_of_two_sizes(monkeypatch):
    """More trims, smaller errors; the report and the figure show both."""
    truth = off_lattice.load().take(slice(None, 300))
    monkeypatch.setattr(trim_map_study, "SIZES", {name: trim_map_study.SIZES[name] for name in ("coarse", "medium")})
    coarse, medium = trim_map_study.curve(("rudder",), truth, lambda *_: None)
    assert coarse["trims"] < medium["trims"]
    assert medium["percentile_95_kt"] < surrogate_figures.SEVERAL_GOAL_KT < coarse["percentile_95_kt"]
    results = {"trim map": {"rudder": [coarse, medium]}}
    assert surrogates_report(results).count("| rudder |") == 2
    axes = surrogate_figures.plot_trims(results).axes[0]
    assert axes.lines[0].get_ydata().tolist() == [coarse["percentile_95_kt"], medium["percentile_95_kt"]]


@pytest.mark.parametrize(
    ("given", "controls"),
    [
        (("--rudder-deg", "5", "10", "--aileron-deg", "-5", "5"), {"rudder_deg": (5, 10), "aileron_deg": (-5, 5)}),
        (("--elevator-deg", "-3", "2"), {"elevator_deg": (-3, 2)}),
        (("--elevator-deg", "-3", "2", "--model", "trim-map"), {"elevator_deg": (-3, 2)}),
        (("--aileron-deg", "7", "7"), {"aileron_deg": (7, 7)}),
    ],
)
def test_predict_of_other_controls(ask, given, controls):
    """By their thrust maps, and by the trim map where there are several."""
    exact = FlightCondition(10000.0, 0.0, ControlLimits(**controls)).envelope()
    found = ask("predict", "--altitude-ft", "10000", *given, "--json").json
    assert found["model"] == ("trim-map" if len(controls) > 1 or "trim-map" in given else given[0][2:-4])
    assert found["v_min_kt"] == pytest.approx(exact.v_min_kt, abs=1.0)
    assert found["v_max_kt"] == pytest.approx(exact.v_max_kt, abs=1.0)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (("--elevator-deg", "-3", "2", "--model", "network"), "'network' is of a failed rudder, but --elevator-deg"),
        (
            ("--elevator-deg", "-3", "2", "--rudder-deg", "0", "1", "--model", "paper"),
            "'paper' is of one failed control",
        ),
        (("--rudder-deg", "0", "1", "--model", "elevator"), "'elevator' is of a failed elevator, but --rudder-deg"),
        (("--aileron-deg", "-25", "1"), "aileron in deg"),
    ],
)
def test_predict_of_the_wrong_control(ask, given, said):
    refused = ask("predict", "--altitude-ft", "10000", *given)
    assert (refused.code, refused.out) == (2, "")
    assert said in refused.err


def test_tables_of_other_controls(ask, tmp_path):
    """One by the elevator's map, one by the trim map; the same numbers as one by one."""
    condition = "altitude_ft,gamma_deg,elevator_lower_deg,elevator_upper_deg"
    (tmp_path / "one.csv").write_text(f"{condition}\n10000,0,-3,2\n")
    (tmp_path / "all.csv").write_text(
        f"{condition},aileron_lower_deg,aileron_upper_deg,rudder_lower_deg,rudder_upper_deg\n10000,0,-3,2,0,0,-30,30\n"
    )
    for name, model in (("one", "elevator"), ("all", "trim-map")):
        answered = tmp_path / f"{name}_answers.csv"
        answer = ask("predict", "--data", tmp_path / f"{name}.csv", "--output", answered, "--model", model, "--json")
        assert (answer.code, answer.json["rows"]) == (0, 1)
        row = dict(zip(*(line.split(",") for line in answered.read_text().split()), strict=True))
        given = ("--elevator-deg", "-3", "2", *(("--aileron-deg", "0", "0") if name == "all" else ()))
        alone = ask("predict", "--altitude-ft", "10000", *given, "--json").json
        assert float(row["v_max_kt"]) == pytest.approx(alone["v_max_kt"])


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
    monkeypatch.setitem(thrust_survey.NODES, "rudder", nodes)
    answer = ask("thrust-map", "--output", str(tmp_path / "map.npz"), "--json")
    assert answer.code == 0
    written = ThrustMap.load(tmp_path / "map.npz")
    assert written.table.shape == (2, 1, 2, 10)
    assert written.provenance["off_lattice"]["all"] == json.loads(answer.out)["all"]


def test_thrust_map_command_of_an_aileron(ask, tmp_path, monkeypatch):
    """Its exact cases are solved for it, here few, and kept beside it."""
    nodes = thrust_survey.Nodes((0.0,), (-5.0, 5.0), (-20.0, 0.0, 20.0), 9)
    monkeypatch.setitem(thrust_survey.NODES, "aileron", nodes)
    table = off_lattice.case_table(("aileron",), 6)
    monkeypatch.setattr(off_lattice, "case_table", lambda controls, cases: table)
    path = tmp_path / "map.npz"
    answer = ask("thrust-map", "--control", "aileron", "--output", path, "--workers", "1", "--json")
    assert answer.code == 0
    assert ThrustMap.load(path).control == "aileron"
    assert json.loads(answer.out)["all"]["cases"] == 6
    assert ask("thrust-map", "--control", "flaps").code == 2
