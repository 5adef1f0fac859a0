"""A data set computed by `dask.distributed`, on this machine's cores or on the user's cluster.

The process that asks holds the store and writes it; workers solve pieces of a few cases and keep nothing. Only a few
pieces a worker are under way at any time, so no memory grows with the data set. A piece of a lost worker is solved by
another.
"""

import logging
import resource
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Any

import dask
import numpy as np
from dask.system import CPU_COUNT
from distributed import CancelledError, Client, Future, KilledWorker, LocalCluster, Security, as_completed
from distributed.comm import CommClosedError, get_address_host_port
from distributed.utils import silence_logging_cmgr

from gtm_fmu.aircraft import ranges
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.aircraft.ranges import Range
from gtm_fmu.airframe.provenance import provenance
from gtm_fmu.datasets.cases import Cases
from gtm_fmu.datasets.store import CaseStore, writer_lock
from gtm_fmu.envelopes.tolerances import Tolerances
from gtm_fmu.errors import InputError
from gtm_fmu.files import real_path
from gtm_fmu.trims import manoeuvre

PIECE = 128
"""Cases a task at most: some seconds of work, against which its way there and back is short."""
WORKER_MEMORY = "500MB"
"""A worker that takes more is started anew."""
MOST_WORKERS = 1024
_ENCRYPTED = ("tls:", "wss:")
_FILES, _FILES_A_WORKER = 32, 16
"""Open files that a cluster of this machine takes."""
_LOST = (CancelledError, CommClosedError, TimeoutError)
_PIECES_A_THREAD = 2
_RETRIES = 3
_CONNECTION_S, _WORKER_S = 10, 60

_IGNORE_INTERRUPT = "import signal; signal.signal(signal.SIGINT, signal.SIG_IGN)"  # this process ends its workers

Progress = Callable[[int, int], None]


def compute(
    path: str | Path,
    table: Cases,
    alpha_deg: Range = ranges.ALPHA_DEG,
    phi_deg: Range = ranges.PHI_DEG,
    *,
    chunk: int | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Progress | None = None,
    replace: bool = False,
    tolerances: Tolerances | None = None,
) -> int:
    """Fill a store with the envelopes of a table's cases; a store that was left unfinished is continued.

    Args:
        path: of the store, a folder that ends in .zarr.
        table: the cases.
        alpha_deg: least and greatest angle of attack in deg.
        phi_deg: least and greatest bank in deg.
        chunk: cases a chunk of the store; default by the number of cases.
        workers: processes on this machine; default one a core.
        scheduler: address of a `dask.distributed` scheduler whose workers are used instead; they need this package.
        progress: called with the number of solved cases and of all that were missing.
        tolerances: of the aircraft, and the gust: guaranteed and possible speeds are kept too.
        replace: begin anew where a store of another version or with other options is, instead of refusing it.

    Returns:
        Number of cases that were missing.

    Raises:
        InputError: bounds outside what is allowed, a store that is written by another process, damaged, or of another
            version or with other options; no room on the disk; no workers, or workers that fail.
    """
    path = real_path(Path(path))
    manoeuvre.bounds(ControlLimits(), alpha_deg, phi_deg)
    if workers is not None and not 1 <= workers <= MOST_WORKERS:
        raise InputError(f"{workers} workers were asked for; ask for 1 to {MOST_WORKERS}.")
    options: dict[str, Any] = {"alpha_deg": list(alpha_deg), "phi_deg": list(phi_deg)}
    if tolerances:
        options["tolerances"] = asdict(tolerances)
    with writer_lock(path):
        store = CaseStore(path, table, options, chunk, replace)
        chunks = store.unfinished()
        if chunks:
            with silence_logging_cmgr(logging.CRITICAL), _client(workers, scheduler) as client:
                try:
                    _fill(store, chunks, client, options, progress)
                except _LOST as error:
                    raise _unfinished("The scheduler was lost") from error
    return sum(map(len, chunks))


