"""Envelopes of random failures against dense scans of trims: nothing beyond an end, no envelope missed, none invented.

    python benchmarks/certainty.py [CASES [SEED]]

Jams and restrictions of the rudder, in half of the cases with limits or jams of elevator, aileron and throttle too. The
scan steps by 0.5 kn up to 15 kn beyond either end, by 0.25 deg of bank with a jammed rudder and by 1 deg of bank and
2.5 deg of rudder with a free one; over all speeds it steps by 1 or 2 kn. Jammed controls are held. Errors are printed.
"""

import sys
import time
from pathlib import Path

import numpy as np
from rich.progress import track

sys.path.insert(0, str(Path(__file__).parent))
sys.path.insert(0, str(Path(__file__).parents[1]))
from table import row, write

from tests.reference.dense_scan import Case, Steps, errors, random_case


def steps(case: Case) -> tuple[Steps, Steps]:
    """Of the scans near the ends and over all speeds."""
    lower, upper = case.limits.rudder_deg
    return (Steps(0.5, 0.25, 2.5), Steps(1, 1, 2.5)) if lower == upper else (Steps(0.5, 1, 2.5), Steps(2, 2, 5))


def main(cases: int = 200, seed: int = 1) -> None:
    rng = np.random.default_rng(seed)
    feasible, wrong, processor = 0, 0, 0.0
    for _ in track(range(cases), "Envelopes against dense scans"):
        case = random_case(rng)
        began = time.process_time()
        found = case.envelope()
        processor += time.process_time() - began
        feasible += found.feasible
        problems = errors(case, found, *steps(case))
        wrong += bool(problems)
        for problem in problems:
            print(f"{case}: {problem}")
    rows = [
        row(f"random failures, seed {seed}", cases, "cases"),
        row("with an envelope", feasible, "cases"),
        row("where the scan finds more than 0.01 kn beyond, an envelope missed or an end invented", wrong, "cases"),
        row("one envelope (V_min, V_max, t_min), nothing shared, processor time", 1e3 * processor / cases, "ms"),
    ]
    write("certainty", rows)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
