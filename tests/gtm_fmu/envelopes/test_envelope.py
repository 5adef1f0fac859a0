"""V_min and V_max against dense scans, unions of jams, the facts of methods/ENVELOPE.md and the paper's Fig. 3."""

import json
from typing import Any, NamedTuple

import numpy as np
import pytest

from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.aircraft.ranges import Range
from gtm_fmu.airframe.names import PHI, RUDDER, THROTTLE, V
from gtm_fmu.core import solver
from gtm_fmu.datasets import lattice as dataset
from gtm_fmu.envelopes.envelope import Envelope, FlightCondition, envelope
from gtm_fmu.errors import InputError
from gtm_fmu.trims import manoeuvre, steady
from gtm_fmu.trims.manoeuvre import Trim
from gtm_fmu.units import FT_S_PER_KT, KT_PER_FT_S, RAD_PER_DEG
from tests.reference import plain_model

SCALE = solver.scale()
SPEED_TOLERANCE_KT = 0.01
HELD = 1e-6  # of a typical size: as near to a bound as an optimum is


class Case(NamedTuple):
    """A flight condition, what a failure leaves, and what the scans of it step by (speed in kn, bank in deg)."""

    altitude_ft: float
    gamma_deg: float
    rudder_deg: Range
    steps: tuple[float, float] = (0.5, 1.0)
    limits: dict[str, Range] = {}  # noqa: RUF012

    @property
    def condition(self) -> FlightCondition:
        return FlightCondition(self.altitude_ft, self.gamma_deg, ControlLimits(**self.limits))

    @property
    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        return manoeuvre.bounds(ControlLimits(**{"rudder_deg": self.rudder_deg} | self.limits))


def jam(altitude_ft, gamma_deg, rudder_deg, **limits) -> Case:
    return Case(altitude_ft, gamma_deg, (rudder_deg, rudder_deg), limits=limits)


def restriction(altitude_ft, gamma_deg, lower, upper, **limits) -> Case:
    return Case(altitude_ft, gamma_deg, (lower, upper), (1.0, 3.0), limits)


CASES = {
    "jam": jam(7431.0, 1.37, -6.4),
    "jam at a breakpoint": jam(12000.0, -4.2, 10.0),
    "hard jam": jam(18250.0, -3.1, 22.6),
    "hard jam to the other side": jam(2000.0, 1.8, -21.3),
    "jam beyond what the ailerons hold": jam(15000.0, 0.0, 29.0),
    "near the ceiling": jam(30000.0, 1.5, 8.0),
    "just below the ceiling": jam(30000.0, 1.0, 12.0),
    "just above the ceiling": jam(30000.0, 1.06, 12.0),
    "with a gap": jam(33591.549399502124, 0.3801354179272882, 7.731865359248744),
    "steep descent": jam(25981.0, -12.41, -10.91),
    "descent with a few slow trims": jam(33950.0, -8.25, 10.91),
    "small ailerons": jam(5000.0, 2.0, 3.3, aileron_deg=(-5.0, 5.0)),
    "weak engines": jam(5000.0, -1.0, -8.0, throttle_pct=(20.0, 60.0)),
    "small elevator": jam(9000.0, -2.0, 4.0, elevator_deg=(-2.0, 1.0)),
    "restriction": restriction(3120.0, 3.3, -4.1, 17.8),
    "restriction off centre": restriction(14210.0, -1.9, 13.7, 21.2),
    "restriction near the ceiling": restriction(31000.0, 0.6, -9.0, -5.5),
    "restriction with small ailerons": restriction(2000.0, 0.5, 4.0, 9.0, aileron_deg=(-6.0, 20.0)),
}


def scan(case: Case, tas_kt, phi_deg, rudder_deg, throttle_limit_pct: float | None = None) -> np.ndarray:
    """Unknowns (m, 9) of all trims inside the limits at the given speeds, banks and deflections."""
    held = np.meshgrid(np.asarray(tas_kt) * FT_S_PER_KT, np.radians(phi_deg), rudder_deg)
    held = np.column_stack([axis.ravel() for axis in held])
    y = solver.cold_starts(case.altitude_ft, case.gamma_deg * RAD_PER_DEG, held)
    lower, upper = case.bounds
    if throttle_limit_pct is not None:
        upper[THROTTLE] = throttle_limit_pct
    return y[np.all((lower <= y) & (y <= upper), axis=1)]


