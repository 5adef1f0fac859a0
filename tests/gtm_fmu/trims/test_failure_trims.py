"""Trims and linear models under every kind of failure, against the plain model of any configuration."""

from dataclasses import replace

import numpy as np
import pytest

from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.limits import ControlLimits, RateLimits
from gtm_fmu.core.configuration import Configuration, derivatives
from gtm_fmu.core.solver import dead_controls
from gtm_fmu.envelopes.envelope import FlightCondition
from gtm_fmu.envelopes.grid import envelope_grid
from gtm_fmu.errors import InputError
from gtm_fmu.trims import steady
from gtm_fmu.trims.linearization import linearize
from gtm_fmu.trims.manoeuvre import Trim
from tests.reference import plain_configuration

pytestmark = pytest.mark.slow

LEFT_OUT, RIGHT_OUT, BOTH_OUT = (False, True), (True, False), (False, False)


def fixed(**values) -> Failure:
    return Failure(configuration=Configuration(**values))


FAILURES = {
    **{f"damage case {n}": fixed(damage_case=n) for n in range(1, 7)},
    "left engine out": fixed(engine_running=LEFT_OUT),
    "right engine out": fixed(engine_running=RIGHT_OUT),
    "left engine and rudder out": fixed(engine_running=LEFT_OUT, damage_case=1),
    "right engine and left wing tip out": fixed(engine_running=RIGHT_OUT, damage_case=4),
    "stabiliser set": fixed(stabilizer_deg=-4.0),
    "flaps": fixed(flap_deg=(10.0, 12.0, 14.0, 16.0)),
    "spoilers": fixed(spoiler_deg=(5.0, 20.0, 10.0, 15.0)),
    "gear down, fuel used": fixed(gear=1.0, fuel_used_lb=7.0),
    "a left aileron jammed, half a right one": fixed(
        surface_gain=(1, 1, 1, 1, 0, 0.5, 1, 1), surface_offset_deg=(0, 0, 0, 0, 4.0, 1.0, 0, 0)
    ),
    "upper rudder jammed, elevator segment lost": fixed(
        surface_gain=(0, 1, 1, 1, 1, 1, 0, 1), surface_offset_deg=(0, 0, 0, 0, 0, 0, 6.0, 0)
    ),
    "aileron jam": Failure(ControlLimits(aileron_deg=(3, 3))),
    "throttle jam": Failure(ControlLimits(throttle_pct=(60, 60))),
    "rudder jam, tail damaged": Failure(ControlLimits(rudder_deg=(6, 6)), Configuration(damage_case=6)),
    "separate throttles": Failure(throttle_left_pct=(0, 100)),
    "left throttle jam": Failure(throttle_left_pct=(30, 30)),
    "left throttle weak, rudder jam": Failure(ControlLimits(rudder_deg=(-4, -4)), throttle_left_pct=(0, 25)),
    "separate throttles, no rudder": Failure(configuration=Configuration(damage_case=2), throttle_right_pct=(0, 40)),
}
CONDITIONS = [(10000.0, 100.0, 0.0, 0.0), (3000.0, 118.0, -2.0, 4.0), (15000.0, 110.0, 1.0, -3.0)]


def plain_state_and_configuration(trim: Trim):
    """State and configuration of the plain model at a trim."""
    x, u = trim.state_and_controls
    c = trim.configuration or Configuration()
    bus = plain_configuration.allocated([*u[:3], 0.0])
    for k, name in enumerate(plain_configuration.SIGNALS[:8]):
        bus[name] = c.surface_gain[k] * bus[name] + c.surface_offset_deg[k]
    bus |= dict(zip(plain_configuration.SIGNALS[8:16], (*c.spoiler_deg, *c.flap_deg), strict=True))
    bus |= {"STAB": c.stabilizer_deg, "GEAR": c.gear, "THROTL": u[3], "THROTR": u[-1]}
    plain = plain_configuration.Configuration(
        bus, fuel_used=c.fuel_used_lb, damage_case=c.damage_case, engines_on=c.engine_running
    )
    return x, plain


def plain_accelerations(trim: Trim):
    return plain_configuration.derivatives(*plain_state_and_configuration(trim))[:6]


@pytest.mark.parametrize("name", FAILURES)
def test_trims_hold_still_in_the_plain_model(name):
    failure, found = FAILURES[name], 0
    for altitude_ft, tas_kt, gamma_deg, turn_rate_deg_s in CONDITIONS:
        trim = steady.trim(altitude_ft, tas_kt, gamma_deg, turn_rate_deg_s, failure)
        if not trim.feasible:
            continue
        found += 1
        assert np.abs(plain_accelerations(trim)).max() < 1e-9
        x, plain = plain_state_and_configuration(trim)
        dx, V = plain_configuration.derivatives(x, plain), np.linalg.norm(x[:3])
        assert pytest.approx(tas_kt, rel=1e-12) == V * 0.592487
        assert np.degrees(np.arcsin(dx[8] / V)) == pytest.approx(gamma_deg, abs=1e-9)
        np.testing.assert_allclose(np.degrees(dx[9:]), [0, 0, turn_rate_deg_s], atol=1e-9)
        controls = trim.unknowns[5:]
        assert ((controls >= failure.lower - 1e-6) & (controls <= failure.upper + 1e-6)).all()
    assert found >= 2


