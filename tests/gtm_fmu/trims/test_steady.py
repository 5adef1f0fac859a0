"""Many trims at once: SPEC 13, the plain model, dense scans of the rudder, and limits that leave nothing free."""

from itertools import combinations

import numpy as np
import pytest
from scipy.optimize import brentq

from gtm_fmu.aircraft import ranges
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.aircraft.ranges import WIDEST
from gtm_fmu.airframe.names import BETA, PHI, PSI_DOT, RUDDER, V
from gtm_fmu.core import solver
from gtm_fmu.errors import InputError
from gtm_fmu.trims import manoeuvre, steady
from gtm_fmu.units import DEG_PER_RAD, FT_S_PER_KT, KT_PER_FT_S, RAD_PER_DEG
from tests.reference import plain_model
from tests.reference.spec_values import TRIMS, half_unit

SCALE = solver.scale()
INSIDE = 1e-9  # of a typical size: rounding


def plain_accelerations(altitude_ft, gamma_deg, y):
    """State, controls and the six accelerations of unknowns y, from the plain model alone."""
    speed, alpha, beta, psi_dot, phi = y[:5]
    x = plain_model.steady_state(altitude_ft, speed, np.radians(gamma_deg), psi_dot, alpha, beta, phi)
    return plain_model.derivatives(x, y[5:])[:6]


def excess(y, lower, upper):
    """Largest excess over the bounds in typical sizes, 0 inside."""
    return np.max(np.maximum(np.maximum(lower - y, y - upper), 0) / SCALE, axis=-1)


def bounds(tas_kt, turn_rate_deg_s, rudder_deg=WIDEST["rudder_deg"], **limits):
    held = (tas_kt, tas_kt), (turn_rate_deg_s, turn_rate_deg_s)
    return manoeuvre.bounds(ControlLimits(rudder_deg=rudder_deg, **limits), ranges.ALPHA_DEG, (-30, 30), *held)


@pytest.mark.parametrize("printed", TRIMS, ids=lambda trim: trim.name)
def test_the_trims_of_the_specification(printed):
    """SPEC 13: what is printed as free comes out to within the last two digits; a free V or turn rate is sought."""
    jammed = "rudder" not in printed.free
    limits = ControlLimits(rudder_deg=(float(printed.rudder),) * 2) if jammed else None
    tas_kt = float(printed.V) * KT_PER_FT_S
    if printed.eas is not None:
        tas_kt = printed.eas / plain_model.atmosphere(printed.h).root_density_ratio

    def trim(tas_kt=tas_kt, turn_rate_deg_s=printed.psi_dot):
        return steady.trim(printed.h, tas_kt, printed.gamma, turn_rate_deg_s, limits, phi_deg=(-60, 60))

    if "V" in printed.free:
        found = trim(tas_kt=brentq(lambda tas: trim(tas_kt=tas).alpha_deg - float(printed.alpha), 80, 120, xtol=1e-12))
        assert found.tas_kt * FT_S_PER_KT == pytest.approx(float(printed.V), abs=2 * half_unit(printed.V))
    elif "psi_dot" in printed.free:
        banked = float(printed.phi)
        found = trim(
            turn_rate_deg_s=brentq(lambda rate: trim(turn_rate_deg_s=rate).phi_deg - banked, 5, 15, xtol=1e-12)
        )
    else:
        found = trim()
    assert found.feasible
    for name in ("alpha", "beta", "phi", "elevator", "aileron", "rudder", "throttle"):
        value = getattr(found, f"{name}_{'pct' if name == 'throttle' else 'deg'}")
        text = getattr(printed, name)
        assert value == pytest.approx(float(text), abs=2 * max(half_unit(text), 1e-12)), name


@pytest.fixture(scope="module")
def conditions():
    """Random altitude, speed, flight path, turn rate and rudder limits: jams, restrictions and the full range."""
    rng = np.random.default_rng(1)
    n = 600
    rudder = np.sort(rng.uniform(-30, 30, (n, 2)), axis=1)
    rudder[::3, 1] = rudder[::3, 0]
    rudder[1::9] = WIDEST["rudder_deg"]
    return (
        rng.uniform(0, 30000, n),
        rng.uniform(60, 180, n),
        rng.uniform(-5, 5, n),
        rng.uniform(-8, 8, n),
        rudder,
    )


