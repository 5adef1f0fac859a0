"""Indices against closed forms, quadrature and SALib; intervals against their own spread and coverage."""

import json

import numpy as np
import pytest
from numpy.polynomial.legendre import leggauss
from SALib.analyze import sobol as salib_analyze
from SALib.sample import sobol as salib_sample
from scipy.stats import norm

from sensitivity import Distribution, OrderedUniform, Uniform, variance_design, variance_indices

pytestmark = pytest.mark.slow

PI = np.pi
TRIANGLE = Distribution([Uniform("x", 0.0, 1.0), OrderedUniform(("L", "U"), 0.0, 1.0)])


def ishigami(x):
    return np.sin(x[:, 0]) + 7.0 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])


def ishigami_indices():
    """Ishigami and Homma 1990, a = 7, b = 0.1: V1 = (1 + b pi^4/5)^2/2, V2 = a^2/8, V13 = b^2 pi^8 (1/18 - 1/50)."""
    v1, v2, v13 = (1 + 0.1 * PI**4 / 5) ** 2 / 2, 49 / 8, 0.01 * PI**8 * (1 / 18 - 1 / 50)
    return np.array([v1, v2, 0.0]) / (v1 + v2 + v13), np.array([v1 + v13, v2, v13]) / (v1 + v2 + v13)


G_COEFFICIENTS = np.array([0.0, 1.0, 4.5, 9.0, 99.0, 99.0])


def g_function(x):
    return np.prod((np.abs(4 * x - 2) + G_COEFFICIENTS) / (1 + G_COEFFICIENTS), axis=1)


def g_indices():
    """Sobol 1993: V_i = 1 / (3 (1 + a_i)^2), D = prod(1 + V_i) - 1, V_Ti = V_i prod over j != i of (1 + V_j)."""
    v = 1 / (3 * (1 + G_COEFFICIENTS) ** 2)
    product = np.prod(1 + v)
    return v / (product - 1), v * product / (1 + v) / (product - 1)


def independent(n_inputs, lower, upper):
    return Distribution([Uniform(f"x{i + 1}", lower, upper) for i in range(n_inputs)])


INDEPENDENT_CASES = {
    "ishigami": (ishigami, independent(3, -PI, PI), ishigami_indices()),
    "g function": (g_function, independent(6, 0.0, 1.0), g_indices()),
}


def linear_indices(a, b, c):
    """f = c x + a L + b U, x uniform on [0, 1] and (L, U) uniform on 0 <= L <= U <= 1, density 2.

    V(x) = 1/12, V(L) = V(U) = 1/18, cov(L, U) = 1/36, so D = c^2/12 + (a^2 + b^2 + a b)/18.
    E(U | L) = (1 + L)/2, so V[E(f | L)] = (a + b/2)^2/18; E(L | U) = U/2, so V[E(f | U)] = (b + a/2)^2/18.
    V(L | U) = U^2/12 and E(U^2) = integral of 2 U^3 = 1/2, so E[V(f | x, U)] = a^2/24; by the symmetry
    (L, U) -> (1 - U, 1 - L) also E[V(f | x, L)] = b^2/24.
    The pair's closed and total variance is (a^2 + b^2 + a b)/18, that of x is c^2/12.
    Rows: x, L, U, {L, U}.
    """
    pair, own = (a * a + b * b + a * b) / 18, c * c / 12
    first = np.array([own, (a + b / 2) ** 2 / 18, (b + a / 2) ** 2 / 18, pair])
    total = np.array([own, a * a / 24, b * b / 24, pair])
    return first / (pair + own), total / (pair + own)


