"""The closed form of a fitted model, as programs of vector operations (paper eqs. 41-46)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from surrogate.exports.program import Program
from surrogate.exports.steps import Affine, Apply, Constant, GroupSum, Join, Products, Softmax, Take
from surrogate.models.evaluation import Variable, safe_name
from surrogate.models.local_models import LocalModelNetwork
from surrogate.models.network import Network
from surrogate.models.partitions import AxisPartition, ObliquePartition
from surrogate.models.safety import Safety
from surrogate.scaling import Array

Model = Network | LocalModelNetwork


@dataclass(frozen=True, eq=False)
class ClosedForm:
    """What an export says of a model."""

    inputs: tuple[Variable, ...]
    outputs: tuple[Variable, ...]
    input_ranges: Array
    """Least and greatest value of each input in the training data (d, 2), in the input's unit."""
    output_ranges: Array
    """The same of the outputs (m, 2)."""
    predict: Program
    """Outputs from inputs, each in its unit."""
    std: Program | None
    """Their standard deviations, where the model has them."""
    safe: Safety | None = None
    """Margins of its safe outputs, where the model was calibrated."""

    @property
    def safe_outputs(self) -> tuple[Variable, ...]:
        """Names and units of the safe values."""
        if self.safe is None:
            return ()
        return tuple(Variable(safe_name(self.outputs[k].name), self.outputs[k].unit) for k in self.safe_places)

    @property
    def safe_places(self) -> list[int]:
        """Number of the output that each safe value is of."""
        return [] if self.safe is None else self.safe.places(self.outputs).tolist()

    @property
    def safe_program(self) -> Program | None:
        """Safe values from the outputs: each is moved by its margin, so that its slopes are those of the output."""
        if self.safe is None:
            return None
        program = Program(len(self.outputs))
        program.scale(program.add(Take(0, self.safe.places(self.outputs))), offset=self.safe.shifts)
        return program


def closed_form(model: Model, *, has_std: bool = True, has_short_factor: bool = False) -> ClosedForm:
    """The closed form of a model; its programs give what `predict` and `predict_std` give.

    Args:
        model: a fitted model.
        has_std: with the program of the standard deviations, where the model has them; it is much the longer one.
        has_short_factor: keep the factor of the posterior covariance, by far the largest table, in single precision.
            Standard deviations are then right to seven digits.
    """
    std = None
    if isinstance(model, Network):
        predict = _network(model)
        if has_std and model.log_std is not None:
            std = _network(model.log_std)
            std.add(Apply(len(std.steps), "exp"))
        elif has_std and model.posterior_factor is not None and model.beta is not None:
            factor = model.posterior_factor.astype(np.float32 if has_short_factor else float)
            std = _deviations(model, factor, model.beta)
    else:
        predict = _local_models(model)
    return ClosedForm(model.inputs, model.outputs, model.input_ranges, model.target_ranges, predict, std, model.safe)


def _activations(network: Network, program: Program) -> list[int]:
    """Scaled inputs, and what the hidden layers give (eqs. 43, 44)."""
    least, greatest = network.input_ranges.T
    a = [program.scale(0, least, 2.0 / (greatest - least), -1.0)]
    for W, b in zip(network.weights[:-1], network.biases[:-1], strict=True):
        a.append(program.add(Apply(program.add(Affine(a[-1], W, b)), "tanh")))
    return a


def _network(network: Network) -> Program:
    """y_p = W_L tanh(... W_1 I_p + b_1 ...) + b_L between the maps of inputs and outputs (eqs. 43-45)."""
    program = Program(len(network.inputs))
    a = _activations(network, program)
    least, greatest = network.target_ranges.T
    y_p = program.add(Affine(a[-1], network.weights[-1], network.biases[-1]))
    program.scale(y_p, -1.0, (greatest - least) / 2.0, least)
    return program


