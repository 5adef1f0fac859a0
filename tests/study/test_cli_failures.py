"""Damage and engines that are out, on the command line."""

import pytest

from gtm_fmu import steady
from gtm_fmu.core.configuration import Configuration
from gtm_fmu.envelope import FlightCondition
from gtm_fmu.failures import ControlLimits, Failure

FAILURE = "--damage-case 5 --engine-out left --rudder-deg -10 10"
SAME = Failure(ControlLimits(rudder_deg=(-10, 10)), Configuration(damage_case=5, engine_running=(False, True)))


def test_trim(ask):
    answer = ask(f"trim --altitude-ft 8000 --tas-kt 100 --turn-rate-deg-s 2 {FAILURE} --json")
    assert answer.code == 0
    same = steady.trim(8000, 100, 0, 2, SAME)
    for name in ("throttle_pct", "rudder_deg", "beta_deg", "elevator_deg"):
        assert answer.json[name] == getattr(same, name)
    assert answer.json["feasible"]
    assert answer.json["controllable"] is True


def test_envelope(ask):
    answer = ask(f"envelope --altitude-ft 8000 {FAILURE} --json").json
    same = FlightCondition(8000, 0, SAME).envelope()
    assert (answer["v_min_kt"], answer["v_max_kt"]) == (same.v_min_kt, same.v_max_kt)
    assert answer["failure"]["configuration"]["damage_case"] == 5
    assert answer["failure"]["configuration"]["engine_running"] == [False, True]
    assert "failure" not in ask("envelope --altitude-ft 8000 --rudder-deg 5 5 --json").json


def test_linear_model_has_no_lost_rudder(ask):
    model = ask("linearize --altitude-ft 8000 --tas-kt 100 --damage-case 2 --json").json
    assert model["inputs"] == ["elevator", "aileron", "throttle"]


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        ("--damage-case 7", "damage_case is 7; allowed are 0 .. 6."),
        ("--damage-case -1", "damage_case is -1; allowed are 0 .. 6."),
        ("--damage-case tail", "'--damage-case'"),
        ("--engine-out both", "'both' is not one of 'left', 'right'"),
        ("--engine-out left --fmu none.fmu", "'none.fmu' is the undamaged aircraft; leave out --fmu"),
    ],
)
def test_wrong_failures_are_told(ask, options, complaint):
    answer = ask(f"trim --altitude-ft 8000 --tas-kt 100 {options}")
    assert answer.code == 2
    assert complaint in answer.err
    assert answer.err.count("\n") == 1
    assert answer.out == ""
