"""A local model network in closed form: polynomials, each valid in a part of the inputs (paper eqs. 16-20)."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surrogate.models.evaluation import Variable, check_names, evaluate_by_blocks, frozen_array, frozen_ranges, in_range
from surrogate.models.partitions import Partition, SplitTree, partition_from_plain
from surrogate.models.safety import Safety, safe_values
from surrogate.models.storage import StoredModel
from surrogate.scaling import Array, to_unit

LocalModel = Literal["linear", "sparse_quadratic", "quadratic"]
"""The paper's three kinds: linear, quadratic without and with cross-products."""

Terms = NDArray[np.int64]


def polynomial_terms(kind: LocalModel, n_inputs: int) -> Terms:
    """Terms (K, 2) of a local model: each is the product of two of (z_1, ..., z_d, 1), numbered from 0 to d."""
    d, one = n_inputs, n_inputs
    pairs = [(one, one), *((j, one) for j in range(d))]
    if kind == "sparse_quadratic":
        pairs += [(j, j) for j in range(d)]
    elif kind == "quadratic":
        pairs += [(i, j) for i in range(d) for j in range(i, d)]
    elif kind != "linear":
        raise ValueError(f"'{kind}' is no kind of local model: choose 'linear', 'sparse_quadratic' or 'quadratic'.")
    return np.array(pairs, dtype=np.int64)


def polynomial_basis(z: Array, terms: Terms) -> Array:
    """Values (n, K) of the terms at the scaled inputs z (n, d)."""
    z_1 = np.column_stack([z, np.ones(len(z))])
    return z_1[:, terms[:, 0]] * z_1[:, terms[:, 1]]


