"""Samplers of dependent inputs against their exact laws; Kolmogorov-Smirnov at fixed seeds."""

import numpy as np
import pytest
from scipy import stats

from sensitivity import (
    Conditioned,
    Distribution,
    Empirical,
    Equal,
    Gaussian,
    GaussianCopula,
    Marginal,
    Mixture,
    OrderedUniform,
    PointMass,
    Simplex,
    Uniform,
    conditioned,
    from_salib,
    ordered_with_jams,
)
from tests.sensitivity.test_distributions import assert_distributed, unit

N = 20000


def redrawn_joint(block, marks, seed):
    """Points whose marked columns were drawn anew given the others: they must have the joint law again."""
    m = len(block.names)
    return block.conditional(block.sample(unit(seed, m, N)), marks, unit(seed + 1, m, N))


class TestMarginal:
    def test_its_text_can_be_typed_in(self):
        """Without an address in memory, so that results of the same design are the same text."""
        for law in (stats.norm(2, 0.5), stats.gumbel_r(loc=800, scale=100), stats.randint(0, 7)):
            text = repr(Marginal("x", law, "mm"))
            again = eval(text)
            assert again.law.stats() == law.stats()
            assert (again.unit, repr(again)) == ("mm", text)
        assert repr(Marginal("x", stats.norm(2, 0.5))) == "Marginal('x', stats.norm(2, 0.5), '')"

    @pytest.mark.parametrize("law", [stats.norm(2.0, 0.5), stats.beta(2, 5), stats.gumbel_r(1, 2)])
    def test_continuous(self, law):
        assert_distributed(Marginal("x", law).sample(unit(1, 1))[:, 0], law.cdf)

    def test_discrete(self):
        x = Marginal("n", stats.poisson(3.0)).sample(unit(2, 1))[:, 0]
        counts = np.array([(x == k).sum() for k in range(8)] + [(x >= 8).sum()])
        expected = N * np.append(stats.poisson.pmf(np.arange(8), 3.0), stats.poisson.sf(7, 3.0))
        assert stats.chisquare(counts, expected).pvalue > 0.01

    def test_zero_gives_no_infinity(self):
        assert np.isfinite(Marginal("x", stats.norm()).sample(np.array([[0.0], [1 - 2**-53]]))).all()

    @pytest.mark.parametrize("law", ["norm", stats.norm([0, 1], 1), stats.norm(np.nan, 1)])
    def test_refused(self, law):
        with pytest.raises(ValueError, match="law of x"):
            Marginal("x", law)


R = np.array([[1.0, 0.6, -0.3], [0.6, 1.0, 0.2], [-0.3, 0.2, 1.0]])
DEVIATION = np.array([0.5, 2.0, 3.0])
GAUSSIAN = Gaussian(("a", "b", "c"), (1.0, -2.0, 0.0), R * np.outer(DEVIATION, DEVIATION))


class TestGaussian:
    def test_moments(self):
        x = GAUSSIAN.sample(unit(3, 3, 400_000))
        np.testing.assert_allclose(x.mean(axis=0), [1.0, -2.0, 0.0], atol=0.02)
        np.testing.assert_allclose(np.corrcoef(x.T), R, atol=0.006)

    @pytest.mark.parametrize("marks", [(True, False, False), (False, True, True), (True, False, True)])
    def test_conditional_draws_keep_the_joint_law(self, marks):
        x = redrawn_joint(GAUSSIAN, marks, 4)
        np.testing.assert_allclose(np.corrcoef(x.T), R, atol=0.03)
        for k in range(3):
            assert_distributed(x[:, k], stats.norm(GAUSSIAN.mean[k], DEVIATION[k]).cdf)

    def test_conditional_law(self):
        """a | b = 0, c = 3 for unit normals: mean R_yz R_zz^-1 z, variance 1 - R_yz R_zz^-1 R_zy."""
        block = Gaussian(("a", "b", "c"), np.zeros(3), R)
        x = block.conditional(np.tile([9.0, 0.0, 3.0], (N, 1)), (True, False, False), unit(6, 3, N))
        gain = np.linalg.solve(R[1:, 1:], R[1:, 0])
        assert_distributed(x[:, 0], stats.norm(gain @ [0.0, 3.0], np.sqrt(1 - gain @ R[1:, 0])).cdf)
        assert (x[:, 1:] == [0.0, 3.0]).all()

    @pytest.mark.parametrize(
        ("matrix", "message"),
        [
            ([[1, 2], [2, 1]], "positive definite"),
            ([[1, 0.5], [0.4, 1]], "not symmetric"),
            ([[1, 1], [1, 1]], "positive definite"),
            ([[1, np.nan], [0, 1]], "finite"),
            (np.eye(3), "shape"),
            ([[0, 0], [0, 1]], "above 0"),
        ],
    )
    def test_refused(self, matrix, message):
        with pytest.raises(ValueError, match=message):
            Gaussian(("a", "b"), (0, 0), matrix)


