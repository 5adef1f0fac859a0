"""Distributions of TOML and JSON, against the same made in Python; what is refused."""

import json
import textwrap
import tomllib

import numpy as np
import pytest
from scipy import stats

from sensitivity import (
    Distribution,
    Empirical,
    GaussianCopula,
    Marginal,
    Mixture,
    PointMass,
    Simplex,
    Uniform,
    described_distribution,
    description,
    ordered_with_jams,
    read_distribution,
)


def sampled(distribution):
    return distribution.sample(np.random.default_rng(0).random((200, len(distribution.names))))


def test_the_example_of_the_module(tmp_path):
    """Every kind of input, from a file with a table beside it."""
    table = np.random.default_rng(1).random((30, 2))
    np.savetxt(tmp_path / "weather.csv", table, delimiter=",", header="wind,waves", comments="", fmt="%.17g")
    example = textwrap.dedent("\n".join(description.__doc__.splitlines()[2:]))
    example = example.replace('["width", "height"]', '["length", "load"]')
    (tmp_path / "example.toml").write_text(example)
    found, groups = read_distribution(tmp_path / "example.toml")
    load, length = (
        Marginal("load", stats.gumbel_r(loc=800, scale=100)),
        Marginal("length", stats.uniform(1.9, 0.2), "m"),
    )
    expected = Distribution(
        [
            GaussianCopula([length, load], [[1, 0.7], [0.7, 1]]),
            ordered_with_jams(("low", "high"), -30, 30, 0.2),
            Simplex(("sand", "silt", "clay")),
            Mixture((Uniform("valve", 0, 1), PointMass(("valve",), (1.0,))), (0.9, 0.1)),
            Empirical(("wind", "waves"), table),
        ]
    )
    assert groups == (("load", "length"),)
    assert (found.names, found.units) == (expected.names, expected.units)
    np.testing.assert_allclose(sampled(found), sampled(expected), rtol=1e-14)
    (tmp_path / "example.json").write_text(json.dumps(tomllib.loads(example)))
    again, _ = read_distribution(tmp_path / "example.json")
    assert (sampled(again) == sampled(found)).all()


X = {"name": "x", "uniform": [0, 1]}
Y = {"name": "y", "law": "norm"}
BAD = [
    ({}, "list of inputs"),
    ({"inputs": []}, "list of inputs"),
    ({"inputs": [X], "input": 1}, "unknown entry 'input'"),
    ({"inputs": [{"uniform": [0, 1]}]}, "give its name"),
    ({"inputs": [{"name": "x"}]}, "x is described by nothing"),
    ({"inputs": [X | {"law": "norm"}]}, "x is described by uniform and law"),
    ({"inputs": [X | {"low": 1}]}, "unknown entry 'low'"),
    ({"inputs": [{"name": "x", "uniform": [0]}]}, "give two numbers"),
    ({"inputs": [{"name": "x", "uniform": ["0", "1"]}]}, "are no numbers"),
    ({"inputs": [{"name": "x", "uniform": [0, float("inf")]}]}, "give finite bounds"),
    ({"inputs": [{"name": "x", "law": "gauss"}]}, "no law 'gauss'"),
    ({"inputs": [Y | {"parameters": {"mean": 1}}]}, "norm does not take the parameters"),
    ({"inputs": [Y | {"parameters": [0, -1]}]}, "norm does not exist with the parameters"),
    ({"inputs": [{"name": "x", "ordered": [0, 1]}]}, "two names"),
    ({"inputs": [{"names": ["a", "b"], "uniform": [0, 1]}]}, "describes one input"),
    ({"inputs": [{"name": "x", "mixture": 3}]}, "is a list"),
    ({"inputs": [{"name": "x", "mixture": [{"uniform": [0, 1]}, {"at": 1, "weight": 1}]}]}, "Weights of a mixture"),
    ({"inputs": [{"name": "x", "table": "nowhere.csv"}]}, "Cannot read the table"),
    ({"inputs": [X, X]}, "occur more than once"),
    ({"inputs": [X, Y], "groups": ["x"]}, "Groups are lists"),
    ({"inputs": [X, Y], "groups": [["z"]]}, "choose from x, y"),
    ({"inputs": [X, Y], "correlated": [{"names": ["x", "z"], "correlation": 0.5}]}, "which z is not"),
    ({"inputs": [X, Y], "correlated": [{"names": ["x", "y"], "correlation": 1.5}]}, "positive definite"),
    ({"inputs": [X, Y], "correlated": [{"names": ["x", "y"]}]}, "either correlation or rank_correlation"),
    ({"inputs": [X, Y], "correlated": [{"names": ["x", "y"], "correlation": "strong"}]}, "matrix of numbers"),
    ({"inputs": [X, Y], "correlated": {"names": ["x", "y"]}}, "is a list"),
]


@pytest.mark.parametrize(("given", "message"), BAD, ids=[message for _, message in BAD])
def test_what_is_no_distribution_is_refused(given, message):
    with pytest.raises(ValueError, match=message):
        described_distribution(given)


def test_files_that_cannot_be_read_are_refused(tmp_path):
    (tmp_path / "a.toml").write_text("inputs = [")
    (tmp_path / "a.json").write_text("[[inputs]]")
    for name, message in (("a.toml", "no TOML"), ("a.json", "no JSON"), ("b.toml", "Cannot read")):
        with pytest.raises(ValueError, match=message):
            read_distribution(tmp_path / name)