def deflections(case: Case, step: float) -> np.ndarray:
    lower, upper = case.rudder_deg
    return np.linspace(lower, upper, int((upper - lower) / step) + 2) if lower < upper else np.array([lower])


def assert_is_a_trim_of_the_condition(trim: Trim, altitude_ft, gamma_deg, lower, upper):
    """Steady for the plain model, on the flight path, inside the bounds."""
    x, u = trim.state_and_controls
    dx = plain_model.derivatives(x, u)
    assert np.abs(dx[:6]).max() < 1e-9
    assert x[8] == altitude_ft
    assert dx[8] == pytest.approx(np.linalg.norm(x[:3]) * np.sin(np.radians(gamma_deg)), abs=1e-9)
    assert np.all(trim.unknowns >= lower - HELD * SCALE)
    assert np.all(trim.unknowns <= upper + HELD * SCALE)
    assert trim.feasible


@pytest.mark.parametrize("name", CASES)
def test_ends_against_a_dense_scan(name):
    """Nothing feasible beyond the ends by more than 0.01 kn, no feasible case missed, and none invented."""
    case = CASES[name]
    found = case.condition.envelope(case.rudder_deg)
    speed_step, bank_step = case.steps
    banks = np.arange(-30, 30 + 1e-9, bank_step)
    y = scan(case, np.arange(40, 275, speed_step), banks, deflections(case, 2.0), throttle_limit_pct=400)
    feasible = y[y[:, THROTTLE] <= case.bounds[1][THROTTLE]]
    assert len(y)
    least = y[:, THROTTLE].min()
    assert found.t_min_pct is not None
    assert found.t_min_pct <= least + 1e-6
    assert found.feasible == (found.t_min_pct <= case.bounds[1][THROTTLE] + 1e-6)
    if not found.feasible:
        assert not len(feasible)
        assert (found.v_min_kt, found.v_max_kt) == (None, None)
        return

    speeds = feasible[:, V] * KT_PER_FT_S
    for trim, speed, outward in ((found.at_v_min, found.v_min_kt, -1), (found.at_v_max, found.v_max_kt, 1)):
        assert_is_a_trim_of_the_condition(trim, case.altitude_ft, case.gamma_deg, *case.bounds)
        assert trim.tas_kt == speed
        assert np.all(outward * speeds <= outward * speed + SPEED_TOLERANCE_KT)
        near = np.clip(trim.rudder_deg + np.linspace(-1, 1, 9), *case.rudder_deg)
        beyond = speed + outward * np.array([SPEED_TOLERANCE_KT, 0.03, 0.1, 0.3])
        assert not len(scan(case, beyond, np.arange(-30, 30.01, 0.2), np.unique([trim.rudder_deg, *near])))


def test_the_cases_hold_every_kind():
    """A jam with and without an envelope, one with a gap in speed, ends at different limits."""
    kinds = {name: case.condition.envelope(case.rudder_deg) for name, case in CASES.items()}
    assert not kinds["jam beyond what the ailerons hold"].feasible
    below, above = kinds["just below the ceiling"], kinds["just above the ceiling"]
    assert below.feasible
    assert not above.feasible
    assert 99 < below.t_min_pct < 100 < above.t_min_pct < 101
    held = {limit for found in kinds.values() if found.feasible for limit in found.at_v_min.limits_hit}
    held |= {limit for found in kinds.values() if found.feasible for limit in found.at_v_max.limits_hit}
    assert {"alpha.upper", "throttle.upper", "aileron.upper", "aileron.lower", "elevator.upper"} <= held

    case, gap = CASES["with a gap"], kinds["with a gap"]
    inner = np.linspace(gap.v_min_kt, gap.v_max_kt, 60)[1:-1]
    reached = np.unique(np.round(scan(case, inner, np.arange(-30, 30.01, 0.5), [case.rudder_deg[0]])[:, V], 6))
    assert 5 < len(reached) < len(inner) - 5


