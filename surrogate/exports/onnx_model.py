"""A closed form as an ONNX model. Needs onnx."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from surrogate.exports import steps
from surrogate.exports.closed_form import ClosedForm
from surrogate.exports.program import Program
from surrogate.exports.steps import Step

if TYPE_CHECKING:
    from onnx import ModelProto

OPSET, IR_VERSION = 17, 8
SINGLE_ERROR = 1e-6
"""Error of single precision that is promised, as a share of a variable's range."""
FUNCTIONS = {"tanh": "Tanh", "exp": "Exp", "sqrt": "Sqrt"}


class _Graph:
    """Nodes and constants of a graph under construction."""

    def __init__(self, dtype: Any):
        self.dtype = dtype
        self.nodes: list[Any] = []
        self.constants: dict[tuple, Any] = {}

    def constant(self, values: np.ndarray) -> str:
        from onnx import numpy_helper

        typed = values.astype(self.dtype) if values.dtype.kind == "f" else values.astype(np.int64)
        key = typed.dtype.str, typed.shape, typed.tobytes()
        if key not in self.constants:
            self.constants[key] = numpy_helper.from_array(np.ascontiguousarray(typed), f"c{len(self.constants) + 1}")
        return str(self.constants[key].name)

    def node(self, operator: str, inputs: list[str], output: str | None = None, **attributes: Any) -> str:
        from onnx import helper

        output = output or f"n{len(self.nodes) + 1}"
        self.nodes.append(helper.make_node(operator, inputs, [output], **attributes))
        return output


def onnx_model(form: ClosedForm, dtype: str = "float64") -> ModelProto:
    """A model from `inputs` (n, d) to `outputs` (n, m), to `std` (n, m) where the model has standard deviations, and to
    `safe` (n, s) where it was calibrated.

    Args:
        form: closed form of a model.
        dtype: 'float64', or 'float32' for runtimes without double precision.

    Names, units and the ranges of the inputs are in the model's metadata.

    Raises:
        ValueError: in single precision a variable would be rounded by more than `SINGLE_ERROR` of its range.
    """
    import json

    from onnx import checker, helper

    if dtype not in ("float64", "float32"):
        raise ValueError(f"'{dtype}' is no precision of an ONNX export: choose 'float64' or 'float32'.")
    if dtype == "float32":
        _check_single(form)
    graph = _Graph(np.dtype(dtype))
    kind = helper.np_dtype_to_tensor_dtype(np.dtype(dtype))
    programs = {"outputs": form.predict, "std": form.std, "safe": form.safe_program}
    results = {name: program for name, program in programs.items() if program}
    for name, program in results.items():
        _add(graph, program, name, "outputs" if name == "safe" else "inputs")
    made = helper.make_model(
        helper.make_graph(
            graph.nodes,
            "model",
            [helper.make_tensor_value_info("inputs", kind, ["n", len(form.inputs)])],
            [helper.make_tensor_value_info(name, kind, ["n", made.sizes[-1]]) for name, made in results.items()],
            list(graph.constants.values()),
        ),
        opset_imports=[helper.make_opsetid("", OPSET)],
        ir_version=IR_VERSION,
        producer_name="gtm-fmu",
    )
    about: dict[str, Any] = {"inputs": form.inputs, "outputs": form.outputs}
    about |= {"input_ranges": form.input_ranges.tolist()}
    about |= {"safe_outputs": form.safe_outputs} if form.safe else {}
    helper.set_model_props(made, {name: json.dumps(value) for name, value in about.items()})
    checker.check_model(made, full_check=True)
    return made


def _check_single(form: ClosedForm) -> None:
    eps = np.finfo(np.float32).eps
    ranges = np.concatenate([form.input_ranges, form.output_ranges])
    for variable, (least, greatest) in zip((*form.inputs, *form.outputs), ranges.tolist(), strict=True):
        size = max(abs(least), abs(greatest))
        if eps * size > SINGLE_ERROR * (greatest - least):
            raise ValueError(
                f"Single precision rounds '{variable.name}', {least:.10g} .. {greatest:.10g}, by up to "
                f"{eps * size / (greatest - least):.1e} of its range: take --onnx, or train with '{variable.name}' "
                "counted from a near value."
            )


def _add(graph: _Graph, program: Program, result: str, given: str) -> None:
    values = [given]
    for step in program.steps:
        values.append(_node(graph, step, values, program))
    graph.node("Identity", [values[-1]], result)


def _node(graph: _Graph, step: Step, values: list[str], program: Program) -> str:
    node, constant = graph.node, graph.constant
    match step:
        case steps.Constant(numbers):
            first = node("Gather", ["inputs", constant(np.zeros(1, int))], axis=1)
            zero = node("Sub", [first, first])
            return node("Add", [zero, constant(numbers)])
        case steps.Scale(x, shift, factor, offset):
            scaled = node("Mul", [node("Sub", [values[x], constant(shift)]), constant(factor)])
            return node("Add", [scaled, constant(offset)])
        case steps.Affine(x, W, b):
            return node("Add", [node("MatMul", [values[x], constant(W.T)]), constant(b)])
        case steps.Apply(x, "square"):
            return node("Mul", [values[x], values[x]])
        case steps.Apply(x, "softplus"):  # max(x, 0) + log(1 + e^-|x|): onnxruntime has no Softplus in double precision
            power = node("Exp", [node("Neg", [node("Abs", [values[x]])])])
            return node("Add", [node("Relu", [values[x]]), node("Log", [node("Add", [power, constant(np.ones(1))])])])
        case steps.Apply(x, function):
            return node(FUNCTIONS[function], [values[x]])
        case steps.Take(x, i):
            return node("Gather", [values[x], constant(i)], axis=1)
        case steps.Products(x, y, i, j):
            pair = [node("Gather", [values[v], constant(k)], axis=1) for v, k in ((x, i), (y, j))]
            return node("Mul", pair)
        case steps.GroupSum(x, size):
            shape = constant(np.array([-1, program.sizes[x] // size, size]))
            grouped = node("Reshape", [values[x], shape])
            return node("ReduceSum", [grouped, constant(np.array([2]))], keepdims=0)
        case steps.Softmax(x):
            return node("Softmax", [values[x]], axis=1)
        case steps.Join(parts):
            return node("Concat", [values[x] for x in parts], axis=1)