def test_trims_are_trims_of_the_plain_model(conditions):
    """Accelerations zero for the airframe written a second time, held values held, inside every limit."""
    altitude, tas, gamma, rate, rudder = conditions
    found = steady.trims(altitude, tas, gamma, rate, rudder_deg=rudder)
    feasible = np.flatnonzero(found.status == solver.TRIMMED)
    assert len(feasible) > 150
    for k in feasible:
        y = found.y[k]
        assert np.abs(plain_accelerations(altitude[k], gamma[k], y)).max() < 1e-9
        assert excess(y, *bounds(tas[k], rate[k], rudder[k])) < INSIDE
    np.testing.assert_allclose(found.y[:, V] * KT_PER_FT_S, tas, rtol=1e-14)
    np.testing.assert_allclose(found.y[:, PSI_DOT] * DEG_PER_RAD, rate, rtol=1e-13)
    assert np.all(found.residual[feasible] < 1e-9)
    assert np.all(found.violation[feasible] < INSIDE)


def test_a_status_says_what_was_found(conditions):
    """Only outside the limits: accelerations still zero, the excess as told. No trim: accelerations are left."""
    altitude, tas, gamma, rate, rudder = conditions
    found = steady.trims(altitude, 1.6 * tas - 50, gamma, rate, rudder_deg=rudder)
    outside, none = found.status == solver.OUTSIDE, found.status == solver.NO_TRIM
    assert outside.sum() > 150
    assert none.sum() > 5
    for k in np.flatnonzero(outside):
        y = found.y[k]
        assert np.abs(plain_accelerations(altitude[k], gamma[k], y)).max() < 1e-9
        told = excess(y, *bounds(1.6 * tas[k] - 50, rate[k], rudder[k]))
        assert found.violation[k] == pytest.approx(told, rel=1e-9, abs=1e-12)
        assert told > INSIDE
    assert np.all(found.residual[none] > 1e-9)


def test_a_batch_gives_the_bits_of_single_trims(conditions):
    altitude, tas, gamma, rate, rudder = conditions
    sides = [bounds(*condition) for condition in zip(tas, rate, rudder, strict=True)]
    lower, upper = (np.array(side) for side in zip(*sides, strict=True))
    batch = solver.trims(altitude, gamma * RAD_PER_DEG, lower, upper)
    for k in range(0, len(altitude), 5):
        row = slice(k, k + 1)
        one = solver.trims(altitude[row], gamma[row] * RAD_PER_DEG, lower[row], upper[row])
        for many, single in zip(batch, one, strict=True):
            np.testing.assert_array_equal(many[row], single)


def test_batch_and_single_trims_are_the_same(conditions):
    altitude, tas, gamma, rate, rudder = (column[:150] for column in conditions)
    batch = steady.trims(altitude, tas, gamma, rate, rudder_deg=rudder)
    for k in range(len(altitude)):
        one = steady.trim(altitude[k], tas[k], gamma[k], rate[k], ControlLimits(rudder_deg=rudder[k]))
        assert one.feasible == (batch.status[k] == solver.TRIMMED)
        assert one.converged == (batch.status[k] != solver.NO_TRIM)
        if one.converged:
            np.testing.assert_allclose(one.unknowns / SCALE, batch.y[k] / SCALE, atol=1e-9)


def test_conditions_broadcast():
    grid = steady.trims(10000, [[100], [120]], 0, [0, 2, 4])
    assert grid.y.shape == (6, 9)
    np.testing.assert_allclose(grid.y[:, V] * KT_PER_FT_S, [100] * 3 + [120] * 3)
    np.testing.assert_allclose(grid.y[:, PSI_DOT] * DEG_PER_RAD, [0, 2, 4] * 2, atol=1e-14)
    assert steady.trims([], 100, 0, 0).y.shape == (0, 9)


def test_cold_trims_miss_nothing():
    """Feasible points of the manifold, met by bank angle, are found again by their turn rate.

    8000 random starts at 400 points found no second feasible solution (methods/ENVELOPE.md), so they are the same.
    """
    rng = np.random.default_rng(2)
    lower, upper = manoeuvre.bounds(ControlLimits())
    points = 0
    for _ in range(60):
        altitude, gamma = rng.uniform(0, 34000), rng.uniform(-8, 8)
        low, high = [50 * FT_S_PER_KT, np.radians(-30), -30], [220 * FT_S_PER_KT, np.radians(30), 30]
        y = solver.cold_starts(altitude, np.radians(gamma), rng.uniform(low, high, (400, 3)))
        y = y[excess(y, lower, upper) == 0]
        tas, rate, rudder = y[:, V] * KT_PER_FT_S, y[:, PSI_DOT] * DEG_PER_RAD, y[:, [RUDDER, RUDDER]]
        found = steady.trims(altitude, tas, gamma, rate, rudder_deg=rudder)
        assert np.all(found.status == solver.TRIMMED)
        np.testing.assert_allclose(found.y / SCALE, y / SCALE, atol=1e-8)
        points += len(y)
    assert points > 5000


