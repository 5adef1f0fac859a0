"""`gtm-fmu sensitivity` on models and tables whose indices are known in closed form, on an FMU and on the aircraft."""

import json
import os
import signal
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

import sensitivity
from fmu_src.fmus import build_fmu
from gtm_fmu.datasets.off_lattice import load
from gtm_study.commands import evaluated_model, sensitivity_models
from sensitivity import test_functions as functions
from surrogate import LolimotRegressor, load_model
from surrogate.rudder.surrogates import load_surrogate
from tests.gtm_study.commands.test_cli_refusals import assert_sentence

pytestmark = pytest.mark.slow

CORRELATED = """
groups = [["a", "b"]]
[[inputs]]
name = "a"
law = "norm"
parameters = [0, 1]
[[inputs]]
name = "b"
law = "norm"
parameters = {loc = 0, scale = 2}
[[inputs]]
name = "c"
law = "norm"
[[correlated]]
names = ["a", "b"]
correlation = 0.5
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """3 a + b + c as a model's file, a + a b of two inputs on [-1, 1] as another, and runs of Ishigami's function."""
    place = tmp_path_factory.mktemp("models")
    rng = np.random.default_rng(0)
    X = pd.DataFrame(rng.uniform(-1, 1, (60, 3)), columns=["a", "b", "c"])
    X.iloc[:2] = [[-1, -1, -1], [1, 1, 1]]  # so that the ranges are whole
    one = {"max_models": 1, "criterion": "size"}
    linear = LolimotRegressor("linear", **one).fit(X, pd.Series(3 * X.a + X.b + X.c, name="y"))
    product = LolimotRegressor("quadratic", **one).fit(X[["a", "b"]], pd.Series(X.a + X.a * X.b, name="y"))
    linear.network_.save(place / "linear.json")
    product.network_.save(place / "product.json")
    x = functions.ISHIGAMI.distribution.sample(rng.random((8000, 3)))
    pd.DataFrame(x, columns=["x1", "x2", "x3"]).assign(y=functions.ISHIGAMI(x)).to_csv(place / "runs.csv", index=False)
    (place / "correlated.toml").write_text(CORRELATED)
    return place


def values(found, kind, output="y"):
    indices = found["result"]["outputs"][output].get("indices", found["result"]["outputs"][output])
    return {name: (row.get(kind) or row)["value"] for name, row in indices.items()}


def test_correlated_normal_inputs_by_a_file(ask, folder):
    """f = w'x: S_i = (C w)_i^2 / C_ii / V and ST_i = w_i^2 / (C^-1)_ii / V."""
    options = f"--distribution {folder}/correlated.toml --samples 8192"
    found = ask(f"sensitivity --model {folder}/linear.json {options} --json").json
    w, C = np.array([3.0, 1.0, 1.0]), np.array([[1.0, 1.0, 0.0], [1.0, 4.0, 0.0], [0.0, 0.0, 1.0]])
    V = w @ C @ w
    first, total = values(found, "first"), values(found, "total")
    for i, name in enumerate("abc"):
        assert first[name] == pytest.approx((C @ w)[i] ** 2 / C[i, i] / V, abs=0.01)
        assert total[name] == pytest.approx(w[i] ** 2 / np.linalg.inv(C)[i, i] / V, abs=0.01)
    assert first["a,b"] == pytest.approx(1 - 1 / V, abs=0.01)


def test_shares_that_all_depend_on_each_other(ask, folder):
    """3 a + b + c = 1 + 2 a on the simplex: a alone tells all, and follows from the others."""
    (folder / "shares.json").write_text(json.dumps({"inputs": [{"names": ["a", "b", "c"], "simplex": 1}]}))
    found = ask(f"sensitivity --model {folder}/linear.json --distribution {folder}/shares.json --json").json
    assert values(found, "first")["a"] == pytest.approx(1.0, abs=0.01)
    assert [*values(found, "total").values()] == pytest.approx([0.0, 0.0, 0.0], abs=1e-6)


