"""Damage and engines that are out, on the command line."""

import pytest

from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.core.configuration import Configuration
from gtm_fmu.envelopes.envelope import FlightCondition
from gtm_fmu.trims import steady

pytestmark = pytest.mark.slow

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


ALL_SET = (
    "--throttle-left-pct 10 70 --elevator-deg -8 12 --stabilizer-deg -1 --flaps-deg 10 --spoilers-deg 3 --gear 1 "
    "--fuel-used-lb 7"
)


def test_every_setting(ask):
    settings = Configuration(stabilizer_deg=-1, flap_deg=(10,) * 4, spoiler_deg=(3,) * 4, gear=1, fuel_used_lb=7)
    same = Failure(ControlLimits(elevator_deg=(-8, 12)), settings, throttle_left_pct=(10, 70))
    answer = ask(f"trim --altitude-ft 3000 --tas-kt 80 {ALL_SET} --json").json
    exact = steady.trim(3000, 80, 0, 0, same)
    assert answer["feasible"]
    for name in ("throttle_left_pct", "throttle_right_pct", "elevator_deg", "alpha_deg"):
        assert answer[name] == getattr(exact, name)
    model = ask(f"linearize --altitude-ft 3000 --tas-kt 80 {ALL_SET} --json").json
    assert model["inputs"][-2:] == ["throttle_left", "throttle_right"]


def test_both_engines_out_glide(ask):
    answer = ask("envelope --altitude-ft 10000 --gamma-deg -7 --engine-out both --json").json
    gliding = Failure(configuration=Configuration(engine_running=(False, False)))
    assert answer["v_max_kt"] == FlightCondition(10000, -7, gliding).envelope().v_max_kt


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        ("--damage-case 7", "damage_case is 7; allowed are 0 .. 6."),
        ("--damage-case -1", "damage_case is -1; allowed are 0 .. 6."),
        ("--damage-case tail", "'--damage-case'"),
        ("--engine-out all", "'all' is not one of 'none', 'left', 'right', 'both'"),
        ("--engine-out left --fmu none.fmu", "'none.fmu' is the study's airframe with one throttle; leave out --fmu"),
        (
            "--throttle-pct 10 20 --throttle-left-pct 0 50 --throttle-right-pct 0 60",
            "--throttle-pct has no effect beside --throttle-left-pct and --throttle-right-pct; leave one of them out.",
        ),
        ("--throttle-left-pct 60 40", "throttle left in %: limits 60 40 are reversed"),
        ("--throttle-right-pct 0 nan", "throttle right in %: limits 0 nan are not finite"),
        ("--fuel-used-lb -1", "fuel_used_lb is -1.0; allowed are 0 .. 20."),
        ("--stabilizer-deg nan", "stabilizer_deg is nan; allowed are -90 .. 90."),
        ("--flaps-deg 91", "flap_deg is (91.0, 91.0, 91.0, 91.0); allowed are -90 .. 90."),
    ],
)
def test_wrong_failures_are_told(ask, options, complaint):
    answer = ask(f"trim --altitude-ft 8000 --tas-kt 100 {options}")
    assert answer.code == 2
    assert complaint in answer.err
    assert answer.err.count("\n") == 1
    assert answer.out == ""
