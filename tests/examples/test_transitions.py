"""Transitions after a failure: yes, or no with the limit and the time; nothing is exceeded on the way."""

import sys

import numpy as np
import pytest

from examples.transitions import run
from examples.transitions.flight import STEP_S
from examples.transitions.path import Manoeuvre, Rates
from examples.transitions.transition import transition
from gtm_fmu import ControlLimits, Failure, InputError, RateLimits, manoeuvres, turn_rate_interval
from gtm_fmu.core.configuration import Configuration

pytestmark = pytest.mark.slow

JAM = ControlLimits(rudder_deg=(15, 15))
ALTITUDE_FT = 10000.0
QUICK = Rates(3.0, 3.0, 2.0)


@pytest.fixture(scope="module")
def easy():
    """Slower, into a climb and a turn to the other side."""
    return transition(ALTITUDE_FT, Manoeuvre(110), Manoeuvre(100, 2, -3), JAM, QUICK)


def test_easy_one_ends_at_the_target(easy):
    """Speed, path and turn rate as asked for; alpha, bank and controls those of an independent trim there."""
    assert easy.possible, easy.reason
    assert (easy.reason, easy.limit, easy.time_s) == ("", None, None)
    end = {name: values[-1] for name, values in easy.flight.items()}
    assert end["tas_kt"] == pytest.approx(100, abs=0.5)
    assert end["gamma_deg"] == pytest.approx(2, abs=0.2)
    assert end["turn_rate_deg_s"] == pytest.approx(-3, abs=0.2)
    trim = manoeuvres(end["altitude_ft"], 100, 2, -3, JAM).trim(0)
    assert end["alpha_deg"] == pytest.approx(trim.alpha_deg, abs=0.1)
    assert end["phi_deg"] == pytest.approx(trim.phi_deg, abs=0.3)
    assert end["aileron_deg"] == pytest.approx(trim.aileron_deg, abs=0.3)
    assert end["throttle_pct"] == pytest.approx(trim.throttle_pct, abs=2)
    assert end["altitude_ft"] > ALTITUDE_FT + 20


def test_limits_hold_at_every_sample(easy):
    """The study's bounds of alpha and bank (SPEC 9), the servos' travel and rate (SPEC 10.1), the jam."""
    flight = easy.flight
    np.testing.assert_allclose(np.diff(flight["time_s"])[:-1], STEP_S, atol=1e-9)
    bounds = {"alpha_deg": (-5, 10.5), "phi_deg": (-30, 30), "elevator_deg": (-30, 20), "aileron_deg": (-20, 20)}
    bounds |= {"throttle_pct": (0, 100), "rudder_deg": (15 - 1e-9, 15 + 1e-9)}
    for name, (lower, upper) in bounds.items():
        assert lower <= flight[name].min() <= flight[name].max() <= upper, name
    for name in ("elevator_deg", "aileron_deg"):
        assert np.abs(np.diff(flight[name])).max() / STEP_S <= 300
    assert set(easy.limits) >= {"tas_kt", "altitude_ft", "elevator_demand", "aileron_rate"}


def test_staying_changes_nothing():
    """No motion of the reference: the trim is held to rounding for the ten seconds that it settles."""
    found = transition(ALTITUDE_FT, Manoeuvre(110), Manoeuvre(110), JAM)
    assert found.possible
    assert found.flight["time_s"][-1] == pytest.approx(10)
    assert np.ptp(found.flight["phi_deg"]) < 1e-6


def test_path_across_the_edge_is_refused():
    """Both ends exist, what lies between does not: at the speed named the exact section ends below the turn asked."""
    found = transition(ALTITUDE_FT, run.TURN, run.FAST, JAM)
    assert not found.possible
    assert found.limit == "phi.upper"
    assert "no steady flight at 96.4 kn" in found.reason
    assert "phi exceeds its upper limit" in found.reason
    assert not found.flight
    asked = found.path.manoeuvre(found.path.refusal)
    before = found.path.manoeuvre(found.path.refusal - 1)
    for manoeuvre, inside in ((asked, False), (before, True), (run.TURN, True), (run.FAST, True)):
        section = turn_rate_interval(ALTITUDE_FT, manoeuvre.tas_kt, 0, JAM)
        assert (manoeuvre.turn_rate_deg_s in section) is inside


def test_too_fast_is_stopped_at_the_limit():
    """At 5 kn/s the throttle is not enough; the flight ends where it is asked for more than it has."""
    found = transition(ALTITUDE_FT, Manoeuvre(80, 0, 0.4), Manoeuvre(120, 0, 0.4), JAM, Rates(tas=5))
    assert not found.possible
    assert found.limit == "throttle.upper"
    assert found.time_s == pytest.approx(found.flight["time_s"][-1])
    assert (found.flight["throttle_demand"][:-1] <= 100.01).all()
    assert found.flight["throttle_demand"][-1] > 100.01
    assert f"At {found.time_s:.1f} s the autopilot asks the throttle" in found.reason


def test_slow_surfaces_are_a_limit():
    """Ailerons left with 5 deg/s do not make the fast roll that healthy servos make."""
    stations = Manoeuvre(80, 0, 2.6), Manoeuvre(80, 0, -4)
    assert transition(ALTITUDE_FT, *stations, JAM, Rates(turn_rate=6)).possible
    slow = transition(ALTITUDE_FT, *stations, Failure(JAM, rate_limits=RateLimits(aileron_deg_s=5)), Rates(turn_rate=6))
    assert not slow.possible
    assert slow.limit.startswith("aileron_rate.")
    assert "faster than 5" in slow.reason


def test_ground_on_the_way():
    found = transition(100, Manoeuvre(110), Manoeuvre(110, -5), JAM, QUICK)
    assert (found.possible, found.limit) == (False, "altitude.lower")
    assert found.path.altitude_ft[np.searchsorted(found.path.time_s, found.time_s)] < 0


@pytest.mark.parametrize(
    ("arguments", "what"),
    [
        ({"rates": Rates(0.0)}, "positive"),
        ({"target": Manoeuvre(110, 0, 99)}, "turn rate in deg/s 99"),
        ({"altitude_ft": -1.0}, "altitude in ft -1"),
        ({"limits": Failure(throttle_left_pct=(0, 50))}, "one throttle"),
        ({"limits": Failure(configuration=Configuration(gear=1.0))}, "every other change"),
    ],
)
def test_bad_input(arguments, what):
    asked = {"altitude_ft": ALTITUDE_FT, "start": Manoeuvre(110), "target": Manoeuvre(100)}
    with pytest.raises(InputError, match=what):
        transition(**asked | arguments)


def test_program(monkeypatch, capsys, tmp_path):
    """A leg that exists and one that does not: both are told and drawn; a start that is missing is asked for."""
    asked = ["--rudder-deg", "15", "15", "--target", "100", "0", "0", "--rates", "3", "3", "3"]
    output = ["--output", str(tmp_path / "way.png")]
    monkeypatch.setattr(
        sys, "argv", ["run.py", *asked, "--start", "110", "0", "0", "--target", "60", "0", "0", *output]
    )
    assert run.main() == 3
    printed = capsys.readouterr().out
    assert "to 100.0 kn, flight path 0.0 deg and 0.0 deg/s of turn: yes" in printed
    assert "to 60.0 kn, flight path 0.0 deg and 0.0 deg/s of turn: no. There is no steady flight at" in printed
    assert (tmp_path / "way.png").read_bytes().startswith(b"\x89PNG")
    monkeypatch.setattr(sys, "argv", ["run.py", *asked, *output])
    assert run.main() == 2
    assert "give --start" in capsys.readouterr().err