def scan(altitude, tas, gamma, rate, rudder, limits):
    """Least |beta| (rad) of the jams inside the rudder limits, to about 1e-5 deg of rudder; infinite where none is."""
    lower, upper = bounds(tas, rate, rudder, **limits)
    least, ends = np.inf, rudder
    for points in (241, 41, 41, 41, 41):
        deflections = np.linspace(*ends, points)
        jams = steady.trims(altitude, tas, gamma, rate, rudder_deg=np.column_stack([deflections] * 2))
        feasible = (jams.status != solver.NO_TRIM) & (excess(jams.y, lower, upper) < INSIDE)
        if not feasible.any():
            break
        slip = np.where(feasible, np.abs(jams.y[:, BETA]), np.inf)
        k = slip.argmin()
        least = min(least, slip[k])
        ends = deflections[max(k - 1, 0)], deflections[min(k + 1, points - 1)]
    return least


def test_a_movable_rudder_gives_the_least_sideslip():
    """Against a dense scan of the rudder: no feasible case missed, none with more sideslip than a jam in the range."""
    rng = np.random.default_rng(3)
    straight = slipping = without = 0
    for case in range(400):
        altitude, tas, gamma = rng.uniform(0, 30000), rng.uniform(60, 170), rng.uniform(-5, 5)
        rate = rng.uniform(-6, 6)
        rudder = tuple(np.sort(rng.uniform(-20, 20, 2)))
        limits = {}
        if case % 4 == 0:
            limits["aileron_deg"] = tuple(np.sort(rng.uniform(-15, 15, 2)))
        if case % 5 == 0:
            rudder = (-30, 30)
        expected = scan(altitude, tas, gamma, rate, rudder, limits)
        trim = steady.trim(altitude, tas, gamma, rate, ControlLimits(rudder_deg=rudder, **limits))
        if np.isinf(expected):
            without += not trim.feasible
            if trim.feasible:  # a sliver between two points of the scan: then it must be real
                assert excess(trim.unknowns, *bounds(tas, rate, rudder, **limits)) < INSIDE
                assert np.abs(plain_accelerations(altitude, gamma, trim.unknowns)).max() < 1e-9
            continue
        assert trim.feasible, f"missed: {altitude} ft, {tas} kt, {gamma} deg, {rate} deg/s, {rudder}, {limits}"
        assert abs(trim.beta_deg) * RAD_PER_DEG <= expected + 1e-9
        assert abs(trim.beta_deg) * RAD_PER_DEG >= expected - 1e-5
        straight += abs(trim.beta_deg) < 1e-9
        slipping += abs(trim.beta_deg) > 0.1
    assert min(straight, slipping, without) > 60, (straight, slipping, without)


def test_steep_glides_are_found():
    """At idle only sideslip makes drag, and the throttle has no slope: nothing that a scan of jams finds is missed."""
    rng = np.random.default_rng(1)
    idle = 0
    for _ in range(150):
        condition = rng.uniform((0, 75, -11, -6), (30000, 140, -7, 6))
        rudder = np.sort(rng.uniform(-30, 30, 2))
        jams = steady.trims(*condition, rudder_deg=np.linspace(rudder[0], rudder[1], 121).repeat(2).reshape(-1, 2))
        feasible = jams.status == solver.TRIMMED
        if not feasible.any():
            continue
        trim = steady.trim(*condition, ControlLimits(rudder_deg=tuple(rudder)))
        assert trim.feasible, (condition, rudder)
        assert abs(trim.beta_deg) * RAD_PER_DEG <= np.abs(jams.y[feasible, BETA]).min() + 1e-9, (condition, rudder)
        idle += "throttle.lower" in trim.limits_hit
    assert idle > 10, idle


def test_without_a_feasible_trim_the_nearest_is_given():
    """No jam inside the rudder limits exceeds the other limits less (dense scan); the limits it exceeds are named."""
    rng = np.random.default_rng(4)
    checked = 0
    for _ in range(300):
        altitude, tas, gamma = rng.uniform(0, 30000), rng.uniform(60, 190), rng.uniform(-5, 5)
        rate = rng.uniform(-8, 8)
        rudder = tuple(np.sort(rng.uniform(-30, 30, 2)))
        trim = steady.trim(altitude, tas, gamma, rate, ControlLimits(rudder_deg=rudder))
        if trim.feasible or not trim.converged:
            continue
        lower, upper = bounds(tas, rate, rudder)
        deflections = np.linspace(*rudder, 121)
        jams = steady.trims(altitude, tas, gamma, rate, rudder_deg=np.column_stack([deflections] * 2))
        jams_excess = excess(jams.y, lower, upper)[jams.status != solver.NO_TRIM]
        assert excess(trim.unknowns, lower, upper) <= jams_excess.min(initial=np.inf) + 1e-6
        assert trim.limits_hit
        checked += 1
    assert checked > 60


JAMS = [jam for n in (1, 2, 3, 4) for jam in combinations(WIDEST, n)]


