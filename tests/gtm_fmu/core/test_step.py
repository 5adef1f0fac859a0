"""The linear and the quadratic step of a search along the manifold, on the toy aircraft."""

import ctypes

import numpy as np
import pytest
from scipy.optimize import linprog

from gtm_fmu.airframe.names import BETA, PSI_DOT, RUDDER, THROTTLE, V
from gtm_fmu.core.library import address
from tests.gtm_fmu.core.toy_aircraft import KINK, LOWER, MOST, MOST_NULL, NT, SCALE, UPPER, manoeuvre, manoeuvres, real


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
