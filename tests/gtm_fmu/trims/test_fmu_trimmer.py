"""Trims over FMU evaluations: SPEC 13, the compiled solver, the plain model, and what is refused."""

import numpy as np
import pytest

from fmu_src.fmus import build_fmu
from gtm_fmu.aircraft.client import FmuClient, FmuError
from gtm_fmu.aircraft.evaluation import LINEAR_ROWS, FmuAirframe
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.airframe.names import ALPHA, CONTROLS, STATES
from gtm_fmu.core import motion, solver
from gtm_fmu.errors import InputError
from gtm_fmu.trims import manoeuvre, steady
from gtm_fmu.trims.fmu_trimmer import FmuTrimmer
from gtm_fmu.units import KT_PER_FT_S
from gtm_study.paper import nasa_comparison
from tests.reference import plain_model
from tests.reference.spec_values import TRIMS, half_unit

pytestmark = pytest.mark.slow

NASA = nasa_comparison.READINGS
EDGE = ("alpha_deg", "beta_deg", "phi_deg", "theta_deg", "elevator_deg", "aileron_deg", "rudder_deg", "throttle_pct")


@pytest.fixture(scope="module")
def fmu(tmp_path_factory):
    with FmuClient(build_fmu("dynamics", tmp_path_factory.mktemp("fmu"))) as client:
        yield client


@pytest.fixture(scope="module")
def trimmer(fmu):
    return FmuTrimmer(fmu)


def questions(seed: int, count: int, tas_kt=(75.0, 165.0)):
    """Random trims: a third with a jammed rudder, a third with a restricted one, a third free."""
    rng = np.random.default_rng(seed)
    for k in range(count):
        low, high = np.sort(rng.uniform(-30.0, 30.0, 2))
        rudder_deg = ((low, low), (low, high), (-30.0, 30.0))[k % 3]
        conditions = rng.uniform((0.0, tas_kt[0], -5.0, -6.0), (30000.0, tas_kt[1], 5.0, 6.0)).tolist()
        yield (*conditions, ControlLimits(rudder_deg=rudder_deg))


@pytest.mark.parametrize("printed", [trim for trim in TRIMS if trim.psi_dot is not None], ids=lambda trim: trim.name)
def test_specified_trims_to_the_printed_digits(trimmer, printed):
    jammed = float(printed.beta) != 0.0
    limits = ControlLimits(rudder_deg=(float(printed.rudder),) * 2) if jammed else ControlLimits()
    speed = float(printed.V)
    if printed.eas:
        # The printed speed is rounded; the target is the equivalent airspeed.
        density_ratio = plain_model.atmosphere(printed.h).density / 0.0023769
        speed = printed.eas / KT_PER_FT_S / np.sqrt(density_ratio)
    found = trimmer.trim(printed.h, speed * KT_PER_FT_S, printed.gamma, printed.psi_dot, limits, phi_deg=(-60.0, 60.0))
    assert found.feasible
    assert found.residual <= 1e-9
    for name in ("alpha_deg", "beta_deg", "phi_deg", "elevator_deg", "aileron_deg", "rudder_deg", "throttle_pct"):
        text = getattr(printed, name.split("_")[0])
        # The speed of the first trim is printed to 5e-6 ft/s of 164; a last digit follows from that.
        assert getattr(found, name) == pytest.approx(float(text), abs=4 * max(half_unit(text), 5e-7)), name


def test_directional_derivatives_of_the_native_fmu_give_the_same_trims(trimmer, tmp_path):
    """Exact slopes instead of differences: to 1e-8, restrictions that end in a glide aside."""
    compared = 0
    with FmuClient(build_fmu("dynamics-native", tmp_path)) as client:
        assert client.jacobian is not None
        native = FmuTrimmer(client)
        for question in questions(5, 60):
            core = steady.trim(*question)
            found = native.trim(*question)
            assert found.feasible == core.feasible, question
            if core.feasible:
                np.testing.assert_allclose(found.unknowns, core.unknowns, atol=1e-8, err_msg=str(question))
                compared += 1
    assert compared > 30


def test_two_solvers_agree_on_two_hundred_trims(trimmer):
    """To 1e-6 deg and % at the edge, and on which of the questions have an answer at all."""
    feasible, infeasible = [0, 0, 0], 0
    for k, question in enumerate(questions(11, 330)):
        core = steady.trim(*question)
        if not core.feasible and infeasible >= 60:
            continue
        found = trimmer.trim(*question)
        assert found.feasible == core.feasible, question
        if not core.feasible:
            infeasible += 1
            continue
        feasible[k % 3] += 1
        for name in EDGE:
            assert getattr(found, name) == pytest.approx(getattr(core, name), abs=1e-6), (name, question)
    assert sum(feasible) >= 200
    assert min(feasible) >= 40
    assert infeasible >= 40


