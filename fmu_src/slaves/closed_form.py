"""A fitted model without NumPy: the steps of its closed form, one sample at a time, in the Python of the host."""

from collections.abc import Callable
from math import exp, log1p, sqrt, tanh
from operator import mul

Vector = list[float]
FUNCTIONS = {
    "tanh": tanh,
    "exp": exp,
    "softplus": lambda x: max(x, 0.0) + log1p(exp(-abs(x))),
    "square": lambda x: x * x,
    "sqrt": sqrt,
}


def prepared(step: dict) -> Callable[[list[Vector]], Vector]:
    """A step of `surrogate.exports.program` as a function of the vectors before it."""
    name, x = step["step"], step.get("x", 0)
    if name == "Constant":
        return lambda vectors: step["values"]
    if name == "Scale":
        numbers = list(zip(step["shift"], step["factor"], step["offset"], strict=True))
        return lambda vectors: [
            (value - shift) * factor + offset
            for value, (shift, factor, offset) in zip(vectors[x], numbers, strict=True)
        ]
    if name == "Affine":
        starts = [next((k for k, weight in enumerate(row) if weight), 0) for row in step["W"]]  # of a triangle
        rows = [(start, row[start:], b) for start, row, b in zip(starts, step["W"], step["b"], strict=True)]
        return lambda vectors: [sum(map(mul, row, vectors[x][start:]), b) for start, row, b in rows]
    if name == "Apply":
        function = FUNCTIONS[step["function"]]
        return lambda vectors: [function(value) for value in vectors[x]]
    if name == "Take":
        return lambda vectors: [vectors[x][i] for i in step["i"]]
    if name == "Products":
        y, pairs = step["y"], list(zip(step["i"], step["j"], strict=True))
        return lambda vectors: [vectors[x][i] * vectors[y][j] for i, j in pairs]
    if name == "GroupSum":
        size = step["size"]
        return lambda vectors: [sum(vectors[x][k : k + size]) for k in range(0, len(vectors[x]), size)]
    if name == "Softmax":
        return lambda vectors: shares(vectors[x])
    return lambda vectors: [value for k in step["parts"] for value in vectors[k]]


def shares(values: Vector) -> Vector:
    """Softmax, with the largest argument taken out so that nothing overflows."""
    powers = [exp(value - max(values)) for value in values]
    return [power / sum(powers) for power in powers]


class ClosedForm:
    """What `surrogate.exports.forms` writes as JSON."""

    def __init__(self, document: dict):
        """Take the content of the file."""
        self.ranges = [(variable["least"], variable["greatest"]) for variable in document["inputs"]]
        self.steps = {
            name: [prepared(step) for step in document.get(name) or ()] for name in ("predict", "std", "safe")
        }

    def _run(self, name: str, inputs: Vector) -> Vector:
        vectors = [inputs]
        for step in self.steps[name]:
            vectors.append(step(vectors))
        return vectors[-1]

    def predict(self, inputs: Vector) -> Vector:
        """Outputs in their units."""
        return self._run("predict", inputs)

    def predict_std(self, inputs: Vector) -> Vector:
        """Standard deviations of the outputs."""
        return self._run("std", inputs)

    def safe(self, outputs: Vector) -> Vector:
        """Safe values by the outputs of `predict`."""
        return self._run("safe", outputs)
