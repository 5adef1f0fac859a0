"""Designs: roles of the rows, cost, and the refusal of outputs that do not belong."""

import numpy as np
import pytest

from sensitivity import Distribution, OrderedUniform, Uniform, variance_design, variance_indices

DISTRIBUTION = Distribution([Uniform("h", 0, 1), Uniform("gamma", -5, 5), OrderedUniform(("LL", "UL"), -30, 30)])
INDEPENDENT = Distribution([Uniform("x", 0, 1), Uniform("y", 0, 1), Uniform("z", 0, 1)])


def model(x):
    return x[:, 0] + x[:, -1]


@pytest.mark.parametrize("sampling", ["sobol", "random"])
def test_each_block_redraws_its_inputs_and_only_those(sampling):
    design = variance_design(DISTRIBUTION, 64, sampling=sampling, replicates=4, seed=3)
    assert design.factors == (("h",), ("gamma",), ("LL",), ("UL",), ("LL", "UL"))
    blocks = design.points.reshape(len(design.redrawn), 64, 4)
    for role, block in zip(design.redrawn, blocks, strict=True):
        for j, name in enumerate(DISTRIBUTION.names):
            assert (block[:, j] == blocks[0, :, j]).all() == (name not in role)
    for factor in design.factors:
        assert factor in design.redrawn
        assert design.distribution.complement(factor) in design.redrawn
    assert design.n_outside == 0
    assert not design.points.flags.writeable


def test_cost():
    """N (2 M + 2) with M factors that share no block; less where one's complement is another."""
    assert variance_design(INDEPENDENT, 64, replicates=2).n_evaluations == 64 * (2 * 3 + 2)
    assert variance_design(DISTRIBUTION, 64, replicates=2).n_evaluations == 64 * (2 * 5 + 2)
    # The group {h, gamma} needs the same two blocks as {LL, UL}.
    shared = variance_design(DISTRIBUTION, 64, replicates=2, groups=[["gamma", "h"]])
    assert shared.factors[-1] == ("h", "gamma")
    assert shared.n_evaluations == 64 * (2 * 5 + 2)


def test_only_some_factors():
    """Two factors cost their two blocks each, the base sample and the one of all inputs."""
    design = variance_design(DISTRIBUTION, 64, factors=[["gamma"], ["UL", "LL"]], replicates=2)
    assert design.factors == (("gamma",), ("LL", "UL"))
    assert design.n_evaluations == 64 * (2 * 2 + 2)
    with pytest.raises(ValueError, match="some, but not all"):
        variance_design(DISTRIBUTION, 64, factors=[DISTRIBUTION.names])


def test_same_seed_same_points_and_replicates_differ():
    first, second = (variance_design(DISTRIBUTION, 64, replicates=2, seed=5) for _ in range(2))
    np.testing.assert_array_equal(first.points, second.points)
    assert (first.points[:32] != first.points[32:64]).all()
    assert (first.points != variance_design(DISTRIBUTION, 64, replicates=2, seed=6).points).any()


def test_sobol_replicates_are_balanced():
    """Each replicate of 2^k points puts exactly one point into each of the 2^k equal slices of every marginal."""
    design = variance_design(INDEPENDENT, 4 * 32, replicates=4, seed=1)
    for replicate in design.points[: 4 * 32].reshape(4, 32, 3):
        slices = np.sort(np.floor(replicate * 32), axis=0)
        np.testing.assert_array_equal(slices, np.arange(32)[:, np.newaxis] * np.ones(3))


def test_chunks_do_not_change_the_outputs():
    design = variance_design(DISTRIBUTION, 64, replicates=2)
    sizes = []

    def counting(x):
        sizes.append(len(x))
        return np.column_stack([model(x), x[:, 1]])

    evaluated = design.evaluate(counting, ["a", "b"], chunk_size=100)
    assert sum(sizes) == design.n_evaluations
    assert max(sizes) == 100
    np.testing.assert_array_equal(evaluated.outputs[:, 0], model(design.points))
    np.testing.assert_array_equal(evaluated.outputs, design.attach(design.points, counting(design.points)).outputs)


def test_misaligned_outputs_are_refused():
    design = variance_design(DISTRIBUTION, 64, replicates=2)
    y = model(design.points)
    shuffled = np.roll(design.points, 1, axis=0)
    with pytest.raises(ValueError, match="768 points differ, first at row 0; keep the order"):
        design.attach(shuffled, model(shuffled))
    with pytest.raises(ValueError, match="evaluate every point of this design"):
        design.attach(design.points[1:], y[1:])
    other = variance_design(DISTRIBUTION, 64, replicates=2, seed=1)
    with pytest.raises(ValueError, match="do not belong to this design"):
        design.attach(other.points, model(other.points))
    with pytest.raises(ValueError, match=r"Outputs have shape \(767, 1\) for 768 points"):
        design.attach(design.points, y[1:])
    with pytest.raises(ValueError, match="return a row of outputs a point"):
        design.evaluate(lambda x: model(x)[:-1])
    with pytest.raises(ValueError, match="read-only"):
        design.points[0] = 0.0


