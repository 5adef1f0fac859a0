"""A trained network without NumPy: the closed form of `surrogate.Network` for one sample, in the Python of the host."""

from math import sqrt, tanh
from operator import mul


def dot(a: list[float], b: list[float]) -> float:
    """Sum of products."""
    return sum(map(mul, a, b))


class ClosedForm:
    """One hidden layer: y_p = LW tanh(IW I_p + b1) + b2 on inputs and outputs mapped to [-1, 1] (paper eqs 43-45)."""

    def __init__(self, network: dict):
        """Take the content of a network file."""
        self.hidden = [[*weights, bias] for weights, bias in zip(network["IW"], network["b1"], strict=True)]
        self.output = [[*weights, bias] for weights, bias in zip(network["LW"], network["b2"], strict=True)]
        self.input_ranges, self.target_ranges = network["input_ranges"], network["target_ranges"]
        self.noise = 0.5 / network["beta"]
        self.factor = [row[i:] for i, row in enumerate(network["posterior_factor"])]  # upper triangular

    def _layers(self, inputs: list[float]) -> tuple[list[float], list[float]]:
        """Scaled inputs and activations of the hidden layer, each with a last 1 for the biases."""
        scaled = [
            2 * (value - least) / (greatest - least) - 1
            for value, (least, greatest) in zip(inputs, self.input_ranges, strict=True)
        ]
        scaled.append(1.0)
        return scaled, [*(tanh(dot(row, scaled)) for row in self.hidden), 1.0]

    def predict(self, inputs: list[float]) -> list[float]:
        """Outputs in their units."""
        _, activations = self._layers(inputs)
        return [
            (dot(row, activations) + 1) * (greatest - least) / 2 + least
            for row, (least, greatest) in zip(self.output, self.target_ranges, strict=True)
        ]

    def predict_std(self, inputs: list[float]) -> list[float]:
        """Standard deviations of the outputs: the noise, and what the uncertain parameters add."""
        scaled, activations = self._layers(inputs)
        deviations = []
        for i, (row, (least, greatest)) in enumerate(zip(self.output, self.target_ranges, strict=True)):
            slopes = [weight * (1 - a * a) for weight, a in zip(row[:-1], activations[:-1], strict=True)]
            gradient = [slope * value for slope in slopes for value in scaled]
            for j in range(len(self.output)):
                gradient += activations if i == j else [0.0] * len(activations)
            spread = [dot(factors, gradient[k:]) for k, factors in enumerate(self.factor)]
            deviations.append(sqrt(self.noise + dot(spread, spread)) * (greatest - least) / 2)
        return deviations

    def in_range(self, inputs: list[float], rounding: float) -> bool:
        """Whether every input lies inside the ranges of the training data, but for a relative rounding."""
        return all(
            least - rounding * (greatest - least) <= value <= greatest + rounding * (greatest - least)
            for value, (least, greatest) in zip(inputs, self.input_ranges, strict=True)
        )
