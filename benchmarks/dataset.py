"""Cases per second of a random data set with one and two dask workers, beside plain processes, and their memory.

    python benchmarks/dataset.py

The cases are the first ones of a random table over altitude, flight-path angle and rudder failures, one in five a jam.
Rounds of all four alternate, and the best one of each counts, from its first chunks on. The time of a million cases is
extrapolated from this sample. On a machine with other work the ratio of processor times tells how evenly two workers
share the cases.
"""

import resource
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack
from multiprocessing import get_context
from pathlib import Path

from distributed import Client, LocalCluster

sys.path.insert(0, str(Path(__file__).parent))
from table import row, write

from gtm_fmu import results
from gtm_fmu.axes import limits_span, span
from gtm_fmu.cases import CaseTable, Sampling
from gtm_fmu.distribution import PIECE, compute

CASES, CHUNK, ROUNDS, MILLION = 512, 64, 2, 1_000_000
TABLE = CaseTable.sampled(
    [span("altitude", 0, 30000), span("gamma", -5, 5), limits_span("rudder", -30, 30, jam_share=0.2)],
    Sampling.RANDOM,
    CASES,
    seed=0,
)


def solve(start: int) -> None:
    results.evaluate(TABLE.rows(start, start + PIECE))


def rate(marks: list[tuple[int, float]]) -> float:
    """Cases a second between the first marks of (cases done, time) after the first chunks and the last mark."""
    marks = [mark for mark in marks if mark[0] >= 2 * CHUNK]
    (first, start), (last, stop) = marks[0], marks[-1]
    return (last - first) / (stop - start)


def plain_processes(stack: ExitStack, processes: int) -> Callable[[], float]:
    """The solver in plain processes, without dask and without a store."""
    pool = stack.enter_context(get_context("spawn").Pool(processes))

    def run() -> float:
        solved = pool.imap_unordered(solve, range(0, CASES, PIECE))
        return rate([(PIECE * (k + 1), time.perf_counter()) for k, _ in enumerate(solved)])

    return run


def dask_workers(stack: ExitStack, workers: int) -> tuple[Callable[[], float], Client]:
    options = {"n_workers": workers, "threads_per_worker": 1, "dashboard_address": ":0"}
    client = stack.enter_context(Client(stack.enter_context(LocalCluster(**options))))

    def run() -> float:
        marks: list[tuple[int, float]] = []
        with tempfile.TemporaryDirectory() as folder:
            compute(
                Path(folder) / "a.zarr",
                TABLE,
                chunk=CHUNK,
                scheduler=client.scheduler.address,
                progress=lambda done, _: marks.append((done, time.perf_counter())),
            )
        return rate(marks)

    return run, client


def peak_mb() -> float:
    """Largest resident memory of this process so far."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def largest(client: Client, ask: Callable[[], float]) -> float:
    return max(client.run(ask).values())


def main() -> None:
    with ExitStack() as stack:
        one, client_of_one = dask_workers(stack, 1)
        two, client_of_two = dask_workers(stack, 2)
        runs = [plain_processes(stack, 1), plain_processes(stack, 2), one, two]
        one()
        two()
        peak = largest(client_of_two, peak_mb)
        busy = [largest(client, time.process_time) for client in (client_of_one, client_of_two)]
        rates = [[run() for run in runs] for _ in range(ROUNDS)]
        busy_one, busy_two = (
            (largest(client, time.process_time) - before) / ROUNDS
            for client, before in zip((client_of_one, client_of_two), busy, strict=True)
        )
        growth = largest(client_of_two, peak_mb) - peak
    plain_one, plain_two, one_worker, two_workers = map(max, zip(*rates, strict=True))
    scaling, plain_scaling = two_workers / one_worker, plain_two / plain_one
    rows = [
        row("cases, one worker", one_worker, "1/s", "plain process, 1/s", plain_one, one_worker / plain_one),
        row("cases, two workers", two_workers, "1/s", "plain processes, 1/s", plain_two, two_workers / plain_two),
        row("scaling to two workers", scaling, "", "plain processes", plain_scaling, scaling / plain_scaling),
        row("cases a second of a worker's processor time", CASES / busy_one, "1/s"),
        row("processor time of one worker over that of the busier of two", busy_one / busy_two, ""),
        row("peak memory of a worker", peak + growth, "MB"),
        row(f"its growth from {CASES} to {(ROUNDS + 1) * CASES} cases", growth, "MB"),
        row("peak memory of the process that asks", peak_mb(), "MB"),
        row("a million cases, two workers, extrapolated", MILLION / two_workers / 3600, "h"),
    ]
    write("dataset", rows)


if __name__ == "__main__":
    main()
