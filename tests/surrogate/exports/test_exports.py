"""Every export of every kind of model gives what the model's own `predict` gives."""

import ctypes
import json
import math
import re
import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pytest

from fmu_src.slaves.closed_form import ClosedForm
from surrogate import LocalModelNetwork, Network, Variable
from surrogate.exports.c_source import c_header, c_source
from surrogate.exports.closed_form import closed_form
from surrogate.exports.forms import FORMS, export_c, export_form
from surrogate.models.local_models import polynomial_terms
from surrogate.models.partitions import AxisPartition, ObliquePartition, SplitTree
from surrogate.models.safety import Safety

pytestmark = pytest.mark.slow

INPUTS = tuple(Variable(*pair) for pair in (("wing span", "mm"), ("flap */ \\ 50%", "deg"), ('"q"', "-")))
OUTPUTS = tuple(Variable(*pair) for pair in (("lift_N", "N"), ("speed", "kt")))
RANGES = np.array([[1000.0, 9000.0], [-5.0, 5.0], [-1.0, 1.0]])
TARGETS = np.array([[40.0, 140.0], [0.01, 0.03]])


SAFE = Safety(("speed", "lift_N"), ("high", "low"), np.array([0.001, 2.5]), 0.001, 1234)
"""Of both outputs, the second one first."""


def network(*hidden: int, has_std: bool = True, d: int = 3, m: int = 2) -> Network:
    """Layers with random weights, of the first d inputs and m outputs."""
    rng, sizes = np.random.default_rng(len(hidden)), (d, *hidden, m)
    layers = list(zip(sizes[1:], sizes[:-1], strict=True))
    P = sum(size * (before + 1) for size, before in layers)
    return Network(
        weights=tuple(rng.normal(size=shape) for shape in layers),
        biases=tuple(rng.normal(size=size) for size, _ in layers),
        input_ranges=RANGES[:d],
        target_ranges=TARGETS[:m],
        inputs=INPUTS[:d],
        outputs=OUTPUTS[:m],
        beta=50.0 if has_std else None,
        posterior_factor=np.triu(rng.normal(scale=0.05, size=(P, P))) if has_std else None,
    )


def local_models(partition: AxisPartition | ObliquePartition, kind: str) -> LocalModelNetwork:
    """Random polynomials in a partition."""
    terms = polynomial_terms(kind, 3)
    coefficients = np.random.default_rng(6).normal(size=(partition.tree.models, len(terms), 2)) + 3
    return LocalModelNetwork(terms, coefficients, partition, RANGES, TARGETS, INPUTS, OUTPUTS)


def models() -> dict[str, Network | LocalModelNetwork]:
    rng, children = np.random.default_rng(5), np.array([[1, -1], [2, -2], [-3, -4]])
    directions = rng.normal(size=(3, 3))
    tree = SplitTree(directions / np.linalg.norm(directions, axis=1)[:, None], rng.uniform(0.3, 0.7, 3), children)
    axes = AxisPartition(
        SplitTree(np.eye(3), np.full(3, 0.5), children), rng.uniform(0, 1, (4, 3)), np.full((4, 3), 0.3)
    )
    undivided = SplitTree(np.empty((0, 3)), np.empty(0), np.empty((0, 2)))
    return {
        "one hidden layer": replace(network(5), safe=SAFE),
        "three hidden layers": network(5, 4, 3),
        "without deviations": network(4, has_std=False),
        "axes, quadratic": replace(local_models(axes, "quadratic"), safe=SAFE),
        "oblique, sparse": local_models(ObliquePartition(tree, np.array([20.0, 8.0, 30.0])), "sparse_quadratic"),
        "one local model": local_models(ObliquePartition(undivided, np.empty(0)), "linear"),
    }


MODELS = models()
X = np.random.default_rng(1).uniform(*RANGES.T, (40, 3))
OUTSIDE = np.array([[9001.0, 0.0, 0.0], [5000.0, -5.1, 0.0]])


