"""The thrust map against closed forms, brute force over turn rates, exact envelopes, and its own promises."""

import io
import json
import zipfile
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.airframe.atmosphere import atmosphere
from gtm_fmu.datasets import off_lattice
from gtm_fmu.envelopes.envelope import FlightCondition
from gtm_fmu.envelopes.thrust_map import RUDDER_MAP, THRUST_MAPS, ThrustMap
from gtm_fmu.envelopes.thrust_survey import FASTEST_KT, Nodes, gross_thrust_lbf, reach, survey, thrust_curve
from gtm_fmu.errors import InputError
from gtm_fmu.trims import steady
from tests.reference import spec_values

WIDE = 1e-9  # kt: rounding
ALTITUDES_FT, GAMMAS_DEG = (0.0, 36000.0), (-5.0, 0.0, 5.0)
FULL_THRUST_LBF = 30.0


@pytest.fixture(scope="module")
def rudder() -> ThrustMap:
    return ThrustMap.load()


def density_ratio(*altitudes_ft):
    return np.array([float(atmosphere(h).density) / float(atmosphere(0).density) for h in altitudes_ft])


def synthetic(deflections_deg, slowest_kt, fastest_kt, thrust_lbf, speeds=33) -> ThrustMap:
    """A map from functions of deflection, and of speed, deflection and flight path."""
    shares = np.linspace(0, 1, speeds) ** 2
    table = np.empty((len(ALTITUDES_FT), len(GAMMAS_DEG), len(deflections_deg), 2 + speeds))
    for l, gamma in enumerate(GAMMAS_DEG):  # noqa: E741
        for m, deflection in enumerate(deflections_deg):
            slow, fast = slowest_kt(deflection), fastest_kt(deflection)
            speed = slow + (fast - slow) * shares
            table[:, l, m] = [slow, fast, *thrust_lbf(speed, deflection, gamma)]
    density = density_ratio(*ALTITUDES_FT)
    return ThrustMap("rudder", ALTITUDES_FT, density, GAMMAS_DEG, deflections_deg, table, FULL_THRUST_LBF)


def available(altitude_ft) -> float:
    return FULL_THRUST_LBF * float(atmosphere(altitude_ft).pressure_ratio)


@pytest.mark.parametrize("limits", [(7.0, 7.0), (-20.0, -4.0), (-3.0, 12.0), (10.0, 30.0)])
@pytest.mark.parametrize(("altitude_ft", "gamma_deg"), [(0.0, 0.0), (18000.0, 3.7), (30000.0, -2.0)])
def test_linear_thrust_has_its_closed_form(limits, altitude_ft, gamma_deg):
    """Thrust 5 + 0.1 (V - 60) + 0.2 |d| + 0.4 gamma from V = 60 + |d| on: everything is linear, so nothing is lost."""

    def thrust(speed, deflection, gamma):
        return 5 + 0.1 * (speed - 60) + 0.2 * abs(deflection) + 0.4 * gamma

    even = synthetic(np.linspace(-30, 30, 7), lambda d: 60 + abs(d), lambda d: 400.0, thrust)
    found = even.predict([altitude_ft, gamma_deg, *limits])
    least = 0.0 if limits[0] <= 0 <= limits[1] else min(map(abs, limits))
    eas_per_tas = float(atmosphere(altitude_ft).sqrt_density_ratio)
    assert found.spare_thrust_lbf[0] == pytest.approx(
        available(altitude_ft) - thrust(60 + least, least, gamma_deg), abs=1e-5
    )
    assert found.feasible[0] == (found.spare_thrust_lbf[0] >= 0)
    if found.feasible[0]:
        fastest = 60 + (available(altitude_ft) - 5 - 0.2 * least - 0.4 * gamma_deg) / 0.1
        assert found.v_min_kt[0] * eas_per_tas == pytest.approx(60 + least, abs=1e-4)
        assert found.v_max_kt[0] * eas_per_tas == pytest.approx(fastest, abs=1e-3)