def quadrature_indices(f, order=12):
    """The same rows for any f(x, L, U) by brute force: nested Gauss-Legendre sums, exact for low-degree polynomials."""
    nodes, weights = leggauss(order)
    nodes, weights = (nodes + 1) / 2, weights / 2
    x = nodes[:, None, None]

    def mean(values, axes, outer):
        """Mean over axes of the tensor (x, held limit, other limit); the held limit has the triangle's marginal."""
        for axis in sorted(axes, reverse=True):
            values = np.tensordot(values, outer if axis == 1 else weights, axes=(axis, 0))
        return values

    held = nodes[None, :, None]
    given_l = f(x, held, held + (1 - held) * nodes), weights * 2 * (1 - nodes)
    given_u = f(x, held * nodes, held), weights * 2 * nodes
    values, marginal = given_l
    f0 = mean(values, (0, 1, 2), marginal)
    variance = mean(values**2, (0, 1, 2), marginal) - f0**2

    def explained(tensor, kept):
        values, marginal = tensor
        inner = mean(values, set(range(3)) - set(kept), marginal) ** 2
        for axis in sorted(kept, reverse=True):
            inner = np.tensordot(inner, marginal if axis == 1 else weights, axes=(sorted(kept).index(axis), 0))
        return (inner - f0**2) / variance

    first = [explained(given_l, [0]), explained(given_l, [1]), explained(given_u, [1]), explained(given_l, [1, 2])]
    rest = [explained(given_l, [1, 2]), explained(given_u, [0, 1]), explained(given_l, [0, 1]), explained(given_l, [0])]
    return np.array(first), 1 - np.array(rest)


def product(x, lower, upper):
    """Not additive, and far from symmetric in L and U; a polynomial, so the quadrature is exact."""
    return (x + 1) * lower * upper**2


TRIANGLE_CASES = {
    "linear": (lambda x, lo, up: 0.7 * x + 2.0 * lo - 1.0 * up, linear_indices(2.0, -1.0, 0.7)),
    "sum": (lambda x, lo, up: x + lo + up, linear_indices(1.0, 1.0, 1.0)),
    "product": (product, quadrature_indices(product)),
}


def on_columns(f):
    return lambda points: f(points[:, 0], points[:, 1], points[:, 2])


def assert_indices(result, exact, tolerance, output=0):
    """Within the tolerance, and within four of the standard errors that the result states."""
    for estimate, expected in zip((result.first, result.total), exact, strict=True):
        error = np.abs(estimate.value[:, output] - expected)
        assert (error <= tolerance).all(), error
        assert (error <= 4 * estimate.standard_error[:, output] + 1e-12).all(), error


@pytest.mark.parametrize(("sampling", "tolerance"), [("random", 0.02), ("sobol", 0.004)])
@pytest.mark.parametrize("case", INDEPENDENT_CASES)
def test_independent_closed_forms(case, sampling, tolerance):
    f, distribution, exact = INDEPENDENT_CASES[case]
    result = variance_indices(variance_design(distribution, 2**14, sampling=sampling, seed=1).evaluate(f))
    assert_indices(result, exact, tolerance)
    assert result.identities == ()


@pytest.mark.parametrize("case", INDEPENDENT_CASES)
def test_against_salib(case):
    """SALib 1.6, the usual package for independent inputs, at the same function and number of base rows."""
    f, distribution, _ = INDEPENDENT_CASES[case]
    bounds = [[block.lower, block.upper] for block in distribution.blocks]
    problem = {"num_vars": len(bounds), "names": list(distribution.names), "bounds": bounds}
    points = salib_sample.sample(problem, 2**13, calc_second_order=False, seed=2)
    theirs = salib_analyze.analyze(problem, f(points), calc_second_order=False, num_resamples=20, seed=2)
    ours = variance_indices(variance_design(distribution, 2**13, seed=2).evaluate(f))
    np.testing.assert_allclose(ours.first.value[:, 0], theirs["S1"], atol=0.01)
    np.testing.assert_allclose(ours.total.value[:, 0], theirs["ST"], atol=0.01)


def test_quadrature_agrees_with_the_closed_form():
    for a, b, c in [(2.0, -1.0, 0.7), (1.0, 1.0, 1.0), (0.3, 4.0, 0.0)]:
        quadrature = quadrature_indices(lambda x, lo, up, a=a, b=b, c=c: c * x + a * lo + b * up)
        np.testing.assert_allclose(quadrature, linear_indices(a, b, c), atol=1e-13)