def _deviations(network: Network, factor: np.ndarray, beta: float) -> Program:
    """Square root of 1 / (2 beta) + |K g|^2, with g the gradient of an output with respect to the parameters."""
    program = Program(len(network.inputs))
    a = _activations(network, program)
    one = program.add(Constant(np.ones(1)))
    a_1 = [program.add(Join((x, one))) for x in a]
    slope = [program.scale(program.add(Apply(x, "square")), 0.0, -1.0, 1.0) for x in a[1:]]  # 1 - a^2
    m = len(network.outputs)
    zeros = program.add(Constant(np.zeros(program.sizes[a_1[-1]]))) if m > 1 else None
    Kg = []
    for o in range(m):
        delta = program.scale(slope[-1], 0.0, network.weights[-1][o])
        gradient = [_outer(program, delta, a_1[-2])]
        for W, s, x in zip(network.weights[-2:0:-1], slope[-2::-1], a_1[-3::-1], strict=True):
            back = program.add(Affine(delta, W.T, np.zeros(W.shape[1])))
            each = np.arange(W.shape[1])
            delta = program.add(Products(back, s, each, each))
            gradient.insert(0, _outer(program, delta, x))
        gradient += [a_1[-1] if k == o or zeros is None else zeros for k in range(m)]
        g = program.add(Join(tuple(gradient)))
        Kg.append(program.add(Affine(g, factor, np.zeros(len(factor)))))
    squares = program.add(Apply(program.add(Join(tuple(Kg))), "square"))
    variance = program.scale(program.add(GroupSum(squares, len(factor))), offset=0.5 / beta)
    program.scale(program.add(Apply(variance, "sqrt")), factor=np.ptp(network.target_ranges, axis=1) / 2.0)
    return program


def _outer(program: Program, x: int, y: int) -> int:
    """All products x_i y_j, row by row."""
    i, j = np.indices((program.sizes[x], program.sizes[y])).reshape(2, -1)
    return program.add(Products(x, y, i, j))


def _local_models(model: LocalModelNetwork) -> Program:
    """y = sum_i phi_i(z) p_i(z) (eq. 16)."""
    d, m, M = len(model.inputs), len(model.outputs), model.models
    program = Program(d)
    least, greatest = model.input_ranges.T
    z = program.scale(0, least, 1.0 / (greatest - least))
    z_1 = program.add(Join((z, program.add(Constant(np.ones(1))))))
    basis = program.add(Products(z_1, z_1, *model.terms.T))
    coefficients = model.coefficients.transpose(2, 0, 1).reshape(m * M, -1)
    p = program.add(Affine(basis, coefficients, np.zeros(m * M)))
    phi = _validity(model.partition, program, z)
    weighted = program.add(Products(phi, p, np.tile(np.arange(M), m), np.arange(m * M)))
    program.add(GroupSum(weighted, M))
    return program


def _validity(partition: AxisPartition | ObliquePartition, program: Program, z: int) -> int:
    if isinstance(partition, AxisPartition):
        M, d = partition.centres.shape
        repeated = program.add(Take(z, np.tile(np.arange(d), M)))
        distance = program.scale(repeated, partition.centres.ravel(), 1.0 / partition.sigmas.ravel())
        squared = program.add(GroupSum(program.add(Apply(distance, "square")), d))
        return program.add(Softmax(program.scale(squared, factor=-0.5)))
    tree = partition.tree
    if tree.models == 1:
        return program.add(Constant(np.ones(1)))
    # log of the shares 1 - psi and psi of every split is -softplus(t) and -softplus(-t)
    W, b = partition.steepness[:, None] * tree.directions, -partition.steepness * tree.offsets
    t = program.add(Affine(z, np.vstack([W, -W]), np.concatenate([b, -b])))
    log_share = program.add(Apply(t, "softplus"))
    way = _ways(tree.children)
    return program.add(Apply(program.add(Affine(log_share, -way, np.zeros(len(way)))), "exp"))


def _ways(children: np.ndarray) -> Array:
    """Which shares (M, 2 (M - 1)), first those of all first children, lie on the way to each model."""
    splits = len(children)
    to_split, to_model = np.zeros((splits, 2 * splits)), np.zeros((splits + 1, 2 * splits))
    for k, pair in enumerate(children.tolist()):
        for side, child in enumerate(pair):
            way = to_model[-1 - child] if child < 0 else to_split[child]
            way[:] = to_split[k]
            way[side * splits + k] = 1.0
    return to_model
