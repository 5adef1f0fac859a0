"""Slopes of envelopes by the multipliers of the optimum against differences of the exact solver.

    python benchmarks/slopes.py [CASES [SEED]]

Random failures as in certainty.py, at random altitudes and flight paths; every quantity of `envelope_slopes`, to both
sides. Differences are taken over two lengths of steps, for an end may bend inside the longer one. Where a difference is
no slope, as at a jump, they disagree; all that do are printed.
"""

import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from rich.progress import track

sys.path.insert(0, str(Path(__file__).parent))
sys.path.insert(0, str(Path(__file__).parents[1]))
from table import row, write

from gtm_fmu import Envelope
from tests.reference.dense_scan import Case, random_case
from tests.reference.slope_differences import compared


def with_envelope(rng: np.random.Generator) -> Iterator[tuple[Case, Envelope]]:
    """Random failures that leave an envelope."""
    while True:
        case = random_case(rng)
        if (found := case.envelope()).feasible:
            yield case, found


def main(cases: int = 200, seed: int = 1) -> None:
    rng = np.random.default_rng(seed)
    wrong, unsettled, count, processor = 0, 0, 0, 0.0
    for _ in track(range(cases), "Slopes against differences"):
        case, found = next(with_envelope(rng))
        began = time.process_time()
        _ = found.slopes
        processor += time.process_time() - began
        for each in compared(found):
            count += 1
            if each.difference is None:
                unsettled += 1
            elif not each.agrees:
                wrong += 1
                print(f"{case}: {each.name} {each.slope:.6g}, by differences {each.difference:.6g}")
    rows = [
        row(f"random failures with an envelope, seed {seed}", cases, "cases"),
        row("slopes, each to one side", count, "slopes"),
        row("without a solution to differ from", unsettled, "slopes"),
        row("that differ from differences of the exact solver", wrong, "slopes"),
        row("all slopes of an envelope, processor time", 1e3 * processor / cases, "ms"),
    ]
    write("slopes", rows)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