COPULA_MARGINALS = (Marginal("e", stats.expon(scale=2.0)), Marginal("b", stats.beta(2, 3)))


class TestCopula:
    def test_rank_correlation(self):
        block = GaussianCopula(COPULA_MARGINALS, rank_correlation=[[1, 0.5], [0.5, 1]])
        x = block.sample(unit(8, 2, 200_000))
        assert stats.spearmanr(x[:, 0], x[:, 1]).statistic == pytest.approx(0.5, abs=0.006)
        assert block.correlation[0, 1] == pytest.approx(2 * np.sin(np.pi / 12))

    @pytest.mark.parametrize("marks", [(True, False), (False, True)])
    def test_conditional_draws_keep_the_joint_law(self, marks):
        block = GaussianCopula(COPULA_MARGINALS, rank_correlation=[[1, 0.5], [0.5, 1]])
        x = redrawn_joint(block, marks, 9)
        for k, marginal in enumerate(COPULA_MARGINALS):
            assert_distributed(x[:, k], marginal.law.cdf)
        assert stats.spearmanr(x[:, 0], x[:, 1]).statistic == pytest.approx(0.5, abs=0.02)

    def test_normal_marginals_are_the_gaussian(self):
        copula = GaussianCopula(
            [Marginal(n, stats.norm(m, d)) for n, m, d in zip("abc", (1, -2, 0), DEVIATION, strict=True)], R
        )
        x = GAUSSIAN.sample(unit(11, 3, 100))
        for kept in ((True, True, True), (True, False, True), (False, True, False)):
            np.testing.assert_allclose(copula.density(x, kept).value, GAUSSIAN.density(x, kept).value, rtol=1e-6)

    def test_refused(self):
        with pytest.raises(ValueError, match="one of them"):
            GaussianCopula(COPULA_MARGINALS)
        with pytest.raises(ValueError, match="discrete"):
            GaussianCopula([Marginal("n", stats.poisson(3)), COPULA_MARGINALS[0]], np.eye(2))


class TestSimplex:
    @pytest.mark.parametrize("marks", [None, (True, True, False), (False, True, True)])
    def test_dirichlet(self, marks):
        """Marginals of Dirichlet's law are beta laws: a_k, the sum of the others."""
        block = Simplex(("x", "y", "z"), (2.0, 1.0, 3.0), total=5.0)
        x = block.sample(unit(12, 3, N)) if marks is None else redrawn_joint(block, marks, 33)
        for k, a in enumerate(block.concentration):
            assert_distributed(x[:, k] / 5.0, stats.beta(a, 6.0 - a).cdf)
        assert block.contains(x).all()

    def test_a_single_share_is_what_is_left(self):
        block = Simplex(("x", "y", "z"))
        x = block.sample(unit(14, 3, 100))
        np.testing.assert_allclose(block.conditional(x, (False, True, False), unit(15, 3, 100)), x, atol=1e-15)

    def test_refused(self):
        with pytest.raises(ValueError, match="two or more"):
            Simplex(("x",))
        with pytest.raises(ValueError, match="above 0"):
            Simplex(("x", "y"), (1.0, 0.0))


SHARE = 0.25
JAMS = ordered_with_jams(("LL", "UL"), -30.0, 30.0, SHARE, "deg")


