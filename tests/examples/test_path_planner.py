"""The planner: its geometry in closed form, and its answers against the exact solver's own interface."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from examples.path_planner.planner import NoPathError, dubins, exact_fmus, plan, read_scenario, tracks
from examples.path_planner.planner.climbs import climbs
from examples.path_planner.planner.connections import Target, connections
from examples.path_planner.planner.elevation_files import read_geotiff, read_hgt
from examples.path_planner.planner.flight import fly
from examples.path_planner.planner.glides import ENGINES_OUT, Glides
from examples.path_planner.planner.landing import Descent
from examples.path_planner.planner.planning import footprint, map_fmu
from examples.path_planner.planner.primitives import Primitives
from examples.path_planner.planner.scenario import Pose, scenario
from examples.path_planner.planner.sources import second_failures
from examples.path_planner.planner.terrain import flat
from gtm_fmu import ControlLimits, Failure, InputError, envelope, manoeuvres, performance, turn_rate_interval
from gtm_fmu.core.configuration import Configuration
from gtm_fmu.units import M_PER_FT, M_S_PER_KT

pytestmark = pytest.mark.slow  # builds FMUs

SCENARIOS = Path(__file__).parents[2] / "examples" / "path_planner" / "scenarios"
JAM = ControlLimits(rudder_deg=(18, 18))


@pytest.fixture(scope="module")
def fmus(tmp_path_factory):
    return tmp_path_factory.mktemp("planner_fmus")


@pytest.fixture(scope="module")
def ridge():
    return read_scenario(SCENARIOS / "ridge.toml")


@pytest.fixture(scope="module")
def exact(fmus, ridge):
    source = exact_fmus(fmus, ridge)
    yield source
    source.close()


@pytest.fixture(scope="module")
def plans(exact, ridge):
    """Around the ridge for a second failure, over it for time."""
    safe = plan(ridge, exact, alternatives=False)
    return {"second failure": safe, "time": plan(replace(ridge, cost=replace(ridge.cost, of="time")), exact, False)}


# Geometry


def test_tracks_are_those_of_the_equations_of_motion():
    """A climbing turn in wind against the integration of dN/dt = V cos(gamma) cos(psi) + W_N and its like."""
    speed, gamma, rate, wind = 50.0, math.radians(5), math.radians(-4), tracks.Wind(6.0, -3.0)

    def motion(t, _):
        psi = math.radians(30) + rate * t
        along = speed * math.cos(gamma)
        return [
            along * math.cos(psi) + wind.north_m_s,
            along * math.sin(psi) + wind.east_m_s,
            speed * math.sin(gamma),
        ]

    end = solve_ivp(motion, (0, 40), [0, 0, 0], rtol=1e-10, atol=1e-10).y[:, -1]
    ahead, right, up, turned = tracks.displacement(speed / M_S_PER_KT, 5.0, -4.0, np.array([40.0]))
    north, east = tracks.over_ground(ahead, right, 30.0, np.array([40.0]), wind)
    assert [north[0], east[0], up[0] * M_PER_FT] == pytest.approx(end, abs=1e-5)
    assert turned[0] == pytest.approx(-160)


def test_the_wind_triangle():
    """3-4-5: 5 m/s against 3 m/s across hold a track at 4 m/s; at 3 m/s nothing does."""
    heading, ground = tracks.heading_for_track(0.0, 5.0, tracks.Wind(0.0, 3.0))
    assert heading == pytest.approx(-math.degrees(math.asin(0.6)))
    assert ground == pytest.approx(4.0)
    assert tracks.heading_for_track(0.0, 3.0, tracks.Wind(0.0, 3.0)) is None


@pytest.mark.parametrize("kind", range(4))
def test_turns_of_unequal_radii_meet_the_end(kind):
    """Flown piece by piece, every pair of turns ends at the place and on the heading."""
    start, end, radii = (0.0, 0.0, 0.4), (3000.0, -2000.0, 2.1), (300.0, 900.0)
    path = dubins.path(start, end, radii, kind)
    north, east, heading = start
    for radius, amount in ((path.first_m, path.first_angle), (0, path.straight_m), (path.last_m, path.last_angle)):
        if radius:
            north -= radius * (math.sin(heading) - math.sin(heading + amount))
            east += radius * (math.cos(heading) - math.cos(heading + amount))
            heading += amount
        else:
            north, east = north + amount * math.cos(heading), east + amount * math.sin(heading)
    assert (north, east) == pytest.approx(end[:2], abs=1e-6)
    assert math.cos(heading - end[2]) == pytest.approx(1)


def test_the_shortest_path_between_opposite_poses_is_known():
    """Radius R to the left alone: from heading north to a place behind, at 2 R to the west heading south, pi R."""
    ends = np.array([0.0]), np.array([-600.0]), math.pi
    zero = np.zeros(1)
    assert dubins.lengths_m(zero, zero, zero, ends, (300.0, 5000.0))[0] == pytest.approx(math.pi * 300, rel=1e-6)


def test_whole_turns_lead_up_where_the_way_is_too_short(ridge):
    """3000 ft higher 2 km ahead at 3 deg at most, in wind: every way ends there, and none without whole turns."""
    windy, start = replace(ridge, wind=tracks.Wind(3.0, -5.0)), ridge.start
    target = Target(2000.0, 500.0, (9000.0, 9000.0), 90.0)
    found = list(connections(start, target, 100.0, (-6.0, 3.0), (-3.0, 0.0, 3.0), windy.wind))
    assert len(found) >= 3  # circles that overlap have no straight line from one side to the other
    for legs in found:
        pose = start
        for leg in legs:
            pose = Pose(*(float(value) for value in fly(pose, leg, np.float64(leg.duration_s), windy)))
            assert 0 < leg.manoeuvre.gamma_deg <= 3.0
        assert (pose.north_m, pose.east_m, pose.altitude_ft) == pytest.approx((2000, 500, 9000), abs=0.1)
        assert pose.heading_deg % 360 == pytest.approx(90)
        turned = sum(abs(leg.manoeuvre.turn_rate_deg_s) * leg.duration_s for leg in legs)
        assert turned > 360


# What the failure leaves


def test_turns_are_those_of_the_exact_solver_and_differ_by_side(exact):
    left, right = exact.turn_rates(6000, 0.0, 107)
    assert (left, right) == pytest.approx(turn_rate_interval(6000, 107, limits=JAM).intervals[0], abs=1e-6)
    assert -left > 8 * right
    rates = Primitives(exact, 107, (0.0,), 0.8, 6000).rates((left, right))
    assert rates == pytest.approx((0.8 * left, 0.5 * left, 0, 0.5 * right, 0.8 * right))


def test_margins_and_speeds_are_those_of_the_exact_solver(exact):
    answer = exact.answer(7000, 3.0, 100, 0.5)
    expected = manoeuvres(7000, 100, 3, 0.5, limits=JAM)
    assert answer.feasible
    assert answer.binding == expected.binding[0].replace("phi", "bank")
    assert answer.margins["aileron_deg"] == pytest.approx(expected.margins(0)["aileron_deg"], abs=1e-6)
    found = envelope(7000, 3.0, limits=JAM)
    failure = {"limits.rudder.lower": 18, "limits.rudder.upper": 18}
    assert exact.speeds(7000, 3.0, failure) == pytest.approx((found.v_min_kt, found.v_max_kt), abs=1e-6)


def test_second_failures_of_a_jam_and_of_a_range():
    jam = {"limits.rudder.lower": 18, "limits.rudder.upper": 18}
    rudder = second_failures(jam, 5.0, False)["rudder 5 deg further"]
    assert [(each["limits.rudder.lower"], each["limits.rudder.upper"]) for each in rudder] == [(13, 13), (23, 23)]
    whole = second_failures({}, 5.0, True)
    assert [each["limits.rudder.lower"] for each in whole["rudder 5 deg further"]] == [-25, -30]
    assert [each["engine.left.running"] for each in whole["an engine out"][:1]] == [False]


def test_without_straight_flight_it_turns_to_one_side():
    """A rudder jammed at 25 deg leaves left turns only at 110 kn; no rate to choose from is zero."""
    left, right = turn_rate_interval(6000, 110, limits=ControlLimits(rudder_deg=(25, 25))).intervals[0]
    assert right < 0
    rates = Primitives.__new__(Primitives)
    rates.reserve = 0.8
    assert all(left < rate < right for rate in rates.rates((left, right)))


# Paths


def test_the_second_failure_asks_for_the_level_way_around(plans):
    """The paper's case: over the ridge is faster, around it is what a second failure of the rudder is survived on."""
    safe, fast = plans["second failure"], plans["time"]
    assert all(segment.gamma_deg == 0 for segment in safe.segments)
    assert max(segment.gamma_deg for segment in fast.segments) >= 3
    assert safe.measures.time_s > 1.2 * fast.measures.time_s
    assert safe.measures.second_failure_kt > 15 > 5 > fast.measures.second_failure_kt


