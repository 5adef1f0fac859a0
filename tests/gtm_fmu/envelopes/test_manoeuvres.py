"""Can this be flown: answers, remedies and sections against trims, closed forms and the study's symmetry."""

import numpy as np
import pytest

from gtm_fmu import (
    ControlLimits,
    Failure,
    InputError,
    climb_interval,
    envelope,
    manoeuvres,
    remedies,
    speed_interval,
    trim,
    turn_rate_interval,
)
from gtm_fmu.core.configuration import Configuration

JAM = ControlLimits(rudder_deg=(10, 10))
GRAVITY_FT_S2, FT_S_PER_KT = 32.17, 1 / 0.592487


def test_answers_are_those_of_trims():
    found = manoeuvres(10000, [118.5, 90, 200, 40], 0, [0, 8, 0, 0], JAM)
    assert found.feasible.tolist() == [True, False, False, False]
    assert found.is_trimmed.tolist() == [True, True, True, False]
    alone = trim(10000, 118.5, 0, 0, JAM)
    for name in ("alpha_deg", "beta_deg", "phi_deg", "elevator_deg", "aileron_deg", "throttle_pct"):
        assert getattr(found.trim(0), name) == pytest.approx(getattr(alone, name), abs=1e-9)
    margins = found.margins(0)
    assert margins["phi_deg"] == pytest.approx((alone.phi_deg + 30, 30 - alone.phi_deg), abs=1e-12)
    assert margins["throttle_pct"] == pytest.approx((alone.throttle_pct, 100 - alone.throttle_pct), abs=1e-12)
    assert "rudder_deg" not in margins  # it is jammed
    assert found.binding[0] == "phi.upper"
    assert found.margins(3) == {}
    assert found.trim(3) is None
    assert found.to_dict(3)["binding"] is None


def test_a_steady_turn_has_its_closed_form():
    """Without sideslip tan phi = V psi_dot / g, but for the angle of attack."""
    found = manoeuvres(5000, 100, 0, [-6, -3, 3, 6]).answers["y"]
    bank = np.arctan(100 * FT_S_PER_KT * np.radians([-6, -3, 3, 6]) / GRAVITY_FT_S2)
    np.testing.assert_allclose(found[:, 4], bank, atol=np.radians(0.4))
    np.testing.assert_allclose(found[:, 2], 0, atol=1e-12)


def test_each_manoeuvre_may_have_a_failure_of_its_own():
    failures = [JAM, Failure(), Failure(configuration=Configuration(damage_case=2)), JAM]
    together = manoeuvres(8000, [80, 100, 110, 120], 0, 1, failures)
    for k, failure in enumerate(failures):
        alone = manoeuvres(8000, [80, 100, 110, 120][k], 0, 1, failure)
        assert together.answers[k].tobytes() == alone.answers[0].tobytes()


def test_nothing_asked_is_nothing_answered():
    assert len(manoeuvres([], [])) == 0


@pytest.mark.parametrize(
    ("asked", "sentence"),
    [
        (([1000], [20, 30, 40], [0, 1]), "do not fit together"),
        ((40000, 100), "altitude in ft"),
        ((1000, 1000), "tas in kn"),
        ((1000, "fast"), "no array of numbers"),
        ((1000, [100, 110], 0, 0, [JAM]), "2 manoeuvres but 1 failures"),
    ],
)
def test_what_cannot_be_asked_is_said(asked, sentence):
    with pytest.raises(InputError, match=sentence):
        manoeuvres(*asked)


@pytest.mark.parametrize("limits", [JAM, ControlLimits(rudder_deg=(-5, 10), throttle_pct=(0, 60))], ids=str)
def test_a_remedy_is_just_enough(limits):
    """With the limit moved as far as is said the manoeuvre is feasible, a little less far it is not."""
    rng = np.random.default_rng(3)
    checked = 0
    for altitude, tas, gamma, rate in rng.uniform((0, 70, -4, -9), (15000, 140, 6, 9), (25, 4)).tolist():
        found = manoeuvres(altitude, tas, gamma, rate, limits)
        for remedy in remedies(found, 0):
            control, side = remedy.name.split(".")
            if remedy.needed > 100 or control in ("alpha", "phi"):
                continue
            label = f"{control}_{'pct' if control == 'throttle' else 'deg'}"
            pair = list(getattr(limits, label))
            for short, is_enough in ((1e-6, True), (-1e-3, False)):
                pair[side == "upper"] = remedy.needed + short * np.sign(remedy.move)
                moved = Failure(limits).with_limits(label, tuple(pair))
                assert manoeuvres(altitude, tas, gamma, rate, moved).feasible[0] == is_enough, remedy
            checked += 1
    assert checked > 5


def test_remedies_of_bank_throttle_and_nothing():
    """A turn that needs 41.7 deg of bank; speeds that no limit alone allows; nothing to remedy; no trim at all."""
    found = manoeuvres(10000, [90, 200, 118.5, 30], 0, [8, 0, 0, 0], JAM)
    needs_bank = remedies(found, 0)
    assert [remedy.name for remedy in needs_bank] == ["phi.upper", "rudder.lower"]
    steeper = manoeuvres(10000, 90, 0, 8, JAM, phi_deg=(-30, needs_bank[0].needed + 1e-6))
    assert steeper.feasible[0]
    assert remedies(found, 1) == remedies(found, 2) == remedies(found, 3) == ()


def test_sections_meet_the_envelope():
    """At V_min and V_max of the envelope the section of speed at their turn rates ends."""
    whole = envelope(10000, 0, JAM)
    for end, rate, place in (("v_min_kt", whole.at_v_min, 0), ("v_max_kt", whole.at_v_max, 1)):
        section = speed_interval(10000, 0, rate.turn_rate_deg_s, JAM)
        assert section.intervals[-place][place] == pytest.approx(getattr(whole, end), abs=1e-3)


def test_sections_cross_where_they_should():
    """The end of one section is an end of the others through it."""
    turns = turn_rate_interval(10000, 100, 2, JAM)
    rate = turns.intervals[0][1]
    speeds = speed_interval(10000, 2, rate, JAM)
    assert np.abs(np.array(speeds.intervals) - 100).min() < 0.01
    paths = climb_interval(10000, 100, 0, JAM)
    top = paths.intervals[0][1]
    assert np.abs(np.array(speed_interval(10000, top, 0, JAM).intervals) - 100).min() < 0.01
    assert 0 in turns
    assert rate + 1 not in turns
    assert "throttle.upper" in paths.trims[0][1].limits_hit


def test_the_healthy_aircraft_turns_nearly_alike_to_either_side():
    """Its centre of gravity lies 0.0118 ft off the plane of symmetry, and its engines are toed apart."""
    ((low, high),) = turn_rate_interval(5000, 90).intervals
    assert -low == pytest.approx(high, rel=0.1)


def test_sections_refuse_what_is_outside():
    with pytest.raises(InputError, match="tas in kn"):
        turn_rate_interval(5000, 900)
    with pytest.raises(InputError, match="turn rate in deg/s"):
        climb_interval(5000, 90, 100)
