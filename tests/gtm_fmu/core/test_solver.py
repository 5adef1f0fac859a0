"""The solver above its linear algebra, layer by layer, with an aircraft in closed form (toy_aircraft.c)."""

import ctypes
from itertools import pairwise

import numpy as np
import pytest
from scipy.optimize import linprog

from gtm_fmu.airframe.names import (
    AILERON,
    ALPHA,
    BETA,
    ELEVATOR,
    PHI,
    PSI_DOT,
    RUDDER,
    THROTTLE,
    TRIM_UNKNOWNS,
    V,
)
from gtm_fmu.core.library import address

NT, MOST, MOST_NULL, NF = len(TRIM_UNKNOWNS), 10, 4, 6
SCALE = np.array([30, 0.05, 0.05, 0.1, 0.17, 4, 4, 6, 20])
LOWER = np.array([20, -0.2, -0.3, -1, -1, -20, -20, -30, 0.0])
UPPER = np.array([400, 0.1, 0.3, 1, 1, 20, 20, 30, 100.0])
KINK = 10.0
EVERYWHERE = np.inf


def real(value: float) -> ctypes.c_double:
    return ctypes.c_double(value)


def manoeuvre(speed, rate, rudder) -> np.ndarray:
    """The toy's steady manoeuvre in closed form."""
    alpha = 900 / speed**2
    beta = 0.002 * rudder * (1 + speed / 300)
    aileron = -0.5 * rudder - 0.5 * max(rudder - KINK, 0)
    throttle = 10 + (speed - 100) ** 2 / 50
    bank = np.arctan(speed * rate / 32)
    return np.array([speed, alpha, beta, rate, bank, 3 - 20 * alpha, aileron, rudder, throttle])


def manoeuvres(count: int, seed: int = 0) -> list[np.ndarray]:
    rng = np.random.default_rng(seed)
    return [manoeuvre(*given) for given in rng.uniform((95, -0.2, -25), (160, 0.2, 25), (count, 3))]


def accelerations(toy, y) -> tuple[np.ndarray, np.ndarray]:
    y, F, J = np.array(y, dtype=float), np.empty(NF), np.empty((NF, NT))
    toy.toy_jacobian(address(y), address(F), address(J))
    return F, J


def test_the_toy_is_its_closed_form(toy):
    """And its slopes are those of differences."""
    for y in manoeuvres(20):
        F, J = accelerations(toy, y)
        np.testing.assert_allclose(F, 0, atol=1e-11)
        for k in range(NT):
            step = 1e-6 * SCALE * (np.arange(NT) == k)
            difference = (accelerations(toy, y + step)[0] - accelerations(toy, y - step)[0]) / (2 * step[k])
            np.testing.assert_allclose(J[:, k], difference, rtol=1e-6, atol=1e-6 * np.abs(J).max())


class Cell(ctypes.Structure):
    _fields_ = (("lower", ctypes.c_double * MOST), ("upper", ctypes.c_double * MOST))

    @property
    def rudder(self) -> tuple[float, float]:
        return self.lower[RUDDER], self.upper[RUDDER]


