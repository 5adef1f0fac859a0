"""Partial derivatives of the native envelope FMUs against differences of the FMU itself."""

import math

import numpy as np
import pytest

from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.core.configuration import Configuration
from gtm_fmu.envelopes.envelope import envelope
from tests.fmu_src.native_session import OK

pytestmark = pytest.mark.slow

FT, DEG, LB = 0.3048, math.pi / 180, 0.45359237
KN = 0.3048 / 0.592487  # SPEC 1
OUTPUTS = ("v_min", "v_max", "margin.slow", "margin.fast")
STEPS = {"altitude": 1.0, "tas": 0.1, "fuel.used": 1e-3}
KNOWNS = (
    *("altitude", "gamma", "rudder.lower", "rudder.upper", "tas", "limits.elevator.upper", "limits.aileron.lower"),
    *("limits.throttle.upper", "limits.alpha.upper", "limits.bank.lower"),
    *("stabilizer.setting", "control.flaps", "control.spoilers", "fuel.used"),
)
CASE = {
    **{"altitude": 2000.0, "gamma": -0.03, "tas": 55.0, "rudder.lower": 4 * DEG, "rudder.upper": 6 * DEG},
    **{"limits.throttle.upper": 0.8, "limits.alpha.upper": 8.7 * DEG},
    **{"stabilizer.setting": 0.5 * DEG, "control.flaps": 3 * DEG, "control.spoilers": 2 * DEG, "fuel.used": 1.0},
}


@pytest.fixture
def asked(envelope_session):
    session = envelope_session("cs")
    assert session.set([session.names[name] for name in CASE], list(CASE.values())) == OK
    return session


def outputs(session) -> np.ndarray:
    status, values = session.get([session.names[name] for name in OUTPUTS])
    assert status == OK
    return np.array(values)


def slopes_over(session, known: str) -> list[float]:
    status, slopes = session.directional([session.names[name] for name in OUTPUTS], [session.names[known]], [1.0])
    assert status == OK
    return slopes


@pytest.mark.parametrize("known", KNOWNS)
def test_against_differences(asked, known):
    """Upper limits move inwards: some are at their widest."""
    reference = [asked.names[known]]
    slopes, here = slopes_over(asked, known), outputs(asked)
    (value,) = asked.get(reference)[1]
    step = STEPS.get(known, 1e-5) * (-1 if known.endswith("upper") else 1)
    quotients = []
    for part in (0.5, 1.0):
        assert asked.set(reference, [value + part * step]) == OK
        quotients.append((outputs(asked) - here) / (part * step))
    np.testing.assert_allclose(slopes, 2 * quotients[0] - quotients[1], rtol=1e-3, atol=1e-6 / abs(step))


def test_against_the_multipliers_in_python(asked):
    """In kn per deg, % and lb there; the FMU is in SI."""
    limits = ControlLimits(rudder_deg=(4, 6), throttle_pct=(0, 80))
    airframe = Configuration(stabilizer_deg=0.5, flap_deg=(3.0,) * 4, spoiler_deg=(2.0,) * 4, fuel_used_lb=1 / LB)
    found = envelope(2000 / FT, -0.03 / DEG, Failure(limits, airframe), alpha_deg=(-5, 8.7))
    slopes = {slope.name: slope for slope in found.slopes}
    for theirs, ours, unit in (
        ("altitude", "altitude", 1000 * FT),
        ("rudder.lower", "rudder.lower", DEG),
        ("limits.throttle.upper", "throttle.upper", 0.01),
        ("limits.alpha.upper", "alpha.upper", DEG),
        ("fuel.used", "fuel_used", LB),
    ):
        expected = [slopes[ours].v_min.above * KN / unit, slopes[ours].v_max.above * KN / unit]
        np.testing.assert_allclose(slopes_over(asked, theirs)[:2], expected, rtol=1e-6, atol=1e-7)


def test_a_jam_moves_by_both_limits(asked):
    """Together they are the slope of its position."""
    names = [asked.names[f"rudder.{end}"] for end in ("lower", "upper")]
    ends = []
    for jam in (4 * DEG, 4 * DEG + 1e-5):
        asked.set(names, [jam, jam])
        ends.append(outputs(asked))
    asked.set(names, [4 * DEG, 4 * DEG])
    status, slopes = asked.directional([asked.names[name] for name in OUTPUTS], names, [1.0, 1.0])
    assert status == OK
    np.testing.assert_allclose(slopes, (ends[1] - ends[0]) / 1e-5, rtol=2e-3, atol=0.02)


def test_without_an_envelope_they_are_zero(asked):
    asked.set([asked.names[name] for name in ("altitude", "gamma")], [10900.0, 0.08])
    assert outputs(asked)[:2].tolist() == [0, 0]
    assert slopes_over(asked, "altitude") == [0, 0, 0, 0]
    assert slopes_over(asked, "tas") == [0, 0, 1, -1]
