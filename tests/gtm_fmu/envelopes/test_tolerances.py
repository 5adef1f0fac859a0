"""Guaranteed and possible envelopes and manoeuvres: closed forms of the gust, and every corner of the box."""

import math
from dataclasses import replace

import numpy as np
import pytest

from gtm_fmu import (
    CaseTable,
    ControlLimits,
    Failure,
    FlightCondition,
    InputError,
    Tolerances,
    manoeuvres,
    span,
    tolerant_envelope,
    tolerant_manoeuvres,
)
from gtm_fmu.airframe.names import V
from gtm_fmu.core.configuration import Configuration
from gtm_fmu.datasets import results
from gtm_fmu.datasets.axes import limit_levels
from gtm_fmu.datasets.cases import Sampling
from gtm_fmu.datasets.store import CaseStore, open_cases, slices
from gtm_fmu.envelopes.box_search import EndSearch
from gtm_fmu.envelopes.maps import limit_surface
from tests.reference import plain_model

JAM, JAM_10 = ControlLimits(rudder_deg=(15, 15)), ControlLimits(rudder_deg=(10, 10))
CASES = {
    "jam": (10000.0, 0.0, JAM),
    "jam at a limit of alpha": (3000.0, -2.0, ControlLimits(rudder_deg=(4, 4))),
    "restricted": (5000.0, 0.0, ControlLimits(rudder_deg=(6, 8))),
    "damaged": (2000.0, 0.0, Failure(ControlLimits(rudder_deg=(-7, -7)), Configuration(damage_case=5))),
}
BOX = Tolerances(mass_tolerance=0.05, cg_tolerance=0.02, aero_tolerance=0.05)
KT, G = 0.592487, 32.174  # kn in ft/s (SPEC 1), ft/s^2 of load factors (SPEC 8)
DENSITY_10000 = 0.0017555  # slug/ft^3, standard atmosphere
S, WEIGHT = 5.9018, 57.75  # ft^2, lb (SPEC 3)


@pytest.fixture(scope="module")
def in_gust():
    return tolerant_envelope(10000, 0, ControlLimits(rudder_deg=(0, 0)), Tolerances(gust_kt=8))


def lift_coefficient(alpha_deg: float, elevator_deg: float) -> float:
    """Of the plain model's tables without sideslip and rates."""
    tables = plain_model.airframe_tables()
    u = np.array([elevator_deg, 0.0, 0.0, 0.0])
    x = np.zeros(12)
    x[0], x[2] = 150 * math.cos(math.radians(alpha_deg)), 150 * math.sin(math.radians(alpha_deg))
    C = plain_model.coefficients(x, u, tables)
    return C[0] * math.sin(math.radians(alpha_deg)) - C[2] * math.cos(math.radians(alpha_deg))


def test_alpha_reaches_its_bound_in_the_gust(in_gust):
    low, _ = in_gust.guaranteed
    assert low.trim.alpha_deg + math.degrees(math.atan(8 / low.trim.tas_kt)) == pytest.approx(10.5, abs=1e-4)
    assert low.gust_alpha_deg == pytest.approx(math.degrees(math.atan(8 / low.trim.tas_kt)), abs=1e-12)


def test_slowest_speed_in_the_gust_is_that_of_the_lift_at_the_lower_alpha(in_gust):
    """1-g stall: V_min goes with CL(alpha)^-1/2, and alpha with the gust is the bound. The thrust carries a share."""
    low, nominal = in_gust.guaranteed[0].trim, in_gust.nominal.at_v_min
    lift = [lift_coefficient(trim.alpha_deg, trim.elevator_deg) for trim in (nominal, low)]
    assert low.tas_kt / nominal.tas_kt == pytest.approx(math.sqrt(lift[0] / lift[1]), rel=0.01)


def test_load_factor_of_the_gust_is_the_textbooks(in_gust):
    """Delta n = rho V w S CL_alpha / 2 W of a sharp-edged gust."""
    for end in in_gust.guaranteed:
        trim = end.trim
        around = [lift_coefficient(trim.alpha_deg + d, trim.elevator_deg) for d in (-0.05, 0.05)]
        slope = (around[1] - around[0]) / math.radians(0.1)
        expected = DENSITY_10000 * trim.tas_kt / KT * 8 / KT * S * slope / (2 * WEIGHT)
        assert end.gust_load_factor == pytest.approx(expected, rel=0.06)


