"""Plans by the exact FMUs and by maps in their place, and how fast questions are through FMPy.

    python benchmarks/path_planner.py

The ridge of examples/path_planner: the time of the search, what the exact FMUs say of the path, questions a second.
"""

import sys
import tempfile
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
sys.path.insert(0, str(Path(__file__).parents[1]))
from table import row, write

from examples.path_planner.planner import exact_fmus, read_scenario
from examples.path_planner.planner.comparison import compared
from examples.path_planner.planner.planning import map_fmu
from gtm_fmu import manoeuvres
from gtm_fmu.aircraft.limits import ControlLimits

SCENARIO = Path(__file__).parents[1] / "examples" / "path_planner" / "scenarios" / "ridge.toml"
QUESTIONS = 20_000


def main() -> None:
    ridge = read_scenario(SCENARIO)
    with tempfile.TemporaryDirectory() as folder:
        exact = exact_fmus(Path(folder), ridge)
        maps = [
            map_fmu(Path(folder), ridge),
            map_fmu(Path(folder), ridge, is_safe=True),
            map_fmu(Path(folder), ridge, "GtmSurrogateNative", "network"),
        ]
        rng = np.random.default_rng(1)
        asked = rng.uniform((4000, -6, 90, -5), (8000, 6, 130, 1), (QUESTIONS, 4))
        began = time.perf_counter()
        answers = exact.are_feasible(asked)
        through_fmpy = QUESTIONS / (time.perf_counter() - began)
        began = time.perf_counter()
        jam = ControlLimits(rudder_deg=(18, 18))
        expected = manoeuvres(asked[:, 0], asked[:, 2], asked[:, 1], asked[:, 3], limits=jam).feasible
        in_batches = QUESTIONS / (time.perf_counter() - began)
        rows = [
            row(
                "questions to GtmManoeuvreNative through FMPy",
                through_fmpy,
                "1/s",
                "gtm_fmu.manoeuvres, in C in batches",
                in_batches,
                through_fmpy / in_batches,
            ),
            row("of them answered otherwise", int((answers != expected).sum()), "questions"),
        ]
        for choice in compared(ridge, exact, maps):
            name = f"plan by {choice.source}"
            rows.append(row(name, choice.seconds, "s"))
            if choice.plan is not None:
                rows.append(row(f"{name}: questions", choice.plan.queries, "questions"))
                rows.append(row(f"{name}: time on the way", choice.plan.measures.time_s, "s"))
                rows.append(row(f"{name}: of that infeasible by the exact FMU", choice.infeasible_s, "s"))
                rows.append(row(f"{name}: V_min, V_max off by at most", choice.speeds_off_kt or 0.0, "kn"))
        for source in (exact, *maps):
            source.close()
    write("path_planner", rows)


if __name__ == "__main__":
    main()
