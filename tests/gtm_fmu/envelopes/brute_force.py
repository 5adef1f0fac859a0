"""Grids of an envelope by brute force: every cell and every rudder deflection tried from cold, nothing followed.

    python -m tests.gtm_fmu.envelopes.brute_force

holds the grid of 1 kn x 1 deg/s of all `CASES` against it and prints what is missed, a few minutes on one core.
"""

import time
from typing import NamedTuple

import numpy as np

from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.airframe.names import BETA, RUDDER
from gtm_fmu.core import motion, solver
from gtm_fmu.core.configuration import Configuration, trim_residual
from gtm_fmu.envelopes.envelope import FlightCondition
from gtm_fmu.envelopes.grid import EnvelopeGrid, envelope_grid
from gtm_fmu.trims import steady
from gtm_fmu.units import RAD_PER_DEG


def _failure(rudder_deg=(-30, 30), elevator_deg=(-30, 30), **configuration) -> Failure:
    return Failure(ControlLimits(elevator_deg, rudder_deg=rudder_deg), Configuration(**configuration))


CASES = {
    "jam": (10000.0, -5.0, _failure((20, 20))),
    "jam near the ceiling": (30000.0, 1.0, _failure((8, 8))),
    "jam with a gap in speed": (33591.549399502124, 0.3801354179272882, _failure((7.731865359248744,) * 2)),
    "jam with a notch": (28850.196529201738, 2.196066164883864, _failure((3.744290907350578,) * 2)),
    "no failure": (20000.0, -3.0, _failure()),
    "restriction": (10000.0, -5.0, _failure((5, 25))),
    "hard restriction": (14210.0, -1.9, _failure((13.7, 21.2))),
    "restriction near the ceiling": (31000.0, 0.6, _failure((-9, -5.5))),
    "elevator and rudder restricted": (15000.0, 1.0, _failure((5, 20), (-1, 2.5))),
    "left engine out, elevator restricted, flaps down": (
        5000.0,
        0.0,
        _failure(elevator_deg=(-1, 2.5), engine_running=(False, True), flap_deg=(20.0,) * 4),
    ),
    "left wing tip off, rudder restricted": (5000.0, 2.0, _failure((-15, 5), damage_case=4)),
    "left engine out, left elevator off": (5000.0, 0.0, _failure(engine_running=(False, True), damage_case=5)),
}


class BruteForce(NamedTuple):
    """Cells (n, m) with a trim at one of the deflections, and the least |beta| of those trims in rad."""

    feasible: np.ndarray
    least_sideslip: np.ndarray


def brute_force(condition: FlightCondition, tas_kt, turn_rate_deg_s, rudder_step_deg: float = 0.5) -> BruteForce:
    """All cells, with the rudder jammed in turn at every step between its limits."""
    lower, upper = (bound[RUDDER] for bound in condition.bounds)
    deflections = np.linspace(lower, upper, int(np.ceil((upper - lower) / rudder_step_deg)) + 1)
    shape = len(tas_kt), len(turn_rate_deg_s)
    feasible, sideslip = np.zeros(shape, dtype=bool), np.full(shape, np.inf)
    for deflection in deflections:
        cell = condition.altitude_ft, np.asarray(tas_kt)[:, None], condition.gamma_deg, turn_rate_deg_s
        found = steady.trims(*cell, condition.failure, rudder_deg=(deflection, deflection))
        here = (found.status == solver.TRIMMED).reshape(shape)
        beta = np.abs(found.y[:, BETA]).reshape(shape)
        sideslip = np.where(here, np.minimum(sideslip, beta), sideslip)
        feasible |= here
    return BruteForce(feasible, sideslip)


def missed(grid: EnvelopeGrid, condition: FlightCondition, beyond: int = 3, **step) -> tuple[int, int, float]:
    """Cells that brute force finds, those of them that the grid lacks, and by how much rad their |beta| is not least.

    It tries the rectangle about the grid's trims and some cells ``beyond`` it on every side.
    """
    columns = np.flatnonzero(grid.feasible.any(axis=0))
    columns = np.arange(columns[0] - beyond, columns[-1] + beyond + 1)
    apart = np.diff(grid.tas_kt[:2])[0] * np.arange(1, beyond + 1)
    speeds = np.concatenate([grid.tas_kt[0] - apart[::-1], grid.tas_kt, grid.tas_kt[-1] + apart])
    found = brute_force(condition, speeds, grid.turn_rate_deg_s[columns], **step)
    known = np.pad(grid.feasible[:, columns], ((beyond, beyond), (0, 0)))
    inner = slice(beyond, -beyond)
    both = (found.feasible & known)[inner]
    excess = np.abs(grid.y[:, columns, BETA])[both] - found.least_sideslip[inner][both]
    return int(found.feasible.sum()), int((found.feasible & ~known).sum()), float(excess.max(initial=0.0))


def worst_residual(grid: EnvelopeGrid) -> tuple[float, float]:
    """Largest acceleration of the grid's trims in ft/s^2 and rad/s^2, and largest excess over a bound in core units."""
    y, airframe = grid.y[grid.feasible], grid.failure.airframe
    gamma = grid.gamma_deg * RAD_PER_DEG
    if airframe.configuration is None:
        F = motion.derivatives(*solver.trim_states(grid.altitude_ft, gamma, y))[..., :6]
    else:
        at, y_both = (grid.altitude_ft, gamma), solver.with_both_throttles(y, airframe)
        F = np.array([trim_residual(row, *at, airframe.configuration) for row in y_both])
    lower, upper = FlightCondition(grid.altitude_ft, grid.gamma_deg, grid.failure).bounds
    return float(np.abs(F).max()), float(np.maximum(lower - y, y - upper).max())


def main() -> None:
    print(
        "cells of the grid, by brute force, missed, excess of |beta| in deg, largest acceleration, seconds (processor)"
    )
    total = 0
    for name, case in CASES.items():
        condition, began = FlightCondition(*case), time.process_time()
        grid = envelope_grid(condition)
        taken = time.process_time() - began
        by_force, lost, excess = missed(grid, condition)
        total += lost
        residual, _ = worst_residual(grid)
        cells = f"{grid.feasible.sum():6d} {by_force:6d} {lost:4d}"
        print(f"{name:50s} {cells} {excess / RAD_PER_DEG:9.1e} {residual:9.1e} {taken:7.3f}", flush=True)
    print(f"{total} missed")


if __name__ == "__main__":
    main()