def test_trims_satisfy_the_plain_model(trimmer):
    checked = 0
    for question in questions(12, 12):
        found = trimmer.trim(*question)
        if found.feasible:
            speed, alpha, beta, psi_dot, phi = found.unknowns[:5]
            gamma = np.radians(found.gamma_deg)
            x = plain_model.steady_state(found.altitude_ft, speed, gamma, psi_dot, alpha, beta, phi)
            assert np.abs(plain_model.derivatives(x, found.unknowns[5:9])[:6]).max() < 1e-8
            checked += 1
    assert checked >= 5


def test_without_a_trim_the_nearest_inside_the_limits_is_told(trimmer):
    limits = ControlLimits(rudder_deg=(30.0, 30.0))
    found = trimmer.trim(30000.0, 110.0, 5.0, 0.0, limits)
    assert not found.feasible
    assert found.residual > 1e-3
    lower, upper = manoeuvre.bounds(limits, tas_kt=(110.0, 110.0), turn_rate_deg_s=(0.0, 0.0))
    assert (found.unknowns >= lower - 1e-9 * solver.scale()).all()
    assert (found.unknowns <= upper + 1e-9 * solver.scale()).all()
    assert "throttle.upper" in found.limits_hit
    # No nearby point inside the limits costs less (paper eq. 21 with Q = 1).
    rng = np.random.default_rng(0)

    def cost(y) -> float:
        gamma = np.radians(5.0)
        x = plain_model.steady_state(30000.0, y[0], gamma, y[3], y[1], y[2], y[4])
        return 0.5 * float(np.sum(plain_model.derivatives(x, y[5:])[:6] ** 2))

    least = cost(found.unknowns)
    for _ in range(300):
        step = rng.normal(size=len(lower)) * solver.scale() * 10.0 ** rng.uniform(-4, -1)
        assert cost(np.clip(found.unknowns + step, lower, upper)) >= least * (1 - 1e-6)


def test_warm_start_gives_the_same_trim(trimmer):
    question = (12000.0, 118.0, 1.0, 2.0, ControlLimits(rudder_deg=(-8.0, -8.0)))
    cold = trimmer.trim(*question)
    near = trimmer.trim(12000.0, 115.0, 1.0, 2.0, ControlLimits(rudder_deg=(-8.0, -8.0)))
    warm = trimmer.trim(*question, warm_start=near)
    for name in EDGE:
        assert getattr(warm, name) == pytest.approx(getattr(cold, name), abs=1e-7)


def test_limits_hit_name_what_holds_a_trim(trimmer):
    found = trimmer.trim(10000.0, 100.0, 0.0, 0.0, ControlLimits(rudder_deg=(20.0, 30.0)))
    assert found.feasible
    assert found.limits_hit == ("rudder.lower",)


class Counted:
    """An evaluator that counts."""

    def __init__(self, evaluator):
        self.evaluator, self.count = evaluator, 0

    def evaluate(self, x, u):
        self.count += 1
        return self.evaluator.evaluate(x, u)


def test_warm_start_needs_fewer_evaluations(fmu):
    counted = Counted(fmu)
    trimmer = FmuTrimmer(counted)
    limits, counts = ControlLimits(rudder_deg=(14.0, 14.0)), []
    near = trimmer.trim(20000.0, 128.0, -1.0, -3.0, limits)
    for start in (None, near):
        counted.count = 0
        assert trimmer.trim(20000.0, 130.0, -1.0, -3.0, limits, warm_start=start).feasible
        counts.append(counted.count)
    assert counts[1] < counts[0] < 300


def test_any_unknown_can_be_held(trimmer):
    """NASA's level trims up to 28 deg, with alpha held and the speed free, to the reading error of the plots."""
    ratio = np.sqrt(plain_model.atmosphere(800.0).density / 0.0023769)
    table = np.genfromtxt(NASA / "level_trim_vs_alpha.csv", delimiter=",", names=True)
    assert table["alpha_deg"].max() == 28.0
    for row in table:
        lower, upper = manoeuvre.bounds(ControlLimits(), turn_rate_deg_s=(0.0, 0.0))
        lower[ALPHA] = upper[ALPHA] = np.radians(row["alpha_deg"])
        found = trimmer.trim_within(800.0, 0.0, lower, upper)
        assert found.feasible
        assert found.elevator_deg == pytest.approx(row["elevator_deg"], abs=0.1)
        assert found.throttle_pct == pytest.approx(row["throttle_pct"], abs=0.15)
        if np.isfinite(row["eas_kt"]):
            assert found.tas_kt * ratio == pytest.approx(row["eas_kt"], abs=0.1)