class TestMixture:
    def test_share_of_jams(self):
        x = JAMS.sample(unit(16, 2, N))
        jam = x[:, 0] == x[:, 1]
        assert abs(jam.mean() - SHARE) < 4 * np.sqrt(SHARE * (1 - SHARE) / N)
        assert_distributed(x[jam, 0], stats.uniform(-30, 60).cdf)
        assert_distributed(x[~jam, 0], lambda v: 1 - ((30 - v) / 60) ** 2)

    @pytest.mark.parametrize("marks", [(True, False), (False, True)])
    def test_conditional_draws_keep_the_joint_law(self, marks):
        x = redrawn_joint(JAMS, marks, 17)
        jam = x[:, 0] == x[:, 1]
        assert abs(jam.mean() - SHARE) < 4 * np.sqrt(SHARE * (1 - SHARE) / N)
        assert_distributed(x[jam, 0], stats.uniform(-30, 60).cdf)
        assert_distributed(x[~jam, 1], lambda v: ((v + 30) / 60) ** 2)

    def test_a_jam_given_the_lower_limit(self):
        """p(jam | LL) = q / W over (q / W + (1 - q) 2 (30 - LL) / W^2), at LL = 0: 0.25 / (0.25 + 0.75) = 1/4."""
        x = JAMS.conditional(np.tile([0.0, 9.0], (N, 1)), (False, True), unit(19, 2, N))
        assert abs((x[:, 1] == 0.0).mean() - 0.25) < 4 * np.sqrt(0.25 * 0.75 / N)

    def test_a_point_outweighs_a_density(self):
        block = Mixture((OrderedUniform(("a", "b"), 0.0, 1.0), PointMass(("a", "b"), (0.5, 0.5))), (0.9, 0.1))
        at = block.conditional(np.tile([0.5, 0.7], (1000, 1)), (False, True), unit(20, 2, 1000))
        beside = block.conditional(np.tile([0.4, 0.7], (1000, 1)), (False, True), unit(20, 2, 1000))
        assert (at[:, 1] == 0.5).all()
        assert_distributed(beside[:, 1], stats.uniform(0.4, 0.6).cdf)

    def test_two_gaussians(self):
        one, other = (Gaussian(("a", "b"), m, [[1.0, r], [r, 1.0]]) for m, r in (((0, 0), 0.8), ((3, 1), -0.5)))
        block = Mixture((one, other), (0.3, 0.7))
        x = redrawn_joint(block, (True, False), 21)
        assert_distributed(x[:, 0], lambda v: 0.3 * stats.norm.cdf(v) + 0.7 * stats.norm.cdf(v - 3))

    @pytest.mark.parametrize(
        ("parts", "weights", "message"),
        [
            ((Uniform("a", 0, 1),), (1.0,), "two or more"),
            ((Uniform("a", 0, 1), Uniform("b", 0, 1)), (1, 1), "names"),
            ((Uniform("a", 0, 1), Uniform("a", 1, 2)), (1, -1), "Weights"),
            ((Simplex(("a", "b")), OrderedUniform(("a", "b"), 0, 1)), (1, 1), "no density"),
        ],
    )
    def test_refused(self, parts, weights, message):
        with pytest.raises(ValueError, match=message):
            Mixture(parts, weights)

    def test_ends(self):
        assert isinstance(ordered_with_jams(("a", "b"), 0, 1, 1.0), Equal)
        assert isinstance(ordered_with_jams(("a", "b"), 0, 1, 0.0), OrderedUniform)
        with pytest.raises(ValueError, match="share of jams"):
            ordered_with_jams(("a", "b"), 0, 1, 1.5)


