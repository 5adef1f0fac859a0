"""Cases per second of a random data set with one and two dask workers, beside plain processes, and their memory.

    python benchmarks/dataset.py

The cases are the first ones of a random table over altitude, flight-path angle and rudder failures, one in five a jam:
as many as one process solves in some seconds. Rounds of all four alternate and the best one of each counts, between its
first chunks and its last pieces. The time of a million cases is extrapolated. On a machine with other work only the
processor times tell something. How memory grows with the data set is seen with made-up results, too, as they are quick.
"""

import os
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from unittest.mock import patch

import numpy as np
import psutil

sys.path.insert(0, str(Path(__file__).parent))
from table import row, write

from gtm_fmu.datasets import distribution, results
from gtm_fmu.datasets.axes import limits_span, span
from gtm_fmu.datasets.cases import CaseTable, Sampling
from gtm_fmu.datasets.distribution import compute
from gtm_fmu.datasets.store import LARGEST_CHUNK, CaseStore

SECONDS, ROUNDS, CHUNK, MADE_UP, MILLION = 12, 2, 64, 20_480, 1_000_000
MB = 2**20


def table(cases: int) -> CaseTable:
    """The first cases of a table of any length."""
    axes = [span("altitude", 0, 30000), span("gamma", -5, 5), limits_span("rudder", -30, 30, jam_share=0.2)]
    return CaseTable.sampled(axes, Sampling.RANDOM, cases, seed=0)


def solve(start: int) -> None:
    results.evaluate(table(MILLION).rows(start, start + CHUNK))


@dataclass(frozen=True)
class Mark:
    """Where a run was: cases done, seconds, processor seconds and memory of its processes, and that of this one."""

    done: int
    wall: float
    processor: float
    largest_mb: float
    own_mb: float


@dataclass(frozen=True)
class Run:
    """A run between its first chunks and its last pieces."""

    marks: list[Mark]

    def _from_to(self, quantity: str) -> float:
        return getattr(self.marks[-1], quantity) - getattr(self.marks[0], quantity)

    @property
    def rate(self) -> float:
        """Cases a second."""
        return self._from_to("done") / self._from_to("wall")

    @property
    def processor_rate(self) -> float:
        """Cases a second of processor time."""
        return self._from_to("done") / self._from_to("processor")

    @property
    def peak_mb(self) -> float:
        """Largest process."""
        return max(mark.largest_mb for mark in self.marks)

    def growth_mb(self, whose: str) -> float:
        """How much larger it was in the second half than in the first."""
        half = len(self.marks) // 2
        first, second = (max(getattr(mark, whose) for mark in part) for part in (self.marks[:half], self.marks[half:]))
        return second - first


def memory_mb(process: psutil.Process) -> float:
    return process.memory_info().rss / MB


def watched(cases: int, run: Callable[[Callable[[int], None]], None]) -> Run:
    """A run whose processes are children of this one."""
    marks = []

    def mark(done: int) -> None:
        children = psutil.Process().children(recursive=True)
        times = (child.cpu_times() for child in children)
        processor = sum(each.user + each.system for each in times)
        largest, own = max(memory_mb(child) for child in children), memory_mb(psutil.Process())
        marks.append(Mark(done, time.perf_counter(), processor, largest, own))

    run(mark)
    return Run([each for each in marks if 2 * CHUNK <= each.done <= cases - 2 * CHUNK])


def plain_processes(cases: int, processes: int) -> Run:
    """The solver in plain processes, without dask and without a store."""

    def run(mark: Callable[[int], None]) -> None:
        with get_context("spawn").Pool(processes) as pool:
            for k, _ in enumerate(pool.imap_unordered(solve, range(0, cases, CHUNK))):
                mark(CHUNK * (k + 1))

    return watched(cases, run)


def dask_workers(cases: int, workers: int, chunk: int = CHUNK) -> Run:
    """`gtm-fmu dataset` without its command line."""

    def run(mark: Callable[[int], None]) -> None:
        with tempfile.TemporaryDirectory() as folder:
            store = Path(folder) / "a.zarr"
            compute(store, table(cases), chunk=chunk, workers=workers, progress=lambda done, _: mark(done))

    return watched(cases, run)


