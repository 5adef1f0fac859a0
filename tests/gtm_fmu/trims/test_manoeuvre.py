"""What may be asked of a steady manoeuvre, what is told about wrong input, and the trim that answers."""

import json
import math
from dataclasses import fields

import numpy as np
import pytest

from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.airframe.names import TRIM_UNKNOWNS
from gtm_fmu.core import solver
from gtm_fmu.envelopes.envelope import FlightCondition
from gtm_fmu.errors import InputError
from gtm_fmu.trims import manoeuvre, steady
from gtm_fmu.trims.manoeuvre import Trim
from tests.reference import plain_model

NAN = float("nan")


def test_the_study_bounds_in_the_units_of_the_core():
    """SPEC 9: alpha -5..10.5, phi +-30 deg; knots per ft/s 0.592487 (SPEC 1); order of names.TRIM_UNKNOWNS."""
    lower, upper = manoeuvre.bounds(ControlLimits(rudder_deg=(-7, 12)), tas_kt=(100, 100), turn_rate_deg_s=(-3, 4))
    degree = math.pi / 180
    knot = 1 / 0.592487
    np.testing.assert_allclose(
        lower, [100 * knot, -5 * degree, -45 * degree, -3 * degree, -30 * degree, -30, -20, -7, 0]
    )
    np.testing.assert_allclose(
        upper, [100 * knot, 10.5 * degree, 45 * degree, 4 * degree, 30 * degree, 30, 20, 12, 100]
    )


@pytest.mark.parametrize(
    ("name", "value", "complaint"),
    [
        ("altitude_ft", -1, "altitude in ft -1 is outside 0 .. 36089"),
        ("altitude_ft", 36090, "altitude in ft 36090 is outside 0 .. 36089"),
        ("altitude_ft", NAN, "altitude in ft nan is outside"),
        ("altitude_ft", "high", "altitude in ft 'high' is not a number"),
        ("altitude_ft", None, "altitude in ft None is not a number"),
        ("gamma_deg", 45.01, "gamma in deg 45.01 is outside -45 .. 45"),
        ("gamma_deg", -90, "gamma in deg -90 is outside"),
        ("gamma_deg", NAN, "gamma in deg nan is outside"),
        ("gamma_deg", [0, 1], "gamma in deg .* is not a number"),
        ("tas_kt", 19.9, "tas in kn 19.9 is outside 20 .. 350"),
        ("tas_kt", 351, "tas in kn 351 is outside"),
        ("tas_kt", 0, "tas in kn 0 is outside"),
        ("tas_kt", NAN, "tas in kn nan is outside"),
        ("tas_kt", math.inf, "tas in kn inf is outside"),
        ("turn_rate_deg_s", 91, "turn rate in deg/s 91 is outside -90 .. 90"),
        ("turn_rate_deg_s", NAN, "turn rate in deg/s nan is outside"),
        ("alpha_deg", (5, -5), "alpha in deg 5 -5 are reversed"),
        ("alpha_deg", (-21, 5), "alpha in deg -21 is outside -20 .. 40"),
        ("alpha_deg", (NAN, 5), "alpha in deg nan is outside"),
        ("alpha_deg", 5, "alpha in deg 5 is not a pair"),
        ("alpha_deg", (1, 2, 3), "is not a pair; give two numbers"),
        ("alpha_deg", "12", "alpha in deg '12' is not a pair; give two numbers"),
        ("phi_deg", (10, 0), "phi in deg 10 0 are reversed"),
        ("phi_deg", (-90, 90), "phi in deg -90 is outside -80 .. 80"),
        ("phi_deg", ("left", 0), "phi in deg 'left' is not a number"),
    ],
)
def test_wrong_input_is_told_in_one_sentence(name, value, complaint):
    asked = {"altitude_ft": 10000.0, "tas_kt": 100.0} | {name: value}
    with pytest.raises(InputError, match=complaint) as told:
        steady.trim(**asked)
    assert str(told.value).endswith(".")
    assert "\n" not in str(told.value)
    if name in ("altitude_ft", "gamma_deg", "alpha_deg", "phi_deg"):
        with pytest.raises(InputError, match=complaint):
            FlightCondition(**{"altitude_ft": 10000.0, "gamma_deg": 0.0} | {name: value})


@pytest.mark.parametrize("altitude_ft", [0, 36089, "10000"])
@pytest.mark.parametrize("gamma_deg", [-45, 45])
def test_the_ends_of_what_may_be_asked(altitude_ft, gamma_deg):
    """Also numbers that arrive as text; the answer is honest: converged or not, and then not feasible."""
    for tas_kt in (20, 350):
        trim = steady.trim(altitude_ft, tas_kt, str(gamma_deg), 90)
        assert not trim.feasible
        assert trim.converged == (trim.residual <= 1e-9)
    assert FlightCondition(altitude_ft, gamma_deg).envelope().feasible in (True, False)