def test_an_end_inside_a_cell_is_found():
    """The slowest speed falls with deflection while the thrust rises: V_min of a range is where it is just enough."""
    crossing = synthetic(
        [-30.0, 30.0], lambda d: 90 - d, lambda d: 400.0, lambda v, d, gamma: 20 + 0.5 * d + 0 * v, speeds=9
    )
    found = crossing.predict([[0.0, 0.0, -30.0, 30.0], [0.0, 0.0, 20.0, 20.0], [0.0, 0.0, 21.0, 30.0]])
    assert found.v_min_kt[:2] == pytest.approx([70.0, 70.0], abs=1e-6)
    assert found.feasible.tolist() == [True, True, False]


def with_reach(least_deg, greatest_deg) -> ThrustMap:
    """A map of thrust 10 + 0.1 (V - 60) whose slowest speed is 60 + 2 x deflection, between deflections that move."""
    shares = np.linspace(0, 1, 17) ** 2
    places = np.linspace(0, 1, 5)
    table, reach = np.empty((2, 3, 5, 19)), np.empty((2, 3, 2))
    for l, gamma in enumerate(GAMMAS_DEG):  # noqa: E741
        reach[:, l] = ends = least_deg(gamma), greatest_deg(gamma)
        for m, deflection in enumerate(ends[0] + (ends[1] - ends[0]) * places):
            slow = 60 + 2 * deflection
            speed = slow + (300 - slow) * shares
            table[:, l, m] = [slow, 300, *(10 + 0.1 * (speed - 60))]
    nodes = density_ratio(*ALTITUDES_FT), GAMMAS_DEG, -30 + 60 * places
    return ThrustMap("elevator", ALTITUDES_FT, *nodes, table, FULL_THRUST_LBF, reach_deg=reach)


def test_deflections_without_manoeuvres():
    """The last deflections are -6 + gamma / 5 and 5: beyond there is nothing, and ranges count as far as these."""
    part = with_reach(lambda gamma: -6 + gamma / 5, lambda gamma: 5.0)
    gamma, last = 2.5, -5.5
    limits = [(-30.0, 30.0), (last, last), (-5.0, 1.0), (last - 1, last - 1), (-30.0, last - 0.01), (6.0, 7.0)]
    found = part.predict([[0.0, gamma, *ends] for ends in limits])
    assert found.feasible.tolist() == [True, True, True, False, False, False]
    assert found.v_min_kt[:3] == pytest.approx([60 + 2 * last, 60 + 2 * last, 50.0], abs=1e-4)
    assert found.v_max_kt[:3] == pytest.approx([260.0] * 3, abs=1e-3)
    assert np.isnan(found.spare_thrust_lbf[3:]).all()
    assert found.fold.tolist() == [False, True, False, False, True, False]  # 0.05 deg from the last one
    assert part.predict_one(0.0, gamma, (20.0, 20.0))["spare_thrust_lbf"] is None


def test_a_file_holds_the_reach(tmp_path):
    part = with_reach(lambda gamma: -6.0, lambda gamma: 5.0)
    again = ThrustMap.load(part.save(tmp_path / "map.npz"))
    assert np.array_equal(again.reach, part.reach)
    with pytest.raises(InputError, match="reach of the shape"):
        replace(part, reach_deg=part.reach[:1])
    with pytest.raises(InputError, match="reversed"):
        replace(part, reach_deg=part.reach[..., ::-1])


def test_jumps_are_told():
    """Thrust over speed with a second valley whose floor is 0.01 lbf below full thrust: V_max jumps with altitude."""

    def valleys(speed, deflection, gamma):
        first = 25 + 0.175 * (speed - 60)
        return np.minimum(first, FULL_THRUST_LBF - 0.01 + 0.1 * np.maximum(0, abs(speed - 120) - 3))

    folded = synthetic(np.linspace(-30, 30, 5), lambda d: 60.0, lambda d: 160.0, valleys, speeds=97)
    found = folded.predict([[altitude, 0.0, 0.0, 0.0] for altitude in (0.0, 20.0, 3000.0)])
    first_valley = [60 + (available(altitude) - 25) / 0.175 for altitude in (20.0, 3000.0)]
    assert found.fold.tolist() == [True, True, False]
    assert found.v_max_kt[0] == pytest.approx(123.1, abs=1.5)  # between two tabulated speeds
    assert found.v_max_kt[1:] * np.sqrt(density_ratio(20.0, 3000.0)) == pytest.approx(first_valley, abs=1e-3)
    assert found.v_max_std_kt[0] > 10 > found.v_max_std_kt[2]


