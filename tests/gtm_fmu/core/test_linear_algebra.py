"""The small linear systems of the solver against NumPy."""

import numpy as np
import pytest

from gtm_fmu.core.library import address


@pytest.mark.parametrize("n", range(1, 7))
def test_elimination(toy, n):
    rng = np.random.default_rng(n)
    for _ in range(50):
        A, b = rng.normal(size=(n, n)), rng.normal(size=n)
        expected = np.linalg.solve(A, b)
        assert toy.gtm_solve(n, address(A), address(b)) == 0
        np.testing.assert_allclose(b, expected, rtol=1e-8, atol=1e-9 * np.abs(expected).max())


def test_a_singular_system_is_refused(toy):
    A, b = np.ones((3, 3)), np.ones(3)
    assert toy.gtm_solve(3, address(A), address(b)) == 1


@pytest.mark.parametrize("n", range(1, 6))
def test_cholesky_in_wider_rows(toy, n):
    rng = np.random.default_rng(n)
    root, b, H = rng.normal(size=(n, n + 1)), rng.normal(size=n), np.zeros((n, 5))
    H[:, :n] = root @ root.T
    expected = np.linalg.solve(H[:, :n], b)
    assert toy.gtm_solve_definite(n, 5, address(H), address(b)) == 0
    np.testing.assert_allclose(b, expected, rtol=1e-8, atol=1e-9 * np.abs(expected).max())


def test_an_indefinite_system_is_refused(toy):
    H, b = np.diag([1.0, -1.0]), np.ones(2)
    assert toy.gtm_solve_definite(2, 2, address(H), address(b)) == 1