class TestCell:
    """Breakpoints of the rudder at -10 and 10 deg; a value within 1e-9 of its size, 6 deg, is on one."""

    @pytest.fixture
    def cell_at(self, toy):
        def cell_at(rudder: float, upper: float = 30.0) -> Cell:
            y, bounds, cell = manoeuvre(120, 0.1, rudder), UPPER.copy(), Cell()
            bounds[RUDDER] = upper
            toy.toy_cell_at(address(y), address(bounds), ctypes.byref(cell))
            return cell

        return cell_at

    @pytest.mark.parametrize(
        ("rudder", "interval"),
        [
            (3, (-KINK, KINK)),
            (-25, (-EVERYWHERE, -KINK)),
            (12, (KINK, EVERYWHERE)),
            (KINK, (KINK, EVERYWHERE)),
            (-KINK, (-KINK, KINK)),
            (KINK - 5e-9, (KINK, EVERYWHERE)),
            (KINK - 7e-9, (-KINK, KINK)),
        ],
    )
    def test_borders_are_breakpoints(self, cell_at, rudder, interval):
        cell = cell_at(rudder)
        assert cell.rudder == interval
        others = [k for k in range(MOST) if k != RUDDER]
        assert all((cell.lower[k], cell.upper[k]) == (-EVERYWHERE, EVERYWHERE) for k in others)

    def test_at_its_upper_bound_an_unknown_looks_below(self, cell_at):
        assert cell_at(KINK, upper=KINK).rudder == (-KINK, KINK)

    @pytest.mark.parametrize(("above", "interval"), [(0, (-KINK, KINK)), (1, (KINK, EVERYWHERE))])
    def test_beyond_a_border(self, toy, cell_at, above, interval):
        here, beyond = cell_at(3), Cell()
        toy.toy_cell_beyond(ctypes.byref(here), RUDDER, real(KINK), above, ctypes.byref(beyond))
        assert beyond.rudder == interval

    @pytest.mark.parametrize(
        ("rudder", "interval"),
        [(9, (-KINK, KINK)), (KINK, (-KINK, KINK)), (KINK + 1e-6, (KINK, EVERYWHERE)), (-11, (-EVERYWHERE, -KINK))],
    )
    def test_follows_a_point_but_stays_on_its_border(self, toy, cell_at, rudder, interval):
        cell, y = cell_at(3), manoeuvre(120, 0.1, rudder)
        toy.toy_update_cell(ctypes.byref(cell), address(y))
        assert cell.rudder == interval

    @pytest.mark.parametrize(("rudder", "expected"), [(KINK, True), (-KINK, True), (KINK + 1e-6, False), (0, False)])
    def test_which_unknowns_lie_on_breakpoints(self, toy, rudder, expected):
        is_on = np.ones(NT, dtype=np.uint8)
        toy.toy_find_breakpoints(address(manoeuvre(120, 0.1, rudder)), address(is_on))
        assert is_on.astype(bool).tolist() == [expected and k == RUDDER for k in range(NT)]


def tangent(toy, y, is_free=None) -> tuple[np.ndarray, np.ndarray]:
    """Directions (9, m) and second derivatives (9, m, m) of the manifold in scaled unknowns."""
    free = np.ones(MOST, dtype=np.int32) if is_free is None else np.append(is_free, 0).astype(np.int32)
    direction, second = np.empty((MOST, MOST_NULL)), np.empty((MOST, MOST_NULL, MOST_NULL))
    m = toy.toy_tangent(address(y), address(free), address(direction), address(second))
    assert m >= 0
    return direction[:NT, :m], second[:NT, :m, :m]


