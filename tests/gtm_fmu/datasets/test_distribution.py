"""Data sets by dask: the values of the solver, whatever is killed on the way, on this machine or a user's cluster."""

import os
import signal
import subprocess
import sys
import time
from logging import CRITICAL
from pathlib import Path

import dask
import numpy as np
import psutil
import pytest
from distributed import Client, LocalCluster

from gtm_fmu.datasets import distribution, results
from gtm_fmu.datasets.distribution import compute
from gtm_fmu.datasets.store import CaseStore, open_cases
from gtm_fmu.errors import InputError
from tests.gtm_fmu.datasets import dataset_run
from tests.gtm_fmu.datasets.dataset_run import CHUNK, TABLE

pytestmark = pytest.mark.slow

OPTIONS = {"alpha_deg": [-5.0, 10.5], "phi_deg": [-30.0, 30.0]}
CHUNKS = -(-len(TABLE) // CHUNK)


def files(path: Path) -> dict[str, bytes]:
    return {str(file.relative_to(path)): file.read_bytes() for file in path.rglob("*") if file.is_file()}


@pytest.fixture(scope="module")
def expected(tmp_path_factory) -> dict[str, bytes]:
    """Every byte of the store, filled here from one call of the solver over all cases."""
    path = tmp_path_factory.mktemp("expected") / "a.zarr"
    store, found = CaseStore(path, TABLE, OPTIONS, CHUNK), results.evaluate(TABLE.rows(0, len(TABLE)))
    assert 0 < found["feasible"].sum() < len(TABLE)
    for cases in store.unfinished():
        store.write(cases, {name: values[cases.start : cases.stop] for name, values in found.items()})
    return files(path)


@pytest.fixture(scope="module")
def cluster():
    """A user's cluster with one worker of two threads."""
    with LocalCluster(1, 2, processes=False, protocol="tcp://", dashboard_address=":0") as cluster:
        yield cluster


@pytest.fixture
def address(cluster) -> str:
    return cluster.scheduler_address


def finished_chunks(path: Path) -> int:
    return len(list(path.glob("finished/c/*")))


@pytest.fixture
def run(tmp_path):
    """A run in a process of its own that has just finished its first chunks, and its store."""
    path = tmp_path / "a.zarr"
    command = [sys.executable, dataset_run.__file__, path]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        deadline = time.monotonic() + 120
        while not finished_chunks(path) and process.poll() is None and time.monotonic() < deadline:
            time.sleep(0.005)
        yield process, path
        process.kill()


def worker_processes(process: subprocess.Popen) -> list[psutil.Process]:
    children = psutil.Process(process.pid).children(recursive=True)
    return [child for child in children if "spawn_main" in " ".join(child.cmdline())]


class TestKilled:
    def test_run(self, run, expected, address):
        process, path = run
        workers = worker_processes(process)
        with pytest.raises(InputError, match=f"is being written by process {process.pid} on"):
            compute(path, TABLE, chunk=CHUNK)
        process.send_signal(signal.SIGKILL)
        process.wait()
        kept = int(open_cases(path).finished.sum())
        assert 0 < kept < len(TABLE)
        gone, alive = psutil.wait_procs(workers, timeout=20)
        assert (len(gone), alive) == (2, [])
        missing = compute(path, TABLE, chunk=CHUNK, scheduler=address)
        assert missing == len(TABLE) - kept
        assert files(path) == expected

    def test_one_worker(self, run, expected):
        process, path = run
        worker = worker_processes(process)[0]
        worker.kill()
        assert finished_chunks(path) < CHUNKS
        out, err = process.communicate(timeout=120)
        assert (process.returncode, out, err) == (0, f"{len(TABLE)}\n", "")
        assert not worker.is_running()
        assert files(path) == expected


def failing_at(case: int, fail):
    """`results.evaluate` that fails at one case."""
    evaluate, wanted = results.evaluate, TABLE.rows(case, case + 1)

    def evaluate_or_fail(cases: np.ndarray, **options):
        if (cases == wanted).all(axis=1).any():
            fail()
        return evaluate(cases, **options)

    return evaluate_or_fail


WITHOUT_PACKAGE = """
import sys
class Nowhere:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] == "gtm_fmu":
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)
sys.meta_path.insert(0, Nowhere())
assert "gtm_fmu" not in sys.modules
"""


def test_script_without_a_guard(tmp_path):
    """The worker processes import it and would compute, too."""
    script = tmp_path / "script.py"
    script.write_text(
        "from tests.gtm_fmu.datasets.dataset_run import TABLE, compute\ncompute('a.zarr', TABLE, workers=1)\n"
    )
    path = {"PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run(
        [sys.executable, script], cwd=tmp_path, env=os.environ | path, capture_output=True, text=True, timeout=120
    )
    assert "InputError: The worker processes do not start (Nanny failed to start.)" in done.stderr.splitlines()[-1]
    assert not (tmp_path / "a.zarr").exists()


class TestCluster:
    def test_of_the_user(self, tmp_path, address, expected):
        calls = []
        assert compute(tmp_path / "a", TABLE, chunk=CHUNK, scheduler=address, progress=lambda *done: calls.append(done))
        assert files(tmp_path / "a") == expected
        assert calls[-1] == (len(TABLE), len(TABLE))
        assert [done for done, _ in calls] == sorted(done for done, _ in calls)
        assert compute(tmp_path / "a", TABLE, chunk=CHUNK, scheduler=address) == 0

    def test_few_pieces_are_under_way(self, tmp_path, address, monkeypatch):
        submit, asked, under_way = Client.submit, [], []

        def counted(*arguments, **options):
            asked.append(None)
            return submit(*arguments, **options)

        monkeypatch.setattr(Client, "submit", counted)
        monkeypatch.setattr(distribution, "PIECE", 3)
        compute(
            tmp_path / "a",
            TABLE,
            chunk=CHUNK,
            scheduler=address,
            progress=lambda done, total: under_way.append(len(asked) - len(under_way) - 1),
        )
        assert len(asked) == 2 * CHUNKS - 1  # chunks of four cases in pieces of three and one, the last of two in one
        assert max(under_way) <= 4

    def test_exception(self, tmp_path, address, expected, monkeypatch):
        def fail():
            raise ZeroDivisionError("by zero")

        with monkeypatch.context() as patched:
            patched.setattr(results, "evaluate", failing_at(41, fail))
            reason = r"A worker failed at cases 40 to 43 \(ZeroDivisionError: by zero\); finished chunks are kept"
            with pytest.raises(InputError, match=reason):
                compute(tmp_path / "a", TABLE, chunk=CHUNK, scheduler=address)
        data = open_cases(tmp_path / "a").load()
        assert data.finished[:28].all()  # the window is of four chunks
        assert not data.finished[40:44].any()
        compute(tmp_path / "a", TABLE, chunk=CHUNK, scheduler=address)
        assert files(tmp_path / "a") == expected

    def test_workers_that_die_again_and_again(self, tmp_path, monkeypatch):
        monkeypatch.setattr(distribution, "_evaluation", lambda: failing_at(9, lambda: os._exit(1)))
        with (
            dask.config.set({"distributed.scheduler.allowed-failures": 0}),
            pytest.raises(InputError, match=r"Workers died again and again at cases .*; finished chunks are kept"),
        ):
            compute(tmp_path / "a", TABLE, chunk=CHUNK, workers=1)

    def test_lost_scheduler(self, tmp_path):
        with LocalCluster(1, 1, processes=False, protocol="tcp://", dashboard_address=":0") as cluster:

            def lose(done: int, total: int) -> None:
                if done == 2 * CHUNK:
                    cluster.close()

            reason = "The scheduler was lost; finished chunks are kept, and the same command continues"
            with pytest.raises(InputError, match=reason):
                compute(tmp_path / "a", TABLE, chunk=CHUNK, scheduler=cluster.scheduler_address, progress=lose)
        assert open_cases(tmp_path / "a").finished.sum() >= 2 * CHUNK  # two chunks, in whichever order they came

    def test_workers_without_the_package(self, tmp_path):
        with (
            LocalCluster(1, 1, preload=[WITHOUT_PACKAGE], dashboard_address=":0", silence_logs=CRITICAL) as cluster,
            pytest.raises(InputError, match=r"A worker has no module gtm_fmu; install gtm-fmu .* on every worker and"),
        ):
            compute(tmp_path / "a", TABLE, scheduler=cluster.scheduler_address)
        assert not list(tmp_path.iterdir())

    def test_without_workers(self, tmp_path, monkeypatch):
        monkeypatch.setattr(distribution, "_WORKER_S", 0.2)
        with (
            LocalCluster(n_workers=0, processes=False, protocol="tcp://", dashboard_address=":0") as cluster,
            pytest.raises(InputError, match=rf"No dask worker at {cluster.scheduler_address} .*start `dask scheduler`"),
        ):
            compute(tmp_path / "a", TABLE, scheduler=cluster.scheduler_address)
        assert not list(tmp_path.iterdir())

    @pytest.mark.parametrize("scheduler", ["nowhere", "tcp://", "tcp://127.0.0.1:1"])
    def test_bad_address(self, tmp_path, scheduler, monkeypatch):
        monkeypatch.setattr(distribution, "_CONNECTION_S", 0.2)
        with pytest.raises(InputError, match=f"No dask worker at {scheduler} "):
            compute(tmp_path / "a", TABLE, scheduler=scheduler)
        assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"workers": 0}, "0 workers were asked for; ask for 1 to 1024"),
        ({"workers": 1025}, "1025 workers were asked for; ask for 1 to 1024"),
        ({"alpha_deg": (10, -5)}, "alpha in deg 10 -5 are reversed"),
        ({"phi_deg": (-90, 0)}, "phi in deg -90 is outside"),
    ],
)
def test_bad_options(tmp_path, options, sentence):
    with pytest.raises(InputError, match=sentence):
        compute(tmp_path / "a", TABLE, **options)
    assert not list(tmp_path.iterdir())