def made_up(count: int) -> dict[str, np.ndarray]:
    """Results of no solver."""
    rng = np.random.default_rng(0)
    return {name: rng.random(count).astype(dtype) for name, (dtype, _) in results.schema().items()}


def without_solver() -> Callable[..., dict[str, np.ndarray]]:
    """What is sent to a worker instead of the solver."""
    return lambda cases, **_: made_up(len(cases))


def cases_in(seconds: float) -> int:
    """Whole chunks that one process solves in about this time."""
    began = time.process_time()
    results.evaluate(table(MILLION).rows(0, CHUNK))
    return CHUNK * max(8, round(seconds / (time.process_time() - began)))


def chunk_seconds(chunks: int = 8) -> float:
    """Seconds to write a chunk of a store of a million cases, with made-up values."""
    with tempfile.TemporaryDirectory() as folder:
        store = CaseStore(Path(folder) / "a.zarr", table(MILLION), {})
        spent = []
        for cases in store.unfinished()[:chunks]:
            found = made_up(len(cases))
            began = time.perf_counter()
            store.write(cases, found)
            spent.append(time.perf_counter() - began)
        return float(np.median(spent))


def fastest(runs: list[Run]) -> Run:
    return max(runs, key=lambda run: run.rate)


def main() -> None:
    other_load, cases = os.getloadavg()[0], cases_in(SECONDS)
    kinds = [(kind, processes) for kind in (plain_processes, dask_workers) for processes in (1, 2)]
    rounds = [[kind(cases, processes) for kind, processes in kinds] for _ in range(ROUNDS)]
    with patch.object(distribution, "_evaluation", without_solver):
        quick = dask_workers(MADE_UP, 1, LARGEST_CHUNK)
    plain_one, plain_two, one, two = (fastest(list(runs)) for runs in zip(*rounds, strict=True))
    peak = max(run.peak_mb for each in rounds for run in each[2:])
    scaling, plain_scaling = two.rate / one.rate, plain_two.rate / plain_one.rate
    busy, plain_busy = (
        2 * many.processor_rate / single.processor_rate for many, single in ((two, one), (plain_two, plain_one))
    )
    write(
        "dataset",
        [
            row("cases, one worker", one.rate, "1/s", "plain process, 1/s", plain_one.rate, one.rate / plain_one.rate),
            row(
                "cases, two workers", two.rate, "1/s", "plain processes, 1/s", plain_two.rate, two.rate / plain_two.rate
            ),
            row(
                "cases a second of processor time, one worker",
                one.processor_rate,
                "1/s",
                "plain process, 1/s",
                plain_one.processor_rate,
                one.processor_rate / plain_one.processor_rate,
            ),
            row("scaling to two workers", scaling, "", "plain processes", plain_scaling, scaling / plain_scaling),
            row(
                "scaling if two cores were free, by processor time",
                busy,
                "",
                "plain processes",
                plain_busy,
                busy / plain_busy,
            ),
            row("cases of a run", cases, ""),
            row("processes that wanted a core before (load average)", other_load, ""),
            row("peak memory of a worker", peak, "MB"),
            row("its growth in the second half of a run", two.growth_mb("largest_mb"), "MB"),
            row(f"its growth in the second half of {MADE_UP} made-up cases", quick.growth_mb("largest_mb"), "MB"),
            row("peak memory of the process that asks", max(mark.own_mb for mark in quick.marks), "MB"),
            row("its growth in the second half of the made-up cases", quick.growth_mb("own_mb"), "MB"),
            row(f"writing {LARGEST_CHUNK} of a million cases", 1e3 * chunk_seconds(), "ms"),
            row("a million cases, two workers, extrapolated", MILLION / two.rate / 3600, "h"),
        ],
    )


if __name__ == "__main__":
    main()