class TestEmpirical:
    def test_rows(self):
        table = GAUSSIAN.sample(unit(22, 3, 5000))
        block = Empirical(("a", "b", "c"), table)
        x = block.sample(unit(23, 3, 2000))
        assert set(map(tuple, x)) <= set(map(tuple, table))

    def test_conditional_draws_follow_the_table(self):
        table = GAUSSIAN.sample(unit(24, 3, 20000))
        x = redrawn_joint(Empirical(("a", "b", "c"), table), (True, False, False), 25)
        np.testing.assert_allclose(np.corrcoef(x.T), R, atol=0.03)

    def test_refused(self):
        with pytest.raises(ValueError, match="at least 20"):
            Empirical(("a",), np.zeros((3, 1)))
        rows = np.ones((30, 2))
        rows[7, 1] = np.nan
        with pytest.raises(ValueError, match="first row 7"):
            Empirical(("a", "b"), rows)
        with pytest.raises(ValueError, match="Neighbours"):
            Empirical(("a", "b"), np.random.default_rng(0).random((30, 2)), neighbours=31)


class TestConditioned:
    def test_triangle(self):
        """Two uniforms given a <= b are the ordered pair; half of all draws meet that."""
        block = Conditioned(Distribution([Uniform("a", 0, 1), Uniform("b", 0, 1)]), lambda x: x[:, 0] <= x[:, 1])
        x = block.sample(unit(26, 2, N))
        assert_distributed(x[:, 0], lambda v: 1 - (1 - v) ** 2)
        assert block.acceptance == pytest.approx(0.5, abs=0.01)
        again = block.conditional(x, (False, True), unit(27, 2, N))
        assert_distributed((again[:, 1] - x[:, 0]) / (1 - x[:, 0]), "uniform")
        assert block.contains(again).all()

    def test_whole_distribution(self):
        distribution = conditioned([Uniform("a", 0, 1), Uniform("b", 0, 1)], lambda x: x.sum(axis=1) < 1)
        assert distribution.dependent == (("a", "b"),)

    def test_nowhere(self, monkeypatch):
        monkeypatch.setattr("sensitivity.rejection.MOST_TRIES", 10)
        block = Conditioned(Distribution([Uniform("a", 0, 1)]), lambda x: x[:, 0] > 2)
        with pytest.raises(ValueError, match="held in none of 10 draws of 5 rows"):
            block.sample(unit(28, 1, 5))
        monkeypatch.undo()
        with pytest.raises(ValueError, match=r"held in none of 10\d\d draws: choose"):
            Conditioned(Distribution([Uniform("a", 0, 1)]), lambda x: x[:, 0] > 2).sample(unit(28, 1, 5))
        with pytest.raises(ValueError, match="one truth a point"):
            Conditioned(Distribution([Uniform("a", 0, 1)]), lambda x: x > 2).sample(unit(28, 1, 5))


class TestSalibProblem:
    def test_same_scaling(self):
        from SALib.util import scale_samples

        problem = {
            "names": list("abcdefg"),
            "bounds": [[-1, 2], [1, 10], [0, 4, 0.25], [3, 2], [-1, 1, 0, 0.5], [0, 1], [2, 3]],
            "dists": ["unif", "logunif", "triang", "norm", "truncnorm", "lognorm", "weibull"],
            "num_vars": 7,
        }
        u = unit(29, 7, 100)
        distribution, groups = from_salib(problem)
        np.testing.assert_allclose(distribution.sample(u), scale_samples(u.copy(), problem), rtol=1e-9)
        assert groups == ()

    def test_groups(self):
        problem = {"names": ["a", "b", "c"], "bounds": [[0, 1]] * 3, "groups": ["one", "two", "one"]}
        assert from_salib(problem)[1] == (("a", "c"),)

    @pytest.mark.parametrize(
        ("changed", "message"),
        [
            ({"bounds": [[1, 0], [0, 1]]}, "Bounds of a"),
            ({"bounds": [[0, 1]]}, "as many of each"),
            ({"dists": ["unif", "cauchy"]}, "choose one of"),
            ({"dists": ["triang", "unif"]}, "give 3"),
            ({"bounds": [[0, -1], [0, 1]], "dists": ["norm", "unif"]}, "law of a"),
            ({"names": None}, "dictionary with both"),
        ],
    )
    def test_refused(self, changed, message):
        problem = {"names": ["a", "b"], "bounds": [[0, 1], [0, 1]]} | changed
        with pytest.raises(ValueError, match=message):
            from_salib(problem)
