"""Slopes by multipliers: against differences of exact solutions, the atmosphere, and advice's own differences."""

import math

import numpy as np
import pytest

from gtm_fmu import ControlLimits, Envelope, Failure, envelope, envelope_slopes
from gtm_fmu.core.configuration import Configuration
from gtm_fmu.envelopes.multipliers import Sides, Slope
from tests.reference.slope_differences import compared

JAM = ControlLimits(rudder_deg=(-7.3, -7.3))
CASES = {
    "jam": (12000.0, -1.0, JAM),
    "jam on a breakpoint": (10000.0, -5.0, ControlLimits(rudder_deg=(10, 10))),
    "two jams": (3000.0, 1.0, ControlLimits(rudder_deg=(4, 4), elevator_deg=(2.2, 2.2))),
    "restricted": (5000.0, 0.0, ControlLimits(rudder_deg=(6, 8), aileron_deg=(-12, 3), throttle_pct=(20, 70))),
    "engines apart": (4000.0, 0.0, Failure(ControlLimits(rudder_deg=(12, 12)), throttle_left_pct=(0, 60))),
    "damaged": (2000.0, 0.0, Failure(JAM, Configuration(damage_case=5, fuel_used_lb=3.0))),
}


def of(found: Envelope, name: str) -> Slope:
    return next(slope for slope in found.slopes if slope.name == name)


@pytest.mark.parametrize("case", CASES)
def test_against_differences_of_exact_solutions(case):
    comparisons = list(compared(envelope(*CASES[case])))
    assert len(comparisons) > 20
    assert [each for each in comparisons if not each.agrees] == []


def test_a_jam_on_a_breakpoint_has_two_slopes():
    """The differences of advice say the same of both sides."""
    found = of(envelope(*CASES["jam on a breakpoint"]), "rudder")
    assert found.kinks == ("v_min", "v_max")
    every = envelope_slopes(*CASES["jam on a breakpoint"]).slopes
    proved = next(each for each in every if each.quantity.name == "rudder")
    for ours, theirs in ((found.v_min, proved.v_min), (found.v_max, proved.v_max)):
        assert ours == pytest.approx(theirs, rel=1e-4)


def test_altitude_moves_v_min_as_the_density_does():
    """V goes with density^-1/2 at the largest angle of attack.

    T falls by 0.0019812 K/ft from 288.15 K, and density goes with T^4.2559.
    """
    found = envelope(10000, 0, ControlLimits(rudder_deg=(-10, 20)))
    expected = 1000 * found.v_min_kt * 0.5 * 4.2559 * 0.0019812 / (288.15 - 0.0019812 * 10000)
    altitude = of(found, "altitude")
    assert altitude.units == "kn/1000 ft"
    assert altitude.v_min == pytest.approx((expected, expected), rel=0.01)


def test_weight_moves_v_min_as_lift_does():
    """At the largest angle of attack V goes with the root of the weight, 57.75 lb; the thrust carries a share of it."""
    found = envelope(10000, 0, ControlLimits(rudder_deg=(0, 0)))
    fuel = of(found, "fuel_used")
    assert fuel.units == "kn/lb"
    assert fuel.v_min.above == pytest.approx(-found.v_min_kt / 2 / 57.75, rel=0.2)
    assert fuel.v_min.below is None  # no fuel is used yet


def test_a_limit_that_nothing_touches_is_free_and_one_at_its_widest_moves_inwards_only():
    found = envelope(*CASES["jam"])
    assert of(found, "elevator.upper").v_max == Sides(0.0, None)
    throttle = of(found, "throttle.upper").v_max
    assert throttle.above is None
    assert throttle.below > 0.1


def test_without_an_envelope_there_are_none():
    assert envelope(35000, 5, ControlLimits(rudder_deg=(28, 28))).slopes == ()


def test_bounds_of_the_angles():
    narrow, wider = (envelope(10000, 0, JAM, alpha_deg=(-5, upper)) for upper in (8.0, 8.001))
    expected = (wider.v_min_kt - narrow.v_min_kt) / 0.001
    assert of(narrow, "alpha.upper").v_min.above == pytest.approx(expected, rel=1e-3)
    assert expected < -1


def test_in_json():
    slope = of(envelope(*CASES["jam on a breakpoint"]), "rudder").to_dict()
    assert slope["units"] == "kn/deg"
    assert slope["kinks"] == ["v_min", "v_max"]
    assert all(math.isfinite(slope[end][side]) for end in ("v_min", "v_max") for side in ("below", "above"))
    assert np.sign(slope["v_max"]["above"]) == -1  # more of a jam costs speed