@pytest.fixture(params=MODELS, ids=[name.replace(" ", "_") for name in MODELS])
def model(request) -> Network | LocalModelNetwork:
    return MODELS[request.param]


def export_model(model, form: str) -> bytes:
    return export_form(closed_form(model), form)


def has_std(model) -> bool:
    return getattr(model, "posterior_factor", None) is not None


def std_slopes(model: Network) -> np.ndarray:
    """Slopes of the standard deviation (n, m, d) by central differences."""
    steps = 1e-5 * np.ptp(RANGES, axis=1)
    ends = [[model.predict_std(X + sign * h) for h in np.diag(steps)] for sign in (1, -1)]
    return np.moveaxis((np.array(ends[0]) - ends[1]) / (2 * steps[:, None, None]), 0, 2)


def check_outputs(found, model, x=X) -> None:
    """Equal to 1e-12 of the outputs' range."""
    scale = np.ptp(model.predict(X), axis=0)
    np.testing.assert_allclose(found / scale, model.predict(x) / scale, rtol=1e-12, atol=1e-12)


def check(model, *, predict, std=None, gradient=None, std_gradient=None) -> None:
    """Hold what an export gives at X against the model."""
    check_outputs(predict, model)
    if gradient is not None:
        scale = np.ptp(TARGETS, axis=1)[:, None] / np.ptp(RANGES, axis=1)
        np.testing.assert_allclose(gradient / scale, model.gradient(X) / scale, rtol=1e-12, atol=1e-12)
    if has_std(model):
        np.testing.assert_allclose(std, model.predict_std(X), rtol=1e-12)
        if std_gradient is not None:
            np.testing.assert_allclose(std_gradient, std_slopes(model), rtol=1e-5, atol=1e-8)
    else:
        assert std is None


def safe_values(model) -> np.ndarray:
    """A speed 0.001 lower than the model's, and a lift 2.5 higher (n, 2)."""
    lift, speed = model.predict(X).T
    return np.column_stack([speed - 0.001, lift + 2.5])


def check_safe(found, model) -> None:
    """What an export gives at X: safe values of a calibrated model, nothing (None) of another."""
    assert (found is None) == (model.safe is None)
    if model.safe is not None:
        np.testing.assert_allclose(found, safe_values(model), rtol=1e-12)


def test_safe_values(model):
    if model.safe is None:
        with pytest.raises(ValueError, match="was not calibrated"):
            model.predict_safe(X)
        return
    np.testing.assert_allclose(model.predict_safe(X), safe_values(model), rtol=1e-15)
    form = closed_form(model)
    assert form.safe_outputs == (Variable("speed_safe", "kt"), Variable("lift_N_safe", "N"))
    check_safe(form.safe_program.evaluate(model.predict(X)), model)
    told = export_model(model, "text").decode()
    assert "speed_safe [kt] = output 1 -0.001, not above the true one with a probability of at least 0.999" in told
    assert "lift_N_safe [N] = output 0 +2.5, not below the true one" in told
    assert "over the 1234 rows" in told


def test_one_output():
    """Values and deviations of a network with a single output."""
    model = network(4, 3, m=1)
    form = closed_form(model)
    np.testing.assert_allclose(form.predict.evaluate(X), model.predict(X), rtol=1e-12)
    np.testing.assert_allclose(form.std.evaluate(X), model.predict_std(X), rtol=1e-12)


def test_program(model):
    form = closed_form(model)
    check(model, predict=form.predict.evaluate(X), std=form.std and form.std.evaluate(X))


def test_numpy_source(model):
    namespace: dict = {}
    exec(export_model(model, "numpy").decode(), namespace)
    std = namespace["predict_std"](X) if "predict_std" in namespace else None
    check(model, predict=namespace["predict"](X), std=std)
    check_safe(namespace["safe"](namespace["predict"](X)) if "safe" in namespace else None, model)
    check_outputs(namespace["predict"](X[:6].reshape(2, 3, 3)).reshape(6, 2), model, X[:6])
    assert (namespace["in_range"](X).all(), namespace["in_range"](OUTSIDE).any()) == (True, False)
    assert namespace["INPUTS"] == [tuple(v) for v in INPUTS]


