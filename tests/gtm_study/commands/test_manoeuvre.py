"""`gtm-fmu manoeuvre` and `gtm-fmu performance`: as envelopes say; wrong input is one sentence."""

import csv

import pytest

from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.envelopes.envelope import envelope
from gtm_fmu.trims.steady import trim

pytestmark = pytest.mark.slow
JAM = ("--altitude-ft", "10000", "--rudder-deg", "15", "15")


def test_a_turn_that_cannot_be_flown(ask):
    """Its bank is that of the trim without the limit, which is the remedy."""
    answer = ask("manoeuvre", *JAM, "--tas-kt", "110", "--turn-rate-deg-s", "4", "--json")
    assert answer.code == 3
    found = answer.json
    free = trim(10000, tas_kt=110, turn_rate_deg_s=4, limits=ControlLimits(rudder_deg=(15, 15)), phi_deg=(-80, 80))
    assert not found["feasible"]
    assert found["binding"] == "phi.upper"
    assert found["margins"]["phi_deg"][1] == pytest.approx(30 - free.phi_deg, abs=1e-6)


def test_a_table(ask, tmp_path):
    exact = envelope(10000, 0, ControlLimits(rudder_deg=(15, 15)))
    speeds = [exact.v_max_kt + 1, exact.at_v_max.tas_kt - 20]
    (tmp_path / "asked.csv").write_text("altitude_ft,tas_kt\n" + "".join(f"10000,{speed}\n" for speed in speeds))
    words = ("--data", tmp_path / "asked.csv", "--output", tmp_path / "told.csv", "--rudder-deg", 15, 15)
    assert ask("manoeuvre", *words, "--json").code == 0
    with (tmp_path / "told.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["feasible"] for row in rows] == ["False", "True"]


def test_performance_beside_the_healthy_aircraft(ask):
    found = ask("performance", *JAM, "--json")
    assert found.code == 0
    exact = envelope(10000, 0, ControlLimits(rudder_deg=(15, 15)))
    assert f"{exact.v_max_kt:.4f}"[:7] in found.out
    assert f"{envelope(10000, 0).v_max_kt:.4f}"[:7] in found.out


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("manoeuvre", "--altitude-ft", "10000"), "one speed"),
        (("manoeuvre", "--altitude-ft", "10000", "--tas-kt", "9000"), "outside 20 .. 350"),
        (("manoeuvre", "--tas-kt", "100"), "--altitude-ft"),
        (("manoeuvre", "--data", "none.csv", "--output", "told.csv"), "none.csv"),
        (("performance", "--altitude-ft", "10000", "--damage-case", "9"), "damage_case is 9"),
        (("performance", "--altitude-ft", "10000", "--plot", "x.txt"), "neither .png nor .html"),
    ],
)
def test_wrong_input(ask, tmp_path, monkeypatch, words, sentence):
    monkeypatch.chdir(tmp_path)
    answer = ask(*words)
    assert answer.code == 2
    assert sentence in answer.err
    assert answer.err.count("\n") == 1
    assert not list(tmp_path.iterdir())