@pytest.mark.parametrize("name", FAILURES)
def test_many_trims_are_the_single_ones(name):
    failure = FAILURES[name]
    altitude_ft, tas_kt, gamma_deg, turn_rate_deg_s = np.transpose(CONDITIONS)
    many = steady.trims(altitude_ft, tas_kt, gamma_deg, turn_rate_deg_s, failure)
    for k, condition in enumerate(CONDITIONS):
        one = steady.trim(*condition, failure)
        assert (many.status[k] == 0) == one.feasible
        if one.feasible:
            np.testing.assert_allclose(many.y[k], one.unknowns, atol=1e-7)


def test_least_sideslip_over_both_throttles():
    """A rudder jam is met by thrust where that helps: no point of a scan over the left throttle has less sideslip."""
    limits = ControlLimits(rudder_deg=(12, 12))
    least = abs(steady.trim(10000, 100, 0, 0, Failure(limits, throttle_left_pct=(0, 100))).beta_deg)
    scanned = [
        steady.trim(10000, 100, 0, 0, Failure(limits, throttle_left_pct=(t, t))) for t in np.linspace(0, 100, 51)
    ]
    slips = [abs(trim.beta_deg) for trim in scanned if trim.feasible]
    assert len(slips) > 20
    assert least <= min(slips) + 1e-6
    assert least > min(slips) - 0.2
    assert least < abs(steady.trim(10000, 100, 0, 0, limits).beta_deg) - 1


def test_separate_throttles_stay_together_where_they_can():
    together = steady.trim(10000, 100, 0, 0)
    apart = steady.trim(10000, 100, 0, 0, Failure(throttle_left_pct=(0, 100), throttle_right_pct=(0, 100)))
    assert apart.throttle_pct is None
    assert apart.throttle_left_pct == pytest.approx(together.throttle_pct, abs=1e-9)
    assert apart.throttle_right_pct == pytest.approx(together.throttle_pct, abs=1e-9)
    weak = steady.trim(10000, 100, 0, 0, Failure(throttle_left_pct=(0, 20)))
    assert weak.beta_deg == pytest.approx(0, abs=1e-7)
    assert weak.throttle_left_pct == pytest.approx(20, abs=1e-6)


OVERDETERMINED = {
    "elevator and rudder jammed": ControlLimits(elevator_deg=(3, 3), rudder_deg=(0, 0)),
    "elevator and aileron jammed": ControlLimits(elevator_deg=(3, 3), aileron_deg=(1, 1)),
    "elevator far away": ControlLimits(elevator_deg=(-25, -25)),
    "all jammed": ControlLimits((1, 1), (0, 0), (0, 0), (50, 50)),
    "all separate jammed": Failure(ControlLimits((1, 1), (0, 0), (0, 0)), throttle_left_pct=(40, 40)),
    "no engine": fixed(engine_running=BOTH_OUT),
    "no engine, no rudder": fixed(engine_running=BOTH_OUT, damage_case=2),
    "nothing moves": fixed(surface_gain=(0,) * 8, engine_running=BOTH_OUT),
    "no elevator and no aileron": fixed(surface_gain=(0,) * 6 + (1, 1)),
}


@pytest.mark.parametrize("name", OVERDETERMINED)
def test_impossible_trims_are_told(name):
    """Speed and turn rate are given, so that jams leave nothing; what comes back is not called a trim."""
    trim = steady.trim(10000, 100, 0, 2, OVERDETERMINED[name])
    assert not trim.feasible
    assert trim.residual == pytest.approx(np.abs(plain_accelerations(trim)).max(), rel=1e-6, abs=1e-9)
    failure = Failure.of(OVERDETERMINED[name])
    controls = trim.unknowns[5:]
    is_inside = ((controls >= failure.lower - 1e-9) & (controls <= failure.upper + 1e-9)).all()
    assert not (trim.converged and is_inside and abs(trim.turn_rate_deg_s - 2) < 1e-9)
    assert trim.limits_hit or not trim.converged


def test_jams_at_the_positions_of_a_trim_keep_it():
    free = steady.trim(10000, 100, 0, 2)
    limits = ControlLimits(*((position, position) for position in free.unknowns[5:]))
    jammed = steady.trim(10000, 100, 0, 2, limits)
    assert jammed.feasible
    np.testing.assert_allclose(jammed.unknowns, free.unknowns, atol=1e-6)


