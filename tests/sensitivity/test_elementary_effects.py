"""Elementary effects against SALib, against functions whose effects are known, and inside the domain."""

import numpy as np
import pytest
from scipy import stats

from sensitivity import Distribution, Marginal, OrderedUniform, Simplex, Uniform, effects_design

CUBE = Distribution([Uniform("a", -1.0, 3.0), Uniform("b", 0.0, 1.0), Uniform("c", 10.0, 40.0)])
LIMITS = Distribution([Uniform("h", 0.0, 1.0), OrderedUniform(("low", "high"), -30.0, 30.0)])


def curved(x):
    return np.column_stack([x[:, 0] ** 2 * x[:, 1] + np.sin(x[:, 2]), np.exp(x[:, 1]) - x[:, 2]])


def test_equal_to_salib_on_its_own_design():
    """SALib's trajectories, handed in as a design: mu, mu*, sigma to 1e-12."""
    from SALib.analyze import morris as analyze
    from SALib.sample import morris

    from sensitivity.elementary_effects import EffectsDesign

    problem = {"num_vars": 3, "names": ["a", "b", "c"], "bounds": [[-1, 3], [0, 1], [10, 40]]}
    X = morris.sample(problem, 40, num_levels=4, seed=1)
    moved = np.argmax(np.diff(X.reshape(40, 4, 3), axis=1) != 0, axis=2)
    design = EffectsDesign(CUBE, X, moved, radial=False, seed=1)
    outputs = curved(X)
    found = design.effects(outputs)
    for j in range(2):
        theirs = analyze.analyze(problem, X, outputs[:, j], num_levels=4)
        for kind in ("mu", "mu_star", "sigma"):
            np.testing.assert_allclose(getattr(found, kind).value[:, j], theirs[kind], rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("radial", [True, False])
def test_linear_function(radial):
    """Every effect of a linear function is its slope, times the range; none varies."""
    design = effects_design(CUBE, 10, radial=radial)
    found = design.evaluate(lambda x: x @ [2.0, -3.0, 0.5])
    np.testing.assert_allclose(found.mu.value[:, 0], [8.0, -3.0, 15.0])
    np.testing.assert_allclose(found.mu_star.value[:, 0], [8.0, 3.0, 15.0])
    np.testing.assert_allclose(found.sigma.value, 0.0, atol=1e-11)
    assert len(design.points) == 10 * 4
    plain = design.evaluate(lambda x: x @ [2.0, -3.0, 0.5], scaling="none")
    np.testing.assert_allclose(plain.mu.value[:, 0], [2.0, -3.0, 0.5])


@pytest.mark.parametrize("radial", [True, False])
def test_mean_of_a_product(radial):
    """x1 x2 on [0, 1]^2: the effect of x1 is x2, mean 1/2, deviation sqrt(1/12)."""
    square = Distribution([Uniform("x1", 0.0, 1.0), Uniform("x2", 0.0, 1.0)])
    found = effects_design(square, 4000, radial=radial, step=0.1).evaluate(lambda x: x[:, 0] * x[:, 1])
    np.testing.assert_allclose(found.mu.value[:, 0], 0.5, atol=0.02)
    np.testing.assert_allclose(found.sigma.value[:, 0], np.sqrt(1 / 12), atol=0.01)
    assert ((found.mu.lower < 0.5) & (found.mu.upper > 0.5)).all()


@pytest.mark.parametrize("radial", [True, False])
def test_every_point_lies_in_the_domain(radial):
    design = effects_design(LIMITS, 500, radial=radial, step=0.5)
    assert LIMITS.contains(design.points).all()
    groups = design.points.reshape(500, 4, 3)
    origin = groups[:, :1] if radial else groups[:, :-1]
    changed = (groups[:, 1:] != origin).sum(axis=2)
    assert (changed == 1).all()


def test_papers_scaling():
    """eq. (47): slope times I0 / f(I0); of f = a b c it is 1 for every input, whatever the start."""
    found = effects_design(CUBE, 20, seed=3, step=0.01).evaluate(lambda x: np.prod(x, axis=1), scaling="paper")
    np.testing.assert_allclose(found.mu.value[:, 0], 1.0, rtol=1e-9)
    with pytest.raises(ValueError, match="infinite"):
        effects_design(CUBE, 20).evaluate(lambda x: (x[:, 0] > 1.0).astype(float), scaling="paper")


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: effects_design(Distribution([Marginal("n", stats.norm()), Uniform("a", 0, 1)]), 5), "n is unbounded"),
        (lambda: effects_design(CUBE, 1), "at least 2"),
        (lambda: effects_design(CUBE, 5, step=1.0), "between 0 and 1"),
        (lambda: effects_design(Distribution([Simplex(("x", "y", "z"))]), 5), "cannot be moved alone"),
        (lambda: effects_design(CUBE, 5).effects(np.zeros(3)), "one row of outputs a point"),
        (lambda: effects_design(CUBE, 5).effects(np.arange(20.0), scaling="z"), "choose"),
    ],
)
def test_refused(call, message):
    with pytest.raises(ValueError, match=message):
        call()