@contextmanager
def _client(workers: int | None, scheduler: str | None) -> Iterator[Client]:
    with ExitStack() as stack:
        try:
            if scheduler is None:
                address = stack.enter_context(_local_cluster(workers or CPU_COUNT))
            else:
                get_address_host_port(scheduler)
                if scheduler.startswith(_ENCRYPTED) and not Security().get_connection_args("client").get("ssl_context"):
                    raise ValueError("dask has no certificates for TLS in its configuration")
                address = scheduler
            client = stack.enter_context(Client(address, set_as_default=False, timeout=_CONNECTION_S))
            client.wait_for_workers(1, timeout=_WORKER_S)
        except InputError:
            raise
        except RuntimeError as error:
            raise InputError(
                f"The worker processes do not start ({error}); a script that computes a data set has to do so under "
                '`if __name__ == "__main__":`, because they import it.'
            ) from None
        except (OSError, ValueError, TimeoutError) as error:
            raise InputError(
                f"No dask worker at {scheduler or 'this machine'} ({error}); start `dask scheduler` and `dask worker` "
                "there and give the address as tcp://host:port, or leave it out to use this machine's cores."
            ) from None
        yield client


def _local_cluster(workers: int) -> LocalCluster:
    allowed, needed = resource.getrlimit(resource.RLIMIT_NOFILE)[0], _FILES + _FILES_A_WORKER * workers
    if allowed not in (resource.RLIM_INFINITY, -1) and allowed < needed:  # dask would try again and again
        raise InputError(
            f"{workers} workers need {needed} open files and {allowed} are allowed; raise the limit, as with "
            f"`ulimit -n {needed}`, or take fewer workers."
        )
    with dask.config.set({"distributed.worker.profile.enabled": False}):  # a statistical profile of no use here
        return LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            memory_limit=WORKER_MEMORY,
            dashboard_address=":0",
            silence_logs=logging.CRITICAL,
            preload=[_IGNORE_INTERRUPT],
        )


def _fill(store: CaseStore, chunks: list[range], client: Client, options: dict, progress: Progress | None) -> None:
    pieces = _pieces(store.table, chunks)
    solved: defaultdict[range, dict[range, dict[str, np.ndarray]]] = defaultdict(dict)
    inputs = tuple(column.name for column in store.table.columns)
    asked: dict[Any, tuple[range, range]] = {}
    running = as_completed(loop=client.loop)
    done, total = 0, sum(map(len, chunks))

    def ask() -> None:
        threads = sum(client.nthreads().values())
        while len(asked) < _PIECES_A_THREAD * max(threads, 1) and (next_piece := next(pieces, None)):
            chunk, piece, cases = next_piece
            arguments = {**options, "inputs": inputs, "asked_by": provenance()}
            future = client.submit(_evaluation(), cases, **arguments, pure=False, retries=_RETRIES)
            asked[future.key] = chunk, piece
            running.add(future)

    ask()
    for future in running:
        chunk, piece = asked.pop(future.key)
        parts = solved[chunk]
        parts[piece] = _result(future, piece)
        if sum(map(len, parts)) == len(chunk):
            ordered = [parts[cases] for cases in sorted(parts, key=lambda cases: cases.start)]
            store.write(chunk, {name: np.concatenate([part[name] for part in ordered]) for name in ordered[0]})
            del solved[chunk]
        ask()
        done += len(piece)
        if progress:
            progress(done, total)


def _evaluation() -> Callable[..., dict[str, np.ndarray]]:
    """`results.evaluate`, imported only where it runs, so that a worker without this package can read the task."""

    def evaluate(cases: np.ndarray, **arguments: Any) -> dict[str, np.ndarray]:  # nested, so it is sent by its value
        from gtm_fmu.datasets import results

        return results.evaluate(cases, **arguments)

    return evaluate


def _pieces(table: Cases, chunks: list[range]) -> Iterator[tuple[range, range, np.ndarray]]:
    """Chunk, numbers and rows of the cases of each task; rows by the chunk, as a Sobol sequence is run through anew."""
    size = table.block(PIECE)
    for chunk in chunks:
        rows = table.rows(chunk.start, chunk.stop)
        for start in range(0, len(chunk), size):
            yield chunk, chunk[start : start + size], rows[start : start + size]


def _result(future: Future, piece: range) -> dict[str, np.ndarray]:
    at = f"at cases {piece.start} to {piece.stop - 1}"
    try:
        return future.result()
    except (InputError, *_LOST):
        raise
    except ModuleNotFoundError as error:
        raise InputError(
            f"A worker has no module {error.name}; install gtm-fmu {provenance()['gtm_fmu_version']} on every "
            "worker and give the same command again, finished chunks are kept."
        ) from None
    except KilledWorker:
        raise _unfinished(f"Workers died again and again {at}") from None
    except Exception as error:
        raise _unfinished(f"A worker failed {at} ({type(error).__name__}: {error})") from None


def _unfinished(reason: str) -> InputError:
    return InputError(f"{reason}; finished chunks are kept, and the same command continues.")
