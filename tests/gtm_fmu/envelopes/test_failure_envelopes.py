"""V_min and V_max under failures of every kind: nothing beyond them in scans, unions of jams, no gain by a failure."""

from dataclasses import replace

import numpy as np
import pytest

from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.core import solver
from gtm_fmu.core.configuration import Configuration
from gtm_fmu.envelopes.envelope import FlightCondition
from gtm_fmu.units import FT_S_PER_KT, KT_PER_FT_S, RAD_PER_DEG
from tests.gtm_fmu.trims.test_failure_trims import LEFT_OUT, RIGHT_OUT, fixed, plain_accelerations

pytestmark = pytest.mark.slow

CASES = {
    "rudder off": (10000.0, 0.0, fixed(damage_case=1)),
    "vertical tail off": (20000.0, -2.0, fixed(damage_case=2)),
    "left wing tip off": (5000.0, 2.0, fixed(damage_case=4)),
    "left elevator off": (12000.0, 0.0, fixed(damage_case=5)),
    "left stabiliser off": (8000.0, 1.0, fixed(damage_case=6)),
    "left engine out": (5000.0, 0.0, fixed(engine_running=LEFT_OUT)),
    "right engine out, rudder jam": (
        5000.0,
        -2.0,
        Failure(ControlLimits(rudder_deg=(8, 8)), Configuration(engine_running=RIGHT_OUT)),
    ),
    "left engine out, left wing tip off": (3000.0, 0.0, fixed(engine_running=LEFT_OUT, damage_case=4)),
    "elevator and rudder restricted": (15000.0, 1.0, Failure(ControlLimits((-1, 2.5), rudder_deg=(5, 20)))),
    "elevator nearly jammed": (10000.0, 0.0, Failure(ControlLimits((1.98, 2.02)))),
    "aileron restricted, throttle weak": (
        10000.0,
        0.0,
        Failure(ControlLimits((-30, 30), (2, 9), (-30, 30), (20, 70))),
    ),
    "gliding": (10000.0, -7.0, fixed(engine_running=(False, False))),
    "flaps down": (2000.0, 0.0, fixed(flap_deg=(20.0,) * 4)),
}


def scanned_speeds(condition: FlightCondition, tas_kt) -> np.ndarray:
    """Speeds in kn of the cold trims inside every bound, over 2 deg of bank and of rudder."""
    lower, upper = condition.bounds
    banks = np.arange(-30.0, 30.1, 2.0) * RAD_PER_DEG
    rudders = np.unique(np.linspace(lower[7], upper[7], int((upper[7] - lower[7]) / 2) + 1))
    held = np.array(np.meshgrid(np.asarray(tas_kt) * FT_S_PER_KT, banks, rudders)).reshape(3, -1).T
    at = condition.altitude_ft, condition.gamma_deg * RAD_PER_DEG
    y = solver.cold_starts(*at, held, condition.failure.airframe)
    return y[((y >= lower - 1e-9) & (y <= upper + 1e-9)).all(axis=1), 0] * KT_PER_FT_S


@pytest.mark.parametrize("name", CASES)
def test_no_trim_of_a_dense_scan_is_beyond_the_ends(name):
    altitude_ft, gamma_deg, failure = CASES[name]
    condition = FlightCondition(altitude_ft, gamma_deg, failure)
    found = condition.envelope()
    assert found.feasible
    for end in (found.at_v_min, found.at_v_max):
        assert end.feasible
        assert end.limits_hit or name == "gliding"  # its fastest is inside the limits, where the drag makes the angle
        assert np.abs(plain_accelerations(end)).max() < 1e-9
    near = np.append(found.v_min_kt - np.geomspace(0.02, 1, 8), found.v_max_kt + np.geomspace(0.02, 1, 8))
    speeds = scanned_speeds(condition, np.append(np.arange(52.0, 190.0, 2.0), near))
    assert speeds.size > 20
    assert speeds.min() >= found.v_min_kt - 0.01
    assert speeds.max() <= found.v_max_kt + 0.01
    if name != "elevator nearly jammed":  # of which a scan meets little
        assert speeds.min() <= found.v_min_kt + 3
        assert speeds.max() >= found.v_max_kt - 3


