"""Local model networks in closed form: against the equations written out, and differences."""

from dataclasses import replace
from math import exp

import numpy as np
import pytest

from surrogate import LocalModelNetwork, Network, Variable, load_model
from surrogate.models.local_models import polynomial_terms
from surrogate.models.partitions import AxisPartition, ObliquePartition, SplitTree
from tests.surrogate.conftest import INPUTS, OUTPUTS, random_inputs

RANGES = np.array([[0.0, 9000.0], [-5.0, 5.0], [-1.0, 1.0]])
DIRECTIONS = np.array([[1.0, 0.0, 0.0], [0.6, -0.8, 0.0], [0.0, 0.0, 1.0]])
OFFSETS = np.array([0.5, 0.1, 0.25])
CHILDREN = np.array([[-1, 1], [2, -2], [-3, -4]])


def partition(kind: str) -> AxisPartition | ObliquePartition:
    rng, tree = np.random.default_rng(5), SplitTree(DIRECTIONS, OFFSETS, CHILDREN)
    if kind == "axis":
        return AxisPartition(tree, rng.uniform(0, 1, (4, 3)), rng.uniform(0.1, 0.6, (4, 3)))
    return ObliquePartition(tree, np.array([20.0, 8.0, 30.0]))


@pytest.fixture(params=["axis", "oblique"])
def network(request) -> LocalModelNetwork:
    terms = polynomial_terms("quadratic", 3)
    coefficients = np.random.default_rng(6).normal(size=(4, len(terms), 2))
    names = (tuple(Variable(*pair) for pair in pairs) for pairs in (INPUTS, OUTPUTS))
    target_ranges = np.array([[40.0, 140.0], [0.01, 0.03]])
    return LocalModelNetwork(terms, coefficients, partition(request.param), RANGES, target_ranges, *names)


def test_terms_are_those_of_the_paper():
    """Section II-E: 1 + p, 1 + 2 p and all (p + 1)(p + 2) / 2 terms; (p, p) is the constant."""
    assert polynomial_terms("linear", 2).tolist() == [[2, 2], [0, 2], [1, 2]]
    assert polynomial_terms("sparse_quadratic", 2).tolist()[3:] == [[0, 0], [1, 1]]
    assert polynomial_terms("quadratic", 2).tolist()[3:] == [[0, 0], [0, 1], [1, 1]]
    assert [len(polynomial_terms(kind, 4)) for kind in ("linear", "sparse_quadratic", "quadratic")] == [5, 9, 15]
    with pytest.raises(ValueError, match="choose 'linear'"):
        polynomial_terms("cubic", 2)


def test_gaussian_validity_is_the_papers_equation():
    p, z = partition("axis"), [0.3, 0.9, 0.2]
    mu = [
        exp(-0.5 * sum((x - c) ** 2 / s**2 for x, c, s in zip(z, centre, sigma, strict=True)))
        for centre, sigma in zip(p.centres, p.sigmas, strict=True)
    ]
    np.testing.assert_allclose(p.validity(np.array([z]))[0], np.array(mu) / sum(mu), rtol=1e-12)


def test_sigmoid_validity_is_the_product_along_the_tree():
    z = np.array([0.3, 0.9, 0.2])
    psi = 1 / (1 + np.exp(-np.array([20.0, 8.0, 30.0]) * (DIRECTIONS @ z - OFFSETS)))
    expected = [1 - psi[0], psi[0] * psi[1], psi[0] * (1 - psi[1]) * (1 - psi[2]), psi[0] * (1 - psi[1]) * psi[2]]
    np.testing.assert_allclose(partition("oblique").validity(z[None])[0], expected, rtol=1e-12)


@pytest.mark.parametrize("kind", ["axis", "oblique"])
def test_validities_add_up_to_one_far_outside_too(kind):
    z = np.random.default_rng(1).uniform(-1e3, 1e3, (500, 3))
    phi = partition(kind).validity(z)
    np.testing.assert_allclose(phi.sum(axis=1), 1.0, rtol=1e-14)
    assert (phi >= 0).all()


@pytest.mark.parametrize("kind", ["axis", "oblique"])
def test_validity_gradient_agrees_with_central_differences(kind):
    p, z, step = partition(kind), np.random.default_rng(2).uniform(0, 1, (40, 3)), 1e-6
    slopes = p.validity_gradient(z)
    for j, h in enumerate(step * np.eye(3)):
        difference = (p.validity(z + h) - p.validity(z - h)) / (2 * step)
        np.testing.assert_allclose(slopes[..., j], difference, atol=1e-8)