def test_a_steep_climb_is_the_safer_one_where_v_min_is_near(exact, ridge):
    """At 107 kn the paper's words hold at every moment; at 90 kn they do not, by envelopes of the jam 5 deg further."""
    fast, slow = (climbs(ridge, exact, 1000.0, tas_kt) for tas_kt in (107.0, 90.0))
    after = [climb.after_kt for climb in fast]
    assert after == sorted(after, reverse=True)
    further = (
        envelope(6000, 4, ControlLimits(rudder_deg=(23, 23))),
        envelope(7000, 4, ControlLimits(rudder_deg=(23, 23))),
    )
    assert fast[3].after_kt == pytest.approx(min(each.v_max_kt for each in further) - 107, abs=0.01)
    at_4, at_7 = slow[3], slow[6]
    assert at_4.after_kt == pytest.approx(90 - max(each.v_min_kt for each in further), abs=0.01)
    assert at_7.after_kt > at_4.after_kt
    assert at_7.short_kt_s < 0.6 * at_4.short_kt_s
    assert at_4.seconds == pytest.approx(1000 * M_PER_FT / (90 * M_S_PER_KT * math.sin(math.radians(4))))


@pytest.mark.parametrize("name", ["second failure", "time"])
def test_a_plan_can_be_flown_and_keeps_off_the_ground(plans, ridge, name):
    """Every segment is feasible at both ends by the exact solver's own interface; the ground is that of the grid."""
    found = plans[name]
    rows = [(s.altitude_ft, s.tas_kt, s.gamma_deg, s.turn_rate_deg_s) for s in found.segments]
    ends = [*rows[1:], (found.altitude_ft[-1], *rows[-1][1:])]
    at_ends = [(end[0], *row[1:]) for row, end in zip(rows, ends, strict=True)]
    assert manoeuvres(*np.array(rows + at_ends).T, limits=JAM).feasible.all()
    ground = ridge.terrain.height(found.north_m, found.east_m)
    assert (found.altitude_ft - ground).min() >= ridge.clearance_ft
    speed = np.hypot(np.diff(found.north_m), np.diff(found.east_m)) / np.diff(found.time_s)
    assert speed == pytest.approx(found.segments[0].tas_kt * M_S_PER_KT, rel=0.02)
    assert (found.north_m[-1], found.east_m[-1]) == pytest.approx((9000, -4500), abs=1.0)