def test_head_on_gust_takes_its_speed_from_either_end(in_gust):
    low, high = in_gust.guaranteed
    assert low.tas_kt == pytest.approx(low.trim.tas_kt + 8, abs=1e-12)
    assert high.tas_kt == pytest.approx(high.trim.tas_kt - 8, abs=1e-12)
    assert [end.tas_kt for end in in_gust.possible] == [in_gust.nominal.v_min_kt, in_gust.nominal.v_max_kt]


def test_a_gust_that_leaves_no_alpha():
    """At no speed of this envelope, up to 147 kn, are 15.5 deg of alpha twice the 20 deg that 50 kn make."""
    assert tolerant_envelope(10000, 0, JAM, Tolerances(gust_kt=50)).guaranteed is None


@pytest.mark.parametrize(
    ("case", "tolerances"),
    [
        *((case, Tolerances(gust_kt=2, mass_tolerance=0.05)) for case in CASES),
        pytest.param("jam at a limit of alpha", replace(BOX, gust_kt=2), marks=pytest.mark.slow),
    ],
)
def test_guaranteed_is_inside_and_possible_outside(case, tolerances):
    found = tolerant_envelope(*CASES[case], tolerances)
    (low, high), (lowest, highest) = (found.speeds_kt(kind) for kind in ("nominal", "possible"))
    assert lowest < low < high < highest
    if found.guaranteed:
        assert low < found.guaranteed[0].tas_kt < found.guaranteed[1].tas_kt < high


def test_without_tolerances_all_three_are_the_same():
    found = tolerant_envelope(*CASES["jam"], Tolerances())
    assert found.speeds_kt("guaranteed") == found.speeds_kt("nominal") == found.speeds_kt("possible")


def ends_at(case: tuple, tolerances: Tolerances, place: tuple[float, ...]) -> list[float]:
    altitude_ft, gamma_deg, limits = case
    failure = tolerances.moved(Failure.of(limits), place)
    return (FlightCondition(altitude_ft, gamma_deg, failure).extremes()[:, V] * KT).tolist()


@pytest.mark.slow
@pytest.mark.parametrize("case", ["jam", "damaged"])
def test_every_corner_and_places_inside(case):
    """All 16 corners of mass and centre of gravity solved exactly, and 16 places inside, of which none is farther."""
    tolerances = Tolerances(mass_tolerance=0.05, cg_tolerance=0.02)
    found = tolerant_envelope(*CASES[case], tolerances)
    corners = np.array([ends_at(CASES[case], tolerances, place) for place in tolerances.corners()])
    inside = np.random.default_rng(1).uniform(-1, 1, (16, 10))
    inside = np.array([ends_at(CASES[case], tolerances, tuple(place)) for place in inside])
    assert len(corners) == 16
    guaranteed, possible = found.speeds_kt("guaranteed"), found.speeds_kt("possible")
    assert guaranteed == pytest.approx((corners[:, 0].max(), corners[:, 1].min()), abs=0.02)
    assert possible == pytest.approx((corners[:, 0].min(), corners[:, 1].max()), abs=0.02)
    assert inside[:, 0].max() < guaranteed[0] < guaranteed[1] < inside[:, 1].min()
    assert possible[0] < inside[:, 0].min() < inside[:, 1].max() < possible[1]


def test_a_fold_that_slopes_do_not_see():
    """V_max of the nominal aircraft, 132.7 kn, falls by more than its slopes tell where the drag folds."""
    case = (26182.77589766583, 0.4157056614516961, ControlLimits(rudder_deg=(-13.768277092901366,) * 2))
    corner = (1, -1, 1, 1, 1, 1, -1, -1, 1, 1)
    search = EndSearch(FlightCondition(*case), BOX, -1.0)
    assert search.worst().tas_kt <= ends_at(case, BOX, corner)[1] + 1e-3 < 119.6


