"""A closed form as an ES module of JavaScript."""

import json

from surrogate.exports.closed_form import ClosedForm
from surrogate.exports.loops import Body, Language, Tables
from surrogate.exports.program import Program
from surrogate.exports.text import comment_lines

JAVASCRIPT = Language(
    counter="let",
    number="let {name} = {value};",
    array="const {name} = new Float64Array({size});",
    numbers="const {name} = new Float64Array([\n    {values}]);",
    singles="const {name} = new Float32Array([\n    {values}]);",
    indices="const {name} = new Int32Array([\n    {values}]);",
    words={"tanh": "Math.tanh", "exp": "Math.exp", "softplus": "softplus", "sqrt": "Math.sqrt", "max": "Math.max"},
)
SOFTPLUS = "const softplus = (x) => Math.max(x, 0) + Math.log1p(Math.exp(-Math.abs(x)));"


def javascript(form: ClosedForm) -> str:
    """An ES module without dependencies.

    It exports `inputs` and `outputs` (name, unit; inputs with their range), `predict(x)`, `gradient(x)` (a row of
    slopes for each output), `inRange(x)`; for a model with standard deviations `std(x)` and `stdGradient(x)`; for a
    calibrated one `safeOutputs` (name, unit) and `safe(outputs)`, the safe values by what `predict` gives.
    """
    tables = Tables(JAVASCRIPT, "c")
    functions = _functions(form.predict, "predict", "gradient", tables)
    if form.std:
        functions += _functions(form.std, "std", "stdGradient", tables)
    if safe := form.safe_program:
        functions += _function(safe, "safe", tables)
    inputs = [
        {"name": name, "unit": unit, "least": low, "greatest": high}
        for (name, unit), (low, high) in zip(form.inputs, form.input_ranges.tolist(), strict=True)
    ]
    outputs = [{"name": name, "unit": unit} for name, unit in form.outputs]
    safe_outputs = [{"name": name, "unit": unit} for name, unit in form.safe_outputs]
    body = "\n".join(functions)
    head = [f"// {line}".rstrip() for line in comment_lines(form)]
    parts = [
        *head,
        "",
        f"export const inputs = {json.dumps(inputs)};",
        f"export const outputs = {json.dumps(outputs)};",
        *([f"export const safeOutputs = {json.dumps(safe_outputs)};"] if form.safe else []),
        "",
        *tables.lines,
        *([SOFTPLUS] if "softplus(" in body else []),
        "",
        body,
        "export function inRange(x) {",
        "    return inputs.every(({ least, greatest }, i) => least <= x[i] && x[i] <= greatest);",
        "}",
    ]
    return "\n".join(parts) + "\n"


def _functions(program: Program, value: str, gradient: str, tables: Tables) -> list[str]:
    return _function(program, value, tables) + _function(program, gradient, tables, has_slopes=True)


def _function(program: Program, name: str, tables: Tables, has_slopes: bool = False) -> list[str]:
    d, m = program.n_inputs, program.sizes[-1]
    lines = [f"export function {name}(x) {{", f"    const y = new Float64Array({m});"]
    lines += [f"    const dy = new Float64Array({m * d});"] if has_slopes else []
    lines += [f"    {line}" for line in Body(program, tables, has_slopes=has_slopes).lines()]
    rows = f"Array.from({{ length: {m} }}, (_, o) => Array.from(dy.subarray(o * {d}, (o + 1) * {d})))"
    return [*lines, f"    return {rows if has_slopes else 'Array.from(y)'};", "}", ""]