def test_what_nothing_follows():
    """SPEC 10.5: cases 1 and 2 lose both rudders, 4 one aileron, 5 and 6 one side of the elevator; SPEC 10.2."""
    expected = {1: (False, False, True), 2: (False, False, True)}
    for n in range(7):
        assert dead_controls(Configuration(damage_case=n))[:3] == expected.get(n, (False,) * 3)
    assert dead_controls(Configuration(engine_running=LEFT_OUT))[3:] == (True, False)
    assert fixed(damage_case=1).jammed == (False, False, True, False)
    assert fixed(engine_running=LEFT_OUT).jammed == (False,) * 4
    assert fixed(engine_running=BOTH_OUT).jammed == (False, False, False, True)
    assert dead_controls(Configuration(surface_gain=(0, 0, 0, 0.1, 1, 1, 0, 0))) == (False, False, True, False, False)


@pytest.mark.parametrize("name", ["damage case 5", "left engine out", "left throttle jam", "separate throttles"])
def test_linear_model_against_differences(name):
    failure = FAILURES[name]
    trim = steady.trim(10000, 103, 0, 2, failure)
    model = linearize(trim)
    x, u = trim.state_and_controls
    c, step = trim.configuration or Configuration(), 1e-6
    rows = [0, 1, 2, 3, 4, 5, 9, 10]
    moved = {"elevator": [0], "aileron": [1], "rudder": [2], "throttle": [3, 4]}
    moved |= {"throttle_left": [3], "throttle_right": [4]}
    for k, control in enumerate(model.inputs):
        up, down = u.copy(), u.copy()
        up[moved[control]] += step
        down[moved[control]] -= step
        slope = (derivatives(x, up, c) - derivatives(x, down, c))[rows] / (2 * step)
        np.testing.assert_allclose(model.B[:, k], slope, atol=1e-6)
    assert ("throttle_left" in model.inputs) == (name == "separate throttles")
    assert len(model.inputs) == sum(not jammed for jammed in failure.jammed)


@pytest.mark.parametrize("name", ["damage case 2", "right engine out", "left throttle weak, rudder jam"])
def test_grid_cells_are_cold_trims(name):
    failure = FAILURES[name]
    grid = envelope_grid(FlightCondition(8000.0, -1.0, failure), 8.0, 4.0)
    cold = steady.trims(8000.0, grid.tas_kt[:, None], -1.0, grid.turn_rate_deg_s, failure)
    assert grid.feasible.any()
    np.testing.assert_array_equal(grid.feasible, (cold.status == 0).reshape(grid.feasible.shape))
    y = cold.y.reshape(grid.y.shape)[grid.feasible]
    but_throttles = slice(8)  # below the speed that overcomes its ram drag an engine's throttle hardly matters (SPEC 6)
    np.testing.assert_allclose(grid.y[grid.feasible][:, but_throttles], y[:, but_throttles], atol=1e-5)
    throttles = {"throttle_left", "throttle_right"} if y.shape[-1] == 10 else {"throttle"}
    assert throttles <= set(grid.to_dataset())


@pytest.mark.parametrize("name", list(FAILURES)[:8])
def test_rates_do_not_change_a_steady_manoeuvre(name):
    slow = replace(FAILURES[name], rate_limits=RateLimits(5, 5, 0))
    one, other = (steady.trim(*CONDITIONS[0], failure) for failure in (FAILURES[name], slow))
    np.testing.assert_array_equal(one.unknowns, other.unknowns)


@pytest.mark.parametrize(
    ("make", "complaint"),
    [
        (lambda: RateLimits(elevator_deg_s=301), "elevator rate in deg/s is 301; give a number from 0 to 300."),
        (lambda: RateLimits(rudder_deg_s=float("nan")), "rudder rate in deg/s is nan; give a number from 0 to 300."),
        (lambda: RateLimits(aileron_deg_s="fast"), "aileron rate in deg/s is 'fast'; give a number from 0 to 300."),
        (lambda: Failure(throttle_left_pct=(50, 20)), "throttle left in %: limits 50 20 are reversed"),
        (lambda: Failure(throttle_right_pct=(0, 101)), "throttle right in %: limits 0 101 are outside 0 .. 100"),
        (lambda: Failure(limits=(0, 1)), r"limits of a failure is \(0, 1\); give a ControlLimits."),
        (lambda: Failure(configuration=5), "configuration of a failure is 5; give a Configuration."),
        (lambda: fixed(damage_case=7), "damage_case is 7; allowed are 0 .. 6."),
    ],
)
def test_wrong_failures(make, complaint):
    with pytest.raises(InputError, match=complaint):
        make()
