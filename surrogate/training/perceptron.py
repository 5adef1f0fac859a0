"""A batch of networks with tansig hidden layers as least-squares problems in their parameters.

A network computes a_0 = x, a_l = tanh(W_l [a_(l-1); 1]), y = W_L [a_(L-1); 1] (paper eqs. 12, 13). Its P parameters are
the rows of W_1, then those of W_2, and so on. The errors are e = y - t. With delta_l (m, S_l) the slopes of the outputs
with respect to W_l [a_(l-1); 1], the Jacobian's column of W_l[s, i] for output o is delta_l[o, s] [a_(l-1); 1]_i.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Self

import numpy as np

from surrogate.scaling import Array

if TYPE_CHECKING:
    from torch import Tensor

MEMORY = 64 * 1024**2
"""Bytes of a Jacobian that is formed at once."""


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
    """The data of B networks: x (B, d + 1, n), whose last row is ones, targets t (B, m, n), weights v (B, 1, n).

    `sizes` are the numbers of inputs, of neurons in each hidden layer, and of outputs. The squares of a sample's errors
    count as often as its weight says; without weights v is None.
    """

    x: Tensor
    t: Tensor
    sizes: tuple[int, ...]
    v: Tensor | None = None

    @classmethod
    def from_samples(
        cls, X: Array, T: Array, rows: Array, hidden: Sequence[int], weights: Array | None = None
    ) -> PerceptronBatch:
        """Networks that see the samples `rows` (B, n) of the scaled inputs X (N, d), targets T (N, m), weights (N,)."""
        import torch

        x = np.concatenate([X, np.ones((len(X), 1))], axis=1)[rows].swapaxes(1, 2)
        t = T[rows].swapaxes(1, 2)
        kind = _OneHiddenLayer if len(hidden) == 1 else _DeepBatch
        sizes = X.shape[1], *hidden, T.shape[1]
        v = None if weights is None else torch.from_numpy(weights[rows][:, np.newaxis])
        return kind(torch.from_numpy(np.ascontiguousarray(x)), torch.from_numpy(np.ascontiguousarray(t)), sizes, v)

    @property
    def n_errors(self) -> Tensor | float:
        """Errors of a network: samples x outputs; with weights (B,), each sample as often as it weighs."""
        return self.t.shape[1] * (self.t.shape[2] if self.v is None else self.v.sum((1, 2)))

    def take(self, index: Tensor) -> Self:
        """The networks that `index` selects."""
        return replace(self, x=self.x[index], t=self.t[index], v=None if self.v is None else self.v[index])

    def to(self, device: str) -> Self:
        """The same on a device of torch."""
        v = None if self.v is None else self.v.to(device)
        return replace(self, x=self.x.to(device), t=self.t.to(device), v=v)

    def sum_squared_errors(self, w: Tensor) -> Tensor:
        """e'e (B,) at the parameters w (B, P)."""
        _, e = self._forward(w, self.x, self.t)
        return (e * self._weighted(e)).sum((1, 2))

    def _weighted(self, values: Tensor, part: slice = slice(None)) -> Tensor:
        """Values (B, .., n), those of a sample times its weight."""
        return values if self.v is None else values * self.v[:, :, part]

    def normal_equations(self, w: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """e'e (B,), J'J (B, P, P) and J'e (B, P) at the parameters w (B, P)."""
        raise NotImplementedError

    def _layers(self, w: Tensor) -> list[Tensor]:
        """W_l (B, S_l, S_(l-1) + 1) of every layer."""
        layers, first = [], 0
        for before, size in pairwise(self.sizes):
            last = first + size * (before + 1)
            layers.append(w[:, first:last].unflatten(1, (size, before + 1)))
            first = last
        return layers

    def _forward(self, w: Tensor, x: Tensor, t: Tensor) -> tuple[list[Tensor], Tensor]:
        """[x, then a_l (B, S_l + 1, n) of the hidden layers], each with a last row of ones, and errors e (B, m, n)."""
        *hidden, output = self._layers(w)
        a = [x]
        for W in hidden:
            a_l = x.new_empty(len(x), W.shape[1] + 1, x.shape[2])
            a_l[:, :-1] = W @ a[-1]
            a_l[:, :-1].tanh_()
            a_l[:, -1] = 1.0
            a.append(a_l)
        return a, output @ a[-1] - t


class _OneHiddenLayer(PerceptronBatch):
    """With one hidden layer delta_1[o, s] = LW[o, s] (1 - a_s^2), so that J is never formed.

    Column p for output o is C[o, p] b_c(p), where the basis b = [(1 - a_s^2) x_i, a_s, 1] is shared by the outputs. C
    is LW[o, s] for a parameter of neuron s, and 1 or 0 for one of output o or another. So
    J'J[p, q] = (C'C)[p, q] (b_c(p) b_c(q)) and J'e[p] = sum_o C[o, p] b_c(p) e_o, each sample by its weight.
    """

    def normal_equations(self, w: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        import torch

        columns, S, m = self.x.shape[1], self.sizes[1], self.sizes[2]
        (_, a), e = self._forward(w, self.x, self.t)
        b = a.new_empty(len(w), S * columns + S + 1, a.shape[2])
        b[:, S * columns :] = a
        torch.mul((1 - a[:, :-1] ** 2)[:, :, None], self.x[:, None], out=b[:, : S * columns].unflatten(1, (S, columns)))
        basis, output = torch.arange(b.shape[1], device=w.device).split([S * columns, S + 1])
        c = torch.cat([basis, output.repeat(m)])
        C = torch.zeros(len(w), m, len(c), dtype=w.dtype, device=w.device)
        C[:, :, : S * columns] = self._layers(w)[1][:, :, :-1].repeat_interleave(columns, dim=2)
        for o in range(m):
            C[:, o, S * columns + o * (S + 1) : S * columns + (o + 1) * (S + 1)] = 1.0
        b_v = self._weighted(b)
        JtJ = (b_v @ b.mT)[:, c[:, None], c] * (C.mT @ C)
        Jte = ((b_v @ e.mT)[:, c] * C.mT).sum(2)
        return (e * self._weighted(e)).sum((1, 2)), JtJ, Jte


class _DeepBatch(PerceptronBatch):
    """With more hidden layers J is formed for as many samples at a time as fit into `MEMORY`."""

    def normal_equations(self, w: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        (B, P), n, m = w.shape, self.x.shape[2], self.sizes[-1]
        chunk = max(1, MEMORY // (8 * B * m * P))
        JtJ, Jte, sse = w.new_zeros(B, P, P), w.new_zeros(B, P), w.new_zeros(B)
        for first in range(0, n, chunk):
            part = slice(first, first + chunk)
            a, e = self._forward(w, self.x[:, :, part], self.t[:, :, part])
            J = self._jacobian(w, a).flatten(1, 2)
            J_v = J if self.v is None else J * self.v[:, 0, part].repeat_interleave(m, dim=1)[:, :, None]
            JtJ += J_v.mT @ J
            Jte += (J_v.mT @ e.mT.flatten(1, 2)[:, :, None])[:, :, 0]
            sse += (e * self._weighted(e, part)).sum((1, 2))
        return sse, JtJ, Jte

    def _jacobian(self, w: Tensor, a: list[Tensor]) -> Tensor:
        """Slopes (B, n, m, P) of the outputs with respect to the parameters, by backpropagation."""
        import torch

        B, _, n = a[0].shape
        m = self.sizes[-1]
        delta = torch.eye(m, dtype=w.dtype, device=w.device).expand(B, n, m, m)
        parts: list[Tensor] = []
        for W, a_l in zip(reversed(self._layers(w)), reversed(a), strict=True):
            parts.insert(0, (delta[..., None] * a_l.mT[:, :, None, None]).flatten(3))
            delta = delta @ W[:, None, :, :-1] * (1 - a_l.mT[:, :, None, :-1] ** 2)
        return torch.cat(parts, dim=3)