@pytest.mark.parametrize(
    "case",
    [
        restriction(3120.0, 3.3, -4.1, 17.8),
        restriction(25000.0, -4.0, 8.2, 14.9),
        restriction(20000.0, 1.0, -30.0, -9.5),
        restriction(10000.0, 0.0, -30.0, 30.0),
    ],
)
def test_a_restriction_is_the_union_of_its_jams(case):
    """No jam in the range goes beyond it, and the jam at its own deflection goes as far."""
    condition = case.condition
    whole = condition.envelope(case.rudder_deg)
    lower, upper = case.rudder_deg
    nearby = [np.arange(end.rudder_deg - 0.25, end.rudder_deg + 0.3, 0.05) for end in (whole.at_v_min, whole.at_v_max)]
    ends = [whole.at_v_min.rudder_deg, whole.at_v_max.rudder_deg]
    candidates = np.concatenate([np.arange(np.ceil(lower), upper + 1, 2), *nearby, [lower, upper]])
    jams = [condition.envelope((d, d)) for d in np.unique(np.clip([*candidates, *ends], lower, upper))]
    slowest = min(found.v_min_kt for found in jams if found.feasible)
    fastest = max(found.v_max_kt for found in jams if found.feasible)
    assert whole.v_min_kt == pytest.approx(slowest, abs=1e-4)
    assert whole.v_max_kt == pytest.approx(fastest, abs=1e-4)
    assert whole.t_min_pct <= min(found.t_min_pct for found in jams if found.t_min_pct is not None) + 1e-3


def test_widening_the_rudder_never_shrinks_the_envelope():
    rng = np.random.default_rng(5)
    compared = 0
    for _ in range(12):
        condition = FlightCondition(rng.uniform(0, 32000), rng.uniform(-5, 5))
        lower, upper = np.sort(rng.uniform(-25, 25, 2))
        narrow, wide = condition.envelope((lower, upper)), condition.envelope((lower - 4, upper + 3))
        if narrow.feasible:
            compared += 1
            assert wide.feasible
            assert wide.v_min_kt <= narrow.v_min_kt + 1e-4
            assert wide.v_max_kt >= narrow.v_max_kt - 1e-4
        if narrow.t_min_pct is not None:
            assert wide.t_min_pct <= narrow.t_min_pct + 1e-2
    assert compared > 6


def test_more_throttle_aileron_and_bank_never_shrink_the_envelope():
    narrow = envelope(8000, -1, ControlLimits((-8, 6), (-9, 11), (2, 6), (15, 80)), (-2, 8), (-10, 15))
    for name, wider in {
        "elevator_deg": (-12, 9),
        "aileron_deg": (-20, 20),
        "rudder_deg": (0, 8),
        "throttle_pct": (0, 100),
        "alpha_deg": (-5, 10.5),
        "phi_deg": (-30, 30),
    }.items():
        asked = {"alpha_deg": (-2, 8), "phi_deg": (-10, 15)}
        limits = {"elevator_deg": (-8, 6), "aileron_deg": (-9, 11), "rudder_deg": (2, 6), "throttle_pct": (15, 80)}
        (asked if name in asked else limits)[name] = wider
        wide = envelope(8000, -1, ControlLimits(**limits), **asked)
        assert wide.v_min_kt <= narrow.v_min_kt + 1e-4, name
        assert wide.v_max_kt >= narrow.v_max_kt - 1e-4, name


@pytest.fixture(scope="module")
def figure_3() -> dict[float, Envelope]:
    """Jams at 10000 ft and gamma -5 deg (paper Fig. 3)."""
    condition = FlightCondition(10000, -5)
    return {float(jam): condition.envelope((jam, jam)) for jam in range(-30, 31, 5)}


def test_a_rudder_jammed_at_zero_leaves_what_the_unimpaired_aircraft_has(figure_3):
    """As the paper reads it off Fig. 3; exactly, the free rudder finds up to half a knot more."""
    unimpaired = envelope(10000, -5)
    assert figure_3[0].v_min_kt == pytest.approx(unimpaired.v_min_kt, abs=0.5)
    assert figure_3[0].v_max_kt == pytest.approx(unimpaired.v_max_kt, abs=0.1)
    assert unimpaired.v_min_kt <= figure_3[0].v_min_kt
    assert unimpaired.v_max_kt >= figure_3[0].v_max_kt