class TestManifold:
    def test_tangent_space_is_the_null_space_of_the_slopes(self, toy):
        for y in manoeuvres(50):
            direction, _ = tangent(toy, y)
            J = accelerations(toy, y)[1] * SCALE
            assert direction.shape == (NT, NT - NF)
            assert np.linalg.matrix_rank(direction) == NT - NF
            np.testing.assert_allclose(J @ direction, 0, atol=1e-9 * np.abs(J).max())

    def test_a_held_unknown_has_no_direction(self, toy):
        for held in (V, RUDDER, PSI_DOT):
            y = manoeuvre(120, 0.1, 4)
            direction, _ = tangent(toy, y, np.arange(NT) != held)
            assert direction.shape == (NT, NT - NF - 1)
            assert not direction[held].any()

    def test_with_too_few_free_slopes_there_is_none(self, toy):
        free = (np.arange(MOST) != ALPHA) & (np.arange(MOST) != ELEVATOR)
        buffers = np.empty((MOST, MOST_NULL)), np.empty((MOST, MOST_NULL, MOST_NULL))
        arguments = address(manoeuvre(120, 0.1, 4)), address(free.astype(np.int32)), *map(address, buffers)
        assert toy.toy_tangent(*arguments) == -1  # elevator = 3 - 20 alpha cannot move at all

    def test_on_a_breakpoint_slopes_are_those_of_the_cell(self, toy):
        """Aileron per rudder: -1 in the cell above 10 deg, into which a point on it looks."""
        direction, _ = tangent(toy, manoeuvre(120, 0.1, KINK))
        along = np.linalg.lstsq(direction, np.eye(NT)[RUDDER], rcond=None)[0]
        moved = direction @ along * SCALE
        assert moved[AILERON] / moved[RUDDER] == pytest.approx(-1)

    def test_with_curvature_a_step_misses_by_its_third_power(self, toy):
        """A step misses F = 0 by its second power, with the curvature by its third: halved, by 4 and by 8."""
        rng = np.random.default_rng(1)
        for y in manoeuvres(30):
            if abs(abs(y[RUDDER]) - KINK) < 2:
                continue
            direction, second = tangent(toy, y)
            way = rng.normal(size=direction.shape[1])
            way *= 0.2 / np.abs(direction @ way).max()

            def missed(share, bend, y=y, way=way, direction=direction, second=second):
                z = share * way
                moved = y + SCALE * (direction @ z + 0.5 * bend * np.einsum("ijk,j,k", second, z, z))
                return np.abs(accelerations(toy, moved)[0]).max()

            assert missed(0.5, 0) / missed(1.0, 0) == pytest.approx(1 / 4, rel=0.35)
            assert missed(0.5, 1) / missed(1.0, 1) == pytest.approx(1 / 8, rel=0.5)

    def test_newton_returns_to_the_manifold_quadratically(self, toy):
        rng, movable = np.random.default_rng(2), np.ones(MOST, dtype=np.int32)
        for y in manoeuvres(20):
            near = y + SCALE * rng.uniform(-0.2, 0.2, NT)
            misses = [np.abs(accelerations(toy, near)[0]).max()]
            while misses[-1] > 1e-9:
                assert toy.toy_project(address(near), address(movable), real(0.99 * misses[-1])) == 0
                misses.append(np.abs(accelerations(toy, near)[0]).max())
            assert len(misses) <= 7
            assert all(after < 2 * before**2 for before, after in pairwise(misses[1:]) if after > 1e-10)

    def test_the_way_back_is_the_shortest(self, toy):
        """To first order it is normal to the tangent space, in scaled unknowns."""
        rng, movable = np.random.default_rng(3), np.ones(MOST, dtype=np.int32)
        for y in manoeuvres(20):
            near = y + SCALE * rng.uniform(-1e-4, 1e-4, NT)
            back = near.copy()
            assert toy.toy_project(address(back), address(movable), real(1e-12)) == 0
            direction, _ = tangent(toy, back)
            way = (back - near) / SCALE
            along = np.abs(direction.T @ way) / np.linalg.norm(direction, axis=0)
            assert along.max() < 1e-3 * np.linalg.norm(way)

    def test_what_must_not_move_stays(self, toy):
        y, movable = manoeuvre(120, 0.1, 4) + 0.1 * SCALE, np.ones(MOST, dtype=np.int32)
        movable[[V, RUDDER]] = 0
        before = y.copy()
        assert toy.toy_project(address(y), address(movable), real(1e-11)) == 0
        assert (y[V], y[RUDDER]) == (before[V], before[RUDDER])
        np.testing.assert_allclose(y, manoeuvre(y[V], y[PSI_DOT], y[RUDDER]), atol=1e-9)

    def test_an_unknown_on_its_bound_stays_there(self, toy):
        y, free = manoeuvre(120, 0.1, 4) + 0.05 * SCALE, np.ones(MOST, dtype=np.int32)
        upper = UPPER.copy()
        upper[BETA] = y[BETA]
        bounds = address(LOWER), address(upper)
        assert toy.toy_project_along_bounds(address(y), *bounds, address(free)) == 0
        assert y[BETA] == upper[BETA]
        np.testing.assert_allclose(accelerations(toy, y)[0], 0, atol=1e-10)


class Steps:
    """The linear model about a point and the two steps that it gives."""

    def __init__(self, toy, y, lower, upper, objective, radius: float):
        A, b, x, quadratic = np.empty(40 * 5), np.empty(40), np.empty(5), np.empty(5)
        price, direction = np.empty(5), np.empty((MOST, MOST_NULL))
        d, violation, promised = ctypes.c_int(), real(0), real(0)
        numbers = ctypes.byref(d), address(A), address(b), address(price), ctypes.byref(violation)
        given = address(y), address(lower), address(upper), address(objective), real(radius)
        steps = address(x), address(quadratic), ctypes.byref(promised), address(direction)
        rows = toy.toy_steps(*given, *numbers, *steps)
        assert rows >= 0
        self.A, self.b = A[: rows * d.value].reshape(rows, d.value), b[:rows]
        self.x, self.quadratic, self.price = x[: d.value], quadratic[: d.value], price[: d.value]
        self.violation, self.promised, self.radius = violation.value, promised.value, radius
        self.direction = direction[:NT, : d.value - 1]

    def moved(self, y, x) -> np.ndarray:
        return y + SCALE * (self.direction @ x[:-1])