def test_prediction_is_the_weighted_sum_of_polynomials(network):
    x = np.array([6500.0, -1.25, 0.3])
    z_1 = [*((x - RANGES[:, 0]) / np.ptp(RANGES, axis=1)), 1.0]
    expected = np.zeros(2)
    for phi, coefficients in zip(network.validity(x), network.coefficients, strict=True):
        terms = zip(network.terms.tolist(), coefficients, strict=True)
        expected += phi * sum(c * z_1[a] * z_1[b] for (a, b), c in terms)
    np.testing.assert_allclose(network.predict(x), expected, rtol=1e-12)


def test_gradient_agrees_with_central_differences(network):
    X = random_inputs(50, seed=5)
    for i, step in enumerate(1e-5 * np.ptp(RANGES, axis=1)):
        h = step * np.eye(3)[i]
        difference = (network.predict(X + h) - network.predict(X - h)) / (2 * step)
        np.testing.assert_allclose(network.gradient(X)[..., i], difference, rtol=1e-6, atol=1e-8 / step)


def test_a_loaded_network_has_the_same_bits(network, tmp_path):
    path = tmp_path / "network.json"
    network.save(path)
    for loaded in (LocalModelNetwork.load(path), load_model(path)):
        X = random_inputs(30, seed=7)
        assert loaded.predict(X).tobytes() == network.predict(X).tobytes()
        assert loaded.tree() == network.tree()
        loaded.save(tmp_path / "again.json")
        assert (tmp_path / "again.json").read_bytes() == path.read_bytes()
    with pytest.raises(ValueError, match="holds a LocalModelNetwork, but a Network is needed"):
        Network.load(path)


def test_the_tree_reads_in_the_units_of_the_inputs():
    """A split at 0.25 of -5 .. 5 lies at -2.5; 3 + 2 z with z = (x + 5) / 10 is 4 + 0.2 x."""
    tree = SplitTree(np.array([[0.0, 1.0]]), np.array([0.25]), np.array([[-1, -2]]))
    inputs, outputs = (Variable("height", "m"), Variable("angle", "deg")), (Variable("speed", "m/s"),)
    terms = polynomial_terms("linear", 2)
    coefficients = np.array([[3.0, 0.0, 2.0], [1.0, 90.0, -1.0]])[..., None]
    partition = ObliquePartition(tree, np.array([20.0]))
    ranges = RANGES[:2]
    network = LocalModelNetwork(terms, coefficients, partition, ranges, np.array([[0.0, 1.0]]), inputs, outputs)
    assert network.tree().splitlines() == [
        "if angle < -2.5:",
        "    model 1: speed = 4 + 0 height + 0.2 angle",
        "else:",
        "    model 2: speed = 0.5 + 0.01 height - 0.1 angle",
    ]


def test_the_trees_equations_are_the_local_models(network):
    """With the equations evaluated as text, at a place where one model is alone valid."""
    sharp = replace(network, partition=ObliquePartition(network.partition.tree, np.full(3, 1e6)))
    x = np.array([2000.0, 1.0, -0.5])
    line = next(line for line in sharp.tree().splitlines() if "model 1: speed" in line)
    total = 0.0
    for part in line.split("=")[1].replace(" - ", " + -").split(" + "):
        value, *names = part.split()
        factor = float(value)
        for name in names:
            base, _, power = name.partition("^")
            factor *= x[["height", "angle", "width"].index(base)] ** int(power or 1)
        total += factor
    assert total == pytest.approx(sharp.predict(x)[0], rel=1e-2)


@pytest.mark.parametrize(
    ("children", "message"),
    [([[-1, 1], [2, -2], [-3, -3]], "each local model once"), ([[-1, 2], [-2, -3], [1, -4]], "before the split")],
)
def test_a_tree_that_is_none_is_refused(children, message):
    with pytest.raises(ValueError, match=message):
        SplitTree(DIRECTIONS, OFFSETS, np.array(children))


def test_a_network_that_does_not_fit_together_is_refused(network):
    with pytest.raises(ValueError, match=r"coefficients .* shape \(4, 10, 2\)"):
        replace(network, coefficients=np.zeros((4, 9, 2)))
    with pytest.raises(ValueError, match="pairs of numbers from 0 to 3"):
        replace(network, terms=np.array([[4, 0]]))


def test_no_output_is_not_a_number(network):
    """Gaussians so far away are all 0, and their shares 0 / 0; the squares of a quadratic model overflow."""
    with pytest.raises(ValueError, match="so far from the training data that the outputs are no numbers"):
        network.predict([1e200, 0.0, 0.0])
