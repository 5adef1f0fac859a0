"""A closed form as one self-contained C99 file."""

import numpy as np

from surrogate.exports.closed_form import ClosedForm
from surrogate.exports.loops import Body, Language, Tables
from surrogate.exports.program import Program
from surrogate.exports.text import WRITTEN_BY, comment_lines

C99 = Language(
    counter="int",
    number="double {name} = {value};",
    array="double {name}[{size}];",
    numbers="static const double {name}[{size}] = {{\n    {values}}};",
    singles="static const float {name}[{size}] = {{\n    {values}}};",
    indices="static const int {name}[{size}] = {{\n    {values}}};",
    words={"tanh": "TANSIG", "exp": "exp", "softplus": "SOFTPLUS", "sqrt": "sqrt", "max": "fmax"},
)
HEADER_MARK = f"/* {WRITTEN_BY} */"
"""First line of every header."""
TANSIG = """/* tanh, which this form computes faster than most libraries; it cannot overflow. */
static double {prefix}tansig(double x)
{{
    const double t = exp(-2 * fabs(x));
    return copysign((1 - t) / (1 + t), x);
}}
"""
SOFTPLUS = """/* log(1 + exp(x)) */
static double {prefix}softplus(double x) {{ return fmax(x, 0) + log1p(exp(-fabs(x))); }}
"""


def c_header(form: ClosedForm, name: str = "model") -> str:
    """The header of `c_source` with the same arguments."""
    d, m = len(form.inputs), len(form.outputs)
    guard = f"{name.upper()}_H"
    lines = [
        HEADER_MARK,
        f"#ifndef {guard}",
        f"#define {guard}",
        "",
        f"enum {{ {name}_inputs = {d}, {name}_outputs = {m} }};",
        f"#define {name}_has_std {int(form.std is not None)}",
        f"#define {name}_has_safe {int(form.safe is not None)}",
        *_safe_constants(form, name),
        "",
        *_prototypes(form, name),
        "",
        "#endif",
    ]
    return "\n".join(lines) + "\n"


def c_source(form: ClosedForm, name: str = "model") -> str:
    """C99 that needs the standard library's mathematics only.

    Args:
        form: closed form of a model.
        name: an identifier of C, with which all public names begin.

    The file defines `{name}_predict`, `{name}_gradient` and `{name}_in_range`, and for a model with standard deviations
    `{name}_std` and `{name}_std_gradient`, for a calibrated one `{name}_safe`; its head says what they do.
    """
    d = len(form.inputs)
    tables = Tables(C99, f"{name}_c")
    functions = _functions(form.predict, name, "predict", "gradient", tables)
    if form.std:
        functions += _functions(form.std, name, "std", "std_gradient", tables)
    least, greatest = (tables.name(ends) for ends in np.ascontiguousarray(form.input_ranges.T))
    if safe := form.safe_program:
        functions += _function(safe, f"{name}_safe", tables)
    functions += [
        f"int {name}_in_range(const double x[{d}], double slack)",
        "{",
        f"    for (int i = 0; i < {d}; i++) {{",
        f"        const double more = slack * ({greatest}[i] - {least}[i]);",
        f"        if (!({least}[i] - more <= x[i] && x[i] <= {greatest}[i] + more)) return 0;",
        "    }",
        "    return 1;",
        "}",
    ]
    body = "\n".join(functions)
    helpers = []
    for word, definition in (("TANSIG", TANSIG), ("SOFTPLUS", SOFTPLUS)):
        if word in body:
            body = body.replace(word, f"{name}_{word.lower()}")
            helpers.append(definition.format(prefix=f"{name}_"))
    head = "/*\n" + "\n".join(f"   {line}".rstrip() for line in comment_lines(form)) + "\n*/"
    parts = [head, "#include <math.h>\n", *_prototypes(form, name), "", *tables.lines, "", *helpers, body]
    return "\n".join(parts) + "\n"


def _safe_constants(form: ClosedForm, name: str) -> list[str]:
    """Number of the safe values, and of the output that each is of."""
    if form.safe is None:
        return []
    return [
        f"enum {{ {name}_safe_outputs = {len(form.safe_outputs)} }};",
        f"#define {name}_safe_places {{ {', '.join(map(str, form.safe_places))} }}",
    ]


def _prototypes(form: ClosedForm, name: str) -> list[str]:
    d, m = len(form.inputs), len(form.outputs)
    lines = [
        f"/* Outputs y[{m}] at the inputs x[{d}]. */",
        f"void {name}_predict(const double x[{d}], double y[{m}]);",
        f"/* The same, and the slopes dy[{m * d}]: d y[o] / d x[i] is dy[o * {d} + i]. */",
        f"void {name}_gradient(const double x[{d}], double y[{m}], double dy[{m * d}]);",
        "/* Whether all inputs lie inside the ranges of the training data, widened by a share or 0. */",
        f"int {name}_in_range(const double x[{d}], double slack);",
    ]
    if form.std:
        lines += [
            f"/* Standard deviations y[{m}] of the outputs, and their slopes. */",
            f"void {name}_std(const double x[{d}], double y[{m}]);",
            f"void {name}_std_gradient(const double x[{d}], double y[{m}], double dy[{m * d}]);",
        ]
    if form.safe:
        s = len(form.safe_outputs)
        lines += [
            f"/* Safe values y[{s}], each of an output at its place, by the outputs x[{m}] of {name}_predict. */",
            f"void {name}_safe(const double x[{m}], double y[{s}]);",
        ]
    return lines


def _functions(program: Program, name: str, value: str, gradient: str, tables: Tables) -> list[str]:
    """The function of the values, and that of values and slopes."""
    lines = [_function(program, f"{name}_{function}", tables, function == gradient) for function in (value, gradient)]
    return [line for function in lines for line in function]


def _function(program: Program, name: str, tables: Tables, has_slopes: bool = False) -> list[str]:
    """The function of the values, with slopes if asked."""
    d, m = program.n_inputs, program.sizes[-1]
    more = f", double dy[{m * d}]" if has_slopes else ""
    body = Body(program, tables, has_slopes=has_slopes)
    lines = [f"void {name}(const double x[{d}], double y[{m}]{more})", "{"]
    return [*lines, *(f"    {line}" for line in body.lines()), "}", ""]
