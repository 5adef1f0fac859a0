"""The networks of a failed rudder that come with the package, made anew from exact cases and a seed.

They learn from a Sobol sequence of cases, not from a lattice, and are chosen by cases between those they learn from. A
network of its own gives the standard deviations: it learns how large the errors are, and where, and its level is set by
further cases so that 95 % of the errors lie inside 95 % intervals.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from gtm_fmu.airframe.provenance import provenance
from gtm_fmu.datasets.cases import CaseTable, Sampling
from gtm_fmu.datasets.off_lattice import CALIBRATION_CASES, CALIBRATION_SEED, DEVIATIONS, LEVEL, OffLattice, case_table
from surrogate.models.network import Network
from surrogate.rudder.emulator import INPUTS, SPEEDS, RudderEmulator, train
from surrogate.training.least_squares import Schedule
from surrogate.training.train import train_networks

CASES, CASES_SEED, SEED = 16384, 11, 0
HIDDEN, ROUNDS, EPOCHS = (40, 40), 8, 600
DEVIATIONS_HIDDEN, DEVIATIONS_EPOCHS = 20, 200
LOG_STD = tuple((f"log_{name.removesuffix('_kt')}_std", "ln kt") for name, _ in SPEEDS)
LEAST_ERROR_KT = 0.01
"""Added to an error before its logarithm is taken."""


def tables() -> Mapping[str, CaseTable]:
    """The cases that the networks learn from, and those that set the level of their deviations."""
    return {
        "training_cases": case_table(cases=CASES, seed=CASES_SEED, sampling=Sampling.SOBOL),
        "calibration_cases": case_table(cases=CALIBRATION_CASES, seed=CALIBRATION_SEED),
    }


def train_emulator(
    training: OffLattice,
    calibration: OffLattice,
    device: str = "cpu",
    progress: Callable[[int, int], None] | None = None,
    hidden: tuple[int, ...] = HIDDEN,
    rounds: int = ROUNDS,
    epochs: int = EPOCHS,
) -> RudderEmulator:
    """Networks of the cases (Algorithm 1), with calibrated standard deviations."""
    samples = training.X, training.speeds_kt, training.t_min_pct
    options: dict[str, Any] = {"hidden": hidden, "rounds": rounds, "schedule": Schedule(epochs=epochs)}
    speeds, throttle = train(samples, SEED, progress, device=device, **options)
    return calibrated(speeds.network, throttle.network, training, calibration)


def calibrated(speeds: Network, throttle: Network, training: OffLattice, calibration: OffLattice) -> RudderEmulator:
    """Trained networks with standard deviations in the place of their posterior.

    That has a million numbers, and knows nothing of the folds.
    """
    facts = provenance() | {"cases": len(training.X)}
    speeds, throttle = (
        replace(network, beta=None, posterior_factor=None, provenance=facts | network.provenance)
        for network in (speeds, throttle)
    )
    return RudderEmulator(replace(speeds, log_std=deviations(speeds, training, calibration)), throttle)


def deviations(speeds: Network, training: OffLattice, calibration: OffLattice) -> Network:
    """The logarithms of the standard deviations of V_min and V_max in kt."""
    X, error = _errors(speeds, training)
    log_error = np.log(error + LEAST_ERROR_KT)
    [(network, _)] = train_networks(
        X,
        log_error,
        inputs=INPUTS,
        outputs=LOG_STD,
        rows=[np.arange(len(X))],
        seed=SEED,
        hidden=DEVIATIONS_HIDDEN,
        schedule=Schedule(epochs=DEVIATIONS_EPOCHS),
    )
    X, error = _errors(speeds, calibration)
    ratio = np.sort(error / np.exp(network.predict(X)), axis=0)
    rank = min(int(np.ceil(LEVEL * (len(ratio) + 1))), len(ratio))  # so that LEVEL holds for further cases, too
    level = ratio[rank - 1] / DEVIATIONS
    ranges = network.target_ranges + np.log(level)[:, None]
    return replace(network, target_ranges=ranges, beta=None, posterior_factor=None)


def _errors(speeds: Network, data: OffLattice) -> tuple[np.ndarray, np.ndarray]:
    """Cases with an envelope (n, 4), and the sizes of their errors (n, 2) in kt."""
    X, exact = data.X[data.feasible], data.speeds_kt[data.feasible]
    return X, np.abs(speeds.predict(X) - exact)