class TestStep:
    @pytest.mark.parametrize("objective", [V, THROTTLE, BETA])
    @pytest.mark.parametrize("sign", [-1.0, 1.0])
    def test_linear_step_is_that_of_highs(self, toy, objective, sign):
        """From points inside the bounds and outside of them."""
        wanted = sign * np.eye(MOST)[objective]
        for k, y in enumerate(manoeuvres(40, seed=4)):
            steps = Steps(toy, y, LOWER, UPPER, wanted, radius=10 ** (-2 + 0.05 * k))
            ends = [(-steps.radius, steps.radius)] * (len(steps.x) - 1) + [(0, steps.violation)]
            expected = linprog(steps.price, A_ub=steps.A, b_ub=steps.b, bounds=ends, method="highs")
            assert expected.status == 0
            assert steps.price @ steps.x == pytest.approx(expected.fun, rel=1e-8, abs=1e-8)
            assert np.all(steps.A @ steps.x <= steps.b + 1e-9)

    def test_the_model_is_the_bounds_to_first_order(self, toy):
        """No unknown of a small step passes its bound by more than the step's square."""
        for y in manoeuvres(40, seed=5):
            if np.any((y < LOWER) | (y > UPPER)):
                continue
            steps = Steps(toy, y, LOWER, UPPER, -np.eye(MOST)[V], radius=0.3)
            moved = steps.moved(y, steps.x)
            assert np.all(moved <= UPPER + 1e-9 * SCALE)
            assert np.all(moved >= LOWER - 1e-9 * SCALE)
            assert np.abs((moved - y) / SCALE).max() <= 0.3 + 1e-9

    @pytest.mark.parametrize(("sign", "border"), [(1.0, KINK), (-1.0, -KINK)])
    def test_a_step_ends_at_the_border_of_the_cell(self, toy, sign, border):
        y = manoeuvre(110, 0.0, sign * 8)
        steps = Steps(toy, y, LOWER, UPPER, -sign * np.eye(MOST)[RUDDER], radius=2.0)
        assert steps.moved(y, steps.x)[RUDDER] == pytest.approx(border, abs=1e-9)

    def test_violation_is_measured_in_scale_units(self, toy):
        y = manoeuvre(90, 0.0, 0.0)  # alpha 0.111 with 0.1 allowed
        steps = Steps(toy, y, LOWER, UPPER, -np.eye(MOST)[V], radius=0.3)
        assert steps.violation == pytest.approx((900 / 90**2 - 0.1) / 0.05)

    def test_quadratic_step_ends_at_the_least_of_a_parabola(self, toy):
        """Throttle = 10 + (V - 100)^2 / 50 is least at 100: from 103 it drops by 9 / 50, of its scale of 20."""
        objective = np.eye(MOST)[THROTTLE]
        for rate, rudder in ((0.0, 0.0), (0.1, 4.0), (-0.2, -7.0)):
            y = manoeuvre(103, rate, rudder)
            lower, upper = LOWER.copy(), UPPER.copy()
            lower[[PSI_DOT, RUDDER]] = upper[[PSI_DOT, RUDDER]] = rate, rudder
            steps = Steps(toy, y, lower, upper, objective, radius=0.2)
            assert steps.promised == pytest.approx(9 / 50 / 20, rel=1e-4)
            assert steps.moved(y, steps.quadratic)[V] == pytest.approx(100, abs=1e-3)
            assert np.all(steps.A @ steps.quadratic <= steps.b + 1e-9)

    def test_a_step_without_curvature_to_stop_it_is_none(self, toy):
        """V itself has no least: the quadratic model promises nothing."""
        y = manoeuvre(120, 0.0, 0.0)
        steps = Steps(toy, y, LOWER, UPPER, np.eye(MOST)[V], radius=1e-3)
        assert steps.promised == -1


