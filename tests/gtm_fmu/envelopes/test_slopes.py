"""Slopes of envelopes: against the atmosphere, wider differences, envelopes solved anew; kinks, jumps, no envelope."""

from dataclasses import replace

import numpy as np
import pytest

from gtm_fmu import envelope
from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.core.configuration import Configuration
from gtm_fmu.envelopes.slopes import EnvelopeSlopes, QuantitySlopes, envelope_slopes
from gtm_fmu.errors import InputError

LIMITED = ControlLimits(rudder_deg=(5, 25))
AT = (10000.0, -5.0)


@pytest.fixture(scope="module")
def restricted() -> EnvelopeSlopes:
    return envelope_slopes(*AT, LIMITED)


def of(found: EnvelopeSlopes, name: str) -> QuantitySlopes:
    return next(slopes for slopes in found.slopes if slopes.quantity.name == name)


def test_altitude_moves_v_min_as_the_density_does():
    """At its largest angle of attack the aircraft is lifted by one equivalent airspeed, so V goes with density^-1/2.

    In the standard atmosphere density goes with T^4.2559 and T falls by 0.0019812 K/ft from 288.15 K.
    """
    found = envelope_slopes(10000, 0, ControlLimits(rudder_deg=(-10, 20)))
    assert found.envelope.at_v_min.limits_hit == ("alpha.upper",)
    expected = found.envelope.v_min_kt * 0.5 * 4.2559 * 0.0019812 / (288.15 - 0.0019812 * 10000)
    altitude = of(found, "altitude")
    assert altitude.v_min == pytest.approx((expected, expected), rel=0.01)
    assert altitude.kinks == altitude.jumps == ()


@pytest.mark.parametrize(
    ("name", "step", "moved"),
    [
        ("altitude", 200.0, lambda d: envelope(AT[0] + d, AT[1], LIMITED)),
        ("gamma", 0.2, lambda d: envelope(AT[0], AT[1] + d, LIMITED)),
        ("rudder.lower", 0.2, lambda d: envelope(*AT, ControlLimits(rudder_deg=(5 + d, 25)))),
        ("rudder.upper", 0.2, lambda d: envelope(*AT, ControlLimits(rudder_deg=(5, 25 + d)))),
    ],
)
def test_slopes_are_those_of_wider_differences(restricted, name, step, moved):
    low, high, found = moved(-step), moved(step), of(restricted, name)
    for end, sides in (("v_min_kt", found.v_min), ("v_max_kt", found.v_max)):
        expected = (getattr(high, end) - getattr(low, end)) / (2 * step)
        assert sides == pytest.approx((expected, expected), rel=0.01, abs=2e-6)


def test_what_the_next_degree_costs(restricted):
    """The exact envelopes of limits moved inwards; altitude and flight path move both ways."""
    (lost,) = of(restricted, "rudder.lower").changes
    found = envelope(*AT, ControlLimits(rudder_deg=(6, 25)))
    assert (lost.to, lost.v_min_kt, lost.v_max_kt) == pytest.approx((6.0, found.v_min_kt, found.v_max_kt), abs=0.001)
    down, up = of(restricted, "altitude").changes
    assert (down.to, up.to) == (9000.0, 11000.0)
    assert up.v_min_kt == pytest.approx(envelope(11000, -5, LIMITED).v_min_kt, abs=0.001)
    assert [change.to for change in of(restricted, "gamma").changes] == [-6.0, -4.0]


@pytest.mark.parametrize(
    "failure",
    [
        Failure(ControlLimits(elevator_deg=(0, 3), aileron_deg=(-4, 1), rudder_deg=(-3, 30), throttle_pct=(0, 70))),
        Failure(ControlLimits(rudder_deg=(-12, 4)), Configuration(engine_running=(False, True))),
        Failure(ControlLimits(rudder_deg=(3, 3)), Configuration(damage_case=4), (0, 60), (0, 100)),
    ],
)
def test_every_cost_is_that_of_an_envelope_solved_anew(failure):
    """Also those that are not solved, since both ends keep the limit that moves."""
    found = envelope_slopes(3000, 0, failure)
    assert found.envelope.feasible
    moved = 0
    for slopes in found.slopes:
        if slopes.quantity.name.partition(".")[2] == "":
            continue
        (lost,) = slopes.changes
        label = slopes.quantity.label
        low, high = getattr(failure, label, None) or getattr(failure.limits, label)
        pair = (lost.to, high) if slopes.quantity.name.endswith("lower") else (low, lost.to)
        expected = envelope(3000, 0, failure.with_limits(label, pair))
        assert (lost.v_min_kt, lost.v_max_kt) == pytest.approx((expected.v_min_kt, expected.v_max_kt), abs=0.001)
        moved += expected.v_max_kt != found.envelope.v_max_kt or expected.v_min_kt != found.envelope.v_min_kt
    assert moved