@pytest.mark.parametrize(("sampling", "tolerance"), [("random", 0.025), ("sobol", 0.002)])
@pytest.mark.parametrize("case", TRIANGLE_CASES)
def test_dependent_inputs_on_the_triangle(case, sampling, tolerance):
    f, exact = TRIANGLE_CASES[case]
    result = variance_indices(variance_design(TRIANGLE, 2**14, sampling=sampling, seed=4).evaluate(on_columns(f)))
    assert result.factors == (("x",), ("L",), ("U",), ("L", "U"))
    assert_indices(result, exact, tolerance)


def test_first_order_may_exceed_total_for_dependent_inputs():
    """f = L + U: S_L = 3/4 and ST_L = 1/4 of the pair's variance; nothing is clipped or put in order."""
    f, (first, total) = TRIANGLE_CASES["sum"]
    result = variance_indices(variance_design(TRIANGLE, 2**12, seed=1).evaluate(on_columns(f)))
    assert first[1] > total[1]
    assert result.first.lower[1, 0] > result.total.upper[1, 0]


class CorrelatedNormals:
    """A block of a user's own: two normals of standard deviations 1 and sigma with correlation rho."""

    names, units = ("x2", "x3"), ("", "")

    def __init__(self, sigma, rho):
        self.scale, self.rho = np.array([1.0, sigma]), rho

    def sample(self, u):
        first, second = norm.ppf(u).T
        return self.scale * np.column_stack([first, self.rho * first + np.sqrt(1 - self.rho**2) * second])

    def conditional(self, x, redrawn, u):
        standard = x / self.scale
        new = self.rho * standard[:, ::-1] + np.sqrt(1 - self.rho**2) * norm.ppf(u)
        return self.scale * np.where(redrawn, new, standard)

    def contains(self, x):
        return np.isfinite(x).all(axis=1)


@pytest.mark.parametrize("rho", [-0.8, -0.5, 0.5])
def test_correlated_normals_of_kucherenko(rho):
    """Kucherenko, Tarantola, Annoni 2012, linear model x1 + x2 + x3 of normals; here V(x1) = 1, sigma = 2.

    D = 2 + sigma^2 + 2 rho sigma; S = (1, (1 + rho sigma)^2, (sigma + rho)^2) / D;
    ST = (1, 1 - rho^2, sigma^2 (1 - rho^2)) / D.  x1 is drawn as sqrt(12) times a centred uniform.
    """
    sigma = 2.0
    root = np.sqrt(3.0)
    distribution = Distribution([Uniform("x1", -root, root), CorrelatedNormals(sigma, rho)])
    result = variance_indices(variance_design(distribution, 2**13, seed=3).evaluate(lambda x: x.sum(axis=1)))
    pair = 1 + sigma**2 + 2 * rho * sigma
    first = np.array([1, (1 + rho * sigma) ** 2, (sigma + rho) ** 2, pair]) / (1 + pair)
    total = np.array([1, 1 - rho**2, sigma**2 * (1 - rho**2), pair]) / (1 + pair)
    assert_indices(result, (first, total), 0.003)


def test_group_of_independent_inputs():
    """Ishigami's group {x1, x3}: closed and total index both 1 - S2; {x2, x3}: closed S2, total 1 - S1."""
    f, distribution, (first, _) = INDEPENDENT_CASES["ishigami"]
    design = variance_design(distribution, 2**13, groups=[["x1", "x3"], ["x3", "x2"]], seed=5)
    result = variance_indices(design.evaluate(f))
    assert result.factors[3:] == (("x1", "x3"), ("x2", "x3"))
    np.testing.assert_allclose(result.first.value[3:, 0], [1 - first[1], first[1]], atol=0.005)
    np.testing.assert_allclose(result.total.value[3:, 0], [1 - first[1], 1 - first[0]], atol=0.005)


def test_vector_output_scale_and_offset():
    """Indices do not depend on scale or offset; a mean 1e6 times the spread costs no more than its rounding."""
    f = on_columns(product)
    design = variance_design(TRIANGLE, 2**10, sampling="random", seed=6)
    alone = variance_indices(design.evaluate(f))
    both = variance_indices(design.evaluate(lambda x: np.column_stack([f(x), 1e6 - 3.0 * f(x)]), ["y", "z"]))
    for kind in ("first", "total"):
        for field in ("value", "lower", "upper", "standard_error", "change_on_doubling"):
            one, two = getattr(getattr(alone, kind), field), getattr(getattr(both, kind), field)
            np.testing.assert_allclose(two, np.hstack([one, one]), rtol=1e-6, atol=1e-8)
    assert both.output_mean[1] == pytest.approx(1e6 - 3 * alone.output_mean[0], rel=1e-12)
    assert both.output_variance[1] == pytest.approx(9 * alone.output_variance[0], rel=1e-6)


