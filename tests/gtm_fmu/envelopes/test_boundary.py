"""The boundary polygon against edges found without the search along the manifold: Newton trims and bisection."""

import json
from itertools import pairwise

import numpy as np
import pytest

from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.core import solver
from gtm_fmu.core.configuration import Configuration
from gtm_fmu.envelopes.boundary import RATE_TOLERANCE_DEG_S, SPEED_TOLERANCE_KT, Boundary, envelope_boundary
from gtm_fmu.envelopes.envelope import FlightCondition
from gtm_fmu.trims import manoeuvre, steady
from tests.gtm_fmu.envelopes import brute_force
from tests.reference import plain_model

pytestmark = pytest.mark.slow

GAP = (33591.549399502124, 0.3801354179272882, Failure(ControlLimits(rudder_deg=(7.731865359248744,) * 2)))


def rudder(lower, upper, **others) -> Failure:
    return Failure(ControlLimits(rudder_deg=(lower, upper)), **others)


JAMS = {
    "jam": (7431.0, 1.37, rudder(-6.4, -6.4)),
    "jam at a breakpoint": (12000.0, -4.2, rudder(10, 10)),
    "hard jam": (18250.0, -3.1, rudder(22.6, 22.6)),
    "near the ceiling": (30000.0, 1.0, rudder(9, 9)),
    "with a gap": GAP,
    "jam and a lost wing tip": (5000.0, 1.0, rudder(4, 4, configuration=Configuration(damage_case=4))),
}
RESTRICTIONS = {
    "restriction": (10000.0, -5.0, rudder(5, 25)),
    "narrow, near the ceiling": (31000.0, 0.6, rudder(-9, -5.5)),
}
STEP_DEG_S = 1.0
RATES_DEG_S = np.arange(-20.0, 20.01, STEP_DEG_S)
TOLERANCES = np.array([SPEED_TOLERANCE_KT, RATE_TOLERANCE_DEG_S])


def feasible(condition: FlightCondition, tas_kt, rates_deg_s, rudder_deg):
    """Whether the jammed trim at each place is inside the bounds, and which of them it exceeds or holds."""
    at = condition.altitude_ft, tas_kt, condition.gamma_deg, rates_deg_s, condition.failure
    found = steady.trims(*at, rudder_deg=np.stack([rudder_deg, rudder_deg], axis=-1))
    return (found.status == solver.TRIMMED).reshape(np.shape(tas_kt)), found.y


def edges(condition: FlightCondition, speeds_kt, rudders_deg) -> np.ndarray:
    """Lowest and highest turn rate (2, speeds) of any of the jams, bisected from a scan to 1e-4 deg/s; NaN for none."""
    speed, jam, rate = (a.astype(float) for a in np.meshgrid(speeds_kt, rudders_deg, RATES_DEG_S, indexing="ij"))
    inside, _ = feasible(condition, speed, rate, jam)
    found = []
    for side, order in ((-1, inside), (1, inside[..., ::-1])):
        has_some = inside.any(axis=-1)
        first = order.argmax(axis=-1)
        first = first if side < 0 else len(RATES_DEG_S) - 1 - first
        good, bad = RATES_DEG_S[first], RATES_DEG_S[first] + STEP_DEG_S * side
        for _ in range(14):
            middle = 0.5 * (good + bad)
            is_inside, _ = feasible(condition, speed[..., 0], middle, jam[..., 0])
            good, bad = np.where(is_inside, middle, good), np.where(is_inside, bad, middle)
        outermost = np.where(has_some, side * good, -np.inf).max(axis=-1)
        found.append(np.where(np.isfinite(outermost), side * outermost, np.nan))
    return np.array(found)


def distance(boundary: Boundary, tas_kt: float, rate_deg_s: float) -> float:
    """From a point to the nearest on the polygons, in units of the promised tolerances."""
    nearest = []
    for rates, speeds in boundary.outlines:
        vertices = np.arange(len(speeds))
        places = np.linspace(0, vertices[-1], 40 * len(speeds))
        along = np.array(
            [np.interp(places, vertices, speeds) - tas_kt, np.interp(places, vertices, rates) - rate_deg_s]
        )
        nearest.append(np.abs(along / TOLERANCES[:, None]).max(axis=0).min())
    return min(nearest)


def ends(boundary: Boundary, inside_kt: float) -> tuple[float, float]:
    """Lowest and highest speed of the polygons, and a little inside."""
    speeds = np.concatenate([speed for _, speed in boundary.outlines])
    return speeds.min() + inside_kt, speeds.max() - inside_kt


def crossings(boundary: Boundary, tas_kt: float) -> np.ndarray:
    """Turn rates at which the polygons cross a speed, rising."""
    found = []
    for rates, speeds in boundary.outlines:
        k = np.flatnonzero((speeds[1:] > tas_kt) != (speeds[:-1] > tas_kt))
        found.append(rates[k] + (tas_kt - speeds[k]) / (speeds[k + 1] - speeds[k]) * (rates[k + 1] - rates[k]))
    return np.sort(np.concatenate(found))