def test_outputs_of_an_unfinished_run_are_those_of_its_outputs_and_points(tmp_path):
    def model(output, identity="a"):
        return evaluated_model.Model("m", ("x",), (output,), lambda x: x + (output == "b"), identity)

    x = np.arange(3.0)[:, np.newaxis]
    for one, expected in ((model("a"), x), (model("b"), x + 1), (model("b", "other"), x + 1)):
        assert (evaluated_model.kept_on_disk(one, tmp_path).evaluate(x) == expected).all()
        assert (evaluated_model.kept_on_disk(one, tmp_path).evaluate(x + 5) == expected + 5).all()
    assert len(os.listdir(tmp_path)) == 6


def test_interactions_over_the_ranges_of_the_training(ask, folder):
    """a + a b on [-1, 1]: variances 1/3 and 1/9, so shares 3/4 and 1/4."""
    found = ask(f"sensitivity --model {folder}/product.json --method interactions --json").json
    shares = values(found, "shares")
    assert [shares[name] for name in ("a", "b", "a,b")] == pytest.approx([0.75, 0.0, 0.25], abs=0.01)


def test_indices_of_a_table_of_runs(ask, folder):
    command = f"sensitivity --data {folder}/runs.csv --columns x1,x2,x3 --outputs y --json"
    first = values(ask(f"{command} --method given-data").json, "first")
    assert [*first.values()] == pytest.approx(functions.ISHIGAMI.first, abs=0.02)
    pawn = ask(f"{command} --method pawn").json
    assert pawn["rows"] == 8000


@pytest.mark.parametrize("method", ["variance", "shapley", "full-independent", "effects", "given-data", "pawn"])
def test_the_result_is_that_of_the_python_interface(ask, folder, method):
    options = "--input a=uniform:-1,1 --input b=norm:0,1" if method != "effects" else "--input a=uniform:-1,1"
    options += " --input b=uniform:0,1" if method == "effects" else ""
    found = ask(f"sensitivity --model {folder}/product.json {options} --method {method} --samples 512 --json").json
    model = load_model(folder / "product.json")
    described = [{"name": "a", "uniform": [-1, 1]}, {"name": "b", "law": "norm", "parameters": [0, 1]}]
    if method == "effects":
        described[1] = {"name": "b", "uniform": [0, 1]}
    law, _ = sensitivity.described_distribution({"inputs": described})
    u = np.random.default_rng(0).random((512, 2))
    names = {"input_names": ("a", "b"), "output_names": ["y"]}
    expected = {
        "variance": lambda: sensitivity.variance_indices(
            sensitivity.variance_design(law, 512).evaluate(model.predict, ["y"])
        ),
        "shapley": lambda: sensitivity.shapley_design(law, 512).evaluate(model.predict, ["y"]),
        "full-independent": lambda: sensitivity.full_independent_indices(law, model.predict, 512, output_names=["y"]),
        "effects": lambda: sensitivity.effects_design(law, 512).evaluate(model.predict, ["y"]),
        "given-data": lambda: sensitivity.given_data_indices(law.sample(u), model.predict(law.sample(u)), **names),
        "pawn": lambda: sensitivity.pawn_indices(law.sample(u), model.predict(law.sample(u)), **names),
    }[method]()
    assert found["result"] == json.loads(expected.to_json())


def test_an_fmu_has_the_indices_of_its_model(ask, folder):
    """By the names of its variables, at its start and after a simulation of a second."""
    ask(f"export {folder}/product.json --fmu --output {folder}/product.fmu")
    options = "--input a=uniform:-1,1 --input b=uniform:-1,1 --samples 64 --json"
    expected = values(ask(f"sensitivity --model {folder}/product.json {options}").json, "first")
    at_start = ask(f"sensitivity --model {folder}/product.fmu --outputs y {options}").json
    assert values(at_start, "first") == pytest.approx(expected, abs=1e-9)
    at_end = ask(f"sensitivity --model {folder}/product.fmu --outputs y {options} --stop-time-s 1 --step-s 0.5").json
    assert values(at_end, "first") == pytest.approx(expected, abs=1e-9)
    ask(f"export {folder}/product.json --fmu3 --output {folder}/product3.fmu")
    newer = f"sensitivity --model {folder}/product3.fmu --outputs y {options}"
    assert_sentence(ask(newer), "has to be simulated: give --stop-time-s")
    found = ask(f"{newer} --stop-time-s 0.1 --step-s 0.1").json
    assert values(found, "first") == pytest.approx(expected, abs=1e-9)


