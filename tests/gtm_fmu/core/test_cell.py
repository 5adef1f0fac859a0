"""Cells: the boxes between breakpoints in which slopes are smooth, on the toy aircraft."""

import ctypes

import numpy as np
import pytest

from gtm_fmu.airframe.names import RUDDER
from gtm_fmu.core.library import address
from tests.gtm_fmu.core.toy_aircraft import KINK, MOST, NT, UPPER, manoeuvre, real


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
            (-25, (-np.inf, -KINK)),
            (12, (KINK, np.inf)),
            (KINK, (KINK, np.inf)),
            (-KINK, (-KINK, KINK)),
            (KINK - 5e-9, (KINK, np.inf)),
            (KINK - 7e-9, (-KINK, KINK)),
        ],
    )
    def test_borders_are_breakpoints(self, cell_at, rudder, interval):
        cell = cell_at(rudder)
        assert cell.rudder == interval
        others = [k for k in range(MOST) if k != RUDDER]
        assert all((cell.lower[k], cell.upper[k]) == (-np.inf, np.inf) for k in others)

    def test_at_its_upper_bound_an_unknown_looks_below(self, cell_at):
        assert cell_at(KINK, upper=KINK).rudder == (-KINK, KINK)

    @pytest.mark.parametrize(("above", "interval"), [(0, (-KINK, KINK)), (1, (KINK, np.inf))])
    def test_beyond_a_border(self, toy, cell_at, above, interval):
        here, beyond = cell_at(3), Cell()
        toy.toy_cell_beyond(ctypes.byref(here), RUDDER, real(KINK), above, ctypes.byref(beyond))
        assert beyond.rudder == interval

    @pytest.mark.parametrize(
        ("rudder", "interval"),
        [(9, (-KINK, KINK)), (KINK, (-KINK, KINK)), (KINK + 1e-6, (KINK, np.inf)), (-11, (-np.inf, -KINK))],
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