def test_the_envelope_shrinks_with_the_jam_angle(figure_3):
    """Paper Fig. 3 and its text: V_max falls with |jam|; V_min rises where the ailerons hold it."""
    for side in (1, -1):
        fastest = [figure_3[side * jam].v_max_kt for jam in (0, 5, 10, 15, 20, 25)]
        slowest = [figure_3[side * jam].v_min_kt for jam in (10, 15, 20, 25)]
        assert np.all(np.diff(fastest) < -1)
        assert np.all(np.diff(slowest) > 0.5)
        assert not figure_3[side * 30].feasible
        assert figure_3[side * 25].at_v_min.limits_hit[0] == ("aileron.lower" if side > 0 else "aileron.upper")
        assert "alpha.upper" in figure_3[side * 5].at_v_min.limits_hit
    assert figure_3[0].at_v_min.alpha_deg == pytest.approx(10.5, abs=1e-6)


def test_left_and_right_are_alike_but_not_the_same(figure_3):
    """The centre of gravity lies 0.0118 ft left (SPEC 3) and the engines do not cancel (SPEC 6)."""
    for jam in (5.0, 10.0, 15.0, 20.0):
        difference = figure_3[jam].v_max_kt - figure_3[-jam].v_max_kt
        assert 1e-3 < abs(difference) < 1.0


@pytest.fixture(scope="module")
def paper_lattice(tmp_path_factory):
    return dataset.solved(tmp_path_factory.mktemp("paper") / "lattice.zarr", dataset.lattice(), workers=2)


def test_1044_cases_of_the_lattice_have_an_envelope(paper_lattice):
    """methods/ENVELOPE.md; t_min decides."""
    assert paper_lattice.feasible.size == 1232
    assert int(paper_lattice.feasible.sum()) == 1044
    least = paper_lattice.t_min.values
    np.testing.assert_array_equal(paper_lattice.feasible.values, np.where(np.isnan(least), False, least <= 100 + 1e-6))
    for name in ("v_min", "v_max"):
        np.testing.assert_array_equal(np.isnan(paper_lattice[name].values), ~paper_lattice.feasible.values)


def test_the_lattice_looks_as_described(paper_lattice):
    """methods/ENVELOPE.md: full throttle at V_max; alpha at 10.5 deg, ailerons or throttle at a limit at V_min."""
    feasible = paper_lattice.feasible.values
    ends = {name: values.values[feasible] for name, values in paper_lattice.data_vars.items()}
    assert np.all(ends["v_min"] <= ends["v_max"])
    np.testing.assert_allclose(ends["throttle_at_v_max"], 100, atol=1e-4)
    stalled = np.isclose(ends["alpha_at_v_min"], 10.5, atol=1e-4)
    rolled = np.isclose(np.abs(ends["aileron_at_v_min"]), 20, atol=1e-4)
    powered = np.isclose(np.abs(ends["throttle_at_v_min"] - 50), 50, atol=1e-3)
    assert np.all(stalled | rolled | powered)
    assert min(stalled.sum(), rolled.sum(), powered.sum()) > 20
    inside = {
        "alpha": (-5, 10.5),
        "phi": (-30, 30),
        "elevator": (-30, 30),
        "aileron": (-20, 20),
        "throttle": (0, 100),
    }
    for name, (lower, upper) in inside.items():
        for end in ("v_min", "v_max"):
            assert np.all((ends[f"{name}_at_{end}"] >= lower - 1e-5) & (ends[f"{name}_at_{end}"] <= upper + 1e-5))


def test_wider_failures_of_the_lattice_contain_narrower_ones(paper_lattice):
    """All 28 failures at all 44 conditions: a range holds the envelopes of the ranges inside it."""
    lower, upper = paper_lattice.rudder_lower.values, paper_lattice.rudder_upper.values
    v_min = paper_lattice.v_min.fillna(np.inf).values
    v_max = paper_lattice.v_max.fillna(-np.inf).values
    for wide in range(len(lower)):
        for narrow in np.flatnonzero((lower >= lower[wide]) & (upper <= upper[wide])):
            assert np.all(v_min[..., wide] <= v_min[..., narrow] + 1e-4)
            assert np.all(v_max[..., wide] >= v_max[..., narrow] - 1e-4)


