"""The small linear programs of the envelope solver against SciPy's HiGHS."""

import ctypes
import shutil
import subprocess

import numpy as np
import pytest
from scipy.optimize import linprog

from gtm_fmu.core.library import address, library_path

MOST_VARIABLES, MOST_ROWS = 4, 64
INFEASIBLE = 1


@pytest.fixture(scope="module")
def solve(tmp_path_factory):
    """`gtm_linear_program`, which the core does not export, compiled on its own."""
    compiler, core = shutil.which("cc"), library_path().parent
    if compiler is None:
        pytest.skip("no C compiler `cc` on this machine")
    path = tmp_path_factory.mktemp("linear_program") / "linear_program.so"
    flags = ["-std=c99", "-O2", "-fPIC", "-shared", f"-I{core}"]
    subprocess.run([compiler, *flags, core / "solver" / "linear_program.c", "-o", path, "-lm"], check=True)
    function = ctypes.CDLL(str(path)).gtm_linear_program

    def call(A, b, c, lower, upper):
        arrays = [np.ascontiguousarray(array, dtype=float) for array in (A, b, c, lower, upper)]
        x = np.full(len(c), np.nan)
        code = function(len(c), len(b), *(address(array) for array in (*arrays, x)))
        return code, x

    return call


def box(rng, d):
    return -rng.uniform(0.1, 3, d), rng.uniform(0.1, 3, d)


def general(rng, d, rows):
    """Rows anywhere; the more of them, the likelier nothing is left."""
    b = rng.normal(size=rows) * rng.choice([0.3, 1, 5]) + rng.choice([0, 1])
    return rng.normal(size=(rows, d)), b, rng.normal(size=d), *box(rng, d)


def integers(rng, d, rows):
    """Many parallel and coinciding rows, ties in the objective, rows of zeros."""
    A = rng.integers(-2, 3, (rows, d)).astype(float)
    b = (rng.integers(-1, 4, rows) + rng.integers(0, 3)).astype(float)
    return A, b, rng.integers(-1, 2, d).astype(float), np.full(d, -2.0), np.full(d, 2.0)


def through_one_vertex(rng, d, rows):
    """Feasible, with more rows through one point than it has coordinates."""
    lower, upper = box(rng, d)
    A, vertex = rng.normal(size=(rows, d)), rng.uniform(lower, upper)
    b = A @ vertex + rng.exponential(size=rows) * (rng.random(rows) < 0.5)
    return A, b, rng.normal(size=d), lower, upper


def equalities(rng, d, rows):
    """Pairs of opposite rows leave a plane, a line or a point."""
    lower, upper = box(rng, d)
    point = rng.uniform(lower, upper)
    held, rest = rng.normal(size=(int(rng.integers(1, d + 1)), d)), rng.normal(size=(rows, d))
    b = np.concatenate([held @ point, -(held @ point), rest @ point + rng.exponential(size=rows)])
    return np.vstack([held, -held, rest]), b, rng.normal(size=d), lower, upper


def held_variable(rng, d, rows):
    """Equal bounds on one variable, every row twice."""
    A, b, c, lower, upper = general(rng, d, rows // 2)
    k = rng.integers(d)
    lower[k] = upper[k]
    return np.vstack([A, A]), np.append(b, b), c, lower, upper


def priced_violation(rng, d, rows):
    """As in the envelope solver: a trust region, bounds that a last variable relaxes at a high price."""
    A = np.column_stack([rng.normal(size=(rows, d - 1)), -np.ones(rows)])
    c = np.append(rng.normal(size=d - 1) * rng.choice([1e-3, 1]), 1000.0)
    radius = 10 ** rng.uniform(-1, 0.6)
    b = rng.normal(size=rows) * radius
    return A, b, c, np.append(np.full(d - 1, -radius), 0.0), np.append(np.full(d - 1, radius), 30 * radius)


KINDS = (general, integers, through_one_vertex, equalities, held_variable, priced_violation)


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_random_programs(solve, kind):
    rng = np.random.default_rng(KINDS.index(kind))
    feasible = infeasible = 0
    for _ in range(500):
        d = int(rng.integers(1 if kind is not priced_violation else 2, MOST_VARIABLES + 1))
        A, b, c, lower, upper = kind(rng, d, int(rng.integers(0, 25)))
        assert len(b) <= MOST_ROWS
        expected = linprog(c, A_ub=A, b_ub=b, bounds=np.column_stack([lower, upper]), method="highs")
        code, x = solve(A, b, c, lower, upper)
        assert (code == INFEASIBLE) == (expected.status == 2), expected.message
        infeasible += code == INFEASIBLE
        if code:
            continue
        feasible += 1
        assert c @ x == pytest.approx(expected.fun, rel=1e-7, abs=1e-7 * np.abs(c).max())
        assert np.all(A @ x <= b + 1e-8)
        assert np.all((lower - 1e-8 <= x) & (x <= upper + 1e-8))
    assert feasible > 100
    if kind in (general, integers, held_variable):
        assert infeasible > 50


def test_a_program_without_rows_ends_in_a_corner(solve):
    code, x = solve(np.empty((0, 3)), np.empty(0), [1, -2, 3], [-1, -2, -3], [4, 5, 6])
    assert code == 0
    np.testing.assert_array_equal(x, [-1, 5, -3])


def test_a_row_of_zeros_that_cannot_hold(solve):
    assert solve([[0.0, 0.0]], [-1.0], [1, 1], [-1, -1], [1, 1])[0] == INFEASIBLE
    assert solve([[0.0, 0.0]], [1.0], [1, 1], [-1, -1], [1, 1])[0] == 0