def bounds_of(**held):
    lower, upper = manoeuvre.bounds(ControlLimits())
    for name, (low, high) in held.items():
        k = TRIM_UNKNOWNS.index(name)
        lower[k], upper[k] = low, high
    return lower, upper


@pytest.mark.parametrize("name", TRIM_UNKNOWNS)
def test_limits_hit_names_the_side(name):
    lower, upper = bounds_of()
    k, scale = TRIM_UNKNOWNS.index(name), solver.scale()
    y = 0.5 * (lower + upper)
    assert manoeuvre.limits_hit(y, lower, upper) == ()
    for at, bound, outward in ((f"{name}.lower", lower, -1), (f"{name}.upper", upper, 1)):
        for away, hit in ((0, True), (0.5e-6, True), (-0.5e-6, True), (-2e-6, False), (0.1, True)):
            y[k] = bound[k] + outward * away * scale[k]
            assert manoeuvre.limits_hit(y, lower, upper) == ((at,) if hit else ())


def test_limits_hit_names_several_but_of_what_is_held_only_what_is_missed():
    lower, upper = bounds_of(rudder=(5, 5), V=(150, 150))
    y = 0.5 * (lower + upper)
    y[TRIM_UNKNOWNS.index("alpha")] = upper[TRIM_UNKNOWNS.index("alpha")]
    y[TRIM_UNKNOWNS.index("throttle")] = -3
    assert manoeuvre.limits_hit(y, lower, upper) == ("alpha.upper", "throttle.lower")
    y[TRIM_UNKNOWNS.index("rudder")] = 9
    assert manoeuvre.limits_hit(y, lower, upper) == ("alpha.upper", "rudder.upper", "throttle.lower")


@pytest.fixture(scope="module")
def turning() -> Trim:
    return steady.trim(10000, 110, -2, 6, ControlLimits(rudder_deg=(5, 5)))


def test_a_trim_names_its_state(turning):
    """Every value against the state it stands for, and that against the plain model."""
    x, u = turning.state_and_controls
    V = np.linalg.norm(x[:3])
    expected = {
        "tas_kt": V * 0.592487,
        "alpha_deg": np.degrees(np.arctan2(x[2], x[0])),
        "beta_deg": np.degrees(np.arcsin(x[1] / V)),
        "p_deg_s": np.degrees(x[3]),
        "q_deg_s": np.degrees(x[4]),
        "r_deg_s": np.degrees(x[5]),
        "altitude_ft": x[8],
        "phi_deg": np.degrees(x[9]),
        "theta_deg": np.degrees(x[10]),
        "elevator_deg": u[0],
        "aileron_deg": u[1],
        "rudder_deg": u[2],
        "throttle_pct": u[3],
    }
    for name, value in expected.items():
        assert getattr(turning, name) == pytest.approx(value, rel=1e-12), name
    assert (x[6], x[7], x[11]) == (0, 0, 0)
    dx = plain_model.derivatives(x, u)
    assert np.abs(dx[:6]).max() < 1e-9
    assert np.degrees(np.arcsin(dx[8] / V)) == pytest.approx(turning.gamma_deg, abs=1e-9)
    np.testing.assert_allclose(np.degrees(dx[9:]), [0, 0, turning.turn_rate_deg_s], atol=1e-9)
    assert (turning.tas_kt, turning.gamma_deg) == pytest.approx((110, -2), rel=1e-14)
    assert (turning.turn_rate_deg_s, turning.rudder_deg) == pytest.approx((6, 5), rel=1e-14)


def test_a_trim_as_json_keeps_every_named_value(turning):
    values = json.loads(json.dumps(turning.to_dict()))
    of_a_failure = {"failure", "throttle_left_pct", "throttle_right_pct"}
    names = {f.name for f in fields(Trim)} - {"unknowns"} - of_a_failure
    assert set(values) == names | {"eas_kt", "cas_kt", "load_factor"}
    assert values["limits_hit"] == ["phi.upper"]  # more than 30 deg of bank: a trim, but not a feasible one
    for name in names - {"limits_hit"}:
        assert values[name] == getattr(turning, name)
        assert type(values[name]) in ((bool,) if name in ("converged", "feasible") else (float,))


def test_no_minus_zero_is_shown():
    straight = steady.trim(0, 100)
    rates = straight.p_deg_s, straight.q_deg_s, straight.r_deg_s
    assert rates == (0, 0, 0)
    assert all(math.copysign(1, rate) == 1 for rate in rates)
