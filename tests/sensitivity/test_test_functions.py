"""Every shipped function's values, derived anew: integrals by sympy, Gaussian ones by numerical conditioning."""

import numpy as np
import pytest
import sympy as sp

from sensitivity import test_functions as functions
from sensitivity import variance_design, variance_indices

x, y = sp.symbols("x y")


@pytest.mark.parametrize(
    ("function", "f"),
    [
        (functions.TRIANGLE_SUM, x + y),
        (functions.TRIANGLE_DIFFERENCE, y - x),
        (functions.TRIANGLE_PRODUCT, x * y),
    ],
    ids=lambda p: getattr(p, "name", None),
)
def test_triangle(function, f):
    """Joint density 2 on 0 <= x <= y <= 1; y is uniform on [x, 1] given x, x on [0, y] given y."""

    def mean(g):
        return sp.integrate(sp.integrate(2 * g, (y, x, 1)), (x, 0, 1))

    variance = mean(f**2) - mean(f) ** 2
    given_x, given_y = sp.integrate(f, (y, x, 1)) / (1 - x), sp.integrate(f, (x, 0, y)) / y
    first = [
        sp.integrate(sp.cancel(g**2 * density), (v, 0, 1)) - mean(f) ** 2
        for g, density, v in ((sp.cancel(given_x), 2 * (1 - x), x), (sp.cancel(given_y), 2 * y, y))
    ]
    assert function.variance == pytest.approx(float(variance))
    assert function.first == pytest.approx([float(v / variance) for v in first])
    assert function.total == pytest.approx([float(1 - v / variance) for v in reversed(first)])


def test_shares():
    """Uniform on the simplex: density 2; given one share, another is uniform on what is left."""
    f = x + 2 * y

    def mean(g):
        return sp.integrate(sp.integrate(2 * g, (y, 0, 1 - x)), (x, 0, 1))

    variance = mean(f**2) - mean(f) ** 2
    left = {"x": x + 2 * y, "y": y + 2 * x, "z": y + 2 * (1 - x - y)}
    first = []
    for g in left.values():  # the kept share is x, the other one y
        conditional = sp.cancel(sp.integrate(g, (y, 0, 1 - x)) / (1 - x))
        first.append(sp.integrate(sp.expand(conditional**2 * 2 * (1 - x)), (x, 0, 1)) - mean(f) ** 2)
    assert functions.shares().variance == pytest.approx(float(variance))
    assert functions.shares().first == pytest.approx([float(v / variance) for v in first])


def test_step():
    """A product of two Bernoulli variables of 1/2 and 3/4."""
    p, q = sp.Rational(1, 2), sp.Rational(3, 4)
    variance = p * q * (1 - p * q)
    v1, v2 = q**2 * p * (1 - p), p**2 * q * (1 - q)
    assert functions.STEP.variance == float(variance)
    assert functions.STEP.first == pytest.approx([float(v1 / variance), float(v2 / variance)])
    assert functions.STEP.total == pytest.approx([float(1 - v2 / variance), float(1 - v1 / variance)])
    half = (variance - v1 - v2) / 2
    assert functions.STEP.shapley == pytest.approx([float((v1 + half) / variance), float((v2 + half) / variance)])


def test_ishigami():
    """The moments by integration over one input at a time."""
    a, b = 7, sp.Rational(1, 10)
    u1, u2, u3 = sp.symbols("u1 u2 u3")
    f = sp.sin(u1) + a * sp.sin(u2) ** 2 + b * u3**4 * sp.sin(u1)

    def mean(g, *over):
        for u in over:
            g = sp.integrate(sp.expand(g), (u, -sp.pi, sp.pi)) / (2 * sp.pi)
        return sp.simplify(g)

    whole = mean(f, u1, u2, u3)
    variance = mean(f**2, u1, u2, u3) - whole**2
    first = [mean((mean(f, *rest) - whole) ** 2, u) for u, *rest in ((u1, u2, u3), (u2, u1, u3), (u3, u1, u2))]
    total = [
        variance - mean((mean(f, u) - whole) ** 2, *rest) for u, *rest in ((u1, u2, u3), (u2, u1, u3), (u3, u1, u2))
    ]
    assert functions.ISHIGAMI.variance == pytest.approx(float(variance))
    assert functions.ISHIGAMI.first == pytest.approx([float(v / variance) for v in first])
    assert functions.ISHIGAMI.total == pytest.approx([float(v / variance) for v in total])


@pytest.mark.parametrize("rho", [-0.8, 0.0, 0.5, 0.9])
@pytest.mark.parametrize("sigma", [1.0, 3.0])
def test_linear_gaussian(rho, sigma):
    """Two inputs, b = (1, 1): V = 1 + s^2 + 2 r s; S_1 = (1 + r s)^2 / V, ST_1 = (1 - r^2) / V (Kucherenko 2012)."""
    function = functions.linear_gaussian([1.0, 1.0], [[1.0, rho * sigma], [rho * sigma, sigma**2]])
    v = 1 + sigma**2 + 2 * rho * sigma
    assert function.variance == pytest.approx(v)
    assert function.first == pytest.approx([(1 + rho * sigma) ** 2 / v, (sigma + rho) ** 2 / v])
    assert function.total == pytest.approx([(1 - rho**2) / v, sigma**2 * (1 - rho**2) / v])


ALL = [
    functions.ISHIGAMI,
    functions.sobol_g(),
    functions.linear_gaussian([1.0, 1.0, 1.0], [[1, 0.5, 0.2], [0.5, 1, 0], [0.2, 0, 4]]),
    functions.portfolio(),
    functions.TRIANGLE_SUM,
    functions.TRIANGLE_DIFFERENCE,
    functions.TRIANGLE_PRODUCT,
    functions.shares(),
    functions.STEP,
]


@pytest.mark.parametrize("function", ALL, ids=lambda f: f.name)
def test_estimates_meet_the_values(function):
    """Within 4 standard errors plus the resolution of 2^13 rows."""
    found = variance_indices(variance_design(function.distribution, 2**13, seed=1).evaluate(function))
    n = len(function.first)
    for kind in ("first", "total"):
        estimate = getattr(found, kind)
        assert np.abs(estimate.value[:n, 0] - getattr(function, kind)).max() < 0.015
        error = np.abs(estimate.value[:n, 0] - getattr(function, kind)) / (estimate.standard_error[:n, 0] + 1e-4)
        assert error.max() < 6
    assert found.output_variance[0] == pytest.approx(function.variance, rel=0.03)
