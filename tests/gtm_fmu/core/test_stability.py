"""Stability and controllability of one linear model against LAPACK and systems in closed form."""

import ctypes

import numpy as np
import pytest

N, MOST_INPUTS, THRESHOLD = 8, 5, 1e-3


class Linear(ctypes.Structure):
    """``gtm_linear``."""

    _fields_ = (("inputs", ctypes.c_int), ("row", (ctypes.c_double * (N + MOST_INPUTS)) * N))


class Verdict(ctypes.Structure):
    """``gtm_verdict``."""

    _fields_ = (("stable", ctypes.c_int), ("controllable", ctypes.c_int))


@pytest.fixture(scope="module")
def judge(toy):
    """Stable and controllable of A (8, 8) and B (8, m)."""
    toy.gtm_judge.restype = Verdict
    toy.gtm_judge.argtypes = ctypes.POINTER(Linear), ctypes.c_double

    def judged(A, B) -> tuple[bool, bool]:
        linear = Linear(B.shape[1])
        for i, row in enumerate(np.hstack([A, B])):
            linear.row[i][: len(row)] = row.tolist()
        found = toy.gtm_judge(ctypes.byref(linear), THRESHOLD)
        return bool(found.stable), bool(found.controllable)

    return judged


def expected(A, B) -> tuple[bool, bool]:
    roots = np.linalg.eigvals(A)
    pencils = [np.hstack([root * np.eye(N) - A, B]) for root in roots if root.real > 0]
    margin = min((np.linalg.svd(pencil, compute_uv=False)[-1] for pencil in pencils), default=np.inf)
    return bool(np.all(roots.real <= 0)), bool(margin >= THRESHOLD)


@pytest.mark.parametrize("inputs", [0, 1, 3, 5])
@pytest.mark.parametrize("shift", [0.0, -3.0, -5.0])
def test_random_systems(judge, shift, inputs):
    rng = np.random.default_rng(inputs)
    verdicts = set()
    for _ in range(300):
        A, B = 2 * rng.normal(size=(N, N)) + shift * np.eye(N), rng.normal(size=(N, inputs))
        assert judge(A, B) == expected(A, B)
        verdicts.add(judge(A, B))
    assert len(verdicts) > (shift == -5.0)


@pytest.mark.parametrize("reached", [True, False])
@pytest.mark.parametrize("complex_mode", [True, False], ids=["oscillation", "exponential"])
def test_an_unstable_mode_that_inputs_reach_or_not(judge, complex_mode, reached):
    """Modes side by side, turned at random: one of them grows, and the inputs act on the others or on all."""
    rng = np.random.default_rng(7)
    for _ in range(50):
        modes = -np.diag(rng.uniform(0.1, 9, N))
        grows = [6, 7] if complex_mode else [7]
        modes[7, 7] = modes[6, 6] = rng.uniform(0.001, 2)
        if complex_mode:
            modes[6, 7], modes[7, 6] = 3.0, -3.0
        else:
            modes[6, 6] = -1.0
        B = rng.uniform(1, 2, (N, 3))
        if not reached:
            B[grows] = 0.0
        turn = np.linalg.qr(rng.normal(size=(N, N)))[0]
        assert judge(turn @ modes @ turn.T, turn @ B) == (False, reached)


def test_margins_on_either_side_of_the_threshold(judge):
    """Diagonal: the smallest singular value of the growing mode is its own row of B."""
    A, B = -np.eye(N), np.zeros((N, 1))
    A[0, 0] = 0.5
    for reach, is_controllable in ((1.01 * THRESHOLD, True), (0.99 * THRESHOLD, False)):
        B[0, 0] = reach
        assert judge(A, B) == (False, is_controllable)


def test_growth_is_told_from_decay_near_zero(judge):
    A, B = np.diag(-np.arange(1.0, N + 1)), np.eye(N)[:, :1]
    for growth in (1e-7, -1e-7):
        A[0, 0] = growth
        assert judge(A, B)[0] == (growth < 0)