def test_without_an_envelope_the_nearest_trim_is_given():
    found = envelope(30000, 5, ControlLimits(rudder_deg=(20, 20)))
    assert not found.feasible
    assert (found.v_min_kt, found.v_max_kt) == (None, None)
    assert found.t_min_pct is None or found.t_min_pct > 100
    assert found.at_v_min is found.at_v_max is None
    trim = found.nearest
    assert trim.converged
    assert not trim.feasible
    assert "throttle.upper" in trim.limits_hit
    assert trim.throttle_pct > 100
    x, u = trim.state_and_controls
    assert np.abs(plain_model.derivatives(x, u)[:6]).max() < 1e-9
    values = json.loads(json.dumps(found.to_dict()))
    assert values["feasible"] is False
    assert values["v_min_kt"] is None
    assert values["at_v_min"] is values["at_v_max"] is None
    assert values["nearest"]["feasible"] is False


def test_an_envelope_as_json():
    found = envelope(10000, -2, ControlLimits(rudder_deg=(-10, 20)))
    values: dict[str, Any] = json.loads(json.dumps(found.to_dict()))
    assert values["v_min_kt"] == found.v_min_kt == values["at_v_min"]["tas_kt"]
    assert values["v_max_kt"] == found.v_max_kt == values["at_v_max"]["tas_kt"]
    assert values["limits"]["rudder_deg"] == [-10, 20]
    assert values["altitude_ft"] == 10000
    assert values["gamma_deg"] == -2


@pytest.mark.parametrize("wrong", [(20, 10), (-31, 0), (float("nan"), 0), "left", 5])
def test_wrong_rudder_limits(wrong):
    condition = FlightCondition(0, 0)
    with pytest.raises(InputError, match="rudder in deg"):
        condition.envelope(wrong)


@pytest.mark.parametrize("held", ["elevator_deg", "aileron_deg", "throttle_pct"])
def test_a_second_jam_is_the_limit_of_narrow_ranges(held):
    """With another control jammed at the deflection of a known trim: its speed is inside, and a hair more room gives
    the same envelope."""
    trim = steady.trim(10000, 120, 0, 2, ControlLimits(rudder_deg=(3, 3)))
    assert trim.feasible
    value = getattr(trim, held)
    for rudder in ((3, 3), (1, 8)):
        jammed = envelope(10000, 0, ControlLimits(**{"rudder_deg": rudder, held: (value, value)}))
        room = envelope(10000, 0, ControlLimits(**{"rudder_deg": rudder, held: (value - 1e-4, value + 1e-4)}))
        assert jammed.v_min_kt <= 120 + 1e-6
        assert jammed.v_max_kt >= 120 - 1e-6
        assert jammed.v_min_kt == pytest.approx(room.v_min_kt, abs=0.02)
        assert jammed.v_max_kt == pytest.approx(room.v_max_kt, abs=0.02)
        for end in (jammed.at_v_min, jammed.at_v_max):
            lower, upper = manoeuvre.bounds(ControlLimits(**{"rudder_deg": rudder, held: (value, value)}))
            assert_is_a_trim_of_the_condition(end, 10000, 0, lower, upper)


def test_four_jams_leave_single_points():
    """Elevator, aileron, rudder and throttle jammed where a trim has them: that one speed is left."""
    trim = steady.trim(10000, 118.5, 0, 0, ControlLimits(rudder_deg=(10, 10)))
    jams = {"elevator_deg": trim.elevator_deg, "aileron_deg": trim.aileron_deg, "throttle_pct": trim.throttle_pct}
    limits = ControlLimits(**{name: (value, value) for name, value in jams.items()}, rudder_deg=(10, 10))
    found = envelope(10000, 0, limits)
    assert found.v_min_kt == pytest.approx(118.5, abs=1e-6)
    assert found.v_max_kt == pytest.approx(118.5, abs=1e-6)
    away = ControlLimits(**{name: (value + 2, value + 2) for name, value in jams.items()}, rudder_deg=(10, 10))
    assert not envelope(10000, 0, away).feasible


def test_banks_and_incidence_may_be_held():
    level = FlightCondition(10000, 0, phi_deg=(0, 0)).envelope()
    assert level.feasible
    for trim in (level.at_v_min, level.at_v_max):
        assert trim.unknowns[PHI] == pytest.approx(0, abs=1e-9)
    cruise = FlightCondition(10000, 0, alpha_deg=(3, 3)).envelope()
    assert cruise.at_v_max.alpha_deg == pytest.approx(3, abs=1e-6)
    assert cruise.at_v_max.unknowns[RUDDER] == pytest.approx(cruise.at_v_max.rudder_deg)
    assert level.v_max_kt <= envelope(10000, 0).v_max_kt + 1e-6
