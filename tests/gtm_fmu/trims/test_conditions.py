"""Trims by bank, sideslip, angle of attack and load factor, by every airspeed, and into the stall."""

from pathlib import Path

import numpy as np
import pytest
from fmpy import simulate_fmu

from fmu_src.fmus import build_fmu
from gtm_fmu.aircraft import airspeed
from gtm_fmu.aircraft.client import FmuClient
from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.airframe.names import V
from gtm_fmu.core import solver
from gtm_fmu.core.configuration import Configuration
from gtm_fmu.envelopes.envelope import envelope
from gtm_fmu.errors import InputError
from gtm_fmu.trims import manoeuvre, steady
from gtm_fmu.trims.fmu_trimmer import FmuTrimmer
from gtm_fmu.trims.manoeuvre import Trim
from tests.reference import plain_model
from tests.reference.spec_values import TRIMS, half_unit

pytestmark = pytest.mark.slow

JAM = ControlLimits(rudder_deg=(10, 10))
VALUES = {
    "turn_rate_deg_s": 3.0,
    "bank_deg": 16.0,
    "sideslip_deg": 2.0,
    "angle_of_attack_deg": 4.0,
    "load_factor": 1.05,
}
NAMES = {"bank_deg": "phi_deg", "sideslip_deg": "beta_deg", "angle_of_attack_deg": "alpha_deg"}
PAIRS = [(a, b) for k, a in enumerate(VALUES) for b in list(VALUES)[k + 1 :]]


def assert_trim(found, **asked):
    """Six accelerations of the plain model are zero, and what was asked is met."""
    x, u = found.state_and_controls
    dx = plain_model.derivatives(x, u)
    assert np.abs(dx[:6]).max() < 1e-8
    assert np.abs(dx[9:11]).max() < 1e-12  # bank and pitch stay
    for name, value in asked.items():
        assert getattr(found, NAMES.get(name, name)) == pytest.approx(value, abs=1e-8), name
    p, q = x[3:5]
    load = -((p * x[1] - q * x[0]) / 32.174 - np.cos(x[10]) * np.cos(x[9]))  # SPEC 8, without acceleration
    assert found.load_factor == pytest.approx(load, abs=1e-9)


@pytest.mark.parametrize("pair", PAIRS, ids="-".join)
def test_any_two_conditions_with_a_movable_rudder(pair):
    """At 105 kn; what a pair of these values leaves outside the limits is still a trim that meets them."""
    asked = {name: VALUES[name] for name in pair}
    found = steady.trim(10000, 105.0, 1.0, limits=None, alpha_deg=(-5, 20), phi_deg=(-60, 60), **asked)
    assert found.converged
    assert found.feasible or found.limits_hit
    if found.feasible:
        assert_trim(found, tas_kt=105.0, **asked)


def test_random_manoeuvres_are_found_again_by_their_conditions():
    """Where the conditions settle the turn there is one trim; a load factor or alpha may be met by another, too."""
    rng = np.random.default_rng(5)
    lower, upper = manoeuvre.bounds(ControlLimits())
    held = rng.uniform([85, np.radians(-30), -30], [370, np.radians(30), 30], (400, 3))
    y = solver.cold_starts(12000, np.radians(-1), held)
    y = y[((y >= lower) & (y <= upper)).all(axis=1)][:12]
    assert len(y) == 12
    for each in y:
        trim = Trim.of_unknowns(each, 12000, -1, True, ())
        jam = ControlLimits(rudder_deg=(trim.rudder_deg,) * 2)
        value = {name: getattr(trim, NAMES.get(name, name)) for name in VALUES}
        unique = [
            {"turn_rate_deg_s", "bank_deg"},
            {"bank_deg", "sideslip_deg"},
            {"turn_rate_deg_s", "sideslip_deg"},
        ]
        for names in unique:
            asked = {name: value[name] for name in names}
            by_speed = steady.trim(12000, trim.tas_kt, -1, **asked)
            by_alpha = steady.trim(12000, None, -1, angle_of_attack_deg=trim.alpha_deg, **asked)
            for found in (by_speed, by_alpha, steady.trim(12000, trim.tas_kt, -1, bank_deg=trim.phi_deg, limits=jam)):
                assert found.feasible
                np.testing.assert_allclose(found.unknowns / solver.scale(), each / solver.scale(), atol=1e-6)
        for names in ({"sideslip_deg", "load_factor"}, {"sideslip_deg", "angle_of_attack_deg"}):
            asked = {name: value[name] for name in names}
            assert_trim(steady.trim(12000, trim.tas_kt, -1, **asked), tas_kt=trim.tas_kt, **asked)


@pytest.mark.parametrize("name", VALUES)
def test_one_condition_with_a_jammed_rudder(name):
    found = steady.trim(10000, 118.5, limits=JAM, **{name: {"sideslip_deg": 7.7}.get(name, VALUES[name])})
    assert found.converged
    if found.feasible:
        assert_trim(found, tas_kt=118.5, rudder_deg=10)


