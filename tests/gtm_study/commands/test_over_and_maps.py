"""Envelopes along an axis and maps, from the command line."""

import json

import pytest

from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.envelopes import maps as surveys
from gtm_fmu.envelopes.envelope import FlightCondition

pytestmark = pytest.mark.slow


def test_envelopes_over_flight_path(ask, tmp_path):
    picture = tmp_path / "volume.png"
    answer = ask(f"envelope --altitude-ft 0 --rudder-deg 10 10 --over gamma -4 4 8 --plot {picture} --json").json
    assert (answer["over"], answer["values"], answer["plot"]) == ("gamma_deg", [-4.0, 4.0], str(picture))
    assert picture.read_bytes().startswith(b"\x89PNG")
    for gamma_deg, member in zip(answer["values"], answer["envelopes"], strict=True):
        single = FlightCondition(0.0, gamma_deg, ControlLimits(rudder_deg=(10, 10))).envelope()
        assert (member["gamma_deg"], member["v_min_kt"], member["v_max_kt"]) == (
            gamma_deg,
            single.v_min_kt,
            single.v_max_kt,
        )
        speeds = [speed for piece in member["polygons"][0] for speed in piece["tas_kt"]]
        assert (min(speeds), max(speeds)) == pytest.approx((single.v_min_kt, single.v_max_kt), abs=0.1)
        assert member["manoeuvres"]["accepted"] > member["manoeuvres"]["stable"] > 0


def test_envelopes_over_jams_beside_a_failure(ask):
    answer = ask("envelope --altitude-ft 10000 --engine-out left --over elevator -30 2 32 --json").json
    assert [member["feasible"] for member in answer["envelopes"]] == [False, True]
    assert answer["envelopes"][0]["polygons"] == []
    assert answer["envelopes"][1]["limits"]["elevator_deg"] == [2.0, 2.0]
    rows = ask("envelope --over altitude 0 36000 36000 --gamma-deg 5")
    assert rows.code == 0
    assert "altitude_ft" in rows.out


def test_maps(ask, tmp_path):
    picture = tmp_path / "limits.html"
    answer = ask(f"map limits --altitude-ft 10000 --control aileron --step 20 --plot {picture} --json")
    found = json.loads(answer.out)
    assert (found["control"], found["limits"]) == ("aileron_deg", [-20.0, 0.0, 20.0])
    assert found["v_max_kt"][0][2] == pytest.approx(FlightCondition(10000.0, 0.0).envelope().v_max_kt, abs=1e-3)
    assert found["v_max_kt"][2][0] is None
    assert picture.read_text().startswith("<!doctype html>")
    picture = tmp_path / "map.png"
    lattice = "--altitudes-ft 0 30000 30000 --gammas-deg 5 5 1 --step 30"
    found = json.loads(ask(f"map feasibility {lattice} --plot {picture} --json").out)
    assert (found["altitudes_ft"], found["gammas_deg"], found["jams"]) == ([0.0, 30000.0], [5.0], [-30.0, 0.0, 30.0])
    assert found["feasible"][0][0] == [False, True, False]
    assert picture.exists()


@pytest.mark.parametrize(
    ("command", "sentence"),
    [
        ("envelope --over gamma -5 5 1", "Missing option '--altitude-ft'"),
        ("envelope --altitude-ft 0 --over speed 1 2 1", "Envelopes do not vary over 'speed'; choose one of altitude"),
        ("envelope --altitude-ft 0 --over gamma 5 -5 1", "gamma 5 -5 1 are no range"),
        ("envelope --altitude-ft 0 --over gamma -5 5 0", "gamma: a step of 0 gives none or over 1000 values"),
        ("envelope --altitude-ft 0 --over gamma nan 5 1", "gamma nan 5 1 are no range"),
        ("envelope --altitude-ft 0 --gamma-deg 1 --over gamma -5 5 1", "The gamma is either held or varied"),
        (
            "envelope --altitude-ft 0 --rudder-deg 1 2 --over rudder -5 5 1",
            "The rudder is varied; leave out its limits",
        ),
        ("envelope --altitude-ft 0 --over gamma -5 5 1 --plot x.pdf", "x.pdf ends in neither .png nor .html"),
        ("map limits --altitude-ft 0 --plot x.pdf", "x.pdf ends in neither .png nor .html"),
        ("map limits --altitude-ft 0 --control flaps --plot x.png", "There is no control 'flaps'"),
        ("map limits --altitude-ft 0 --rudder-deg 0 5 --plot x.png", "The rudder is varied; leave out its limits"),
        ("map feasibility --rudder-deg 0 5 --plot x.png", "The rudder is varied; leave out its limits"),
        ("map feasibility --step -1 --plot x.png", "step in deg -1 is outside"),
        ("map feasibility", "Missing option '--plot'"),
    ],
)
def test_mistakes_are_one_sentence(ask, command, sentence, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    answer = ask(command)
    assert answer.code == 2
    assert sentence in answer.err
    assert answer.err.count("gtm-fmu: ") == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("command", ["map feasibility --plot {}/x.png", "dataset {}.zarr --cases 4 --export {}/x.csv"])
def test_a_blocked_folder_is_refused_before_anything_is_computed(ask, command, tmp_path, monkeypatch):
    monkeypatch.setattr(surveys, "feasibility_map", None)
    (tmp_path / "file").touch()
    answer = ask(command.replace("{}", str(tmp_path / "file")))
    assert answer.code == 2
    assert "choose a folder you may write to" in answer.err
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