def pooled_correlation(a, c):
    pooled = np.concatenate([a, c])
    return (np.mean(a * c) - pooled.mean() ** 2) / pooled.var()


def test_estimators_by_hand():
    """1 - S = (1 - corr(a, c)) / (1 - corr(a, b)), with mean and variance of the pooled pair, and b all redrawn.

    ST = [mean (a - c)^2 / (2 D_ac)] / [mean (a - b)^2 / (2 D_ab)].
    """
    design = variance_design(TRIANGLE, 32, sampling="random", seed=7)
    evaluated = design.evaluate(on_columns(product))
    result = variance_indices(evaluated)
    blocks = dict(zip(design.redrawn, evaluated.outputs[:, 0].reshape(-1, 32), strict=True))
    a, b = blocks[()], blocks[TRIANGLE.names]
    for i, factor in enumerate(design.factors):
        c = blocks[design.distribution.complement(factor)]
        expected = 1 - (1 - pooled_correlation(a, c)) / (1 - pooled_correlation(a, b))
        assert result.first.value[i, 0] == pytest.approx(expected, abs=1e-12)
        c = blocks[factor]
        d_ac, d_ab = np.concatenate([a, c]).var(), np.concatenate([a, b]).var()
        expected = np.mean((a - c) ** 2) / np.mean((a - b) ** 2) * d_ab / d_ac
        assert result.total.value[i, 0] == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("sampling", ["random", "sobol"])
def test_change_on_doubling_is_against_the_half_sized_design(sampling):
    """The first half of each replicate is itself the design of half the size."""
    f = on_columns(product)
    full, half = (variance_design(TRIANGLE, n, sampling=sampling, replicates=4, seed=8) for n in (512, 256))
    if sampling == "sobol":
        rows = np.concatenate([np.arange(64) + 128 * replicate for replicate in range(4)])
        np.testing.assert_array_equal(full.points[rows], half.points[:256])
    full, half = (variance_indices(design.evaluate(f)) for design in (full, half))
    for kind in ("first", "total"):
        change = getattr(full, kind).value - getattr(half, kind).value
        np.testing.assert_allclose(getattr(full, kind).change_on_doubling, change, atol=1e-12)


@pytest.mark.parametrize("sampling", ["random", "sobol"])
def test_coverage_of_the_intervals(sampling):
    """200 repeats: every 95 % interval holds the exact value in 89-99 % (binomial error 1.5 %), 93-97 % on average."""
    exact = np.stack(TRIANGLE_CASES["product"][1])
    hits = []
    for seed in range(200):
        design = variance_design(TRIANGLE, 512, sampling=sampling, seed=seed)
        result = variance_indices(design.evaluate(on_columns(product)), n_bootstrap=400, seed=seed)
        lower = np.stack([result.first.lower, result.total.lower])[..., 0]
        upper = np.stack([result.first.upper, result.total.upper])[..., 0]
        hits.append((lower <= exact) & (exact <= upper))
    coverage = np.mean(hits, axis=0)
    assert ((coverage >= 0.89) & (coverage <= 0.99)).all(), coverage
    assert 0.93 <= coverage.mean() <= 0.97, coverage


def test_bootstrap_over_blocks_equals_bootstrap_over_rows():
    """8000 rows are resampled in 2000 blocks of four; the spread over 100 designs says whether the error is right."""
    f = on_columns(product)
    results = [
        variance_indices(variance_design(TRIANGLE, 8000, sampling="random", seed=s).evaluate(f), n_bootstrap=100)
        for s in range(100)
    ]
    for kind in ("first", "total"):
        spread = np.std([getattr(r, kind).value for r in results], axis=0, ddof=1)
        stated = np.mean([getattr(r, kind).standard_error for r in results], axis=0)
        np.testing.assert_allclose(stated, spread, rtol=0.2)