def test_possible_where_the_aircraft_as_it_is_has_no_envelope():
    found = tolerant_envelope(32000, 0, JAM, BOX)
    assert not found.nominal.feasible
    assert found.guaranteed is None
    low, high = found.possible
    assert low.tas_kt < high.tas_kt
    assert low.place["mass"] == -0.05
    assert low.trim.feasible
    assert high.trim.feasible


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"gust_kt": -1}, "gust in kn -1 is outside 0 .. 50"),
        ({"mass_tolerance": 0.5}, "mass tolerance 0.5 is outside 0 .. 0.3"),
        ({"cg_tolerance": math.nan}, "cg tolerance nan is outside"),
        ({"aero_tolerance": "five"}, "aero tolerance 'five' is not a number"),
    ],
)
def test_values_outside_what_is_allowed(values, message):
    with pytest.raises(InputError, match=message.replace(".", r"\.")):
        Tolerances(**values)


SPEEDS = [72.0, 74.0, 80.0, 90.0, 110.0, 135.0, 143.0, 146.0, 148.0, 160.0]


def test_manoeuvres_by_every_aircraft_and_gust():
    """Against the answers about each aircraft, speed and bound of alpha asked for one by one."""
    tolerances = Tolerances(gust_kt=4, mass_tolerance=0.08)
    found = tolerant_manoeuvres(manoeuvres(10000, SPEEDS, limits=JAM), tolerances)
    failures = [Failure(JAM, Configuration(mass_factor=factor)) for factor in (0.92, 1.0, 1.08)]
    for k, speed in enumerate(SPEEDS):
        gusts = []
        for tas_kt in (speed - 4, speed, speed + 4):
            gust_deg = math.degrees(math.atan(4 / tas_kt))
            alpha = -5 + gust_deg, 10.5 - gust_deg
            gusts += [bool(manoeuvres(10000, tas_kt, limits=each, alpha_deg=alpha).feasible[0]) for each in failures]
        assert found.guaranteed[k] == all(gusts)
        still = [bool(manoeuvres(10000, speed, limits=each).feasible[0]) for each in failures]
        assert found.possible[k] == any(still)
    assert 0 < found.guaranteed.sum() < found.possible.sum() < len(SPEEDS)


def test_least_margins_and_who_can_not_fly_it():
    nominal = manoeuvres(10000, [110, 76], limits=JAM)
    found = tolerant_manoeuvres(nominal, Tolerances(gust_kt=3, cg_tolerance=0.02))
    margins = found.to_dict(0)["least_margins"]
    for name, (lower, upper) in nominal.margins(0).items():
        assert 0 < margins[name][0] < lower
        assert 0 < margins[name][1] < upper
    assert found.unfit[0] is None
    told = found.to_dict(1)
    assert (told["guaranteed"], told["possible"], told["least_margins"]) == (False, True, None)
    assert told["not_flown_by"]["tas_kt"] == pytest.approx(73)


@pytest.mark.slow
def test_data_set_keeps_both(tmp_path):
    """As the function gives them, and as a store gives them back."""
    axes = [span("altitude", 0, 20000), span("gamma", -2, 2), limit_levels("rudder", [(10, 10)])]
    table = CaseTable.sampled(axes, Sampling.SOBOL, 2)
    options = {"mass_tolerance": 0.1}
    found = results.evaluate(table.rows(0, 2), tolerances=options)
    for k, case in enumerate(table.rows(0, 2)):
        expected = tolerant_envelope(case[0], case[1], limits=JAM_10, tolerances=Tolerances(**options))
        for kind in ("guaranteed", "possible"):
            assert (found[f"v_min_{kind}"][k], found[f"v_max_{kind}"][k]) == expected.speeds_kt(kind)
    store = CaseStore(tmp_path / "a.zarr", table, {"tolerances": options})
    store.write(range(2), found)
    np.testing.assert_array_equal(open_cases(tmp_path / "a.zarr").v_min_guaranteed, found["v_min_guaranteed"])
    assert sum(part.sizes["case"] for part in slices(tmp_path / "a.zarr")) == 2
    with pytest.raises(InputError, match="tolerances"):
        CaseStore(tmp_path / "a.zarr", table, {"tolerances": {"mass_tolerance": 0.2}})


@pytest.mark.slow
def test_map_of_guaranteed_speeds():
    condition, tolerances = FlightCondition(10000, 0), Tolerances(mass_tolerance=0.1)
    found = limit_surface(condition, step=30, tolerances=tolerances)
    jam = tolerant_envelope(10000, 0, ControlLimits(rudder_deg=(0, 0)), tolerances)
    assert found.v_max_kt[1, 1] == pytest.approx(jam.guaranteed[1].tas_kt)
    assert np.isnan(found.v_max_kt[0, 0])