class TestAbove:
    """Trims, ends and grids of the toy by closed forms."""

    def test_trim_at_speed_and_turn_rate(self, toy):
        """The least sideslip is none, with the rudder at zero."""
        for speed, rate in ((100, 0.0), (130, 0.2), (150, -0.1)):
            lower, upper = LOWER.copy(), UPPER.copy()
            lower[[V, PSI_DOT]] = upper[[V, PSI_DOT]] = speed, rate
            y, residual, violation = np.empty(NT), real(0), real(0)
            ends = ctypes.byref(residual), ctypes.byref(violation)
            assert toy.toy_trim(address(lower), address(upper), address(y), *ends) == 0
            np.testing.assert_allclose(y, manoeuvre(speed, rate, 0.0), atol=1e-9)

    def test_trim_outside_its_bounds_says_how_far(self, toy):
        lower, upper = LOWER.copy(), UPPER.copy()
        lower[[V, PSI_DOT, RUDDER]] = upper[[V, PSI_DOT, RUDDER]] = 170, 0.0, 5.0  # throttle 108
        y, residual, violation = np.empty(NT), real(0), real(0)
        assert (
            toy.toy_trim(address(lower), address(upper), address(y), ctypes.byref(residual), ctypes.byref(violation))
            == 1
        )
        assert violation.value == pytest.approx(8 / 20)

    @pytest.mark.parametrize(
        ("goal", "lower", "upper", "best"),
        [
            (1.0, {}, {}, 900**0.5 / 0.1**0.5),  # alpha 0.1 at V_min
            (-1.0, {}, {}, 100 + 4500**0.5),  # throttle 100
            (-1.0, {}, {"throttle": 60.0}, 150.0),
            (
                1.0,
                {"rudder": 8.0, "beta": 0.03},
                {"rudder": 11.0},
                300 * (0.03 / 0.022 - 1),
            ),  # at 11 deg, beyond the kink
            (1.0, {"rudder": 20.0}, {"aileron": -25.0, "rudder": 30.0}, 900**0.5 / 0.1**0.5),
        ],
    )
    def test_ends(self, toy, goal, lower, upper, best):
        low, high = LOWER.copy(), UPPER.copy()
        low[AILERON] = -50
        for bounds, given in ((low, lower), (high, upper)):
            for name, value in given.items():
                bounds[TRIM_UNKNOWNS.index(name)] = value
        y, violation = np.empty(NT), real(0)
        objective = goal * np.eye(NT)[V]
        arguments = address(low), address(high), address(objective), address(y), ctypes.byref(violation)
        assert toy.toy_end(*arguments) == 0
        assert y[V] == pytest.approx(best, rel=1e-8)
        assert np.all((y >= low - 1e-6 * SCALE) & (y <= high + 1e-6 * SCALE))

    def test_no_end_says_how_far(self, toy):
        """Rudder r of 28 at least needs aileron 5 - r, of -20 at least: (28 - r) / 6 = (r - 25) / 4 at 26.2, 0.3."""
        low, high = LOWER.copy(), UPPER.copy()
        low[RUDDER] = 28
        y, violation = np.empty(NT), real(0)
        objective = np.eye(NT)[V]
        arguments = address(low), address(high), address(objective), address(y), ctypes.byref(violation)
        assert toy.toy_end(*arguments) == 1
        assert violation.value == pytest.approx(0.3, rel=1e-6)
        assert y[RUDDER] == pytest.approx(26.2, rel=1e-6)

    @pytest.mark.parametrize(
        ("lower", "upper", "borders"),
        [
            (-30, 30, [-30, -20, -10, 0, 10, 20, 30]),
            (-7.5, 12, [-7.5, 0, 10, 12]),
            (10, 10, [10, 10]),
            (-10, 0, [-10, 0]),
            (3, 4, [3, 4]),
        ],
    )
    def test_pieces_of_the_rudder_s_range(self, toy, lower, upper, borders):
        found = (ctypes.c_double * 7)()
        assert toy.toy_pieces(real(lower), real(upper), 6, found) == len(borders) - 1
        assert found[: len(borders)] == borders

    def test_pieces_are_no_more_than_there_is_room_for(self, toy):
        found = (ctypes.c_double * 5)(*[7.0] * 5)
        assert toy.toy_pieces(real(-1e6), real(1e6), 3, found) == 3
        assert found[:] == [-1e6, -1e6 + 10, -1e6 + 20, 1e6, 7.0]

    def test_grid(self, toy):
        """A cell has a trim where throttle, alpha and bank allow it."""
        speed, rate = np.arange(80.0, 180, 5), np.arange(-0.3, 0.31, 0.05)
        low, high = LOWER.copy(), UPPER.copy()
        low[PHI], high[PHI] = -0.5, 0.5
        feasible, y = np.zeros((len(speed), len(rate)), np.uint8), np.full((len(speed), len(rate), NT), np.nan)
        seed = manoeuvre(120, 0.01, 0.0)
        solve = toy.toy_grid
        solve.restype = ctypes.c_long
        axes = ctypes.c_long(len(speed)), address(speed), ctypes.c_long(len(rate)), address(rate)
        count = solve(address(low), address(high), *axes, address(seed), address(feasible), address(y))
        expected = np.array([[manoeuvre(v, r, 0.0) for r in rate] for v in speed])
        inside = np.all((expected >= low) & (expected <= high), axis=-1)
        np.testing.assert_array_equal(feasible.astype(bool), inside)
        assert count == inside.sum()
        np.testing.assert_allclose(y[inside], expected[inside], atol=1e-8)
