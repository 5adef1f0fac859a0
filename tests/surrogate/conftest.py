"""A known smooth function, and networks that were fitted to it once for all tests."""

import numpy as np
import pytest

from surrogate import Schedule, Selection, select_network

INPUTS = (("height", "m"), ("angle", "deg"), ("width", "mm"))
OUTPUTS = (("speed", "m/s"), ("force", "N"))


def smooth_function(X: np.ndarray) -> np.ndarray:
    """Two outputs (n, 2) of three inputs (n, 3) with very different ranges."""
    height, angle, width = X.T
    speed = 50.0 + 10.0 * np.tanh((height - 4000.0) / 3000.0) * np.cos(np.radians(6.0 * angle)) + 4.0 * width**2
    force = 1e-3 * np.exp(0.8 * width) * (angle + 10.0) + 2e-6 * height
    return np.column_stack([speed, force])


def random_inputs(n: int, seed: int) -> np.ndarray:
    return np.random.default_rng(seed).uniform([0.0, -5.0, -1.0], [9000.0, 5.0, 1.0], (n, 3))


@pytest.fixture(scope="session")
def selection(torch) -> Selection:
    """Six rounds on 400 samples of the smooth function."""
    X = random_inputs(400, seed=1)
    return select_network(
        X, smooth_function(X), inputs=INPUTS, outputs=OUTPUTS, seed=7, rounds=6, schedule=Schedule(epochs=300)
    )