def test_each_control_once():
    """A jam is one quantity; what moves nothing is none; engines apart have a throttle each."""

    def names(failure: Failure) -> list[str]:
        return [slopes.quantity.name for slopes in envelope_slopes(3000, 0, failure).slopes][2:]

    sides = ("lower", "upper")
    surfaces = [f"{control}.{side}" for control in ("elevator", "aileron") for side in sides]
    throttle = [f"throttle.{side}" for side in sides]
    assert names(Failure(ControlLimits(rudder_deg=(5, 5)))) == [*surfaces, "rudder", *throttle]
    assert names(Failure(configuration=Configuration(damage_case=1))) == [*surfaces, *throttle]  # the rudder is off
    one = Failure(ControlLimits(rudder_deg=(-5, 5)), Configuration(engine_running=(True, False)), (0, 90))
    found = envelope_slopes(3000, 0, one)
    assert of(found, "throttle.upper").quantity.value == 90.0
    apart = [f"throttle_{side}.{end}" for side in ("left", "right") for end in sides]
    assert names(Failure(ControlLimits(rudder_deg=(5, 5)), throttle_left_pct=(0, 80))) == [*surfaces, "rudder", *apart]


def test_at_an_end_of_its_range_a_quantity_moves_one_way():
    found = envelope_slopes(0, 0)
    assert of(found, "altitude").v_min.below is None
    assert of(found, "altitude").v_min.above > 0
    assert [change.to for change in of(found, "altitude").changes] == [1000.0]
    assert of(found, "elevator.upper").v_max.above is None


def test_a_kink():
    """The elevator's tables have a breakpoint at 0 deg, where it holds the slowest flight."""
    found = of(envelope_slopes(10000, 0, ControlLimits(rudder_deg=(-10, 10), elevator_deg=(0, 3))), "elevator.lower")
    assert found.kinks == ("v_min",)
    step = 0.05
    speeds = [
        envelope(10000, 0, ControlLimits(rudder_deg=(-10, 10), elevator_deg=(low, 3))).v_min_kt
        for low in (-step, 0.0, step)
    ]
    assert found.v_min == pytest.approx(np.diff(speeds) / step, rel=0.02)
    assert found.v_min.below > found.v_min.above + 0.4


def test_a_jump():
    """At 30 000 ft and 1 deg V_max falls by 10.4 kn where the jam passes -1.20896 deg, at a fold of the drag."""
    found = of(envelope_slopes(30000, 1, ControlLimits(rudder_deg=(-1.2085, -1.2085))), "rudder")
    assert found.jumps == ("v_max.below",)
    assert found.v_max.below is None
    assert abs(found.v_max.above) < 10
    assert None not in found.v_min
    (below, _) = found.changes
    assert below.v_max_kt > envelope(30000, 1, ControlLimits(rudder_deg=(-1.2085, -1.2085))).v_max_kt + 10


class TestNoEnvelope:
    FAILURE = Failure(ControlLimits(rudder_deg=(20, 30)))

    def test_what_would_bring_one_back(self):
        """Just there an envelope exists; a little nearer to where it is, none does."""
        found = envelope_slopes(30000, 2, self.FAILURE)
        assert not found.envelope.feasible
        assert found.slopes == ()
        remedies = {quantity.name: value for quantity, value in found.remedies}
        assert list(remedies) == ["altitude", "gamma", "rudder.lower"]
        for name, nearer in (("altitude", 20.0), ("gamma", 0.02), ("rudder.lower", 0.02)):
            at = {"altitude": 30000.0, "gamma": 2.0, "rudder.lower": 20.0}
            for value, exists in ((remedies[name], True), (remedies[name] + nearer, False)):
                moved = at | {name: value}
                limits = ControlLimits(rudder_deg=(moved["rudder.lower"], 30))
                assert envelope(moved["altitude"], moved["gamma"], limits).feasible == exists

    def test_nothing_alone(self):
        """Without engines no altitude or limit helps, only a descent."""
        glider = replace(self.FAILURE, configuration=Configuration(engine_running=(False, False)))
        found = envelope_slopes(30000, 2, glider)
        assert {quantity.name for quantity, _ in found.remedies} <= {"gamma"}


def test_what_is_outside():
    with pytest.raises(InputError, match="altitude in ft"):
        envelope_slopes(-1, 0)
