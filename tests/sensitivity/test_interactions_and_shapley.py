"""Interactions, Shapley effects, full and independent indices against closed forms and SALib."""

from itertools import combinations
from math import comb

import numpy as np
import pytest

from sensitivity import (
    Distribution,
    OrderedUniform,
    Uniform,
    full_independent_indices,
    interaction_design,
    interactions,
    shapley_design,
)
from sensitivity import test_functions as functions

N = 2**13


class TestInteractions:
    @pytest.mark.parametrize("sampling", ["sobol", "latin", "random"])
    def test_ishigami(self, sampling):
        """Only x1 with x3: V13 / V (Ishigami's function, closed form)."""
        f = functions.ISHIGAMI
        design = interaction_design(f.distribution, N, sampling=sampling, seed=2)
        found = interactions(design.evaluate(f))
        exact = dict(zip(found.row_names, [*f.first, 0.0, f.total[2], 0.0], strict=True))
        assert list(exact) == ["x1", "x2", "x3", "x1,x2", "x1,x3", "x2,x3"]
        np.testing.assert_allclose(found.shares.value[:, 0], list(exact.values()), atol=0.03)

    def test_all_shares_sum_to_one(self):
        """Sobol's g: V_u is the product of V_i = 1 / (3 (1 + a_i)^2); all orders."""
        f = functions.sobol_g((0.0, 1.0, 4.5, 9.0))
        found = interactions(interaction_design(f.distribution, N, order=4).evaluate(f))
        parts = dict(zip(f.distribution.names, 1 / (3 * (1 + np.array([0.0, 1.0, 4.5, 9.0])) ** 2), strict=True))
        exact = [np.prod([parts[name] for name in subset]) / f.variance for subset in found.subsets]
        assert len(exact) == 15
        np.testing.assert_allclose(found.shares.value[:, 0], exact, atol=0.01)
        assert found.shares.value.sum() == pytest.approx(1.0, abs=1e-9)

    def test_second_order_as_salib(self):
        from SALib.analyze import sobol as analyze
        from SALib.sample import sobol

        f = functions.ISHIGAMI
        problem = {"num_vars": 3, "names": ["x1", "x2", "x3"], "bounds": [[-np.pi, np.pi]] * 3}
        X = sobol.sample(problem, 4096, calc_second_order=True, seed=1)
        theirs = analyze.analyze(problem, f(X), calc_second_order=True, seed=1)
        found = interactions(interaction_design(f.distribution, N).evaluate(f))
        pairs = [theirs["S2"][0, 1], theirs["S2"][0, 2], theirs["S2"][1, 2]]
        np.testing.assert_allclose(found.shares.value[3:, 0], pairs, atol=0.03)
        np.testing.assert_allclose(found.shares.value[:3, 0], theirs["S1"], atol=0.02)

    def test_refused(self):
        with pytest.raises(ValueError, match="use Shapley effects"):
            interaction_design(Distribution([OrderedUniform(("a", "b"), 0, 1)]), 64)
        with pytest.raises(ValueError, match="order 4 among 3"):
            interaction_design(functions.ISHIGAMI.distribution, 64, order=4)
        many = Distribution([Uniform(f"x{k}", 0, 1) for k in range(8)])
        with pytest.raises(ValueError, match="at most 3 beyond 6"):
            interaction_design(many, 64, order=8)


def gaussian_shapley(weights, covariance):
    """Exact effects of b'x: ST_u = b_u' C_(u | others) b_u / V, averaged over all subsets."""
    b, c = np.asarray(weights, float), np.asarray(covariance, float)
    m, v = len(b), b @ c @ b

    def total(u):
        if not u:
            return 0.0
        rest = [k for k in range(m) if k not in u]
        u = list(u)
        left = c[np.ix_(u, u)]
        if rest:
            left = left - c[np.ix_(u, rest)] @ np.linalg.solve(c[np.ix_(rest, rest)], c[np.ix_(rest, u)])
        return b[u] @ left @ b[u] / v

    effects = np.zeros(m)
    for i in range(m):
        others = [k for k in range(m) if k != i]
        for size in range(m):
            for u in combinations(others, size):
                effects[i] += (total((*u, i)) - total(u)) / (m * comb(m - 1, size))
    return effects