def rough(seed: int) -> ThrustMap:
    """Thrusts, slowest and fastest speeds by chance: nothing about them is smooth."""
    rng = np.random.default_rng(seed)
    slow, fast = dict(enumerate(rng.uniform(55, 80, 6))), dict(enumerate(rng.uniform(100, 160, 6)))
    number = {d: k for k, d in enumerate(np.linspace(-30, 30, 6))}
    return synthetic(
        list(number),
        lambda d: slow[number[d]],
        lambda d: fast[number[d]],
        lambda v, d, gamma: rng.uniform(5, 20) + np.cumsum(rng.normal(0.2, 1.5, len(v))),
        speeds=12,
    )


limits = st.lists(st.floats(-30, 30), min_size=4, max_size=4).map(sorted)


def assert_wider_is_no_smaller(map_, altitude_ft, gamma_deg, limits_deg):
    outer_lower, lower, upper, outer_upper = limits_deg
    pairs = [(lower, upper), (outer_lower, upper), (outer_lower, outer_upper)]
    found = map_.predict([[altitude_ft, gamma_deg, *pair] for pair in pairs])
    assert (np.diff(found.feasible.astype(int)) >= 0).all()
    assert not (np.diff(found.v_min_kt) > WIDE).any()  # NaN where there is none
    assert not (np.diff(found.v_max_kt) < -WIDE).any()


@settings(max_examples=150, deadline=None, derandomize=True)
@given(st.floats(0, 36000), st.floats(-5, 5), limits)
def test_wider_limits_never_shrink_the_envelope(rudder, altitude_ft, gamma_deg, limits_deg):
    assert_wider_is_no_smaller(rudder, altitude_ft, gamma_deg, limits_deg)


@settings(max_examples=150, deadline=None, derandomize=True)
@given(st.integers(0, 10_000), st.floats(0, 36000), st.floats(-5, 5), limits)
def test_wider_limits_never_shrink_the_envelope_of_any_map(seed, altitude_ft, gamma_deg, limits_deg):
    assert_wider_is_no_smaller(rough(seed), altitude_ft, gamma_deg, limits_deg)


def test_errors_off_the_lattice(rudder):
    """The goals of the study, on 4096 cases with exact envelopes."""
    truth = off_lattice.load()
    found = rudder.predict(truth.X)
    speeds = np.column_stack([found.v_min_kt, found.v_max_kt])
    scores = off_lattice.scores(truth, speeds, found.feasible)
    assert truth.jammed.sum() > 1500
    for part in ("restrictions", "jams"):
        assert scores[part]["mse"] < 5e-7
        assert scores[part]["percentile_95_kt"] < 0.06
        assert scores[part]["percentile_99_kt"] < 0.2
        assert scores[part]["largest_kt"] < 1.0
        assert scores[part]["same_verdict"] >= 0.998
    assert scores == rudder.provenance["off_lattice"]


def test_standard_deviations_hold_what_they_say(rudder):
    truth = off_lattice.load()
    found = rudder.predict(truth.X)
    known = truth.feasible & found.feasible
    error = np.abs(np.column_stack([found.v_min_kt, found.v_max_kt]) - truth.speeds_kt)[known]
    deviation = np.column_stack([found.v_min_std_kt, found.v_max_std_kt])[known]
    assert 0.93 < (error < 1.96 * deviation).mean() < 0.97
    worst = np.argsort(-error.max(axis=1))[:20]
    told = found.fold[known] | (error < 3 * deviation).all(axis=1)
    assert told[worst].sum() >= 19
    assert (~found.fold).mean() > 0.99