@pytest.mark.parametrize("name", JAMS)
def test_polygon_of_a_jam_lies_on_the_edges_of_its_trims(name):
    condition = FlightCondition(*JAMS[name])
    boundary = envelope_boundary(condition)
    speeds = np.linspace(*ends(boundary, 0.11), 41)
    found = edges(condition, speeds, [condition.limits.rudder_deg[0]])
    assert np.isfinite(found).mean() > 0.6
    for speed, *rates in zip(speeds, *found, strict=True):
        if np.isfinite(rates).all():
            assert max(distance(boundary, speed, rate) for rate in rates) < 1
        else:
            assert not any(outline.min() < speed < outline.max() for _, outline in boundary.outlines)


@pytest.mark.parametrize("name", RESTRICTIONS)
def test_polygon_of_a_restriction_holds_the_edges_of_its_jams(name):
    """All jams lie inside; where it goes beyond their grid, the jam of its own deflection reaches it."""
    condition = FlightCondition(*RESTRICTIONS[name])
    boundary = envelope_boundary(condition)
    speeds = np.linspace(*ends(boundary, 0.3), 5)
    jams = np.linspace(*condition.limits.rudder_deg, 21)
    drawn = np.array([crossings(boundary, speed)[[0, -1]] for speed in speeds])
    for sign, found, rates in zip((-1, 1), edges(condition, speeds, jams), drawn.T, strict=True):
        assert np.all(sign * found <= sign * rates + RATE_TOLERANCE_DEG_S)
        for speed, rate in zip(speeds, rates, strict=True):
            at = condition.altitude_ft, speed, condition.gamma_deg
            assert steady.trim(*at, rate - sign * RATE_TOLERANCE_DEG_S, condition.limits).feasible
            outer, _ = feasible(condition, np.full(21, speed), np.full(21, rate + sign * RATE_TOLERANCE_DEG_S), jams)
            assert not outer.any()


@pytest.mark.parametrize("name", ["jam", "hard jam", "jam and a lost wing tip"])
def test_every_piece_names_the_limit_that_a_trim_beyond_it_exceeds(name):
    condition = FlightCondition(*JAMS[name])
    jam, kinds = condition.limits.rudder_deg[0], set()
    (around,) = envelope_boundary(condition).polygons
    for piece in around:
        points = np.array([piece.tas_kt, piece.turn_rate_deg_s])
        middle, along = 0.5 * (points[:, 1:] + points[:, :-1]), np.diff(points)
        across = 0.02 * np.array([-along[1], along[0]]) / np.hypot(*along)
        corners = np.abs(middle[..., None] - points[:, None, [0, -1]]) / TOLERANCES[:, None, None]
        clear = (corners.max(axis=0) > 1).all(axis=1)  # of the corners, which lie within a tolerance
        for side in (middle + across, middle - across):
            inside, y = feasible(condition, *side, np.full(len(clear), jam))
            for row in y[clear & ~inside][::9]:
                assert set(piece.limits) & set(manoeuvre.limits_hit(row, *condition.bounds, condition.failure.airframe))
                kinds |= set(piece.limits)
    assert {"phi.upper", "throttle.upper"} < kinds


def test_polygons_are_closed_and_their_pieces_meet():
    boundary = envelope_boundary(FlightCondition(*GAP))
    assert len(boundary.polygons) == 2  # a gap in speed
    for around in boundary.polygons:
        points = [np.column_stack([piece.turn_rate_deg_s, piece.tas_kt]) for piece in around]
        for before, after in zip(points, points[1:] + points[:1], strict=True):
            np.testing.assert_array_equal(before[-1], after[0])
        for before, after in pairwise(around):
            assert before.limits != after.limits
        assert all(piece.limits for piece in around)
        assert json.loads(json.dumps([piece.to_dict() for piece in around]))[0]["limits"] == list(around[0].limits)


def test_polygons_reach_the_ends_of_the_envelope():
    for name in ("jam", "hard jam", "with a gap"):
        condition = FlightCondition(*JAMS[name])
        whole = condition.envelope()
        assert ends(envelope_boundary(condition), 0.0) == pytest.approx((whole.v_min_kt, whole.v_max_kt), abs=0.01)


def test_envelopes_with_horns_have_a_boundary_between_them():
    """A restricted elevator leaves fast turns to both sides, but no straight flight as fast (brute force shows it)."""
    condition = FlightCondition(*brute_force.CASES["left engine out, elevator restricted, flaps down"])
    boundary = envelope_boundary(condition)
    left, notch_start, notch_end, right = crossings(boundary, 88.0)
    assert left < -11 < -6 < notch_start < -5 < 7 < notch_end < 9 < right
    rates = np.array([left, notch_start, notch_end, right])
    for inward, is_feasible in ((np.array([1, -1, 1, -1]), True), (np.array([-1, 1, -1, 1]), False)):
        for rate in rates + 0.06 * inward:
            trim = steady.trim(condition.altitude_ft, 88.0, condition.gamma_deg, rate, condition.failure)
            assert trim.feasible == is_feasible


