"""The manifold of steady manoeuvres, its tangents and the way back to it, on the toy aircraft."""

from itertools import pairwise

import numpy as np
import pytest

from gtm_fmu.airframe.names import AILERON, ALPHA, BETA, ELEVATOR, PSI_DOT, RUDDER, V
from gtm_fmu.core.library import address
from tests.gtm_fmu.core.toy_aircraft import (
    KINK,
    LOWER,
    MOST,
    MOST_NULL,
    NF,
    NT,
    SCALE,
    UPPER,
    accelerations,
    manoeuvre,
    manoeuvres,
    real,
)


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
