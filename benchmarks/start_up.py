"""Start-up: whole processes of the command line, medians, beside a Python that only imports what they are built on."""

import os
import statistics
import subprocess
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from benchmarks.table import row, write

RUNS = 15
COMMAND = Path(sys.executable).with_name("gtm-fmu")
PEER = "python -c 'import numpy, typer'"
ASKED = {
    "gtm-fmu --help": "--help",
    "gtm-fmu predict": "predict --altitude-ft 10000 --rudder-deg -10 20 --json",
    "gtm-fmu envelope": "envelope --altitude-ft 10000 --rudder-deg -10 20 --json",
}
BYTECODE_KEPT = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
"""An installed package has its bytecode; where the variable forbids to write it, every run would compile anew."""


def seconds(words: list[str]) -> float:
    """Wall-clock time of one process."""
    started = time.perf_counter()
    subprocess.run(words, check=True, stdout=subprocess.DEVNULL, env=BYTECODE_KEPT)
    return time.perf_counter() - started


def main() -> None:
    """Runs in turn, so that other work meets all of them. The first ones may compile and do not count."""
    processes = {name: [str(COMMAND), *words.split()] for name, words in ASKED.items()}
    processes[PEER] = [sys.executable, "-c", "import numpy, typer"]
    times: dict[str, list[float]] = {name: [] for name in processes}
    for number in range(1 + RUNS):
        for name, words in processes.items():
            taken = seconds(words)
            if number:
                times[name].append(taken)
    medians = {name: 1e3 * statistics.median(each) for name, each in times.items()}
    peer_ms = medians[PEER]
    write("start_up", [row(name, medians[name], "ms", PEER, peer_ms, medians[name] / peer_ms) for name in ASKED])


if __name__ == "__main__":
    main()