def test_a_map_knows_speeds_and_no_turns(fmus, ridge, exact):
    """Its speeds are the exact ones to 0.2 kn; its turns are alike to both sides: five times too fast to the right."""
    source = map_fmu(fmus, ridge)
    safe = map_fmu(fmus, ridge, is_safe=True)
    try:
        for failure in second_failures(ridge.failure, 5.0, False)["rudder 5 deg further"]:
            assert source.speeds(7000, 3.0, failure) == pytest.approx(exact.speeds(7000, 3.0, failure), abs=0.2)
        left, right = source.turn_rates(6000, 0.0, 107)
        inside = safe.speeds(7000, 3.0, ridge.failure)
    finally:
        source.close()
        safe.close()
    assert right == -left == pytest.approx(math.degrees(9.81 * math.tan(math.radians(30)) / (107 * M_S_PER_KT)))
    assert right > 4 * exact.turn_rates(6000, 0.0, 107)[1]
    low, high = exact.speeds(7000, 3.0, ridge.failure)
    assert low < inside[0] < low + 0.5
    assert high - 0.5 < inside[1] < high


# Landing


def test_glides_of_a_jam_are_those_of_the_exact_solver(fmus):
    """The flattest, over speeds, against `performance`."""
    failure = {**ENGINES_OUT, "limits.rudder.lower": 10, "limits.rudder.upper": 10}
    case = scenario(landing_tables(failure), Path(), "glide")
    with_jam = Failure(ControlLimits(rudder_deg=(10, 10)), configuration=Configuration(engine_running=(False, False)))
    source = exact_fmus(fmus, case)
    glides = Glides(source, failure)
    try:
        flattest = max(glides._straight(6000.0).values())
        assert flattest == pytest.approx(performance(6000, with_jam)["flattest_glide_deg"].value, abs=0.02)
        descent = Descent(case, glides)
        legs = descent.path_to(case.runways[0])
    finally:
        glides.close()
        source.close()
    assert legs is not None
    end = descent.legs(case.start, [(leg.manoeuvre.turn_rate_deg_s, leg.duration_s) for leg in legs])[1]
    assert (end.north_m, end.east_m) == pytest.approx((-3000, 1500), abs=5.0)
    assert end.altitude_ft == pytest.approx(4000, abs=10.0)
    assert end.heading_deg % 360 == pytest.approx(180, abs=1e-6)