@pytest.mark.parametrize(
    "jams",
    [
        {"elevator_deg": (1.5, 1.5), "rudder_deg": (5, 5)},  # the load factor sets the speed: left and right turns
        {"aileron_deg": (-5, -5), "rudder_deg": (5, 5)},
    ],
)
def test_two_jams_leave_a_curve(jams):
    condition = FlightCondition(10000, 0, ControlLimits(**jams))
    ((curve,),) = envelope_boundary(condition).polygons
    whole = condition.envelope()
    assert [curve.tas_kt.min(), curve.tas_kt.max()] == pytest.approx([whole.v_min_kt, whole.v_max_kt], abs=0.1)
    assert len(curve.tas_kt) > 10
    assert set(curve.limits) == {f"{name.removesuffix('_deg')}.jam" for name in jams}
    name, (jam, _) = next(iter(jams.items()))
    phi_deg = []
    for tas_kt, rate in zip(curve.tas_kt, curve.turn_rate_deg_s, strict=True):
        free = steady.trim(10000, tas_kt, 0, rate, ControlLimits(rudder_deg=(5, 5)))  # the other control follows
        assert getattr(free, name) == pytest.approx(jam, abs=1e-5)
        phi_deg.append(free.phi_deg)
    if name == "elevator_deg":
        assert [phi_deg[0], phi_deg[-1]] == pytest.approx([-30, 30], abs=1e-4)  # both ways as far as they may bank


def test_an_envelope_of_one_speed_has_a_boundary_of_one_point():
    trim = steady.trim(10000, 118.5, 0, 0, ControlLimits(rudder_deg=(10, 10)))
    held = {"elevator_deg": trim.elevator_deg, "aileron_deg": trim.aileron_deg, "throttle_pct": trim.throttle_pct}
    limits = ControlLimits(**{name: (value, value) for name, value in held.items()}, rudder_deg=(10, 10))
    boundary = envelope_boundary(FlightCondition(10000, 0, limits))
    for rates, speeds in boundary.outlines:
        np.testing.assert_allclose(speeds, 118.5, atol=1e-3)
        np.testing.assert_allclose(rates, 0, atol=1e-3)
    assert len(boundary.polygons) == 1


def test_without_an_envelope_there_is_no_polygon():
    boundary = envelope_boundary(FlightCondition(30000, 5, ControlLimits(rudder_deg=(30, 30))))
    assert boundary.polygons == boundary.outlines == ()


COMPLETE = {
    "paper Fig. 24": (30000.0, 1.0, rudder(-30, 10)),
    "restriction in a climb": (15913.0, 2.95, rudder(-20.968510174729353, 27.820252370698256)),
    "jam in a steep glide": (10507.0, -5.51, rudder(-3.247807235087169, -3.247807235087169)),
    "restriction in a steep glide": (3481.0, -5.97, rudder(-12.643324552684845, 2.921482559459591)),
    "with a gap": GAP,
}


@pytest.mark.parametrize("name", COMPLETE)
def test_every_piece_has_a_length_and_a_limit(name):
    for around in envelope_boundary(FlightCondition(*COMPLETE[name])).polygons:
        for piece in around:
            assert piece.limits
            edges = np.diff([piece.tas_kt, piece.turn_rate_deg_s], axis=1) / TOLERANCES[:, None]
            assert np.abs(edges).max(axis=0).min() > 1e-6


def test_a_trim_that_the_grid_missed_leaves_no_spur():
    """Trims of jams go on beyond (6 deg/s, 103.4 kn), so that it is no place of the boundary."""
    condition = FlightCondition(*COMPLETE["paper Fig. 24"])
    jams = np.arange(-10.0, 0.0, 0.25)
    places = np.full_like(jams, 103.385), np.full_like(jams, 5.9914)
    assert feasible(condition, *places, jams)[0].any()
    assert feasible(condition, places[0] + 0.35, places[1], jams)[0].any()
    assert distance(envelope_boundary(condition), 103.385, 5.9914) > 3


def test_where_the_thrust_sticks_at_zero_idle_holds_the_boundary():
    """Steep glides end where more drag than the least would need a thrust below zero, whatever the throttle."""
    boundary = envelope_boundary(FlightCondition(*COMPLETE["jam in a steep glide"]))
    idle = [piece for around in boundary.polygons for piece in around if "throttle.lower" in piece.limits]
    assert idle
    condition = FlightCondition(*COMPLETE["jam in a steep glide"])
    tas_kt, rate = idle[0].tas_kt[len(idle[0].tas_kt) // 2], idle[0].turn_rate_deg_s[len(idle[0].tas_kt) // 2]
    trim = steady.trim(condition.altitude_ft, tas_kt, condition.gamma_deg, rate, condition.failure)
    x, u = trim.state_and_controls
    assert plain_model.outputs(x, u)[11:13] == pytest.approx([0, 0], abs=0.02)
