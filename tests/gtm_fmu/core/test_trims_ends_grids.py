"""Trims, ends of an envelope and grids of the toy aircraft by closed forms."""

import ctypes

import numpy as np
import pytest

from gtm_fmu.airframe.names import AILERON, PHI, PSI_DOT, RUDDER, THROTTLE, TRIM_UNKNOWNS, V
from gtm_fmu.core.library import address
from tests.gtm_fmu.core.toy_aircraft import LOWER, NT, SCALE, UPPER, manoeuvre, real


class TestTrimsAndEnds:
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


class TestLeastSideslip:
    """Where the throttle may not go below 20, only sideslip uses up its thrust, and no sideslip is no trim.

    At 100 kn throttle = 10 + drag (rudder - without)^2, so that the rudder lies 10 deg or more to either side of where
    it makes no drag. The nearer side of the two has less sideslip.
    """

    @pytest.fixture
    def least_throttle(self) -> np.ndarray:
        lower = LOWER.copy()
        lower[THROTTLE] = 20
        return lower

    @pytest.mark.parametrize(("without", "rudder"), [(2.0, -8.0), (-2.0, 8.0), (4.0, -6.0), (-4.0, 6.0)])
    def test_the_better_sign_is_taken(self, toy, draggy, least_throttle, without, rudder):
        draggy(0.1, without)
        lower, upper = least_throttle, UPPER.copy()
        lower[[V, PSI_DOT]] = upper[[V, PSI_DOT]] = 100, 0.0
        y, residual, violation = np.empty(NT), real(0), real(0)
        ends = ctypes.byref(residual), ctypes.byref(violation)
        assert toy.toy_trim(address(lower), address(upper), address(y), *ends) == 0
        np.testing.assert_allclose(y, manoeuvre(100, 0.0, rudder, drag=10.0), atol=1e-6)

    @pytest.mark.parametrize(("rudder", "expected"), [((-20.0, 7.0), -12.0), ((-11.0, 30.0), 8.0)])
    def test_the_other_sign_where_the_better_one_is_out_of_reach(self, toy, draggy, least_throttle, rudder, expected):
        draggy(0.1, -2.0)
        lower, upper = least_throttle, UPPER.copy()
        lower[[V, PSI_DOT]] = upper[[V, PSI_DOT]] = 100, 0.0
        lower[RUDDER], upper[RUDDER] = rudder
        y, residual, violation = np.empty(NT), real(0), real(0)
        ends = ctypes.byref(residual), ctypes.byref(violation)
        assert toy.toy_trim(address(lower), address(upper), address(y), *ends) == 0
        np.testing.assert_allclose(y, manoeuvre(100, 0.0, expected, drag=10.0), atol=1e-6)


class Grid:
    """A grid of the toy over speeds and turn rates."""

    def __init__(self, toy, lower, upper, speed, rate, *seeds):
        self.feasible = np.zeros((len(speed), len(rate)), np.uint8)
        self.y = np.full((len(speed), len(rate), NT), np.nan)
        solve = toy.toy_grid
        solve.restype = ctypes.c_long
        axes = ctypes.c_long(len(speed)), address(speed), ctypes.c_long(len(rate)), address(rate)
        given, seeds_ = (address(lower), address(upper), *axes), np.array(seeds)
        found = address(self.feasible), address(self.y)
        self.count = solve(*given, ctypes.c_long(len(seeds)), address(seeds_), *found)


class TestGrid:
    def test_cells_with_a_trim(self, toy):
        """Those where throttle, alpha and bank allow it."""
        speed, rate = np.arange(80.0, 180, 5), np.arange(-0.3, 0.31, 0.05)
        low, high = LOWER.copy(), UPPER.copy()
        low[PHI], high[PHI] = -0.5, 0.5
        grid = Grid(toy, low, high, speed, rate, manoeuvre(120, 0.01, 0.0))
        expected = np.array([[manoeuvre(v, r, 0.0) for r in rate] for v in speed])
        inside = np.all((expected >= low) & (expected <= high), axis=-1)
        np.testing.assert_array_equal(grid.feasible.astype(bool), inside)
        assert grid.count == inside.sum()
        np.testing.assert_allclose(grid.y[inside], expected[inside], atol=1e-8)

    @pytest.mark.parametrize(
        ("rates", "solved"),
        [
            (3, [3, 3, 3]),  # the middle cell of the row has six neighbours; then each of the others has five
            (2, [2, 0, 2]),  # each has four
        ],
    )
    def test_cells_enclosed_by_trims_are_solved_from_cold(self, toy, draggy, rates, solved):
        """Five neighbours with a trim enclose a cell.

        At 95 and 105 kn the rudder is at 7.75 deg, near to its bound. At 100 kn 8 deg are needed, or -12 to the other
        side, which no descent from a neighbour reaches.
        """
        draggy(0.1, -2.0)
        speed, rate = np.array([95.0, 100.0, 105.0]), 0.01 * np.arange(rates)
        lower, upper = LOWER.copy(), UPPER.copy()
        lower[THROTTLE], upper[RUDDER] = 20, 7.9
        seeds = [manoeuvre(v, 0.0, 95**0.5 - 2, drag=9.5) for v in (95, 105)]
        grid = Grid(toy, lower, upper, speed, rate, *seeds)
        assert grid.feasible.sum(axis=1).tolist() == solved
        rudder = [95**0.5 - 2, -12.0, 95**0.5 - 2]
        for row, there in enumerate(grid.feasible.astype(bool)):
            np.testing.assert_allclose(grid.y[row, there, RUDDER], rudder[row], atol=1e-6)
