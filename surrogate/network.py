"""A trained network in closed form: values, slopes and standard deviations by NumPy alone (paper eqs. 41-46)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from surrogate.scaling import Array, from_symmetric, to_symmetric

BLOCK = 4096
"""Samples that are evaluated at once."""


class Variable(NamedTuple):
    """Name and unit of an input or output."""

    name: str
    unit: str


@dataclass(frozen=True, eq=False)
class Network:
    """One hidden layer of S tansig neurons, from d inputs to m linear outputs (paper eqs. 12, 13).

    With I_p and y_p the inputs and outputs mapped from their ranges to [-1, 1] (eq. 43):
    y_p = LW tanh(IW I_p + b1) + b2 (eqs. 44, 45; tansig is tanh).
    """

    IW: Array
    """Hidden weights (S, d)."""
    b1: Array
    """Hidden biases (S,)."""
    LW: Array
    """Output weights (m, S)."""
    b2: Array
    """Output biases (m,)."""
    input_ranges: Array
    """Least and greatest value of each input in the training data (d, 2), in the input's unit."""
    target_ranges: Array
    """The same of each target (m, 2)."""
    inputs: tuple[Variable, ...]
    outputs: tuple[Variable, ...]
    beta: float
    """Evidence parameter of the errors on [-1, 1]: their variance is 1 / (2 beta)."""
    posterior_factor: Array
    """Upper triangular K (P, P): K'K is the posterior covariance of the parameters, as in `parameter_gradient`."""
    metrics: dict[str, float] = field(default_factory=dict)
    provenance: dict[str, Any] = field(default_factory=dict)
    """How the network came about: anything that JSON can hold."""

    def __post_init__(self) -> None:
        """Check the shapes, and hold every array unchangeable."""
        S, d, m = len(self.b1), len(self.inputs), len(self.outputs)
        P = S * (d + 1) + m * (S + 1)
        shapes = {
            "IW": (S, d),
            "b1": (S,),
            "LW": (m, S),
            "b2": (m,),
            "input_ranges": (d, 2),
            "target_ranges": (m, 2),
            "posterior_factor": (P, P),
        }
        for name, shape in shapes.items():
            value = np.array(getattr(self, name), dtype=float)
            if value.shape != shape or not np.isfinite(value).all():
                raise ValueError(f"{name} of the network must hold finite numbers in the shape {shape}.")
            value.setflags(write=False)
            object.__setattr__(self, name, value)
        if not 0.0 < self.beta < np.inf:
            raise ValueError(f"beta of the network is {self.beta}, but must be positive and finite.")

    def predict(self, X: ArrayLike) -> Array:
        """Outputs (..., m) in their units, at the inputs X (..., d) in theirs."""

        def outputs(I_p: Array) -> Array:
            return from_symmetric(self._hidden(I_p) @ self.LW.T + self.b2, self.target_ranges)

        return self._by_blocks(outputs, X)

    def gradient(self, X: ArrayLike) -> Array:
        """Slopes d output / d input (..., m, d) at X (..., d), in output units per input unit."""
        scale = np.ptp(self.target_ranges, axis=1)[:, None] / np.ptp(self.input_ranges, axis=1)

        def slopes(I_p: Array) -> Array:
            return (self.LW * (1.0 - self._hidden(I_p) ** 2)[:, None]) @ self.IW * scale

        return self._by_blocks(slopes, X)

    def predict_std(self, X: ArrayLike) -> Array:
        """Standard deviation (..., m) of the outputs at X (..., d), in output units.

        Its square is the noise variance 1 / (2 beta) plus g'K'K g, which the uncertain parameters add, with g the
        gradient of the output with respect to them: MacKay's Gaussian approximation at the trained weights.
        """

        def standard_deviations(I_p: Array) -> Array:
            Kg = self._parameter_gradient(I_p) @ self.posterior_factor.T
            return np.sqrt(0.5 / self.beta + np.einsum("nop,nop->no", Kg, Kg))

        return self._by_blocks(standard_deviations, X) * (np.ptp(self.target_ranges, axis=1) / 2.0)

    def parameter_gradient(self, X: ArrayLike) -> Array:
        """Gradient (..., m, P) of the outputs on [-1, 1] with respect to the parameters, at X (..., d).

        The parameters are the rows of [IW, b1], then the rows of [LW, b2].
        """
        return self._by_blocks(self._parameter_gradient, X)

    def in_range(self, X: ArrayLike) -> np.ndarray[Any, np.dtype[np.bool_]]:
        """Whether each of the inputs X (..., d) lies inside the ranges of the training data (...,)."""
        least, greatest = self.input_ranges.T
        return ((least <= np.asarray(X)) & (np.asarray(X) <= greatest)).all(axis=-1)

    def save(self, path: str | Path) -> None:
        """Write the network to a JSON file, in one piece or not at all; `load` gives the same bits back."""
        from surrogate.storage import write_network

        write_network(self, Path(path))

    @classmethod
    def load(cls, path: str | Path) -> Network:
        """Read a file that `save` wrote; ValueError, saying what is wrong, for any other file."""
        from surrogate.storage import read_network

        return read_network(Path(path))

    def _by_blocks(self, evaluate: Callable[[Array], Array], X: ArrayLike) -> Array:
        """A function of scaled inputs (n, d) at X (..., d), in blocks that stay in the processor's cache."""
        X = np.asarray(X, dtype=float)
        if X.ndim == 0 or X.shape[-1] != len(self.inputs):
            names = ", ".join(variable.name for variable in self.inputs)
            raise ValueError(f"the inputs have the shape {X.shape}, but the last axis must hold {names}.")
        if not np.isfinite(X).all():
            raise ValueError("the inputs hold values that are not finite: leave those samples out.")
        samples = X.reshape(-1, len(self.inputs))
        starts = range(0, max(len(samples), 1), BLOCK)
        blocks = [evaluate(to_symmetric(samples[start : start + BLOCK], self.input_ranges)) for start in starts]
        return np.concatenate(blocks).reshape(*X.shape[:-1], *blocks[0].shape[1:])

    def _hidden(self, I_p: Array) -> Array:
        return np.tanh(I_p @ self.IW.T + self.b1)

    def _parameter_gradient(self, I_p: Array) -> Array:
        a, ones = self._hidden(I_p), np.ones((len(I_p), 1))
        hidden = (self.LW * (1.0 - a**2)[:, None])[..., None] * np.hstack([I_p, ones])[:, None, None]
        output = np.eye(len(self.outputs))[:, :, None] * np.hstack([a, ones])[:, None, None]
        return np.concatenate([part.reshape(*part.shape[:2], -1) for part in (hidden, output)], axis=2)