def test_restricted_elevator_and_rudder_are_the_union_of_their_jams():
    elevators, rudders = np.linspace(-2, 2, 5), np.linspace(-5, 15, 5)
    condition = 10000.0, 0.0
    ranges = ControlLimits((elevators[0], elevators[-1]), rudder_deg=(rudders[0], rudders[-1]))
    whole = FlightCondition(*condition, ranges).envelope()
    jams = [
        FlightCondition(*condition, ControlLimits((e, e), rudder_deg=(r, r))).envelope()
        for e in elevators
        for r in rudders
    ]
    ends = np.array([(jam.v_min_kt, jam.v_max_kt) for jam in jams if jam.feasible])
    assert len(ends) > 15
    assert ends[:, 0].min() >= whole.v_min_kt - 0.005
    assert ends[:, 1].max() <= whole.v_max_kt + 0.005
    for end, speed in ((whole.at_v_min, "v_min_kt"), (whole.at_v_max, "v_max_kt")):
        jam = ControlLimits((end.elevator_deg,) * 2, rudder_deg=(end.rudder_deg,) * 2)
        at_end = FlightCondition(*condition, jam).envelope()
        assert at_end.feasible
        assert getattr(at_end, speed) == pytest.approx(getattr(whole, speed), abs=0.005)


def test_separate_throttles_are_the_union_of_their_jams():
    condition = 10000.0, 0.0
    whole = FlightCondition(*condition, Failure(throttle_left_pct=(0, 100))).envelope()
    assert whole.t_min_pct is None
    for left in (0, 25, 50, 75, 100):
        jam = FlightCondition(*condition, Failure(throttle_left_pct=(left, left))).envelope()
        assert jam.feasible
        assert whole.v_min_kt <= jam.v_min_kt + 0.005
        assert whole.v_max_kt >= jam.v_max_kt - 0.005
    at_end = Failure(throttle_left_pct=(whole.at_v_min.throttle_left_pct,) * 2)
    assert FlightCondition(*condition, at_end).envelope().v_min_kt == pytest.approx(whole.v_min_kt, abs=0.005)
    together = FlightCondition(*condition).envelope()
    assert whole.v_min_kt < together.v_min_kt - 0.05  # asymmetric thrust gives some side force
    assert whole.v_max_kt == pytest.approx(together.v_max_kt, abs=0.005)


def test_every_control_jammed_at_an_end_leaves_it():
    end = FlightCondition(10000.0, 0.0).envelope().at_v_max
    limits = ControlLimits(*((position, position) for position in end.unknowns[5:]))
    left = FlightCondition(10000.0, 0.0, limits).envelope()
    assert left.feasible
    assert left.v_max_kt == pytest.approx(end.tas_kt, abs=0.005)


def test_a_restriction_never_widens_the_envelope():
    rng = np.random.default_rng(20)
    settings = [Configuration(), Configuration(damage_case=5), Configuration(engine_running=LEFT_OUT)]
    feasible = 0
    for trial in range(24):
        condition = rng.uniform(0, 20000), rng.uniform(-4, 2)
        failure = Failure(configuration=settings[trial % 3])
        ends = None
        for _ in range(3):
            found = FlightCondition(*condition, failure).envelope()
            if ends is not None and found.feasible:
                assert ends[0] is not None, "a restriction made a trim"
                assert found.v_min_kt >= ends[0] - 0.005
                assert found.v_max_kt <= ends[1] + 0.005
            ends = found.v_min_kt, found.v_max_kt
            feasible += found.feasible
            limits = failure.limits
            for name in rng.choice(["elevator_deg", "aileron_deg", "rudder_deg", "throttle_pct"], 2, replace=False):
                low, high = getattr(limits, name)
                limits = replace(limits, **{name: tuple(np.sort(low + (high - low) * rng.beta(0.6, 0.6, 2)))})
            failure = replace(failure, limits=limits)
    assert feasible > 30


def test_engines_that_are_the_same_but_for_their_side():
    """The airframe is nearly symmetric: V_min and V_max without the left engine are near those without the right."""
    left, right = (
        FlightCondition(5000.0, 0.0, fixed(engine_running=running)).envelope() for running in (LEFT_OUT, RIGHT_OUT)
    )
    assert left.v_min_kt == pytest.approx(right.v_min_kt, abs=0.5)
    assert left.v_max_kt == pytest.approx(right.v_max_kt, abs=1.5)
    both = FlightCondition(5000.0, 0.0).envelope()
    assert both.v_max_kt > left.v_max_kt + 20
    np.testing.assert_allclose(left.at_v_min.rudder_deg, -right.at_v_min.rudder_deg, atol=8)