def test_an_fmu_says_which_cases_are_feasible(ask, tmp_path):
    """The surrogate's: as many as the thrust map that it carries finds in the same cases."""
    path = build_fmu("surrogate", tmp_path)
    fmu = {"altitude": (0, 9144), "gamma": (0, 0.1), "rudder.lower": (0.3, 0.4), "rudder.upper": (0.4, 0.5)}
    options = " ".join(f"--input {name}=uniform:{low},{high}" for name, (low, high) in fmu.items())
    command = f"sensitivity --model {path} {options} --outputs v_max --samples 64 --seed 1 --method given-data"
    assert_sentence(ask(command), "GtmSurrogate.fmu' has no outputs at altitude = .*choose --infeasible")
    found = ask(f"{command} --infeasible output --output {tmp_path}/result.json --json").json
    u = np.random.default_rng(1).random((64, 4))
    low, high = np.array([*fmu.values()]).T
    cases = (low + u * (high - low)) / [0.3048, *[np.pi / 180] * 3]
    feasible = load_surrogate().predict(cases).feasible
    assert 0 < feasible.sum() < 64
    expected = sensitivity.given_data_indices(u, feasible.astype(float))
    assert [*values(found, "first", "has_value").values()] == pytest.approx(expected.first.value[:, 0], abs=1e-9)


def test_samples_are_doubled_until_intervals_are_narrow(ask, folder):
    found = ask(f"sensitivity --model {folder}/product.json --until 0.02 --samples 256 --json").json
    for row in found["result"]["outputs"]["y"]["indices"].values():
        for kind in ("first", "total"):
            assert row[kind]["upper"] - row[kind]["lower"] <= 0.04
    assert found["result"]["n_evaluations"] > 4 * 256


def test_the_aircraft_by_default(ask, tmp_path):
    """Given an envelope: exact indices 0.821 and 0.080 of altitude, as sampled by the thrust map elsewhere."""
    output, plot = tmp_path / "indices.json", tmp_path / "indices.png"
    answer = ask(f"sensitivity --samples 1024 --output {output} --plot {plot}")
    assert "share with values: 0.95" in answer.out
    found = json.loads(output.read_text())
    assert values(found, "first", "v_min_kt")["altitude_ft"] == pytest.approx(0.821, abs=0.04)
    assert values(found, "first", "v_max_kt")["altitude_ft"] == pytest.approx(0.080, abs=0.06)
    assert plot.read_bytes().startswith(b"\x89PNG")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["indices.json", "indices.png"]


def test_whether_there_is_an_envelope_is_an_output_of_its_own(ask):
    found = ask("sensitivity --infeasible output --samples 512 --json").json
    (output,) = found["result"]["outputs"].values()
    assert 0.93 < output["mean"] < 0.97  # 95.1 % of the triangle have one


def test_the_exact_model_gives_the_exact_test_set():
    """And takes the columns of a data set by their labels."""
    truth = load()
    cases = truth.X[:3]
    names = ("altitude_ft", "gamma_deg", "rudder_lower_deg", "rudder_upper_deg")
    with sensitivity_models.opened("exact", names[::-1], ("v_max_kt",), None) as model:
        found = model.evaluate(cases[:, ::-1])
    np.testing.assert_allclose(found[:, 0], truth.speeds_kt[:3, 1], atol=0.01)