def test_packaged_truth_is_what_the_solver_finds():
    truth = off_lattice.load()
    for k in (3, 14, 159, 2653, 3589):
        altitude_ft, gamma_deg, lower, upper = truth.X[k].tolist()
        exact = FlightCondition(altitude_ft, gamma_deg).envelope((lower, upper))
        assert exact.feasible == truth.feasible[k]
        if exact.feasible:
            assert truth.speeds_kt[k] == pytest.approx([exact.v_min_kt, exact.v_max_kt], abs=1e-4)


def test_a_curve_is_the_least_thrust_over_all_turns():
    """Each thrust against trims at every turn rate; the least of them lies above it, and near."""
    altitude_ft, gamma_deg, deflection = 8000.0, 1.0, 13.0
    slowest, fastest, *thrusts = thrust_curve("rudder", altitude_ft, gamma_deg, deflection, 9)
    eas_per_tas = float(atmosphere(altitude_ft).sqrt_density_ratio)
    assert fastest == pytest.approx(FASTEST_KT)
    limits = ControlLimits(rudder_deg=(deflection, deflection))
    for i in (1, 3, 5):
        tas_kt = (slowest + (fastest - slowest) * (i / 8) ** 2) / eas_per_tas
        turns = [steady.trim(altitude_ft, tas_kt, gamma_deg, rate, limits) for rate in np.arange(-12, 12, 0.1)]
        least = min(gross_thrust_lbf(trim.throttle_pct, altitude_ft) for trim in turns if trim.feasible)
        assert -1e-6 <= least - thrusts[i] < 0.01


def test_full_thrust_is_the_specification_s():
    for row in spec_values.ATMOSPHERE:
        assert gross_thrust_lbf(100.0, row.h) == pytest.approx(2 * float(row.thrust[2]), rel=1e-4)


def test_the_same_thrust_at_all_altitudes():
    """What the map rests on: at equal equivalent airspeed the thrust needed hardly depends on the altitude."""
    low, high = (thrust_curve("rudder", altitude_ft, 0.0, 12.0, 9) for altitude_ft in (0.0, 30000.0))
    assert high == pytest.approx(low, rel=0.005)


def test_a_small_survey_agrees_with_the_exact_solver(tmp_path):
    """Stopped after its first flight condition, it goes on there and ends with the same map."""
    nodes = Nodes((0.0, 10000.0), (0.0, 1.0), (9.0, 10.0), 16)
    seen, kept = [], tmp_path / "kept.npz"
    small = survey(nodes, progress=lambda done, total: seen.append((done, total)), workers=1)
    assert seen[-1] == (nodes.curves, nodes.curves) == (8, 8)

    def stop(done, total):
        if done == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        survey(nodes, progress=stop, workers=1, kept=kept)
    with pytest.raises(InputError, match="another survey"):
        survey(nodes._replace(speeds=17), workers=1, kept=kept)
    seen.clear()
    again = survey(nodes, progress=lambda done, total: seen.append((done, total)), workers=1, kept=kept)
    assert seen[0] == (3, 8)
    assert np.array_equal(again.table, small.table)
    assert not list(tmp_path.iterdir())

    found = small.predict([10000.0, 0.0, 9.0, 9.0])
    exact = FlightCondition(10000.0, 0.0).envelope((9.0, 9.0))
    assert found.v_min_kt[0] == pytest.approx(exact.v_min_kt, abs=1e-3)
    assert found.v_max_kt[0] == pytest.approx(exact.v_max_kt, abs=2.0)


def test_an_elevator_holds_few_deflections():
    """At sea level in level flight the exact solver finds an envelope at -5.70 deg of elevator and none at -5.74."""
    exact = [FlightCondition(0.0, 0.0, ControlLimits(elevator_deg=(e, e))).envelope() for e in (-5.70, -5.74)]
    assert [each.feasible for each in exact] == [True, False]
    least, _ = reach("elevator", 0.0, 0.0, (-30.0, 30.0))
    assert -5.74 < least < -5.70
    with pytest.raises(InputError, match="no manoeuvre to map"):
        reach("elevator", 0.0, 0.0, (20.0, 30.0))