@dataclass(frozen=True, eq=False)
class LocalModelNetwork(StoredModel):
    """M local polynomials, each weighted by its validity: y = sum_i phi_i(z) p_i(z) (paper eq. 16).

    z are the inputs mapped from their ranges to [0, 1]; the outputs come in their units.
    """

    terms: Terms
    """Terms of every polynomial (K, 2); term k is z_a z_b with a, b = terms[k], where the number d stands for 1."""
    coefficients: Array
    """Coefficients of the terms (M, K, m), in output units."""
    partition: Partition
    input_ranges: Array
    """Least and greatest value of each input in the training data (d, 2), in the input's unit."""
    target_ranges: Array
    """The same of each target (m, 2)."""
    inputs: tuple[Variable, ...]
    outputs: tuple[Variable, ...]
    metrics: dict[str, float] = field(default_factory=dict)
    provenance: dict[str, Any] = field(default_factory=dict)
    """How the network came about: anything that JSON can hold."""
    safe: Safety | None = None
    """Margins of its safe outputs, where it was calibrated."""

    def __post_init__(self) -> None:
        """Check names and shapes, and hold every array unchangeable."""
        check_names(self.inputs, self.outputs)
        d, m, M = len(self.inputs), len(self.outputs), self.partition.tree.models
        terms = np.array(self.terms, dtype=np.int64)
        if terms.ndim != 2 or terms.shape[1] != 2 or not ((terms >= 0) & (terms <= d)).all():
            raise ValueError(f"terms of the network must be pairs of numbers from 0 to {d}.")
        terms.setflags(write=False)
        object.__setattr__(self, "terms", terms)
        coefficients = frozen_array(self.coefficients, (M, len(terms), m), "coefficients of the network")
        object.__setattr__(self, "coefficients", coefficients)
        for name, n in {"input_ranges": d, "target_ranges": m}.items():
            object.__setattr__(self, name, frozen_ranges(getattr(self, name), n, f"{name} of the network"))
        if self.safe is not None:
            self.safe.places(self.outputs)
        if self.partition.validity(np.zeros((1, d))).shape != (1, M):
            raise ValueError(f"the partition of the network does not divide {d} inputs.")

    @property
    def models(self) -> int:
        """Number M of local models."""
        return len(self.coefficients)

    def predict(self, X: ArrayLike) -> Array:
        """Outputs (..., m) in their units, at the inputs X (..., d) in theirs."""

        def outputs(X: Array) -> Array:
            z = to_unit(X, self.input_ranges)
            phi, basis = self.partition.validity(z), polynomial_basis(z, self.terms)
            weighted = (phi[:, :, None] * basis[:, None]).reshape(len(z), -1)
            return weighted @ self.coefficients.reshape(-1, len(self.outputs))

        return evaluate_by_blocks(outputs, X, self.inputs)

    def predict_safe(self, X: ArrayLike) -> Array:
        """Safe values (..., s) of the outputs that `safe` names, at X (..., d), in output units.

        Raises:
            ValueError: the network was not calibrated.
        """
        return safe_values(self.safe, self.predict(X), self.outputs)

    def gradient(self, X: ArrayLike) -> Array:
        """Slopes d output / d input (..., m, d) at X (..., d), in output units per input unit."""

        def slopes(X: Array) -> Array:
            z = to_unit(X, self.input_ranges)
            p = np.einsum("nk,iko->nio", polynomial_basis(z, self.terms), self.coefficients)
            p_slope = np.einsum("nkj,iko->nioj", _basis_gradient(z, self.terms), self.coefficients)
            in_z = np.einsum("ni,nioj->noj", self.partition.validity(z), p_slope)
            in_z += np.einsum("nij,nio->noj", self.partition.validity_gradient(z), p)
            return in_z / np.ptp(self.input_ranges, axis=1)

        return evaluate_by_blocks(slopes, X, self.inputs)

    def validity(self, X: ArrayLike) -> Array:
        """Validity (..., M) of every local model at X (..., d); they add up to one."""
        return evaluate_by_blocks(lambda X: self.partition.validity(to_unit(X, self.input_ranges)), X, self.inputs)

    def in_range(self, X: ArrayLike) -> np.ndarray[Any, np.dtype[np.bool_]]:
        """Whether each of the inputs X (..., d) lies inside the ranges of the training data (...,)."""
        return in_range(X, self.input_ranges)

    def tree(self) -> str:
        """The splits and local models as text, in the units of the inputs and outputs.

        A split is where two halves are equally valid; validity moves from one to the other smoothly.
        """
        lines: list[str] = []

        def describe(child: int, indent: str) -> None:
            if child < 0:
                lines.extend(f"{indent}model {-child}: {equation}" for equation in self._equations(-1 - child))
                return
            condition = self._condition(child)
            first, second = self.partition.tree.children[child].tolist()
            lines.append(f"{indent}if {condition}:")
            describe(first, indent + "    ")
            lines.append(f"{indent}else:")
            describe(second, indent + "    ")

        describe(0 if self.models > 1 else -1, "")
        return "\n".join(lines)

    @classmethod
    def from_plain(cls, content: dict[str, Any]) -> LocalModelNetwork:
        """The model of the fields of ``content``, as JSON has them."""
        return super().from_plain(content | {"partition": partition_from_plain(content["partition"])})

    def _condition(self, split: int) -> str:
        tree: SplitTree = self.partition.tree
        least, greatest = self.input_ranges.T
        slopes = tree.directions[split] / (greatest - least)
        threshold = tree.offsets[split] + slopes @ least
        used = np.flatnonzero(tree.directions[split])
        if len(used) == 1:
            [j] = used
            return f"{self.inputs[j].name} {'<' if slopes[j] > 0 else '>'} {threshold / slopes[j]:.4g}"
        return f"{_sum([(slopes[j], self.inputs[j].name) for j in used])} < {threshold:.4g}"

    def _equations(self, model: int) -> list[str]:
        """The polynomials of a local model, expanded in the inputs' own units."""
        d = len(self.inputs)
        least, greatest = self.input_ranges.T
        to_z = np.eye(d + 1)  # (z, 1) = to_z (x, 1)
        to_z[:d, :d] /= (greatest - least)[:, None]
        to_z[:d, d] = -least / (greatest - least)
        names = [variable.name for variable in self.inputs] + [""]
        equations = []
        for output, coefficients in zip(self.outputs, self.coefficients[model].T, strict=True):
            form = np.zeros((d + 1, d + 1))
            np.add.at(form, tuple(self.terms.T), coefficients)
            form = to_z.T @ form @ to_z
            form += np.tril(form, -1).T
            parts = [(form[d, d], "")]
            for a, b in sorted({(min(pair), max(pair)) for pair in self.terms.tolist()} - {(d, d)}):
                name = f"{names[a]}^2" if a == b else " ".join(filter(None, (names[a], names[b])))
                parts.append((form[a, b], name))
            equations.append(f"{output.name} = {_sum(parts)}")
        return equations


def _basis_gradient(z: Array, terms: Terms) -> Array:
    """Slopes of the terms (n, K, d)."""
    n, d = z.shape
    z_1 = np.column_stack([z, np.ones(n)])
    slopes, k = np.zeros((n, len(terms), d + 1)), np.arange(len(terms))
    slopes[:, k, terms[:, 0]] += z_1[:, terms[:, 1]]
    slopes[:, k, terms[:, 1]] += z_1[:, terms[:, 0]]
    return slopes[:, :, :d]


def _sum(parts: list[tuple[float, str]]) -> str:
    """'1.5 a - 2 b' of [(1.5, 'a'), (-2, 'b')]."""
    text = ""
    for value, name in parts:
        sign = "-" if value < 0 else "+" if text else ""
        text += f" {sign} {abs(value):.4g} {name}".rstrip() if text else f"{sign}{abs(value):.4g} {name}".rstrip()
    return text
