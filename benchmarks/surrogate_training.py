"""Seconds to train 20 networks 4-10-2 on data of the study's size, beside scipy.optimize.least_squares.

Both start from the same weights and fit the same 991 samples: `surrogate` with Bayesian regularisation for 1000 epochs
at most, SciPy (MINPACK's Levenberg-Marquardt, analytic Jacobian) without regularisation for 1000 evaluations at most.
SciPy trains one network at a time, so a few stand for all 20.

    python benchmarks/surrogate_training.py
"""

import json
import platform
import time
from pathlib import Path

import numpy as np
import torch
from scipy.optimize import least_squares

from surrogate.levenberg_marquardt import Schedule, train
from surrogate.perceptron import PerceptronBatch, nguyen_widrow, split_parameters

SAMPLES, SHAPE, NETWORKS, PEER_NETWORKS, EPOCHS = 991, (4, 10, 2), 20, 4, 1000
RESULT = Path(__file__).parent / "results" / "surrogate_training.json"


def synthetic_samples() -> tuple[np.ndarray, np.ndarray]:
    """Inputs and targets on [-1, 1]: two limits of a speed range that close in on each other, with bends and a kink."""
    X = np.random.default_rng(0).uniform(-1, 1, (SAMPLES, 4))
    height, slope, lower, upper = X.T
    offset = np.maximum(np.maximum(lower, -upper), 0.0)
    fast = np.tanh(1.5 - height - slope) - 0.8 * offset**2 * np.exp(0.5 * height)
    slow = 0.3 * np.exp(height) + 0.5 * offset**3 + 0.05 * np.sin(3 * slope * height)
    T = np.column_stack([slow, fast])
    return X, 2 * (T - T.min(axis=0)) / np.ptp(T, axis=0) - 1


def peer_seconds_and_mse(X: np.ndarray, T: np.ndarray, w: np.ndarray) -> tuple[float, float, int]:
    """Time, mean squared error on [0, 1] and Jacobian evaluations of least_squares for one network."""
    (n, d), (_, hidden, outputs) = X.shape, SHAPE
    x = np.column_stack([X, np.ones(n)])
    J = np.zeros((outputs, n, len(w)))

    def hidden_outputs(w):
        (IW, LW), (b1, b2) = split_parameters(w, SHAPE)
        return np.tanh(X @ IW.T + b1), LW, b2

    def errors(w):
        a, LW, b2 = hidden_outputs(w)
        return (a @ LW.T + b2 - T).T.ravel()

    def jacobian(w):
        a, LW, _ = hidden_outputs(w)
        slopes = (1 - a**2)[:, :, None] * x[:, None]
        for o in range(outputs):
            first = hidden * (d + 1) + o * (hidden + 1)
            J[o, :, : hidden * (d + 1)] = (slopes * LW[o, :, None]).reshape(n, -1)
            J[o, :, first : first + hidden] = a
            J[o, :, first + hidden] = 1.0
        return J.reshape(outputs * n, -1)

    start = time.perf_counter()
    result = least_squares(errors, w, jacobian, method="lm", max_nfev=EPOCHS, ftol=1e-15, xtol=1e-15, gtol=1e-15)
    return time.perf_counter() - start, float(np.mean(result.fun**2) / 4), result.njev


def main() -> None:
    X, T = synthetic_samples()
    w = np.stack([nguyen_widrow(np.random.default_rng(j), SHAPE) for j in range(NETWORKS)])
    problems = PerceptronBatch.from_samples(X, T, np.tile(np.arange(SAMPLES), (NETWORKS, 1)), [SHAPE[1]])
    train(problems, w, Schedule(epochs=5))

    start, cpu_start = time.perf_counter(), time.process_time()
    fits = train(problems, w, Schedule(epochs=EPOCHS))
    seconds, cpu_seconds = time.perf_counter() - start, time.process_time() - cpu_start
    epochs = sum(len(fit.history.sse) - 1 for fit in fits)
    mse = [fit.history.sse[-1] / T.size / 4 for fit in fits]
    peers = [peer_seconds_and_mse(X, T, w[j]) for j in range(PEER_NETWORKS)]
    peer_seconds = float(np.mean([s for s, _, _ in peers]))
    peer_steps = sum(steps for _, _, steps in peers)
    result = {
        "machine": f"{platform.machine()}, {torch.get_num_threads()} cores, torch {torch.__version__}",
        "networks": NETWORKS,
        "samples": SAMPLES,
        "seconds": round(seconds, 2),
        "cpu_seconds": round(cpu_seconds, 2),
        "epochs_done": epochs,
        "ms_per_epoch": round(1e3 * seconds / epochs, 3),
        "median_mse": float(f"{np.median(mse):.3g}"),
        "peer": "scipy.optimize.least_squares (lm, analytic Jacobian)",
        "peer_seconds_per_network": round(peer_seconds, 2),
        "peer_ms_per_jacobian": round(1e3 * peer_seconds * PEER_NETWORKS / peer_steps, 3),
        "peer_median_mse": float(f"{np.median([m for _, m, _ in peers]):.3g}"),
        "times_faster_per_network": round(peer_seconds * NETWORKS / seconds, 1),
    }
    RESULT.parent.mkdir(exist_ok=True)
    RESULT.write_text(json.dumps(result, indent=1) + "\n")
    for name, value in result.items():
        print(f"| {name} | {value} |")


if __name__ == "__main__":
    main()
