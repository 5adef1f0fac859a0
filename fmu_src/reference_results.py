"""Expected results that travel in a native FMU: doublets of elevator and aileron from the start values, by the core."""

import csv
import io

import numpy as np

from fmu_src.description import ModelDescription
from gtm_fmu import core

STEP_S, STOP_S, RECORDED_EVERY = 0.02, 10.0, 5
DOUBLETS = {"control.elevator": (1.0, 2.0, 3.0, 0.05), "control.aileron": (4.0, 4.5, 5.0, 0.03)}
"""Begin, turn and end in s, and amplitude in rad."""


def commands(time_s: float, trim: dict[str, float]) -> dict[str, float]:
    """Values of the moving controls (SI) that are held over the communication step from a time on."""
    values = {}
    for name, (begin, turn, end, size) in DOUBLETS.items():
        at = time_s + STEP_S / 2  # steps begin a rounding before or after these times
        values[name] = trim[name] + (size if begin <= at < turn else -size if turn <= at < end else 0.0)
    return values


def reference_files(model: ModelDescription) -> dict[str, bytes]:
    """Inputs and results of the reference flight as CSV, in SI, in the folder ``extra``."""
    x, u, outputs = (model.groups[group] for group in ("states", "controls", "outputs"))
    x_scale, u_scale, y_scale = (np.array([variable.scale for variable in group]) for group in (x, u, outputs))
    trim = {variable.name: float(variable.start or 0.0) for variable in u}
    state = np.array([variable.start for variable in x]) / x_scale
    substep_s = float(next(v.start for v in model.groups["solver"] if v.name == "solver.substep") or 0.0)
    inputs, results = [], []
    held = np.array(list(trim.values())) / u_scale
    for i in range(round(STOP_S / STEP_S) + 1):
        time_s = i * STEP_S
        if i % RECORDED_EVERY == 0:  # at the end of a step, with its controls
            results.append([time_s, *(state * x_scale), *(core.outputs(state, held) * y_scale)])
        given = trim | commands(time_s, trim)
        inputs.append([time_s, *given.values()])
        held = np.array(list(given.values())) / u_scale
        state = core.advance(state, held, STEP_S, substep_s)
    return {
        "extra/gtm-fmu/reference_input.csv": _csv(["time", *trim], inputs),
        "extra/gtm-fmu/reference_result.csv": _csv(["time", *(v.name for v in (*x, *outputs))], results),
    }


def _csv(header: list[str], rows: list[list[float]]) -> bytes:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows([[f"{value:.10g}" for value in row] for row in rows])
    return text.getvalue().encode()