@pytest.mark.parametrize("tas_kt", [90, 118.5, 135])
def test_wings_level_with_a_jammed_rudder_is_a_turn(tas_kt):
    """Also where the bounds of the bank are what says so."""
    found = steady.trim(10000, tas_kt, limits=JAM, bank_deg=0)
    assert found.feasible
    assert_trim(found, tas_kt=tas_kt, bank_deg=0, rudder_deg=10)
    assert found.turn_rate_deg_s < -1.5  # a positive rudder yaws left (SPEC 4)
    assert steady.trim(10000, tas_kt, limits=JAM, phi_deg=(0, 0)) == found


def test_a_bank_gives_the_turn_of_the_specification():
    """SPEC 13: eas 95 kn, gamma 3 deg, phi 45 deg, the turn rate free."""
    printed = next(trim for trim in TRIMS if trim.psi_dot is None)
    found = steady.trim(printed.h, eas_kt=printed.eas, gamma_deg=printed.gamma, bank_deg=45, phi_deg=(-60, 60))
    assert found.feasible
    for name in ("alpha_deg", "elevator_deg", "aileron_deg", "rudder_deg", "throttle_pct"):
        text = getattr(printed, name.split("_")[0])
        assert getattr(found, name) == pytest.approx(float(text), abs=2 * half_unit(text)), name


def test_an_angle_of_attack_gives_the_speed_of_the_specification():
    printed = next(trim for trim in TRIMS if trim.name.startswith("alpha 3"))
    found = steady.trim(800, angle_of_attack_deg=3)
    assert found.unknowns[V] == pytest.approx(float(printed.V), abs=2 * half_unit(printed.V))
    assert found.throttle_pct == pytest.approx(float(printed.throttle), abs=2 * half_unit(printed.throttle))


@pytest.mark.parametrize("rudder_deg", [(-30, 30), (3, 3), (-3, -3)])
def test_a_load_factor_is_flown_to_the_right_or_as_the_bounds_leave_it(rudder_deg):
    asked = {"load_factor": 1.08, "limits": ControlLimits(rudder_deg=rudder_deg)}
    right, left = steady.trim(10000, 120, **asked), steady.trim(10000, 120, **asked, phi_deg=(-30, 0))
    for found, sign in ((right, 1), (left, -1)):
        assert found.feasible
        assert_trim(found, tas_kt=120, load_factor=1.08)
        assert found.phi_deg * sign > 10
        again = steady.trim(10000, 120, bank_deg=found.phi_deg, limits=asked["limits"])
        assert again.turn_rate_deg_s == pytest.approx(found.turn_rate_deg_s, abs=1e-7)


def test_a_load_factor_beyond_the_limits_has_no_trim():
    found = steady.trim(10000, 120, load_factor=2)
    assert (found.converged, found.feasible) == (True, False)
    assert found.limits_hit == ("phi.upper", "load_factor.lower")


@pytest.mark.parametrize("alpha_deg", [14, 20, 28])
def test_envelopes_go_into_the_stall(alpha_deg):
    """Where NASA's level trims go (gtm_study/paper/data/nasa_plots), up to 28 deg: V_min is just below such a trim."""
    found = envelope(800, 0, ControlLimits(), alpha_deg=(-5, alpha_deg))
    level = steady.trim(800, angle_of_attack_deg=alpha_deg, alpha_deg=(-5, alpha_deg))
    assert found.at_v_min.alpha_deg == pytest.approx(alpha_deg, abs=1e-6)
    assert level.tas_kt - 0.3 < found.v_min_kt <= level.tas_kt + 1e-4


class TestAirspeeds:
    # JSBSim 1.3.3, its own 1976 atmosphere: ic/vc-kts given, ic/vt-kts and ic/ve-kts read
    @pytest.mark.parametrize(
        ("altitude_ft", "cas_kt", "tas_kt", "eas_kt"),
        [
            (10000, 250, 288.6820068821627, 248.09687622868682),
            (30000, 300, 465.6314424840932, 285.0355604359956),
            (20000, 120, 163.5677967175112, 119.43322958703057),
        ],
    )
    def test_another_tool_agrees(self, altitude_ft, cas_kt, tas_kt, eas_kt):
        found = airspeed.tas_of_cas(cas_kt, altitude_ft)
        assert found == pytest.approx(tas_kt, rel=1e-6)
        assert airspeed.eas_of_tas(found, altitude_ft) == pytest.approx(eas_kt, rel=1e-6)
        assert airspeed.cas_of_tas(found, altitude_ft) == pytest.approx(cas_kt, rel=1e-12)

    def test_at_sea_level_all_are_one(self):
        found = steady.trim(0, cas_kt=100)
        assert found.tas_kt == pytest.approx(100, rel=1e-12)
        assert found.eas_kt == pytest.approx(100, rel=1e-6)  # the reference density is rounded (SPEC 2)

    def test_trims_know_their_speeds(self):
        """Against the printed speed of SPEC 13, and the airframe's own output of EAS."""
        printed = next(trim for trim in TRIMS if trim.name.startswith("eas 75"))
        found = steady.trim(800, eas_kt=75)
        assert found.unknowns[V] == pytest.approx(float(printed.V), abs=2 * half_unit(printed.V))
        x, u = found.state_and_controls
        assert found.eas_kt == pytest.approx(plain_model.outputs(x, u)[1], rel=1e-12)
        assert found.to_dict()["eas_kt"] == pytest.approx(75, rel=1e-12)


