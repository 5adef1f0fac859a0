"""Seconds to train on the paper's lattice: 20 networks by each method, a local model network; beside libraries.

All learn from the same part of the first split of `gtm-fmu protocol` and are judged by its independent part. Seconds
are of processor time over all cores, which other work on the machine does not stretch. Peers: SciPy's least_squares
(MINPACK, analytic Jacobian, from the same weights, without regularisation, one network at a time) and scikit-learn's
Gaussian process (Matern 5/2, a length for each input).

    python benchmarks/surrogate_training.py [STORE]

STORE is the lattice's data set, `envelopes.zarr` of a study; without it the lattice is solved first.
"""

import sys
import time
import warnings
from collections.abc import Callable
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from scipy.optimize import least_squares
from sklearn.exceptions import ConvergenceWarning
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import ConstantKernel, Matern, WhiteKernel
from table import row, write

from gtm_fmu.datasets import lattice as dataset
from surrogate import LocalSettings, select_network, split_samples, train_local_models
from surrogate.rudder.emulator import INPUTS, SPEEDS
from surrogate.scaling import column_ranges, to_symmetric
from surrogate.training.local_selection import ALGORITHMS, LOCAL_MODELS
from surrogate.training.perceptron import nguyen_widrow, split_parameters
from surrogate.training.train import METHODS, generator

ROUNDS, PEERS, SIZES = 20, 3, (4, 10, 2)


def timed(call: Callable[[], Any]) -> tuple[float, float, Any]:
    """Processor seconds, seconds, and the result."""
    wall, cpu = time.perf_counter(), time.process_time()
    result = call()
    return time.process_time() - cpu, time.perf_counter() - wall, result


def lattice(store: Path | None) -> tuple[np.ndarray, np.ndarray]:
    with TemporaryDirectory() as folder:
        X, V, _ = dataset.samples(dataset.solved(store or Path(folder, "lattice.zarr"), dataset.lattice()))
    feasible = np.isfinite(V).all(axis=1)
    return X[feasible], V[feasible]


def least_squares_network(X: np.ndarray, T: np.ndarray, w: np.ndarray) -> np.ndarray:
    """Parameters that SciPy finds from w, on data scaled to [-1, 1]."""
    (n, d), hidden, outputs = X.shape, SIZES[1], SIZES[2]
    x = np.column_stack([X, np.ones(n)])
    J = np.zeros((outputs, n, len(w)))

    def errors(w):
        (IW, LW), (b1, b2) = split_parameters(w, SIZES)
        return (np.tanh(X @ IW.T + b1) @ LW.T + b2 - T).T.ravel()

    def jacobian(w):
        (IW, LW), (b1, _) = split_parameters(w, SIZES)
        a = np.tanh(X @ IW.T + b1)
        slopes = (1 - a**2)[:, :, None] * x[:, None]
        for o in range(outputs):
            first = hidden * (d + 1) + o * (hidden + 1)
            J[o, :, : hidden * (d + 1)] = (slopes * LW[o, :, None]).reshape(n, -1)
            J[o, :, first : first + hidden] = a
            J[o, :, first + hidden] = 1.0
        return J.reshape(outputs * n, -1)

    return least_squares(errors, w, jacobian, method="lm", max_nfev=1000, ftol=1e-15, xtol=1e-15, gtol=1e-15).x


def gaussian_process(X: np.ndarray, T: np.ndarray) -> list[GaussianProcessRegressor]:
    kernel = ConstantKernel(1.0, (1e-3, 1e5)) * Matern(np.ones(4), (1e-2, 1e3), nu=2.5) + WhiteKernel(1e-6, (1e-10, 1))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        return [GaussianProcessRegressor(kernel, normalize_y=True).fit(X, t) for t in T.T]


def main() -> None:
    X, Y = lattice(Path(sys.argv[1]) if len(sys.argv) > 1 else None)
    split = split_samples(len(X), ROUNDS, 0.1, 0)
    design, tests = split.training[0], split.independent
    X_p = to_symmetric(X, column_ranges(X, [name for name, _ in INPUTS]))
    ranges = column_ranges(Y, [name for name, _ in SPEEDS])
    T_p = to_symmetric(Y, ranges)
    names = {"inputs": INPUTS, "outputs": SPEEDS}
    select_network(X, Y, seed=0, rounds=2, hidden=2, **names)  # warms torch up

    peer, _, _ = timed(
        lambda: [
            least_squares_network(X_p[design], T_p[design], nguyen_widrow(generator(0, "weights", j), SIZES))
            for j in range(PEERS)
        ]
    )
    rows = []
    for method, (name, _) in METHODS.items():
        cpu, wall, selection = timed(lambda method=method: select_network(X, Y, seed=0, method=method, **names))
        epochs = sum(len(history.sse) - 1 for history in selection.histories)
        library = "scipy least_squares, a network"
        rows.append(
            row(f"{name}, a network of {ROUNDS}", cpu / ROUNDS, "s", library, peer / PEERS, peer / PEERS * ROUNDS / cpu)
        )
        rows.append(row(f"{name}, {ROUNDS} networks, all cores, clock", wall, "s"))
        rows.append(row(f"{name}, {ROUNDS} networks, {epochs} epochs", cpu, "s"))
        rows.append(row(f"{name}, best MSE on the independent test", selection.mse["independent"].min(), ""))
    cpu, _, processes = timed(lambda: gaussian_process(X_p[design], T_p[design]))
    predicted = np.column_stack([process.predict(X_p[tests]) for process in processes])
    rows.append(row("scikit-learn Gaussian process, V_min and V_max", cpu, "s"))
    rows.append(row("scikit-learn Gaussian process, MSE there", np.mean((predicted - T_p[tests]) ** 2) / 4, ""))
    seconds, errors = {}, []
    for algorithm, local_model, o in product(ALGORITHMS, LOCAL_MODELS, (0, 1)):
        arguments = {"rows": design, "validation_rows": split.test[0], "algorithm": algorithm}
        settings, output = LocalSettings(local_model), {"inputs": INPUTS, "outputs": [SPEEDS[o]]}
        cpu, _, (network, _) = timed(
            lambda a=arguments | output, s=settings, o=o: train_local_models(X, Y[:, [o]], settings=s, **a)
        )
        seconds[algorithm, local_model, o] = cpu
        if (algorithm, local_model) == ("hilomot", "quadratic"):
            errors.append(np.mean((network.predict(X[tests])[:, 0] - Y[tests, o]) ** 2) / np.ptp(Y[:, o]) ** 2)
    rows.append(row("local model network, mean of 12", np.mean(list(seconds.values())), "s"))
    rows.append(row("local model network, slowest of 12", max(seconds.values()), "s"))
    rows.append(row("HILOMOT, quadratic, MSE there", float(np.mean(errors)), ""))
    write("surrogate_training", rows)


if __name__ == "__main__":
    main()
