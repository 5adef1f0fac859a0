"""What a failure leaves of each control, and what is told about wrong limits."""

from dataclasses import FrozenInstanceError

import numpy as np
import pytest

from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.aircraft.ranges import WIDEST
from gtm_fmu.errors import InputError

NAMES = tuple(WIDEST)


def test_the_undamaged_aircraft_has_the_limits_of_the_study():
    """SPEC 9: elevator +-30, aileron +-20, rudder +-30 deg, throttle 0..100 %."""
    limits = ControlLimits()
    np.testing.assert_array_equal(limits.lower, [-30, -20, -30, 0])
    np.testing.assert_array_equal(limits.upper, [30, 20, 30, 100])
    assert limits.jammed == (False, False, False, False)


@pytest.mark.parametrize("name", NAMES)
def test_equal_limits_are_a_jam(name):
    limits = ControlLimits(**{name: (5, 5)})
    k = NAMES.index(name)
    assert limits.lower[k] == limits.upper[k] == 5
    assert limits.jammed == tuple(other == name for other in NAMES)


def test_limits_are_kept_as_floats_and_cannot_change():
    limits = ControlLimits(rudder_deg=[np.int64(-10), "20"])
    assert limits == ControlLimits(rudder_deg=(-10.0, 20.0))
    assert all(type(limit) is float for limit in limits.rudder_deg)
    with pytest.raises(FrozenInstanceError):
        limits.rudder_deg = (0, 0)


@pytest.mark.parametrize("name", NAMES)
def test_the_whole_range_and_its_ends_are_allowed(name):
    lower, upper = WIDEST[name]
    for pair in ((lower, upper), (lower, lower), (upper, upper)):
        assert getattr(ControlLimits(**{name: pair}), name) == pair


@pytest.mark.parametrize(
    ("pair", "complaint"),
    [
        ((20, 10), "limits 20 10 are reversed; give the lower one first"),
        ((float("nan"), 0), "limits nan 0 are not finite; give two numbers"),
        ((0, float("nan")), "limits 0 nan are not finite"),
        ((0, float("inf")), "limits 0 inf are not finite"),
        ((float("-inf"), 0), "limits -inf 0 are not finite"),
        (("low", 10), "give two numbers, lower and upper limit"),
        ((None, 10), "give two numbers"),
        (None, "give two numbers"),
        (10, "give two numbers"),
        ((1, 2, 3), "give two numbers"),
        ("12", "give two numbers"),
        (b"12", "give two numbers"),
        ((), "give two numbers"),
    ],
)
@pytest.mark.parametrize("name", NAMES)
def test_wrong_limits(name, pair, complaint):
    with pytest.raises(InputError, match=complaint) as told:
        ControlLimits(**{name: pair})
    assert_one_sentence_about(name, told)


@pytest.mark.parametrize("name", NAMES)
def test_a_failure_only_takes_range_away(name):
    lower, upper = WIDEST[name]
    for pair in ((lower - 0.001, upper), (lower, upper + 0.001), (upper + 1, upper + 1), (lower - 2, lower - 1)):
        with pytest.raises(InputError, match=f"are outside {lower:g} .. {upper:g}; a failure can only take") as told:
            ControlLimits(**{name: pair})
        assert_one_sentence_about(name, told)


def assert_one_sentence_about(name, told):
    control, unit = name.replace("pct", "%").split("_")
    message = str(told.value)
    assert message.startswith(f"{control} in {unit}: ")
    assert message.endswith(".")
    assert "\n" not in message