class TestShapley:
    def test_two_gaussian_inputs(self):
        """Owen, Prieur 2017: [s1^2 (1 - r^2 / 2) + r s1 s2 + r^2 s2^2 / 2] / V for f = x1 + x2."""
        r, s = 0.6, 2.0
        f = functions.linear_gaussian([1.0, 1.0], [[1.0, r * s], [r * s, s**2]])
        first = (1 - r**2 / 2 + r * s + r**2 * s**2 / 2) / f.variance
        found = shapley_design(f.distribution, N).evaluate(f)
        np.testing.assert_allclose(found.effects.value[:, 0], [first, 1 - first], atol=0.01)
        assert found.effects.value.sum() == pytest.approx(1.0)
        np.testing.assert_allclose(gaussian_shapley([1, 1], [[1.0, r * s], [r * s, s**2]]), [first, 1 - first])

    @pytest.mark.parametrize(
        "f",
        [functions.ISHIGAMI, functions.STEP, functions.TRIANGLE_SUM, functions.TRIANGLE_DIFFERENCE],
        ids=lambda f: f.name,
    )
    def test_known_effects(self, f):
        found = shapley_design(f.distribution, N).evaluate(f)
        np.testing.assert_allclose(found.effects.value[:, 0], f.shapley, atol=0.012)
        inside = (found.effects.lower[:, 0] - 0.003 < f.shapley) & (f.shapley < found.effects.upper[:, 0] + 0.003)
        assert inside.all()

    def test_random_orders(self):
        """Nine Gaussian inputs, too many for all subsets: within four errors, which hold the chance of the orders."""
        rng = np.random.default_rng(5)
        half = rng.standard_normal((9, 4))
        covariance = half @ half.T + np.eye(9)
        weights = np.linspace(-1, 2, 9)
        f = functions.linear_gaussian(weights, covariance)
        design = shapley_design(f.distribution, 1024, orders=24, seed=3)
        found = design.evaluate(f)
        error = np.abs(found.effects.value[:, 0] - gaussian_shapley(weights, covariance))
        assert (error < 4 * found.effects.standard_error[:, 0]).all()
        assert error.max() < 0.05
        assert found.effects.value.sum() == pytest.approx(1.0)

    def test_refused(self):
        with pytest.raises(ValueError, match="at least 2"):
            shapley_design(functions.ISHIGAMI.distribution, 64, orders=1)
        with pytest.raises(ValueError, match="two inputs"):
            shapley_design(Distribution([Uniform("a", 0, 1)]), 64)


class TestFullIndependent:
    @pytest.mark.parametrize("sampling", ["sobol", "random"])
    def test_linear_gaussian(self, sampling):
        """f = x1 + x2 is linear in both xi: S = ST. Full (1 + r s)^2, (s + r)^2 over V; the rest 1 - r^2 of each."""
        r, s = 0.6, 2.0
        f = functions.linear_gaussian([1.0, 1.0], [[1.0, r * s], [r * s, s**2]])
        found = full_independent_indices(f.distribution, f, N, sampling=sampling)
        full = np.array([(1 + r * s) ** 2, (s + r) ** 2]) / f.variance
        independent = np.array([1.0, s**2]) * (1 - r**2) / f.variance
        for kind, exact in zip(found.kinds, (full, full, independent, independent), strict=True):
            np.testing.assert_allclose(found.estimates[kind].value[:, 0], exact, atol=0.02, err_msg=kind)

    def test_independent_inputs_have_sobols_indices(self):
        f = functions.ISHIGAMI
        found = full_independent_indices(f.distribution, f, N)
        for kind, exact in zip(found.kinds, (f.first, f.total, f.first, f.total), strict=True):
            np.testing.assert_allclose(found.estimates[kind].value[:, 0], exact, atol=0.02, err_msg=kind)

    def test_a_product_on_the_triangle(self):
        """Full first and independent total are Kucherenko's; with low first, high = low + (1 - low) xi, f = low high.

        V[E(f | xi)] with E low^2 = 1/6, E low (1 - low) = 1/6: f's mean given xi is 1/6 + xi / 6, V = 1 / 432. So the
        full total of low is 1 - (1 / 432) / (7 / 144) = 20 / 21, and the independent first of high 1 / 21.
        """
        f = functions.TRIANGLE_PRODUCT
        found = full_independent_indices(f.distribution, f, N)
        np.testing.assert_allclose(found.full_first.value[:, 0], f.first, atol=0.015)
        np.testing.assert_allclose(found.independent_total.value[:, 0], f.total, atol=0.015)
        assert found.full_total.value[0, 0] == pytest.approx(20 / 21, abs=0.015)
        assert found.independent_first.value[1, 0] == pytest.approx(1 / 21, abs=0.015)
