"""Joint and conditional samplers against their exact distributions; Kolmogorov-Smirnov at fixed seeds."""

import numpy as np
import pytest
from scipy import stats

from sensitivity import Distribution, OrderedUniform, Uniform

LOWER, UPPER = -30.0, 30.0
WIDTH = UPPER - LOWER
N = 20000
LIMITS = OrderedUniform(("LL", "UL"), LOWER, UPPER, "deg")
DISTRIBUTION = Distribution([Uniform("h", 0.0, 30000.0, "ft"), LIMITS, Uniform("gamma", -5.0, 5.0, "deg")])


def unit(seed, columns=4, n=N):
    return np.random.default_rng(seed).random((n, columns))


def assert_distributed(sample, cdf):
    """A right sampler fails this for one seed in a hundred; the seeds are fixed."""
    assert stats.kstest(sample, cdf).pvalue > 0.01


def lower_cdf(x):
    return 1.0 - ((UPPER - x) / WIDTH) ** 2


def upper_cdf(x):
    return ((x - LOWER) / WIDTH) ** 2


def assert_triangle(lower_limit, upper_limit):
    """LL has its marginal law, UL its uniform law given LL, and the two numbers behind them are independent."""
    p = lower_cdf(lower_limit)
    q = (upper_limit - lower_limit) / (UPPER - lower_limit)
    assert_distributed(p, "uniform")
    assert_distributed(q, "uniform")
    assert_distributed(upper_limit, upper_cdf)
    assert stats.spearmanr(p, q).pvalue > 0.01


def test_columns_follow_the_blocks():
    assert DISTRIBUTION.names == ("h", "LL", "UL", "gamma")
    assert DISTRIBUTION.units == ("ft", "deg", "deg", "deg")
    assert DISTRIBUTION.dependent == (("LL", "UL"),)


def test_joint_sample():
    x = DISTRIBUTION.sample(unit(1))
    assert_distributed(x[:, 0], stats.uniform(0.0, 30000.0).cdf)
    assert_distributed(x[:, 3], stats.uniform(-5.0, 10.0).cdf)
    assert_triangle(x[:, 1], x[:, 2])
    assert DISTRIBUTION.contains(x).all()
    assert abs(stats.spearmanr(x[:, 0], x[:, 1]).statistic) < 0.02


def test_triangle_moments():
    """Uniform triangle 0 <= L <= U <= 1: E L = 1/3, E U = 2/3, both variances 1/18, covariance 1/36."""
    x = OrderedUniform(("L", "U"), 0.0, 1.0).sample(unit(2, 2, 400_000))
    np.testing.assert_allclose(x.mean(axis=0), [1 / 3, 2 / 3], atol=2e-3)
    np.testing.assert_allclose(np.cov(x.T), [[1 / 18, 1 / 36], [1 / 36, 1 / 18]], atol=5e-4)


def test_same_joint_distribution_as_the_papers_map():
    """Paper eq. (63) with A1 (-30, 30), A2 (-30, -30), A3 (30, 30)."""
    p1, p2 = unit(3, 2).T
    corners = np.array([[LOWER, UPPER], [LOWER, LOWER], [UPPER, UPPER]])
    root = np.sqrt(p1)
    paper = np.stack([1 - root, root * (1 - p2), root * p2], axis=1) @ corners
    assert_triangle(*paper.T)
    ours = LIMITS.sample(unit(4, 2))
    for direction in ([1, 0], [0, 1], [-1, 1], [1, 1]):
        assert stats.ks_2samp(paper @ direction, ours @ direction).pvalue > 0.01


@pytest.mark.parametrize("held", [-29.0, 3.0, 29.5])
def test_conditional_at_a_held_value(held):
    u = unit(5)
    x = DISTRIBUTION.sample(unit(6))
    x[:, 1] = held
    assert_distributed(DISTRIBUTION.conditional(x, ["UL"], u)[:, 2], stats.uniform(held, UPPER - held).cdf)
    x[:, 2] = held
    assert_distributed(DISTRIBUTION.conditional(x, ["LL"], u)[:, 1], stats.uniform(LOWER, held - LOWER).cdf)


@pytest.mark.parametrize(
    "redrawn", [["LL"], ["UL"], ["LL", "UL"], ["h", "UL"], ["h", "LL", "gamma"], ["h", "LL", "UL", "gamma"]]
)
def test_redrawing_keeps_the_joint_distribution_and_the_other_columns(redrawn):
    x = DISTRIBUTION.sample(unit(7))
    y = DISTRIBUTION.conditional(x, redrawn, unit(8))
    for j, name in enumerate(DISTRIBUTION.names):
        assert np.array_equal(x[:, j], y[:, j]) == (name not in redrawn)
    assert_triangle(y[:, 1], y[:, 2])
    assert DISTRIBUTION.contains(y).all()


def test_redrawn_pair_is_independent_of_the_old_one():
    x = DISTRIBUTION.sample(unit(9))
    y = DISTRIBUTION.conditional(x, ["LL", "UL"], unit(10))
    assert stats.spearmanr(x[:, 1], y[:, 1]).pvalue > 0.01
    # One limit held ties the other to its old value: corr(LL, LL') = E[V(E(LL | UL))] / V(LL) = 1/4.
    y = DISTRIBUTION.conditional(x, ["LL"], unit(10))
    assert np.corrcoef(x[:, 1], y[:, 1])[0, 1] == pytest.approx(0.25, abs=0.02)


def test_ends_of_the_unit_interval_stay_inside():
    ends = np.array([0.0, 0.5, np.nextafter(1.0, 0.0)])
    u = np.stack(np.meshgrid(ends, ends, ends, ends), axis=-1).reshape(-1, 4)
    x = DISTRIBUTION.sample(u)
    assert DISTRIBUTION.contains(x).all()
    for redrawn in (["LL"], ["UL"]):
        assert DISTRIBUTION.contains(DISTRIBUTION.conditional(x, redrawn, u)).all()
    assert not DISTRIBUTION.contains([[0.0, 5.0, 4.0, 0.0]]).any()


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: Uniform("h", 1.0, 1.0), r"Bounds of h are \[1, 1\]: give finite bounds with lower < upper"),
        (lambda: OrderedUniform(("a", "b"), 0.0, np.inf), r"Bounds of a <= b are \[0, inf\]"),
        (lambda: OrderedUniform("ab", 0.0, 1.0), "exactly two names, got 'ab'"),
        (lambda: Distribution([]), "needs at least one block"),
        (lambda: Distribution([Uniform("h", 0, 1), Uniform("h", 0, 1)]), r"\['h'\] occur more than once"),
        (lambda: DISTRIBUTION.sample(np.zeros((5, 3))), r"shape \(5, 3\), expected \(n, 4\)"),
        (lambda: DISTRIBUTION.sample(np.full((5, 4), 1.0)), r"must lie in \[0, 1\)"),
        (lambda: DISTRIBUTION.sample(np.full((5, 4), np.nan)), r"must lie in \[0, 1\)"),
        (lambda: DISTRIBUTION.conditional(np.zeros((5, 4)), ["V"], np.zeros((5, 4))), "choose from h, LL, UL, gamma"),
        (lambda: DISTRIBUTION.conditional(np.zeros((5, 4)), "h", np.zeros((5, 4))), "'h' is not a list of inputs"),
        (lambda: DISTRIBUTION.conditional(np.zeros((4, 4)), ["h"], np.zeros((5, 4))), "give one number for each"),
    ],
)
def test_bad_input(make, sentence):
    with pytest.raises(ValueError, match=sentence):
        make()