def test_a_bank_angle_can_be_held_instead_of_a_turn_rate(trimmer):
    """SPEC 13: eas 95 kn, gamma 3 deg, phi 45 deg, the turn rate free."""
    printed = next(trim for trim in TRIMS if trim.psi_dot is None)
    tas_kt = printed.eas / np.sqrt(plain_model.atmosphere(printed.h).density / 0.0023769)
    lower, upper = manoeuvre.bounds(ControlLimits(), phi_deg=(45.0, 45.0), tas_kt=(tas_kt, tas_kt))
    found = trimmer.trim_within(printed.h, printed.gamma, lower, upper)
    assert found.feasible
    for name in ("alpha_deg", "elevator_deg", "aileron_deg", "rudder_deg", "throttle_pct"):
        text = getattr(printed, name.split("_")[0])
        assert getattr(found, name) == pytest.approx(float(text), abs=2 * half_unit(text)), name


def test_controls_all_jammed_where_a_trim_lies(trimmer):
    question = (9000.0, 117.0, 1.3, -2.2)
    free = trimmer.trim(*question, ControlLimits(rudder_deg=(6.0, 6.0)))
    jams = {name: (getattr(free, name),) * 2 for name in ("elevator_deg", "aileron_deg", "rudder_deg", "throttle_pct")}
    again = trimmer.trim(*question, ControlLimits(**jams))
    assert again.feasible
    for name in EDGE:
        assert getattr(again, name) == pytest.approx(getattr(free, name), abs=1e-6)
    jams["aileron_deg"] = (free.aileron_deg + 1.0,) * 2
    assert not trimmer.trim(*question, ControlLimits(**jams)).feasible


def test_differences_stay_inside_the_range_of_controls(fmu):
    """At a limit, where the FMU holds commands, they look the other way; all equal the exact slopes of that side."""
    x, _ = steady.trim(9000.0, 117.0, 1.3, -2.2, ControlLimits(rudder_deg=(12.0, 12.0))).state_and_controls
    airframe = FmuAirframe(fmu)
    columns = np.append(LINEAR_ROWS, len(STATES) + np.arange(len(CONTROLS)))
    for u in ([30.0, 20.0, 30.0, 100.0], [-30.0, -20.0, -30.0, 0.0]):
        # Limits are breakpoints of some tables: the exact slopes are those just inside.
        exact = motion.jacobian(x, 0.999999 * np.array(u))[1][:, columns]
        dx, slopes = airframe.differences(x, np.array(u))
        np.testing.assert_allclose(dx, motion.derivatives(x, u), atol=1e-11)
        np.testing.assert_allclose(slopes, exact, atol=2e-5 * max(1.0, np.abs(exact).max()))
        # No control is dead: an idle engine still has its rotor.
        assert np.abs(slopes[:6, -4:]).max(axis=0).min() > 1e-5


def test_a_closed_fmu_is_told_in_its_own_words(tmp_path):
    with FmuClient(build_fmu("dynamics", tmp_path)) as client:
        trimmer = FmuTrimmer(client)
    with pytest.raises(FmuError, match="closed"):
        trimmer.trim(10000.0, 110.0)


@pytest.mark.parametrize(
    ("question", "sentence"),
    [
        ({"altitude_ft": 50000.0, "tas_kt": 110.0}, "altitude in ft 50000 is outside"),
        ({"altitude_ft": 1000.0, "tas_kt": float("nan")}, "nan"),
        ({"altitude_ft": 1000.0, "tas_kt": 110.0, "gamma_deg": 90.0}, "gamma in deg 90 is outside"),
        ({"altitude_ft": 1000.0, "tas_kt": 110.0, "alpha_deg": (5.0, -5.0)}, "reversed"),
    ],
)
def test_bad_input_is_one_sentence(trimmer, question, sentence):
    with pytest.raises(InputError, match=sentence) as caught:
        trimmer.trim(**question)
    assert "\n" not in str(caught.value)