@pytest.mark.parametrize(
    ("asked", "sentence"),
    [
        ({}, "No speed is given; give one"),
        ({"load_factor": 1.1}, "No speed is given; give one"),
        ({"tas_kt": 100, "eas_kt": 90}, "tas_kt and eas_kt are both speeds; give one of them"),
        ({"cas_kt": "fast"}, "cas in kn 'fast' is not a number"),
        ({"eas_kt": 300, "altitude_ft": 30000}, "tas in kn 490.* is outside 20 .. 350"),
        (
            {"tas_kt": 100, "bank_deg": 45},
            "bank in deg 45 is outside -30 .. 30; give a value inside, or wider bounds of phi",
        ),
        ({"tas_kt": 100, "angle_of_attack_deg": 12}, "angle of attack in deg 12 is outside -5 .. 10.5"),
        ({"tas_kt": 100, "sideslip_deg": float("nan")}, "sideslip in deg nan is outside"),
        ({"tas_kt": 100, "load_factor": 9}, "load factor 9 is outside"),
        (
            {"tas_kt": 100, "bank_deg": 5, "sideslip_deg": 1, "turn_rate_deg_s": 1},
            "movable rudder takes 3 conditions, and these are 4: speed, turn rate, bank, sideslip",
        ),
        (
            {"tas_kt": 100, "bank_deg": 5, "sideslip_deg": 1, "limits": JAM},
            "jammed rudder takes 2 conditions, and these are 3",
        ),
        ({"tas_kt": 100, "alpha_deg": (-5, 41)}, "alpha in deg 41 is outside -20 .. 40"),
    ],
)
def test_what_cannot_be_asked_is_told(asked, sentence):
    with pytest.raises(InputError, match=sentence) as told:
        steady.trim(**({"altitude_ft": 10000} | asked))
    assert str(told.value).endswith(".")


@pytest.fixture(scope="module")
def native(tmp_path_factory) -> Path:
    return build_fmu("dynamics-native", tmp_path_factory.mktemp("fmu"))


def test_over_an_fmu_the_trims_are_the_same(native):
    with FmuClient(native) as client:
        trimmer = FmuTrimmer(client)
        for asked in (
            {"tas_kt": 118.5, "limits": JAM, "bank_deg": 0},
            {"cas_kt": 100, "bank_deg": 15, "sideslip_deg": 2},
            {"angle_of_attack_deg": 14, "alpha_deg": (-5, 20)},
        ):
            core, found = steady.trim(9000, **asked), trimmer.trim(9000, **asked)
            assert core.feasible
            assert found.feasible
            np.testing.assert_allclose(found.unknowns, core.unknowns, atol=1e-7, err_msg=str(asked))
        with pytest.raises(InputError, match="takes no load factor"):
            trimmer.trim(9000, 100, load_factor=1.1)


def test_start_values_start_an_fmu_in_the_trim(native):
    """FMPy sets them by name; the accelerations that the FMU gives are zero, and after a second it flies the same."""
    trim = steady.trim(10000, 118.5, limits=JAM, bank_deg=0)
    values = trim.start_values()
    rates = [f"der(state.{name})" for name in ("u", "v", "w", "p", "q", "r", "phi", "theta")]
    states = [f"state.{name}" for name in ("u", "v", "w", "p", "q", "r", "phi", "theta")]
    result = simulate_fmu(native, stop_time=1, start_values=values, output=[*rates, *states])
    assert np.abs([result[name] for name in rates]).max() < 1e-9
    for name in states:
        assert result[name] == pytest.approx(values[name], abs=1e-9)
    assert values["control.rudder"] == pytest.approx(np.radians(10))
    assert values["control.throttle"] == pytest.approx(trim.throttle_pct / 100)
    assert np.hypot(np.hypot(values["state.u"], values["state.v"]), values["state.w"]) == pytest.approx(
        118.5 / 0.592487 * 0.3048
    )


def test_separate_throttles_have_no_start_values():
    trim = steady.trim(10000, 118.5, limits=Failure(throttle_left_pct=(0, 60)))
    assert trim.feasible
    with pytest.raises(InputError, match="a throttle"):
        trim.start_values()


def test_a_damaged_aircraft_takes_the_same_conditions():
    found = steady.trim(5000, 90, limits=Failure(configuration=Configuration(damage_case=5)), bank_deg=10)
    assert found.feasible
    assert found.phi_deg == pytest.approx(10)
    assert abs(found.beta_deg) < 1e-9
