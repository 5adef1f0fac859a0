"""What matters for the envelope of a failed rudder: indices of altitude, flight path and both limits, without sampling.

Some cases have no envelope, so there are three questions:

- "as in the paper": V_min and V_max of every case; where there is none, a network continues them;
- "with an envelope": V_min and V_max, given that there is an envelope; then all inputs depend on each other;
- "whether": whether there is an envelope, and the least throttle that a steady manoeuvre needs.

Each is answered over the cells of a grid by exact solutions and by the thrust map, those of the speeds by networks too.
How far a surrogate's indices are from the exact ones on the same cells is its own error; what the cells do, finer ones
tell.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from gtm_fmu.envelopes.thrust_map import ThrustMap
from gtm_study.paper import rudder_grid
from gtm_study.paper.rudder_grid import Cells, RudderGrid
from sensitivity import TabulatedIndices, tabulated_indices
from surrogate.rudder.emulator import INPUTS, SPEEDS, RudderEmulator

NAMES = tuple(name for name, _ in INPUTS)
LIMITS = NAMES[2:]
SPEED_NAMES = tuple(name for name, _ in SPEEDS)
FINER_CELLS = Cells(24, 24, 60)
AS_IN_THE_PAPER, WITH_AN_ENVELOPE, WHETHER = "as in the paper", "with an envelope", "whether"
EXACT, MAP = "exact", "thrust map"


def answers(grid: RudderGrid, continued_by: RudderEmulator) -> dict[str, TabulatedIndices]:
    """The indices of each question."""
    weights, has_envelope = grid.cells.weights, grid.has_envelope
    missing = (weights > 0.0) & ~has_envelope
    continued = grid.speeds_kt.copy()
    if missing.any():
        continued[missing] = continued_by.speeds.predict(grid.cells.cases[missing])
    whether = {"has_envelope": has_envelope.astype(float)}
    if grid.t_min_pct is not None:
        whether["t_min_pct"] = grid.t_min_pct
    return {
        AS_IN_THE_PAPER: _indices(weights, continued, SPEED_NAMES),
        WITH_AN_ENVELOPE: given_an_envelope(grid),
        WHETHER: _indices(weights, np.stack(list(whether.values()), axis=-1), tuple(whether)),
    }


def given_an_envelope(grid: RudderGrid) -> TabulatedIndices:
    """The indices of V_min and V_max, given that there is an envelope."""
    return _indices(grid.cells.weights * grid.has_envelope, grid.speeds_kt, SPEED_NAMES)


def of_network(truth: RudderGrid, emulator: RudderEmulator) -> dict[str, TabulatedIndices]:
    """The indices of the questions of the speeds, by a network alone; the truth says where there is an envelope."""
    weights = truth.cells.weights
    speeds = np.full((*weights.shape, len(SPEEDS)), np.nan)
    speeds[weights > 0.0] = emulator.speeds.predict(truth.cells.cases[weights > 0.0])
    return {
        AS_IN_THE_PAPER: _indices(weights, speeds, SPEED_NAMES),
        WITH_AN_ENVELOPE: _indices(weights * truth.has_envelope, speeds, SPEED_NAMES),
    }


def _indices(weights: np.ndarray, outputs: np.ndarray, output_names: tuple[str, ...]) -> TabulatedIndices:
    return tabulated_indices(NAMES, weights, outputs, output_names, groups=[LIMITS])


def results(
    thrust_map: ThrustMap,
    networks: Mapping[str, RudderEmulator],
    continued_by: RudderEmulator,
    finer_cells: Cells = FINER_CELLS,
) -> tuple[dict[str, Any], TabulatedIndices]:
    """Everything as plain numbers, and the thrust map's indices of the paper's question.

    Args:
        networks: by name.
        continued_by: the one that continues the speeds where there is no envelope.
        finer_cells: on which the thrust map answers beside the exact ones.
    """
    truth = rudder_grid.exact()
    exact, mapped = answers(truth, continued_by), answers(rudder_grid.mapped(truth.cells, thrust_map), continued_by)
    finer = answers(rudder_grid.mapped(finer_cells, thrust_map), continued_by)
    by_networks = {name: of_network(truth, emulator) for name, emulator in networks.items()}
    questions = {}
    for question, indices in exact.items():
        others = {name: found[question] for name, found in by_networks.items() if question in found}
        answered = {EXACT: indices, MAP: finer[question], **others}
        questions[question] = {
            "answers": {name: each.to_dict() for name, each in answered.items()},
            "own_error": {name: apart(each, indices) for name, each in ({MAP: mapped[question]} | others).items()},
            "cells_error": apart(mapped[question], finer[question]),
        }
    weights = truth.cells.weights
    return {
        "cells": truth.cells._asdict(),
        "finer_cells": finer_cells._asdict(),
        "without_envelope": float((weights * ~truth.has_envelope).sum() / weights.sum()),
        "questions": questions,
    }, finer[AS_IN_THE_PAPER]


def apart(one: TabulatedIndices, other: TabulatedIndices) -> float:
    """Largest difference of the indices of the outputs that both have."""
    shared = [name for name in one.output_names if name in other.output_names]
    mine, theirs = ([each.output_names.index(name) for name in shared] for each in (one, other))
    return max(
        float(np.abs(one.estimates[kind].value[:, mine] - other.estimates[kind].value[:, theirs]).max())
        for kind in one.kinds
    )