def test_a_runway_out_of_reach_is_named_with_what_is_missing(fmus):
    tables = landing_tables(ENGINES_OUT)
    tables["runway"] = [{"name": "far", "north_m": 20000, "east_m": 0, "heading_deg": 0}]
    case = scenario(tables, Path(), "far")
    source = exact_fmus(fmus, case)
    try:
        with pytest.raises(NoPathError, match=r"the nearest, far, is missed by \d+ ft"):
            plan(case, source)
        found = footprint(case, source)
    finally:
        source.close()
    assert not found.runways[0].is_reached
    # A glide of gamma from 2300 ft above the clearance goes as far as that over tan(gamma), less what the turn takes.
    furthest = np.hypot(found.north_m, found.east_m).max()
    assert furthest == pytest.approx(1800 * M_PER_FT / math.tan(-math.radians(found.gamma_deg)), rel=0.02)


def landing_tables(failure):
    names = {}
    for name, value in failure.items():
        names[name] = value
    return {
        "failure": names,
        "start": {"altitude_ft": 6000, "heading_deg": 0},
        "terrain": {"ground_ft": 4000},
        "runway": [{"name": "south", "north_m": -3000, "east_m": 1500, "heading_deg": 180}],
    }


# Terrain


def test_terrain_is_bilinear_and_ends(ridge):
    plain = flat(4000.0, 1000.0)
    assert plain.height(np.array([0.0, 2000.0]), np.array([0.0, 0.0])).tolist() == [4000.0, math.inf]
    plain.height_ft[:] = [[0, 100], [200, 300]]
    assert plain.height(np.array([-500.0]), np.array([500.0]))[0] == pytest.approx(0.25 * 200 + 0.75 * 100)


def test_a_tile_of_srtm(tmp_path):
    """Rows run from the north; one degree of latitude is 111.1 km; a void is as high as the highest."""
    heights = np.zeros((3, 3), ">i2")
    heights[0, 0], heights[2, 2], heights[1, 1] = 1000, 500, -32768
    (tmp_path / "N47E011.hgt").write_bytes(heights.tobytes())
    found = read_hgt(tmp_path / "N47E011.hgt", (47.0, 11.0))
    assert found.north_m == pytest.approx([0, 55566, 111132])
    assert found.height_ft[2, 0] == pytest.approx(1000 / 0.3048)
    assert found.height_ft[0, 2] == pytest.approx(500 / 0.3048)
    assert found.height_ft[1, 1] == found.height_ft.max()
    (tmp_path / "tile.hgt").write_bytes(b"")
    with pytest.raises(InputError, match="does not say its corner"):
        read_hgt(tmp_path / "tile.hgt", None)