def test_c99(model, tmp_path):
    if shutil.which("cc") is None:
        pytest.skip("there is no C compiler")
    (tmp_path / "wing.h").write_text(c_header(closed_form(model), "wing"))
    (tmp_path / "model.c").write_text('#include "wing.h"\n' + c_source(closed_form(model), "wing"))
    flags = "-std=c99 -Wall -Wextra -Wpedantic -Werror -O0 -shared -fPIC"
    subprocess.run(["cc", *flags.split(), "-o", "model.so", "model.c", "-lm"], cwd=tmp_path, check=True)
    library = ctypes.CDLL(str(tmp_path / "model.so"))

    def call(function: str, *sizes: int) -> list[np.ndarray]:
        found = []
        for x in X:
            arrays = [(ctypes.c_double * size)() for size in sizes]
            getattr(library, f"wing_{function}")((ctypes.c_double * 3)(*x), *arrays)
            found.append([np.array(array) for array in arrays])
        return [np.array(arrays) for arrays in zip(*found, strict=True)]

    (predict,), (value, gradient) = call("predict", 2), call("gradient", 2, 6)
    np.testing.assert_allclose(predict, value, rtol=1e-12)
    safe = np.zeros((len(X), 2)) if hasattr(library, "wing_safe") else None
    for y, moved in zip(predict, () if safe is None else safe, strict=False):
        library.wing_safe((ctypes.c_double * 2)(*y), moved.ctypes.data_as(ctypes.c_void_p))
    check_safe(safe, model)
    if has_std(model):
        (std,), (_, std_gradient) = call("std", 2), call("std_gradient", 2, 6)
        check(
            model,
            predict=predict,
            gradient=gradient.reshape(-1, 2, 3),
            std=std,
            std_gradient=std_gradient.reshape(-1, 2, 3),
        )
    else:
        check(model, predict=predict, gradient=gradient.reshape(-1, 2, 3))
        assert not hasattr(library, "wing_std")

    def in_range(slack: float) -> list[int]:
        points = (*X[:2], *OUTSIDE, [math.nan, 0, 0])
        return [library.wing_in_range((ctypes.c_double * 3)(*x), ctypes.c_double(slack)) for x in points]

    assert (in_range(0), in_range(0.001)) == ([1, 1, 0, 0, 0], [1, 1, 1, 0, 0])


def test_javascript(model, tmp_path):
    if shutil.which("node") is None:
        pytest.skip("node is not installed")
    (tmp_path / "model.mjs").write_bytes(export_model(model, "js"))
    program = """
import * as m from "./model.mjs";
const [X, outside] = JSON.parse(process.argv[2]);
const all = (f) => (f ? X.map(f) : null);
const safe = m.safe ? X.map((x) => m.safe(m.predict(x))) : null;
console.log(JSON.stringify([m.predict, m.gradient, m.std, m.stdGradient].map(all)
    .concat([safe, m.safeOutputs ?? null, X.every(m.inRange), outside.some(m.inRange), m.inputs, m.outputs])));
"""
    (tmp_path / "run.mjs").write_text(program)
    command = ["node", "run.mjs", json.dumps([X.tolist(), OUTSIDE.tolist()])]
    printed = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True).stdout
    predict, gradient, std, std_gradient, safe, named, inside, outside, inputs, outputs = json.loads(printed)
    check_safe(safe, model)
    assert named == (model.safe and [{"name": "speed_safe", "unit": "kt"}, {"name": "lift_N_safe", "unit": "N"}])
    check(model, predict=predict, gradient=np.array(gradient), std=std, std_gradient=std_gradient)
    assert (inside, outside) == (True, False)
    assert [(v["name"], v["unit"], v["least"], v["greatest"]) for v in inputs] == [
        (*v, *ends) for v, ends in zip(INPUTS, RANGES.tolist(), strict=True)
    ]
    assert outputs == [{"name": name, "unit": unit} for name, unit in OUTPUTS]


