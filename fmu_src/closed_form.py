"""A trained network without NumPy: the closed form of `surrogate.Network` for one sample, in the Python of the host."""

from collections.abc import Iterable
from math import sqrt, tanh
from operator import mul


def dot(a: Iterable[float], b: Iterable[float]) -> float:
    """Sum of products."""
    return sum(map(mul, a, b))


class ClosedForm:
    """Layers a_l = tanh(W_l a_(l-1) + b_l), the last without tanh, on inputs and outputs mapped to [-1, 1]."""

    def __init__(self, network: dict):
        """Take the content of a network file."""
        layers = zip(network["weights"], network["biases"], strict=True)
        self.layers = [[[*row, bias] for row, bias in zip(*layer, strict=True)] for layer in layers]
        self.input_ranges, self.target_ranges = network["input_ranges"], network["target_ranges"]
        self.noise = 0.5 / network["beta"]
        self.factor = [row[i:] for i, row in enumerate(network["posterior_factor"])]  # upper triangular

    def _activations(self, inputs: list[float]) -> list[list[float]]:
        """Scaled inputs and what each hidden layer gives, each with a last 1 for the biases (paper eqs 43, 44)."""
        a = [
            2 * (x - least) / (greatest - least) - 1
            for x, (least, greatest) in zip(inputs, self.input_ranges, strict=True)
        ]
        activations = [[*a, 1.0]]
        for layer in self.layers[:-1]:
            activations.append([*(tanh(dot(row, activations[-1])) for row in layer), 1.0])
        return activations

    def predict(self, inputs: list[float]) -> list[float]:
        """Outputs in their units (paper eq 45)."""
        a = self._activations(inputs)[-1]
        return [
            (dot(row, a) + 1) * (greatest - least) / 2 + least
            for row, (least, greatest) in zip(self.layers[-1], self.target_ranges, strict=True)
        ]

    def predict_std(self, inputs: list[float]) -> list[float]:
        """Standard deviations of the outputs: the noise, and what the uncertain parameters add."""
        activations = self._activations(inputs)
        deviations = []
        for i, (least, greatest) in enumerate(self.target_ranges):
            gradient = self._parameter_gradient(activations, i)
            spread = [dot(factors, gradient[k:]) for k, factors in enumerate(self.factor)]
            deviations.append(sqrt(self.noise + dot(spread, spread)) * (greatest - least) / 2)
        return deviations

    def _parameter_gradient(self, activations: list[list[float]], output: int) -> list[float]:
        """Slopes of one output on [-1, 1] with respect to all parameters, by backpropagation."""
        delta = [float(i == output) for i in range(len(self.layers[-1]))]
        gradient: list[float] = []
        for a, layer in zip(reversed(activations), reversed(self.layers), strict=True):
            gradient = [d * value for d in delta for value in a] + gradient
            delta = [
                dot(delta, column) * (1 - x * x)
                for column, x in zip(list(zip(*layer, strict=True))[:-1], a[:-1], strict=True)
            ]
        return gradient

    def in_range(self, inputs: list[float], rounding: float) -> bool:
        """Whether every input lies inside the ranges of the training data, but for a relative rounding."""
        return all(
            least - rounding * (greatest - least) <= value <= greatest + rounding * (greatest - least)
            for value, (least, greatest) in zip(inputs, self.input_ranges, strict=True)
        )