def test_a_geotiff(tmp_path):
    rasterio = pytest.importorskip("rasterio")
    heights = np.array([[1000, 2000, 0], [0, 0, 500]], np.float32)
    place = rasterio.transform.from_origin(600_000, 5_300_000, 100, 100)
    options = {"height": 2, "width": 3, "count": 1, "dtype": "float32", "crs": "EPSG:32632", "transform": place}
    with rasterio.open(tmp_path / "alps.tif", "w", driver="GTiff", **options) as file:
        file.write(heights, 1)
    found = read_geotiff(tmp_path / "alps.tif", (5_299_850.0, 600_050.0))
    assert found.north_m == pytest.approx([0, 100])
    assert found.east_m == pytest.approx([0, 100, 200])
    assert found.height_ft[1] == pytest.approx(np.array([1000, 2000, 0]) / 0.3048)


# Wrong input


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "[start]\naltitude_ft = 5000\nheading_deg = 0\n[cost]\nof = 'second failure'\nrudder_lost_deg = 0\n"
            "engine_out = false",
            "there is none; give rudder_lost_deg or engine_out",
        ),
        ("[start", "cannot be read as a scenario"),
        ("[goal]\nnorth_m = 1", "start"),
        ("[start]\naltitude_ft = 99999\nheading_deg = 0", "altitude_ft of .start. 99999 is outside"),
        ("[start]\naltitude_ft = 5000\nheading_deg = 0\nspeed = 3", "unknown key 'speed'"),
        ("[start]\naltitude_ft = 5000\nheading_deg = 0", "neither a .goal. nor a ..runway"),
        ("[start]\naltitude_ft = 5000\nheading_deg = 0\n[terrain]\nfile = 'no.npz'", "There is no terrain"),
        ("[start]\naltitude_ft = 5000\nheading_deg = 0\n[cost]\nof = 'fuel'", "give one of time, distance"),
    ],
)
def test_wrong_scenarios_are_refused_in_one_sentence(tmp_path, text, message):
    (tmp_path / "wrong.toml").write_text(text)
    with pytest.raises(InputError, match=message):
        read_scenario(tmp_path / "wrong.toml")


@pytest.mark.parametrize("failure", [{"limits.rudder.low": 3.0}, {"engine.left.running": 1.0}])
def test_wrong_failures_are_refused(fmus, ridge, failure):
    with pytest.raises(InputError, match="The failure's"):
        exact_fmus(fmus, replace(ridge, failure=failure))


def test_a_start_in_the_ground_and_one_without_an_envelope(exact, fmus, ridge):
    low = replace(ridge, start=ridge.start._replace(altitude_ft=3000.0))
    with pytest.raises(NoPathError, match=r"in the ground of 40\d\d ft there; with the clearance, 42\d\d ft"):
        plan(low, exact)
    inside = replace(ridge, goal=replace(ridge.goal, north_m=5500.0, east_m=-3000.0, altitude_ft=(5000.0, 6000.0)))
    with pytest.raises(
        NoPathError, match=r"too near the ground of 71\d\d ft there, or in it; with the clearance, 73\d\d ft"
    ):
        plan(inside, exact)
    level = replace(ridge, gammas_deg=(0.0,), goal=replace(ridge.goal, altitude_ft=(7000.0, 8000.0)))
    with pytest.raises(NoPathError, match=r"does not climb to 7000 ft .* it gets to about 6000 ft"):
        plan(level, exact)
    jam = {"limits.rudder.lower": 30.0, "limits.rudder.upper": 30.0}
    nothing = replace(ridge, failure=jam)
    source = exact_fmus(fmus, nothing)
    try:
        with pytest.raises(NoPathError, match="No steady flight"):
            plan(nothing, source)
    finally:
        source.close()