@pytest.mark.parametrize(
    ("control", "limits"),
    [("aileron", [(4.3, 4.3), (-20.0, 20.0), (7.0, 12.5)]), ("elevator", [(-3.3, -3.3), (-30.0, 0.7), (1.0, 2.5)])],
)
def test_maps_of_other_controls(control, limits):
    """Shipped, small, and near the exact solver at random conditions between the nodes."""
    shipped = ThrustMap.load(THRUST_MAPS[control])
    assert shipped.control == control
    assert THRUST_MAPS[control].stat().st_size < 150_000
    for k, ends in enumerate(limits):
        altitude_ft, gamma_deg = (4321.0, 13579.0, 24680.0)[k], (-3.1, 1.3, 2.2)[k]
        exact = FlightCondition(altitude_ft, gamma_deg, ControlLimits(**{f"{control}_deg": ends})).envelope()
        found = shipped.predict([altitude_ft, gamma_deg, *ends])
        assert found.v_min_kt[0] == pytest.approx(exact.v_min_kt, abs=0.2)
        assert found.v_max_kt[0] == pytest.approx(exact.v_max_kt, abs=0.5)


def test_a_single_speed_has_a_single_thrust():
    """Where manoeuvres end. Else ranges beyond the last deflection told a V_max of 199.56 kn where it is 189.76."""
    _, greatest = reach("elevator", 0.0, -5.0, (-30.0, 30.0))
    slowest, fastest, *thrusts = thrust_curve("elevator", 0.0, -5.0, greatest, 9)
    assert fastest == pytest.approx(slowest, abs=1e-3)
    assert set(thrusts) == {thrusts[0]}
    found = ThrustMap.load(THRUST_MAPS["elevator"]).predict([335.97390588, -4.6775355, -10.3191973, 12.51024404])
    assert found.v_max_kt[0] == pytest.approx(189.76122, abs=0.05)  # the exact solver's


def test_one_case(rudder):
    found = rudder.predict_one(10000.0, 0.0, (-10.0, 20.0))
    many = rudder.predict([[10000.0, 0.0, -10.0, 20.0]])
    plain = {name: column[0] for name, column in many._asdict().items()}
    assert json.loads(json.dumps(found)) == {name: value if value == value else None for name, value in plain.items()}
    without = rudder.predict_one(30000.0, 5.0, (25.0, 30.0))
    assert (without["feasible"], without["v_min_kt"], without["v_max_std_kt"]) == (False, None, None)
    assert without["spare_thrust_lbf"] < 0


def test_domain(rudder):
    found = rudder.predict([[36089.0, 5.0, 0.0, 0.0], [0.0, 5.01, 0.0, 0.0], [0.0, -5.0, -30.0, 30.0]])
    assert found.in_domain.tolist() == [True, False, True]
    far = rudder.predict([[0.0, gamma, -30.0, 30.0] for gamma in (-45.0, 45.0)])
    assert np.isfinite(far.spare_thrust_lbf).all()
    assert not far.in_domain.any()


@pytest.mark.parametrize(
    ("case", "said"),
    [
        ([-1.0, 0.0, 0.0, 0.0], "altitude in ft"),
        ([0.0, 60.0, 0.0, 0.0], "gamma in deg"),
        ([0.0, 0.0, 0.0, 31.0], "rudder in deg"),
        ([0.0, 0.0, 5.0, 4.0], "reversed"),
        ([0.0, np.nan, 0.0, 0.0], "gamma in deg"),
        ([0.0, 0.0, 0.0], "give altitude, gamma, lower, upper"),
    ],
)
def test_bad_cases_are_refused(rudder, case, said):
    with pytest.raises(InputError, match=said):
        rudder.predict(case)


def test_a_file_gives_the_same_map_back(rudder, tmp_path):
    again = ThrustMap.load(rudder.save(tmp_path / "map.npz"))
    assert np.array_equal(again.table, rudder.table)
    assert (again.tolerances, again.provenance) == (rudder.tolerances, rudder.provenance)
    assert [path.name for path in tmp_path.iterdir()] == ["map.npz"]


