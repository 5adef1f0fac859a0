"""A closed form as the source of NumPy functions."""

from __future__ import annotations

import numpy as np

from surrogate.exports import steps
from surrogate.exports.closed_form import ClosedForm
from surrogate.exports.loops import Language, Tables
from surrogate.exports.program import Program
from surrogate.exports.steps import Step
from surrogate.exports.text import comment_lines

PYTHON = Language(
    counter="",
    number="",
    array="",
    numbers="{name} = np.array([\n    {values},\n])",
    singles="{name} = np.array([\n    {values},\n], np.float32)",
    indices="{name} = np.array([\n    {values},\n])",
    words={},
)


def numpy_source(form: ClosedForm) -> str:
    """A Python module that needs NumPy only.

    It defines INPUTS, OUTPUTS, INPUT_RANGES, `predict(X)`, `in_range(X)`, and for a model with standard deviations
    `predict_std(X)`; X holds the inputs on its last axis. For a calibrated model SAFE_OUTPUTS and `safe(Y)`, the safe
    values by the outputs Y of `predict`.
    """
    tables = Tables(PYTHON, "_C")
    functions = _function(form.predict, "predict", "Outputs (..., m) at the inputs X (..., d).", tables)
    if form.std:
        functions += _function(form.std, "predict_std", "Standard deviations (..., m) of the outputs.", tables)
    if safe := form.safe_program:
        functions += _function(safe, "safe", "Safe values (..., s) by the outputs X (..., m) of `predict`.", tables)
    parts = [
        '"""' + "\n".join(comment_lines(form)).replace("\\", "\\\\").replace('"', "'") + '\n"""',
        "",
        "import numpy as np",
        "",
        f"INPUTS = {[tuple(v) for v in form.inputs]!r}",
        f"OUTPUTS = {[tuple(v) for v in form.outputs]!r}",
        *([f"SAFE_OUTPUTS = {[tuple(v) for v in form.safe_outputs]!r}"] if form.safe else []),
        f"INPUT_RANGES = np.array({form.input_ranges.tolist()!r})",
        *tables.lines,
        "",
        *functions,
        "",
        "def in_range(X):",
        '    """Whether all inputs (..., d) lie inside the ranges of the training data (...,)."""',
        "    X = np.asarray(X, dtype=float)",
        "    return ((INPUT_RANGES[:, 0] <= X) & (X <= INPUT_RANGES[:, 1])).all(axis=-1)",
    ]
    return "\n".join(parts) + "\n"


def _function(program: Program, name: str, text: str, tables: Tables) -> list[str]:
    lines = ["", f"def {name}(X):", f'    """{text}"""', "    v0 = np.asarray(X, dtype=float)"]
    lines += [f"    v{k} = {_expression(step, program, tables)}" for k, step in enumerate(program.steps, start=1)]
    return [*lines, f"    return v{len(program.steps)}", ""]


def _expression(step: Step, program: Program, tables: Tables) -> str:
    table = tables.name
    match step:
        case steps.Constant(values):
            return f"np.broadcast_to({table(values)}, (*v0.shape[:-1], {len(values)}))"
        case steps.Scale(x, shift, factor, offset):
            return f"(v{x} - {table(shift)}) * {table(factor)} + {table(offset)}"
        case steps.Affine(x, W, b):
            return f"v{x} @ {table(np.ascontiguousarray(W.T))}.reshape({W.shape[1]}, {W.shape[0]}) + {table(b)}"
        case steps.Apply(x, "softplus"):
            return f"np.logaddexp(0.0, v{x})"
        case steps.Apply(x, function):
            return f"np.{function}(v{x})"
        case steps.Take(x, i):
            return f"v{x}[..., {table(i)}]"
        case steps.Products(x, y, i, j):
            return f"v{x}[..., {table(i)}] * v{y}[..., {table(j)}]"
        case steps.GroupSum(x, size):
            return f"v{x}.reshape(*v{x}.shape[:-1], {program.sizes[x] // size}, {size}).sum(axis=-1)"
        case steps.Softmax(x):
            shares = f"np.exp(v{x} - v{x}.max(axis=-1, keepdims=True))"
            return f"(lambda shares: shares / shares.sum(axis=-1, keepdims=True))({shares})"
        case steps.Join(parts):
            return f"np.concatenate([{', '.join(f'v{x}' for x in parts)}], axis=-1)"