def test_outputs_without_indices_are_refused():
    design = variance_design(DISTRIBUTION, 64, replicates=2)
    y = model(design.points)
    with pytest.raises(ValueError, match="output flat does not vary"):
        design.attach(design.points, np.column_stack([y, np.ones_like(y)]), ["a", "flat"])
    with pytest.raises(ValueError, match="3 of 768 points are not finite, first at row 0, inputs"):
        design.attach(design.points, np.where(np.arange(768) < 3, np.nan, y))
    with pytest.raises(ValueError, match="give each a name of its own"):
        design.attach(design.points, np.column_stack([y, y]), ["a", "a"])


@pytest.mark.parametrize(
    ("outputs", "sentence"),
    [
        (lambda n: np.where(np.arange(n) % 2, 0.1 + 0.2, 0.3), "does not vary but for rounding"),
        (lambda n: 1.0 + np.random.default_rng(0).integers(0, 2, n) * 2.2e-16, "does not vary but for rounding"),
        (lambda n: 1e-200 * np.random.default_rng(0).random(n), "too small for its squares"),
        (lambda n: 1e-320 * np.arange(n), "too small for its squares"),
        (lambda n: 1e200 * np.random.default_rng(0).random(n), "too large for its squares"),
    ],
)
def test_rounding_noise_is_no_signal(outputs, sentence):
    """A variance of 4e-33 is that of rounding; squares of 1e-200 are 0."""
    design = variance_design(DISTRIBUTION, 64, replicates=2)
    with pytest.raises(ValueError, match=sentence):
        design.attach(design.points, outputs(design.n_evaluations))


def test_small_outputs_have_indices():
    design = variance_design(DISTRIBUTION, 64, replicates=2)
    y = model(design.points)
    small = design.attach(design.points, 1e-120 * y)
    expected, found = (variance_indices(each).first.value for each in (design.attach(design.points, y), small))
    np.testing.assert_allclose(found, expected, rtol=1e-9)


@pytest.mark.parametrize("digits", ["%.6g", "%.10g", "%.17g"])
def test_points_that_went_through_a_text_file(digits):
    design = variance_design(DISTRIBUTION, 64, replicates=2)
    read = np.array([[float(digits % value) for value in row] for row in design.points])
    assert design.attach(read, model(read)).design is design
    coarse = np.array([[float(f"{value:.4g}") for value in row] for row in design.points])
    with pytest.raises(ValueError, match=r"but for rounding by up to .* more digits"):
        design.attach(coarse, model(coarse))


def test_an_input_with_a_comma_and_a_group_have_keys_of_their_own():
    distribution = Distribution([Uniform(name, 0, 1) for name in ("a", "b", "a,b")])
    evaluated = variance_design(distribution, 64, replicates=2, groups=[("a", "b")]).evaluate(lambda x: x @ [1, 2, 3])
    keys = list(variance_indices(evaluated).to_dict()["outputs"]["y0"]["indices"])
    assert keys == ["a", "b", '"a,b"', "a,b"]


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"n": 8}, "8 rows: give at least 16"),
        ({"n": 100, "replicates": 4}, "100 rows in 4 replicates do not make Sobol sequences"),
        ({"n": 64, "replicates": 1}, "at least 2 replicates"),
        ({"n": 64, "replicates": 0}, "at least 2 replicates"),
        ({"n": 64, "sampling": "lhs"}, "choose 'sobol', 'latin' or 'random'"),
        ({"n": 64, "sampling": "latin", "replicates": 7}, "do not make Latin hypercubes"),
        ({"n": 64, "groups": [["V"]]}, "choose from h, gamma, LL, UL"),
        ({"n": 64, "groups": [["h", "gamma", "LL", "UL"]]}, "some, but not all"),
        ({"n": 64, "groups": [[]]}, "some, but not all"),
    ],
)
def test_bad_input(options, sentence):
    with pytest.raises(ValueError, match=sentence):
        variance_design(DISTRIBUTION, **options)


def test_one_input_has_nothing_to_share():
    with pytest.raises(ValueError, match="at least two inputs"):
        variance_design(Distribution([Uniform("x", 0, 1)]), 64)


def test_bad_chunk_size():
    with pytest.raises(ValueError, match="at least 1 row"):
        variance_design(DISTRIBUTION, 64).evaluate(model, chunk_size=0)