def test_identity():
    """Exact sums by quadrature, at most 1: for L the sum lacks what only U with others explains, and the reverse."""
    result = variance_indices(variance_design(TRIANGLE, 2**13, seed=9).evaluate(on_columns(product)))
    first, total = TRIANGLE_CASES["product"][1]
    assert [(i.first, i.total, i.rest) for i in result.identities] == [
        (("U",), ("L",), ("x",)),
        (("L",), ("U",), ("x",)),
    ]
    exact = np.array([first[2] + total[1] + first[0], first[1] + total[2] + first[0]])
    assert (exact < 1).all()
    assert np.abs(result.identity_sums.value[:, 0] - exact).max() < 0.002
    assert result.identities_hold.all()


def test_identity_is_exactly_one_for_additive_functions():
    """For the linear case S_L + ST_U + S_x = 1: (a + b/2)^2 + 3 b^2/4 = a^2 + b^2 + a b."""
    f, (first, total) = TRIANGLE_CASES["linear"]
    assert first[1] + total[2] + first[0] == pytest.approx(1.0, abs=1e-15)
    result = variance_indices(variance_design(TRIANGLE, 2**13, seed=10).evaluate(on_columns(f)))
    np.testing.assert_allclose(result.identity_sums.value[:, 0], 1.0, atol=0.002)


def test_identity_reports_a_wrong_conditional_sampler():
    """Holding UL while LL is redrawn as if it were free breaks p(LL | UL), and the identity shows it."""

    class Wrong(OrderedUniform):
        def conditional(self, x, redrawn, u):
            y = self.sample(u)
            return np.where(redrawn, y, x)

    distribution = Distribution([Uniform("x", 0.0, 1.0), Wrong(("L", "U"), 0.0, 1.0)])
    design = variance_design(distribution, 2**13, seed=11)
    assert design.n_outside > 0
    result = variance_indices(design.evaluate(lambda x: 0.1 * x[:, 0] + x[:, 2] - x[:, 1]))
    assert not result.identities_hold.all()


def test_dictionary_is_json_and_complete():
    design = variance_design(TRIANGLE, 64, replicates=4, seed=12)
    result = variance_indices(design.evaluate(on_columns(product), ["y"]), confidence=0.9)
    read = json.loads(json.dumps(result.to_dict(), allow_nan=False))
    assert read["n_evaluations"] == design.n_evaluations == 64 * (2 * 4 + 2 - 2)
    assert (read["n_base"], read["replicates"], read["seed"], read["sampling"]) == (64, 4, 12, "sobol")
    assert (read["confidence"], read["n_outside"]) == (0.9, 0)
    output = read["outputs"]["y"]
    assert list(output["indices"]) == ["x", "L", "U", "L,U"]
    assert output["indices"]["L,U"]["total"]["upper"] == result.total.upper[3, 0]
    assert output["identities"][0]["sum"]["value"] == result.identity_sums.value[0, 0]
    assert output["identities"][0]["rest"] == ["x"]


def test_confidence_widens_the_interval():
    for sampling in ("random", "sobol"):
        evaluated = variance_design(TRIANGLE, 256, sampling=sampling).evaluate(on_columns(product))
        narrow, wide = (variance_indices(evaluated, confidence=c) for c in (0.5, 0.95))
        ratio = (wide.total.upper - wide.total.lower) / (narrow.total.upper - narrow.total.lower)
        # Normal: 1.960 / 0.674 = 2.9; Student with 7 degrees of freedom: 2.365 / 0.711 = 3.3.
        np.testing.assert_allclose(ratio, 3.1, atol=0.5)


@pytest.mark.parametrize(
    ("options", "sentence"),
    [({"confidence": 95}, "Confidence is 95: give a number between 0 and 1"), ({"n_bootstrap": 1}, "at least 2")],
)
def test_bad_input(options, sentence):
    evaluated = variance_design(TRIANGLE, 64).evaluate(on_columns(product))
    with pytest.raises(ValueError, match=sentence):
        variance_indices(evaluated, **options)
