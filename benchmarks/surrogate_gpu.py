"""Seconds to train networks with Bayesian regularisation on a GPU, beside the processor of the same machine.

Two loads: 1000 restarts of a 4-10-2 network on 991 samples, and 20 restarts on 100 000 samples. The processor does a
smaller share of the same work, and its time per network is compared. Both run a fixed number of epochs.

    python benchmarks/surrogate_gpu.py
"""

import time

import numpy as np
import torch
from table import row, write

from surrogate.training.least_squares import Schedule
from surrogate.training.levenberg_marquardt import train
from surrogate.training.perceptron import PerceptronBatch, nguyen_widrow

SIZES, EPOCHS = (4, 10, 2), 100
LOADS = {  # samples: restarts on the GPU, on the processor
    991: (1000, 40),
    100_000: (20, 2),
}
"""Samples -> restarts on the GPU, and on the processor."""


def samples(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Inputs and targets on [-1, 1]: two limits of a speed range that close in on each other, with bends and a kink."""
    X = np.random.default_rng(0).uniform(-1, 1, (n, 4))
    height, slope, lower, upper = X.T
    offset = np.maximum(np.maximum(lower, -upper), 0.0)
    fast = np.tanh(1.5 - height - slope) - 0.8 * offset**2 * np.exp(0.5 * height)
    slow = 0.3 * np.exp(height) + 0.5 * offset**3 + 0.05 * np.sin(3 * slope * height)
    T = np.column_stack([slow, fast])
    return X, 2 * (T - T.min(axis=0)) / np.ptp(T, axis=0) - 1


def seconds(n: int, restarts: int, device: str, epochs: int = EPOCHS) -> tuple[float, float]:
    """Time to train, and the median mean squared error on [0, 1]."""
    X, T = samples(n)
    batch = PerceptronBatch.from_samples(X, T, np.tile(np.arange(n), (restarts, 1)), SIZES[1:-1])
    w = np.stack([nguyen_widrow(np.random.default_rng(j), SIZES) for j in range(restarts)])
    start = time.perf_counter()
    fits = train(batch, w, Schedule(epochs=epochs, min_grad=0.0), device=device)
    return time.perf_counter() - start, float(np.median([fit.history.sse[-1] for fit in fits]) / T.size / 4)


def main() -> None:
    if not torch.cuda.is_available():
        raise SystemExit("torch finds no CUDA device here; run this on a machine that has one.")
    rows = []
    for n, (restarts, fewer) in LOADS.items():
        for device in ("cuda", "cpu"):
            seconds(n, 2, device, epochs=2)  # warms up
        on_gpu, mse = seconds(n, restarts, "cuda")
        on_cpu, mse_there = seconds(n, fewer, "cpu")
        per_network, peer = on_gpu / restarts, on_cpu / fewer
        name = f"{restarts} restarts, {n} samples, {EPOCHS} epochs, {torch.cuda.get_device_name()}"
        rows.append(row(name, on_gpu, "s"))
        rows.append(
            row(
                f"a network of {n} samples on the GPU",
                per_network,
                "s",
                f"processor, {torch.get_num_threads()} threads, {fewer} restarts",
                peer,
                peer / per_network,
            )
        )
        rows.append(row(f"{n} samples: median MSE on the GPU", mse, "", "processor", mse_there, mse / mse_there))
    write("surrogate_gpu", rows)


if __name__ == "__main__":
    main()