def rewritten(path, **changed) -> None:
    """The shipped map with some arrays changed, as a file; the checksum is that of the whole one."""
    with np.load(RUDDER_MAP) as content:
        np.savez(path, **{name: content[name] for name in content} | changed)


@pytest.mark.parametrize("name", ["altitude_ft", "density_ratio", "gamma_deg", "deflection_deg", "table", "tolerances"])
@pytest.mark.parametrize("change", ["nan", "inf", "reversed", "negative", "shorter", "text", "one bit"])
def test_altered_arrays_are_refused(tmp_path, name, change):
    """In a file, and where the arrays are given: one sentence, or in memory a map that still answers."""
    with np.load(RUDDER_MAP) as content:
        array = content[name].copy()
    if change in ("nan", "inf", "one bit"):
        array.flat[-1] = np.nextafter(array.flat[-1], np.inf) if change == "one bit" else float(change)
    else:
        reversed_ = array[::-1] if name != "table" else array[..., ::-1]
        kinds = {"reversed": reversed_, "negative": -array - 1, "shorter": array[:-1], "text": array.astype(str)}
        array = kinds[change]
    rewritten(tmp_path / "map.npz", **{name: array})
    with pytest.raises(InputError, match=r"^'.*map.npz' is no readable thrust map \([^\n]+\); make one with"):
        ThrustMap.load(tmp_path / "map.npz")


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("gamma_deg", [-5.0, np.nan, 5.0]),
        ("gamma_deg", [5.0, 0.0, -5.0]),
        ("deflection_deg", np.linspace(30, -30, 97)),
        ("density_ratio", [1.0, np.inf]),
        ("density_ratio", [1.0, 1.0]),
        ("full_thrust_lbf", np.nan),
        ("control", "flaps"),
    ],
)
def test_nodes_that_no_map_has(rudder, name, value):
    with pytest.raises(InputError):
        replace(rudder, **{name: value})


def refusal(path) -> str | None:
    """What is said of a map, None where it is read."""
    try:
        ThrustMap.load(path)
    except InputError as error:
        return str(error)
    return None


def test_cut_and_huge_files_are_refused(rudder, tmp_path):
    """Cut anywhere, or flipped; one of a few bytes that declares 87 GB is told before memory is asked for."""
    whole, path = RUDDER_MAP.read_bytes(), tmp_path / "map.npz"
    rng = np.random.default_rng(0)
    for k in range(60):
        content = bytearray(whole[: rng.integers(len(whole))] if k % 2 else whole)
        for place in rng.integers(len(content), size=3 if k % 2 == 0 else 0):
            content[place] ^= 1 << rng.integers(8)
        path.write_bytes(content)
        told = refusal(path)
        assert told is None or ("is no readable thrust map" in told and "\n" not in told)
        assert told or np.array_equal(ThrustMap.load(path).table, rudder.table)  # a bit that says nothing
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(header, {"descr": "<f8", "fortran_order": False, "shape": (10_875_000_000,)})
    with zipfile.ZipFile(path, "w") as archive, zipfile.ZipFile(RUDDER_MAP) as shipped:
        for name in shipped.namelist():
            archive.writestr(name, header.getvalue() if name == "table.npy" else shipped.read(name))
    with pytest.raises(InputError, match="is no readable thrust map"):
        ThrustMap.load(path)


def test_foreign_files_are_refused(tmp_path):
    damaged, foreign = tmp_path / "damaged.npz", tmp_path / "foreign.npz"
    content = bytearray(RUDDER_MAP.read_bytes())
    content[5000] ^= 255
    damaged.write_bytes(content)
    np.savez(foreign, described=json.dumps({"format": "other"}))
    for path in (damaged, foreign, tmp_path / "missing.npz", tmp_path):
        with pytest.raises(InputError, match="is no readable thrust map"):
            ThrustMap.load(path)
    assert RUDDER_MAP.stat().st_size < 300_000
