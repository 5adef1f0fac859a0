"""The options of gusts and tolerances at every command that takes them."""

import pytest

from gtm_fmu import ControlLimits, Tolerances, tolerant_envelope

JAM = "--altitude-ft 10000 --rudder-deg 15 15"


@pytest.fixture(scope="module")
def expected():
    return tolerant_envelope(10000, 0, ControlLimits(rudder_deg=(15, 15)), Tolerances(gust_kt=5, mass_tolerance=0.05))


def test_envelope_tells_both(ask, expected):
    told = ask(f"envelope {JAM} --gust-kt 5 --mass-tolerance 0.05 --json").json
    for kind in ("guaranteed", "possible"):
        assert (told[kind]["v_min_kt"], told[kind]["v_max_kt"]) == expected.speeds_kt(kind)
    assert told["tolerances"]["gust_kt"] == 5
    assert told["guaranteed"]["at_v_min"]["aircraft"] == {"mass": 0.05}
    assert "guaranteed" not in ask(f"envelope {JAM} --json").json


def test_envelope_in_words(ask, expected):
    low, high = expected.speeds_kt("guaranteed")
    assert f"{low:.2f} .. {high:.2f}" in ask(f"envelope {JAM} --gust-kt 5 --mass-tolerance 0.05").out


def test_envelopes_along_an_axis(ask, expected, tmp_path):
    picture = tmp_path / "speeds.html"
    words = "--over altitude 10000 30000 20000 --gust-kt 5 --mass-tolerance 0.05 --json"
    answer = ask(*f"envelope --rudder-deg 15 15 {words} --plot {picture}".split())
    first, last = answer.json["envelopes"]
    assert (first["guaranteed"]["v_min_kt"], first["guaranteed"]["v_max_kt"]) == expected.speeds_kt("guaranteed")
    assert (last["guaranteed"]["feasible"], last["possible"]["feasible"]) == (False, True)
    assert "guaranteed V_min" in picture.read_text(encoding="utf-8")


def test_manoeuvre_tells_who_can_not_fly_it(ask):
    words = "--gust-kt 5 --mass-tolerance 0.05 --json"
    sure = ask(f"manoeuvre {JAM} --tas-kt 110 {words}").json
    assert (sure["guaranteed"], sure["possible"], sure["not_flown_by"]) == (True, True, None)
    unsure = ask(f"manoeuvre {JAM} --tas-kt 80 {words}").json
    assert (unsure["feasible"], unsure["guaranteed"], unsure["possible"]) == (True, False, True)
    assert unsure["not_flown_by"]["tas_kt"] == 75


def test_table_of_manoeuvres(ask, tmp_path):
    table, answers = tmp_path / "asked.csv", tmp_path / "answers.csv"
    table.write_text("altitude_ft,tas_kt\n10000,110\n10000,72\n10000,200\n")
    words = f"--data {table} --output {answers} --rudder-deg 15 15 --mass-tolerance 0.05 --json"
    assert ask(*f"manoeuvre {words}".split()).json | {"output": ""} == {
        **{"output": "", "rows": 3},
        **{"feasible": 2, "guaranteed": 1, "possible": 2},
    }
    assert "guaranteed" in answers.read_text().partition("\n")[0]


@pytest.mark.slow
def test_map_of_feasibility(ask, tmp_path):
    """A jam at 30 deg leaves nothing; without one there is a guaranteed envelope at 10 000 ft."""
    lattice = "--step 30 --altitudes-ft 10000 10000 1000 --gammas-deg 0 0 1"
    words = f"map feasibility {lattice} --mass-tolerance 0.05 --plot {tmp_path / 'map.png'} --json"
    told = ask(*words.split())
    assert '"feasible": [[[false, true, false]]]' in told.out
    assert '"envelopes": "guaranteed"' in told.out


@pytest.mark.parametrize(
    ("command", "message"),
    [
        (f"envelope {JAM} --gust-kt -5", "gust in kn -5 is outside 0 .. 50; give a value inside."),
        (f"envelope {JAM} --mass-tolerance 5", "mass tolerance 5 is outside 0 .. 0.3"),
        (f"manoeuvre {JAM} --tas-kt 110 --cg-tolerance nan", "cg tolerance nan is outside 0 .. 0.3"),
        ("map limits --altitude-ft 10000 --plot x.png --aero-tolerance 1", "aero tolerance 1 is outside 0 .. 0.3"),
        ("dataset x.zarr --gust-kt 99", "gust in kn 99 is outside 0 .. 50"),
        (f"envelope {JAM} --gust-kt 5 --plot x.png", "give --over too"),
    ],
)
def test_refused_in_one_sentence(ask, command, message):
    answer = ask(command)
    assert answer.code == 2
    assert message in answer.err
    assert answer.err.count("\n") == 1