KILLED = """
import os, signal, sys
from dataclasses import replace
from gtm_study.commands import sensitivity_models as models
from gtm_study.commands.cli import main
real, left = models._of_file, [3]
def dying(name):
    model = real(name)
    def values(points):
        if not left[0]:
            os.kill(os.getpid(), signal.SIGKILL)
        left[0] -= 1
        return model.values(points)
    return replace(model, values=values, block=64)
models._of_file = dying
sys.argv[1:] = sys.argv[1:]
main()
"""


def test_a_killed_run_goes_on(ask, folder, tmp_path, monkeypatch):
    output = tmp_path / "result.json"
    command = f"sensitivity --model {folder}/product.json --samples 128 --output {output}"
    run = subprocess.run([sys.executable, "-c", KILLED, *command.split()], capture_output=True)
    assert run.returncode == -signal.SIGKILL
    assert not output.exists()
    kept = tmp_path / "result.json.unfinished"
    assert len(os.listdir(kept)) == 3
    (kept / os.listdir(kept)[0]).write_bytes(b"damaged")
    asked = []
    real = sensitivity_models._of_file

    def counted(name):
        model = real(name)
        return replace(model, values=lambda points: [asked.append(len(points)), model.values(points)][1], block=64)

    monkeypatch.setattr(sensitivity_models, "_of_file", counted)
    ask(command)
    resumed = json.loads(output.read_text())
    assert sum(asked) == resumed["result"]["n_evaluations"] - 2 * 64
    assert not kept.exists()
    ask(command)
    assert json.loads(output.read_text()) == resumed


BAD = [
    ("--model nowhere.json", "give thrust-map, exact, network, a model's file or an FMU"),
    ("--model nowhere.fmu --input a=uniform:0,1", "There is no FMU"),
    ("--model {0}/linear.json --input a=uniform:0,1", "distribution is of a, but 'linear.json' takes a, b, c"),
    ("--model {0}/linear.json --altitude-ft 0 1000", "Ranges of the rudder are not for"),
    ("--distribution {0}/nothing.toml", "Cannot read the distribution"),
    ("--distribution {0}/linear.json", "needs a list of inputs"),
    ("--distribution {0}/correlated.toml --gamma-deg 0 1", "described twice"),
    ("--input a=uniform:1,0", r"Bounds of a are \[1, 0\]"),
    ("--input a=uniform", "give NAME=LAW:NUMBERS"),
    ("--input a=nolaw:1", "scipy.stats has no law 'nolaw'"),
    ("--input a=norm:0,-1", "norm does not"),
    ("--model {0}/linear.json --outputs z", "no output 'z': choose from y"),
    ("--model {0}/linear.json --stop-time-s 1", "--stop-time-s is for an FMU"),
    ("--samples 0", "--samples was given as 0"),
    ("--samples 1000", "do not make Sobol sequences"),
    ("--samples 64 --replications 0", "--replications was given as 0"),
    ("--confidence 1", "--confidence was given as 1"),
    ("--method shapley --until 0.1", "--until is for the method variance"),
    ("--method pawn --order 99", "--order is for the method interactions"),
    ("--method effects --group altitude_ft", "--group is for the method variance"),
    ("--method interactions", "depend on each other"),
    ("--group altitude_ft,nothing", "choose from altitude_ft"),
    ("--jam-share 2", "share of jams is 2"),
    ("--infeasible maybe", "maybe"),
    ("--output a.txt", "ends in .json or .csv"),
    ("--plot a.html", "ends in .png"),
    ("--data {0}/runs.csv --columns x1,x2 --outputs y", "A table has no design"),
    ("--data {0}/runs.csv --columns x1 --method pawn", "by --data, --columns and --outputs"),
    ("--data {0}/runs.csv --columns x9 --outputs y --method pawn", "no column 'x9'"),
    ("--columns x1", "--columns are of a table of runs"),
    ("--data {0}/runs.csv --columns x1 --outputs y --method pawn --output {0}/runs.csv", "is read by this command"),
]


@pytest.mark.parametrize(("options", "pattern"), BAD, ids=[options for options, _ in BAD])
def test_mistakes_are_one_sentence(ask, folder, options, pattern):
    assert_sentence(ask(f"sensitivity {options.format(folder)}"), pattern)