@pytest.mark.parametrize("form", ["onnx", "onnx32"])
def test_onnx(model, form):
    """In float32 the errors are relative to the range of the outputs."""
    onnxruntime = pytest.importorskip("onnxruntime")
    session = onnxruntime.InferenceSession(export_model(model, form))
    dtype = {"onnx": np.float64, "onnx32": np.float32}[form]
    found = session.run(None, {"inputs": X.astype(dtype)})
    names = [output.name for output in session.get_outputs()]
    assert names == ["outputs", *(["std"] if has_std(model) else []), *(["safe"] if model.safe else [])]
    assert json.loads(session.get_modelmeta().custom_metadata_map["inputs"]) == [list(v) for v in INPUTS]
    if form == "onnx":
        check(model, predict=found[0], std=found[1] if has_std(model) else None)
        check_safe(found[-1] if model.safe else None, model)
        return
    for values, expected in zip(
        found[: 1 + has_std(model)], [model.predict(X), has_std(model) and model.predict_std(X)], strict=False
    ):
        assert np.abs((values - expected) / np.ptp(model.predict(X), axis=0)).max() < 1e-6


def test_sympy(model):
    sympy = pytest.importorskip("sympy")
    from surrogate.exports.symbolic import sympy_expressions

    expressions = sympy_expressions(closed_form(model))
    assert list(expressions) == [name for name, _ in OUTPUTS]
    symbols = [sympy.Symbol(name, real=True) for name, _ in INPUTS]
    function = sympy.lambdify(symbols, list(expressions.values()), "math", cse=True)
    check_outputs([function(*x) for x in X], model)


def evaluated(lines: list[str], names: list[str], x: np.ndarray) -> list[float]:
    """y1 and y2 by running equations as Python."""
    scope = {"tanh": math.tanh, "exp": math.exp, "log1p": math.log1p, "log": math.log, "sqrt": math.sqrt}
    scope |= dict(zip(names, x.tolist(), strict=True))
    exec("\n".join(lines), scope)
    return [scope["y1"], scope["y2"]]


def test_text(model):
    lines = export_model(model, "text").decode().splitlines()
    assert "#     1  flap * / \\ 50% [deg]  -5 .. 5" in lines
    found = [evaluated(lines, ["x1", "x2", "x3"], x) for x in X]
    check_outputs(found, model)


def test_latex(model):
    """Read back by turning each command into Python."""
    written = export_model(model, "latex").decode()
    body = written.split("\\begin{align*}\n")[1].split("\n\\end{align*}")[0]
    for pattern, replacement in (
        (r"v_\{(\d+),(\d+)\}", r"v\1_\2"),
        (r"([xy])_\{(\d+)\}", r"\1\2"),
        (r" \\cdot 10\^\{(-?\d+)\}", r"e\1"),
        (r"e\^\{([^{}]*)\}", r"exp(\1)"),
        (r"\\frac\{([^{}]*)\}\{([^{}]*)\}", r"(\1)/(\2)"),
        (r"\^\{2\}", "**2"),
        (r"\\left\(|\\right\)", lambda match: match[0][-1]),
        (r"\\ln", "log"),
        (r"\\tanh", "tanh"),
        (r" \\, ", "*"),
        (r" &= ", " = "),
        (r" \\\\\n", "\n"),
    ):
        body = re.sub(pattern, replacement, body)
    found = [evaluated(body.splitlines(), ["x1", "x2", "x3"], x) for x in X]
    check_outputs(found, model)
    assert r"flap */ \textbackslash{} 50\% (deg)" in written