@pytest.mark.parametrize("jammed", JAMS, ids=" ".join)
def test_jams_of_any_controls(jammed):
    """Jammed where a trim has them, the trim is found, though fewer unknowns than equations may be free.

    One jam a degree (a percent) away leaves nothing when more is held than free, and never a trim outside its limits.
    """
    trims = [
        steady.trim(altitude, tas, gamma, rate, ControlLimits(rudder_deg=(rudder, rudder)))
        for altitude, tas, gamma, rate, rudder in (
            (10000, 118.5, 0, 0, 10),
            (0, 90, -3, 4, -4),
            (20000, 130, 1, -3, 6),
        )
    ]
    for trim in trims:
        assert trim.feasible
        asked = trim.altitude_ft, trim.tas_kt, trim.gamma_deg, trim.turn_rate_deg_s
        held = {name: (getattr(trim, name),) * 2 for name in jammed}
        for rudder in ((trim.rudder_deg, trim.rudder_deg + 5), (trim.rudder_deg - 7, trim.rudder_deg + 9)):
            again = steady.trim(*asked, ControlLimits(**{"rudder_deg": rudder} | held))
            assert again.feasible
            for name in jammed:
                assert getattr(again, name) == pytest.approx(getattr(trim, name), abs=1e-6)
            assert abs(again.beta_deg) <= abs(trim.beta_deg) + 1e-6

        off = held | {jammed[0]: (held[jammed[0]][0] + 1,) * 2}
        other = steady.trim(*asked, ControlLimits(**{"rudder_deg": (-30, 30)} | off))
        limits = {name: pair for name, pair in off.items() if name != "rudder_deg"}
        if len(jammed) > 1:
            assert not other.feasible
        if other.feasible:
            lower, upper = bounds(asked[1], asked[3], off.get("rudder_deg", (-30, 30)), **limits)
            assert excess(other.unknowns, lower, upper) < INSIDE
            assert np.abs(plain_accelerations(asked[0], asked[2], other.unknowns)).max() < 1e-9


def test_equal_bounds_on_alpha_and_phi():
    free = steady.trim(10000, 110, 0, 3, ControlLimits(rudder_deg=(2, 2)))
    assert free.feasible
    held = {"alpha_deg": (free.alpha_deg,) * 2, "phi_deg": (free.phi_deg,) * 2}
    assert steady.trim(10000, 110, 0, 3, ControlLimits(rudder_deg=(2, 2)), **held).feasible
    assert steady.trim(10000, 110, 0, 3, ControlLimits(rudder_deg=(0, 5)), **held).feasible
    held["alpha_deg"] = (free.alpha_deg + 1,) * 2
    assert not steady.trim(10000, 110, 0, 3, ControlLimits(rudder_deg=(2, 2)), **held).feasible


@pytest.mark.parametrize(
    ("wrong", "complaint"),
    [
        ({"altitude_ft": [0, np.nan]}, "altitude in ft: 1 of 2 values are outside 0 .. 36089, the first is nan"),
        ({"altitude_ft": [-1, -2, 5]}, "altitude in ft: 2 of 3 values"),
        ({"tas_kt": [100, 0]}, "tas in kn: 1 of 2 values are outside 20 .. 350"),
        ({"gamma_deg": 50}, "gamma in deg: 1 of 1 values"),
        ({"turn_rate_deg_s": [np.inf]}, "turn rate in deg/s: 1 of 1 values"),
        ({"tas_kt": "fast"}, "tas in kn is no array of numbers"),
        ({"rudder_deg": [[-31, 0]]}, "rudder in deg: 1 of 2 values are outside -30 .. 30"),
        ({"rudder_deg": [[np.nan, 0]]}, "rudder in deg: 1 of 2 values"),
        ({"rudder_deg": [[5, -5]]}, "reversed"),
        ({"rudder_deg": [5, 5, 5]}, "no pairs"),
        ({"rudder_deg": 5}, "no pairs"),
        ({"phi_deg": (5, -5)}, "reversed"),
    ],
)
def test_wrong_batches(wrong, complaint):
    asked = {"altitude_ft": 10000, "tas_kt": 100, "gamma_deg": 0, "turn_rate_deg_s": 0} | wrong
    with pytest.raises(InputError, match=complaint):
        steady.trims(**asked)


def test_the_manifold_is_the_same_by_bank_and_by_turn_rate():
    """A trim in the core's units, asked by phi, has the turn rate that asks for it."""
    (y,) = solver.cold_starts(5000, 0.02, [[170.0, 0.3, -4.0]])
    assert (y[V], y[PHI], y[RUDDER]) == (170.0, 0.3, -4.0)
    assert np.abs(plain_accelerations(5000, np.degrees(0.02), y)).max() < 1e-9
