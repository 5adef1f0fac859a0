"""Functions with known indices, to check a set-up with: each carries its distribution and its exact values.

For independent inputs: `ISHIGAMI`, `sobol_g`. For dependent ones: `linear_gaussian`, `portfolio`, functions on the
triangle of ordered limits, `shares` on a simplex. `STEP` is discontinuous. Where the values come from stands with each.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .correlated import Gaussian
from .distributions import Array, Distribution, OrderedUniform, Uniform
from .simplex import Simplex


@dataclass(frozen=True, eq=False)
class TestFunction:
    """A model of points (n, M) with the indices that its distribution gives it.

    Attributes:
        first: S of each input, V[E(f | x_i)] / V(f).
        total: ST of each input, E[V(f | all others)] / V(f).
        shapley: Shapley effects, where known.
    """

    __test__ = False  # no test of pytest's

    name: str
    distribution: Distribution
    model: Callable[[Array], Array]
    variance: float
    first: tuple[float, ...]
    total: tuple[float, ...]
    shapley: tuple[float, ...] | None = None

    def __call__(self, points: ArrayLike) -> Array:
        """Outputs (n,)."""
        return self.model(np.atleast_2d(np.asarray(points, dtype=float)))


def ishigami(a: float = 7.0, b: float = 0.1) -> TestFunction:
    """sin x1 + a sin^2 x2 + b x3^4 sin x1, inputs uniform on [-pi, pi] (Ishigami, Homma 1990)."""
    p4 = np.pi**4
    v1, v2, v13 = 0.5 * (1.0 + b * p4 / 5.0) ** 2, a**2 / 8.0, 8.0 * b**2 * p4**2 / 225.0
    v = v1 + v2 + v13
    distribution = Distribution([Uniform(f"x{k}", -np.pi, np.pi) for k in (1, 2, 3)])
    return TestFunction(
        "Ishigami",
        distribution,
        lambda x: np.sin(x[:, 0]) + a * np.sin(x[:, 1]) ** 2 + b * x[:, 2] ** 4 * np.sin(x[:, 0]),
        v,
        first=(v1 / v, v2 / v, 0.0),
        total=((v1 + v13) / v, v2 / v, v13 / v),
        shapley=((v1 + v13 / 2) / v, v2 / v, v13 / 2 / v),
    )


def sobol_g(a: Sequence[float] = (0.0, 1.0, 4.5, 9.0)) -> TestFunction:
    """Product of (|4 x_i - 2| + a_i) / (1 + a_i), inputs uniform on [0, 1]: V_i = 1 / (3 (1 + a_i)^2) (Sobol 1993)."""
    parts = 1.0 / (3.0 * (1.0 + np.asarray(a)) ** 2)
    v = float(np.prod(1.0 + parts) - 1.0)
    return TestFunction(
        "Sobol g",
        Distribution([Uniform(f"x{k + 1}", 0.0, 1.0) for k in range(len(a))]),
        lambda x: np.prod((np.abs(4.0 * x - 2.0) + a) / (1.0 + np.asarray(a)), axis=1),
        v,
        first=tuple(parts / v),
        total=tuple(parts * (1.0 + v) / (1.0 + parts) / v),
    )


def linear_gaussian(weights: ArrayLike, covariance: ArrayLike) -> TestFunction:
    """b'x of jointly normal inputs, mean 0: V(f | x_y) is a quadratic form, so every index is a closed form.

    With C the covariance, V[E(f | x_i)] = (C b)_i^2 / C_ii, and E[V(f | all others)] = b_i^2 / (C^-1)_ii.
    """
    b, c = np.asarray(weights, dtype=float), np.asarray(covariance, dtype=float)
    v = float(b @ c @ b)
    return TestFunction(
        "linear, Gaussian",
        Distribution([Gaussian(tuple(f"x{k + 1}" for k in range(len(b))), np.zeros(len(b)), c)]),
        lambda x: x @ b,
        v,
        first=tuple((c @ b) ** 2 / np.diag(c) / v),
        total=tuple(b**2 / np.diag(np.linalg.inv(c)) / v),
    )


def portfolio(deviations: Sequence[float] = (16.0, 2.0, 4.0, 6.0), rho: float = 0.3) -> TestFunction:
    """x1 x3 + x2 x4 with (x1, x2) and (x3, x4) correlated normals (Kucherenko, Tarantola, Annoni 2012, portfolio).

    Means 0 for x1, x2 and 250, 400 for x3, x4; x1 with x2 and x3 with x4 have the correlation rho and -rho.
    """
    s1, s2, s3, s4 = deviations
    m3, m4 = 250.0, 400.0
    c12, c34 = rho * s1 * s2, -rho * s3 * s4
    # V = E x1^2 E x3^2 + E x2^2 E x4^2 + 2 E x1 x2 E x3 x4, as the pairs are independent and x1, x2 have mean 0
    v = s1**2 * (m3**2 + s3**2) + s2**2 * (m4**2 + s4**2) + 2.0 * c12 * (m3 * m4 + c34)
    # E(f | x1) = m3 x1 + m4 (c12 / s1^2) x1;  E(f | x3) = 0, since E x1 = E x2 = 0
    first = ((m3 + m4 * c12 / s1**2) ** 2 * s1**2 / v, (m4 + m3 * c12 / s2**2) ** 2 * s2**2 / v, 0.0, 0.0)
    # V(f | others of x1) = x3^2 V(x1 | x2), and V(x1 | x2) = s1^2 (1 - rho^2)
    left = 1.0 - rho**2
    total = (
        s1**2 * left * (m3**2 + s3**2) / v,
        s2**2 * left * (m4**2 + s4**2) / v,
        s3**2 * left * s1**2 / v,
        s4**2 * left * s2**2 / v,
    )
    return TestFunction(
        "portfolio",
        Distribution(
            [
                Gaussian(("x1", "x2"), np.zeros(2), np.array([[s1**2, c12], [c12, s2**2]])),
                Gaussian(("x3", "x4"), np.array([m3, m4]), np.array([[s3**2, c34], [c34, s4**2]])),
            ]
        ),
        lambda x: x[:, 0] * x[:, 2] + x[:, 1] * x[:, 3],
        v,
        first=first,
        total=total,
    )


_TRIANGLE = Distribution([OrderedUniform(("low", "high"), 0.0, 1.0)])
TRIANGLE_SUM = TestFunction(
    "sum on the triangle", _TRIANGLE, lambda x: x[:, 0] + x[:, 1], 1 / 6, (3 / 4, 3 / 4), (1 / 4, 1 / 4), (1 / 2, 1 / 2)
)
"""low + high, 0 <= low <= high <= 1: E(f | low) = (3 low + 1) / 2, E[V(f | low)] = E (1 - low)^2 / 12 = 1 / 24."""
TRIANGLE_DIFFERENCE = TestFunction(
    "difference on the triangle",
    _TRIANGLE,
    lambda x: x[:, 1] - x[:, 0],
    1 / 18,
    (1 / 4, 1 / 4),
    (3 / 4, 3 / 4),
    (1 / 2, 1 / 2),
)
"""high - low: E(f | low) = (1 - low) / 2 has the variance 1 / 72; what is left, 1 / 24, is the other's total."""
TRIANGLE_PRODUCT = TestFunction(
    "product on the triangle", _TRIANGLE, lambda x: x[:, 0] * x[:, 1], 7 / 144, (33 / 35, 3 / 7), (4 / 7, 2 / 35)
)
"""low high: moments E low^a high^b = 2 / ((a + 1) (a + b + 2))."""


def shares() -> TestFunction:
    """x + 2 y of shares x + y + z = 1, uniform on the simplex: given one share, another is uniform on what is left.

    Every total index is 0: two shares fix the third.
    """
    return TestFunction(
        "shares",
        Distribution([Simplex(("x", "y", "z"))]),
        lambda x: x[:, 0] + 2.0 * x[:, 1],
        1 / 6,
        first=(0.0, 3 / 4, 3 / 4),
        total=(0.0, 0.0, 0.0),
    )


STEP = TestFunction(
    "step",
    Distribution([Uniform("x1", 0.0, 1.0), Uniform("x2", 0.0, 1.0)]),
    lambda x: ((x[:, 0] > 0.5) & (x[:, 1] > 0.25)).astype(float),
    15 / 64,
    first=(9 / 15, 1 / 5),
    total=(4 / 5, 2 / 5),
    shapley=(7 / 10, 3 / 10),
)
"""1 where x1 > 1/2 and x2 > 1/4, else 0: p = 3/8; V[E(f | x1)] = (3/4)^2 / 4, V[E(f | x2)] = (1/2)^2 3/16."""

ISHIGAMI = ishigami()