def test_json(model):
    """Read by what runs in an FMU's host, without NumPy."""
    document = json.loads(export_model(model, "json"))
    form = ClosedForm(document)
    std = [form.predict_std(x) for x in X.tolist()] if has_std(model) else document["std"]
    check(model, predict=[form.predict(x) for x in X.tolist()], std=std)
    check_safe([form.safe(form.predict(x)) for x in X.tolist()] if "safe" in document else None, model)
    assert [list(pair) for pair in form.ranges] == RANGES.tolist()
    assert [(v["name"], v["unit"]) for v in document["outputs"]] == list(OUTPUTS)
    assert [[v["least"], v["greatest"]] for v in document["inputs"]] == RANGES.tolist()


def test_same_model_gives_the_same_bytes(model):
    for form in FORMS:
        if not form.startswith("onnx") or shutil.which("cc"):
            assert export_model(model, form) == export_model(model, form)


def test_standard_deviations_are_left_out():
    form = closed_form(MODELS["one hidden layer"], has_std=False)
    assert form.std is None
    assert b"std" not in export_form(form, "numpy")


def test_unknown_form():
    with pytest.raises(ValueError, match="'fortran' is no form of an export: choose one of c, js"):
        export_model(MODELS["one hidden layer"], "fortran")


def test_far_outside_stays_finite(tmp_path):
    """The programs do not overflow where the models themselves do not."""
    far = RANGES[:, 0] + np.array([[1e6, -1e6, 1e3]]) * np.ptp(RANGES, axis=1)
    for name in ("one hidden layer", "axes, quadratic", "oblique, sparse"):
        with np.errstate(all="raise", under="ignore"):
            found = closed_form(MODELS[name]).predict.evaluate(far)
        np.testing.assert_allclose(found, MODELS[name].predict(far), rtol=1e-9)


def test_variables_that_single_precision_cannot_tell_apart():
    """Unix time over a day: eps |x| / range is 2.4e-3. A day counted from midnight is kept, and a temperature in K."""
    model = MODELS["without deviations"]
    day = np.array([1.76e9, 1.76e9 + 86400.0])
    for ranges in ({"input_ranges": [day, *RANGES[1:]]}, {"target_ranges": [TARGETS[0], day]}):
        with pytest.raises(
            ValueError, match=r"rounds '(wing span|speed)', 1760000000 .. 1760086400, by up to 2\.4e-03"
        ):
            export_form(closed_form(replace(model, **ranges)), "onnx32")
        assert export_form(closed_form(replace(model, **ranges)), "onnx")
    onnxruntime = pytest.importorskip("onnxruntime")
    kept = replace(model, input_ranges=[[280.0, 320.0], [0.0, 86400.0], RANGES[2]])
    x = np.random.default_rng(2).uniform(*kept.input_ranges.T, (500, 3)).astype(np.float32)
    [found] = onnxruntime.InferenceSession(export_model(kept, "onnx32")).run(None, {"inputs": x})
    assert np.abs((found - kept.predict(x)) / np.ptp(TARGETS, axis=1)).max() < 1e-6


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_c_has_no_warnings(tmp_path, compiler):
    """Comments, trigraphs and backslashes in names stay in their comment; nothing is unused, also with one output."""
    if shutil.which(compiler) is None:
        pytest.skip(f"there is no {compiler}")
    names = ("v??/", "/* b", "*/*/ // \\")
    narrow = [network(*hidden, d=d, m=m) for hidden in ((4,), (4, 3)) for d, m in ((1, 1), (3, 1), (1, 2))]
    for k, model in enumerate([*MODELS.values(), *narrow]):
        named = replace(model, inputs=tuple(Variable(name, "*??/") for name in names[: len(model.inputs)]))
        for name, content in export_c(closed_form(named), f"wing{k}").items():
            (tmp_path / name).write_bytes(content)
    flags = ["-std=c99", "-O1", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-fsyntax-only"]
    sources = sorted(path.name for path in tmp_path.glob("*.[ch]"))
    subprocess.run([compiler, *flags, *sources], cwd=tmp_path, check=True)
    head = (tmp_path / "wing0.c").read_text().split("*/")[0]
    assert head.count("/*") == 1
    assert "??" not in head
