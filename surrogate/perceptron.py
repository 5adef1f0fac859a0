"""A batch of one-hidden-layer networks as least-squares problems in their parameters.

A network computes a = tanh(W1 x), y = W2 [a; 1] (paper eqs. 12, 13), where x ends with a constant 1, so that
W1 = [IW, b1] (S, d + 1) and W2 = [LW, b2] (m, S + 1). Its P parameters are the rows of W1, then the rows of W2.

The Jacobian of the errors e = y - t of output o has the columns

    de_o / dW1[s, i] = LW[o, s] (1 - a_s^2) x_i,        de_o / dW2[k, j] = [o = k] [a; 1]_j,

so all that J'J needs is in the Gram matrix of S (d + 1) + S + 1 basis columns that the outputs share: (1 - a_s^2) x_i,
a_s and 1. J itself is never formed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from surrogate.scaling import Array

if TYPE_CHECKING:
    from torch import Tensor


def nguyen_widrow(rng: np.random.Generator, sizes: Sequence[int]) -> Array:
    """Initial parameters (P,) of one network for inputs on [-1, 1] (Nguyen and Widrow, IJCNN 1990).

    `sizes` are the numbers of inputs, of neurons in each hidden layer, and of outputs. The rows of a hidden layer's
    weights (S, d) have random directions and the length 0.7 S^(1/d), and its biases spread the centres of the neurons
    evenly over the range of what comes in, which is [-1, 1] behind a hidden layer too. The output layer starts uniform
    on [-1, 1].
    """
    layers = []
    for d, S in pairwise(sizes[:-1]):
        length = 0.7 * S ** (1.0 / d)
        W = rng.standard_normal((S, d))
        W *= length / np.linalg.norm(W, axis=1, keepdims=True)
        spread = np.linspace(-1.0, 1.0, S) if S > 1 else np.zeros(1)
        layers.append(np.column_stack([W, length * spread * np.sign(W[:, 0])]))
    layers.append(rng.uniform(-1.0, 1.0, (sizes[-1], sizes[-2] + 1)))
    return np.concatenate([layer.ravel() for layer in layers])


def split_parameters(w: Array, sizes: Sequence[int]) -> tuple[tuple[Array, ...], tuple[Array, ...]]:
    """Weights (S_l, S_(l-1)) and biases (S_l,) of every layer, from the parameters w (P,)."""
    weights, biases, first = [], [], 0
    for before, size in pairwise(sizes):
        layer = w[first : first + size * (before + 1)].reshape(size, before + 1)
        weights.append(layer[:, :-1])
        biases.append(layer[:, -1])
        first += layer.size
    return tuple(weights), tuple(biases)


@dataclass(frozen=True)
class PerceptronBatch:
    """The data of B networks with `hidden` neurons: x (B, d + 1, n), whose last row is ones, targets t (B, m, n)."""

    x: Tensor
    t: Tensor
    hidden: int

    @classmethod
    def from_samples(cls, X: Array, T: Array, rows: Array, hidden: int) -> PerceptronBatch:
        """Networks that see the samples `rows` (B, n) of the scaled inputs X (N, d) and targets T (N, m)."""
        import torch

        x = np.concatenate([X, np.ones((len(X), 1))], axis=1)[rows].swapaxes(1, 2)
        t = T[rows].swapaxes(1, 2)
        return cls(torch.from_numpy(np.ascontiguousarray(x)), torch.from_numpy(np.ascontiguousarray(t)), hidden)

    @property
    def n_errors(self) -> int:
        """Errors of one network: samples x outputs."""
        return self.t.shape[1] * self.t.shape[2]

    def take(self, index: Tensor) -> PerceptronBatch:
        """The networks that `index` selects."""
        return PerceptronBatch(self.x[index], self.t[index], self.hidden)

    def sum_squared_errors(self, w: Tensor) -> Tensor:
        """e'e (B,) at the parameters w (B, P)."""
        _, e = self._forward(w)
        return (e * e).sum((1, 2))

    def normal_equations(self, w: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """e'e (B,), J'J (B, P, P) and J'e (B, P) at the parameters w (B, P)."""
        import torch

        S, columns = by_neuron = self.hidden, self.x.shape[1]
        first, second = slice(S * columns), slice(S * columns, None)
        LW = self._weights(w)[1][:, :, :-1]
        a, e = self._forward(w)
        basis = torch.empty(len(w), S * columns + S + 1, self.x.shape[2], dtype=w.dtype)
        torch.mul((1 - a * a)[:, :, None], self.x[:, None], out=basis[:, first].unflatten(1, by_neuron))
        basis[:, S * columns : -1] = a
        basis[:, -1] = 1.0
        gram = basis @ basis.mT
        hidden_gram = gram[:, first, first].unflatten(2, by_neuron).unflatten(1, by_neuron)
        cross_gram = gram[:, first, second].unflatten(1, by_neuron)
        JtJ = torch.zeros(len(w), w.shape[1], w.shape[1], dtype=w.dtype)
        JtJ[:, first, first] = (hidden_gram * (LW.mT @ LW)[:, :, None, :, None]).flatten(3).flatten(1, 2)
        for o in range(LW.shape[1]):
            own = slice(S * columns + o * (S + 1), S * columns + (o + 1) * (S + 1))
            cross = (cross_gram * LW[:, o, :, None, None]).flatten(1, 2)
            JtJ[:, first, own] = cross
            JtJ[:, own, first] = cross.mT
            JtJ[:, own, own] = gram[:, second, second]

        basis_e = basis @ e.mT
        hidden_e = (basis_e[:, first].unflatten(1, by_neuron) * LW.mT[:, :, None]).sum(3).flatten(1)
        Jte = torch.cat([hidden_e, basis_e[:, second].mT.flatten(1)], dim=1)
        return (e * e).sum((1, 2)), JtJ, Jte

    def _weights(self, w: Tensor) -> tuple[Tensor, Tensor]:
        """W1 (B, S, d + 1) and W2 (B, m, S + 1)."""
        S, columns = self.hidden, self.x.shape[1]
        return w[:, : S * columns].unflatten(1, (S, columns)), w[:, S * columns :].unflatten(1, (-1, S + 1))

    def _forward(self, w: Tensor) -> tuple[Tensor, Tensor]:
        """Hidden outputs a (B, S, n) and errors e (B, m, n)."""
        W1, W2 = self._weights(w)
        a = (W1 @ self.x).tanh_()
        return a, W2[:, :, :-1] @ a + W2[:, :, -1:] - self.t
