"""A trained network in closed form: values, slopes and standard deviations (paper eqs. 41-46).

NumPy alone serves; values come from compiled C where the package was built.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property, partial
from itertools import pairwise
from math import prod
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from surrogate.core import PackedNetwork, library
from surrogate.models.evaluation import Variable, check_names, evaluate_by_blocks, frozen_array, frozen_ranges, in_range
from surrogate.models.safety import Safety, safe_values
from surrogate.models.storage import StoredModel
from surrogate.scaling import Array, from_symmetric, to_symmetric

COMPILED_BLOCK = 2**24
"""Samples that are handed to C at once; it cuts them up itself."""


@dataclass(frozen=True, eq=False)
class Network(StoredModel):
    """Layers of tansig neurons, from d inputs to m linear outputs (paper eqs. 12, 13, with one hidden layer).

    With I_p and y_p the inputs and outputs mapped from their ranges to [-1, 1] (eq. 43), a_0 = I_p, and L layers:
    a_l = tanh(W_l a_(l-1) + b_l) for l < L, and y_p = W_L a_(L-1) + b_L (eqs. 44, 45; tansig is tanh).
    """

    weights: tuple[Array, ...]
    """W_1 (S_1, d), W_2 (S_2, S_1), ... W_L (m, S_(L-1)); with one hidden layer the paper's IW and LW."""
    biases: tuple[Array, ...]
    """b_1 (S_1,), b_2 (S_2,), ... b_L (m,)."""
    input_ranges: Array
    """Least and greatest value of each input in the training data (d, 2), in the input's unit."""
    target_ranges: Array
    """The same of each target (m, 2)."""
    inputs: tuple[Variable, ...]
    outputs: tuple[Variable, ...]
    beta: float | None = None
    """Evidence parameter of the errors on [-1, 1]: their variance is 1 / (2 beta). None: not estimated."""
    posterior_factor: Array | None = None
    """Upper triangular K (P, P): K'K is the posterior covariance of the parameters, as in `parameter_gradient`."""
    log_std: Network | None = None
    """A network over the same inputs: logarithms of the outputs' standard deviations, in the place of the posterior."""
    metrics: dict[str, float] = field(default_factory=dict)
    provenance: dict[str, Any] = field(default_factory=dict)
    """How the network came about: anything that JSON can hold."""
    safe: Safety | None = None
    """Margins of its safe outputs, where it was calibrated."""

    def __post_init__(self) -> None:
        """Check names and shapes, and hold every array unchangeable."""
        check_names(self.inputs, self.outputs)
        if not len(self.weights) == len(self.biases) > 1:
            raise ValueError(
                f"the network has {len(self.weights)} weights and {len(self.biases)} biases, but each of its layers, "
                "at least two, needs both."
            )
        d, m = len(self.inputs), len(self.outputs)
        sizes = [d, *(len(bias) for bias in self.biases[:-1]), m]
        layers = [(size, before) for before, size in pairwise(sizes)]

        def checked(name: str, value: ArrayLike, shape: tuple[int, ...]) -> Array:
            return frozen_array(value, shape, f"{name} of the network")

        def set_field(name: str, value: object) -> None:
            object.__setattr__(self, name, value)

        set_field("weights", tuple(checked(f"weights[{k}]", self.weights[k], s) for k, s in enumerate(layers)))
        set_field("biases", tuple(checked(f"biases[{k}]", self.biases[k], (s,)) for k, (s, _) in enumerate(layers)))
        for name, n in {"input_ranges": d, "target_ranges": m}.items():
            set_field(name, frozen_ranges(getattr(self, name), n, f"{name} of the network"))
        if self.posterior_factor is not None:
            P = parameter_count(sizes)
            set_field("posterior_factor", checked("posterior_factor", self.posterior_factor, (P, P)))
        if self.log_std is not None and (self.log_std.inputs, len(self.log_std.outputs)) != (self.inputs, m):
            raise ValueError("the network of the deviations has other inputs or another number of outputs.")
        if self.safe is not None:
            self.safe.places(self.outputs)
        if self.beta is not None and not 0.0 < self.beta < np.inf:
            raise ValueError(f"beta of the network is {self.beta}, but must be positive and finite.")

    @property
    def has_std(self) -> bool:
        """Whether it tells standard deviations."""
        return self.log_std is not None or (self.beta is not None and self.posterior_factor is not None)

    @property
    def sizes(self) -> tuple[int, ...]:
        """Number of inputs, of neurons in each hidden layer, and of outputs: (d, S_1, ..., m)."""
        return len(self.inputs), *(len(bias) for bias in self.biases)

    def predict(self, X: ArrayLike) -> Array:
        """Outputs (..., m) in their units, at the inputs X (..., d) in theirs."""
        if compiled := library():
            return evaluate_by_blocks(partial(self._packed.outputs, compiled), X, self.inputs, COMPILED_BLOCK)

        def outputs(X: Array) -> Array:
            y_p = self._activations(X)[-1] @ self.weights[-1].T + self.biases[-1]
            return from_symmetric(y_p, self.target_ranges)

        return evaluate_by_blocks(outputs, X, self.inputs)

    def predict_safe(self, X: ArrayLike) -> Array:
        """Safe values (..., s) of the outputs that `safe` names, at X (..., d), in output units.

        Raises:
            ValueError: the network was not calibrated.
        """
        return safe_values(self.safe, self.predict(X), self.outputs)

    def gradient(self, X: ArrayLike) -> Array:
        """Slopes d output / d input (..., m, d) at X (..., d), in output units per input unit."""
        scale = np.ptp(self.target_ranges, axis=1)[:, None] / np.ptp(self.input_ranges, axis=1)

        def slopes(X: Array) -> Array:
            return self._sensitivities(self._activations(X))[0] @ self.weights[0] * scale

        return evaluate_by_blocks(slopes, X, self.inputs)

    def predict_std(self, X: ArrayLike) -> Array:
        """Standard deviation (..., m) of the outputs at X (..., d), in output units.

        With a network of their logarithms, what that gives. Else its square is the noise variance 1 / (2 beta) plus
        g'K'K g, which the uncertain parameters add, with g the gradient of the output with respect to them: MacKay's
        Gaussian approximation at the trained weights.

        Raises:
            ValueError: the network was trained without Bayesian regularisation.
        """
        if self.log_std is not None:
            return np.exp(self.log_std.predict(X))
        if self.beta is None or self.posterior_factor is None:
            raise ValueError("the network has no posterior covariance: train it with Bayesian regularisation.")
        noise, factor = 0.5 / self.beta, self.posterior_factor

        def standard_deviations(X: Array) -> Array:
            Kg = self._parameter_gradient(X) @ factor.T
            return np.sqrt(noise + np.einsum("nop,nop->no", Kg, Kg))

        return evaluate_by_blocks(standard_deviations, X, self.inputs) * (np.ptp(self.target_ranges, axis=1) / 2.0)

    def parameter_gradient(self, X: ArrayLike) -> Array:
        """Gradient (..., m, P) of the outputs on [-1, 1] with respect to the parameters, at X (..., d).

        The parameters are the rows of [W_1, b_1], then the rows of [W_2, b_2], and so on.
        """
        return evaluate_by_blocks(self._parameter_gradient, X, self.inputs)

    def in_range(self, X: ArrayLike) -> np.ndarray[Any, np.dtype[np.bool_]]:
        """Whether each of the inputs X (..., d) lies inside the ranges of the training data (...,)."""
        return in_range(X, self.input_ranges)

    @classmethod
    def from_plain(cls, content: dict[str, Any]) -> Network:
        """The network of the fields of ``content``, as JSON has them."""
        log_std = content.get("log_std")
        return super().from_plain(content | {"log_std": log_std and cls.from_plain(log_std)})

    @cached_property
    def _packed(self) -> PackedNetwork:
        return PackedNetwork(self.weights, self.biases, self.input_ranges, self.target_ranges)

    def _activations(self, X: Array) -> list[Array]:
        """Scaled inputs a_0 (n, d), and the outputs a_l (n, S_l) of the hidden layers."""
        a = [to_symmetric(X, self.input_ranges)]
        for W, b in zip(self.weights[:-1], self.biases[:-1], strict=True):
            a.append(np.tanh(a[-1] @ W.T + b))
        return a

    def _sensitivities(self, a: list[Array]) -> list[Array]:
        """Slopes (n, m, S_l) of the outputs on [-1, 1] with respect to W_l a_(l-1) + b_l, for each layer l."""
        delta = [np.broadcast_to(np.eye(len(self.outputs)), (len(a[0]), len(self.outputs), len(self.outputs)))]
        for W, a_l in zip(self.weights[:0:-1], a[:0:-1], strict=True):
            delta.insert(0, (delta[0] @ W) * (1.0 - a_l**2)[:, None])
        return delta

    def _parameter_gradient(self, X: Array) -> Array:
        a, ones = self._activations(X), np.ones((len(X), 1))
        parts = [
            delta[..., None] * np.hstack([a_l, ones])[:, None, None]
            for delta, a_l in zip(self._sensitivities(a), a, strict=True)
        ]
        return np.concatenate([part.reshape(*part.shape[:2], prod(part.shape[2:])) for part in parts], axis=2)


def parameter_count(sizes: tuple[int, ...] | list[int]) -> int:
    """Number P of weights and biases of a network with these layer sizes."""
    return sum(size * (before + 1) for before, size in pairwise(sizes))
