"""Control-C during a trim over an FMU and during its steps."""

import os
import signal
import subprocess
import sys
import threading

import pytest

from fmu_src.fmus import build_fmu
from gtm_fmu.aircraft.client import FmuClient
from gtm_fmu.interrupt import held_interrupt
from gtm_fmu.trims.fmu_trimmer import FmuTrimmer


class Interrupted:
    """An evaluator that gets a Control-C at one of its evaluations."""

    def __init__(self, fmu, at: int):
        self._fmu, self._at, self.count = fmu, at, 0

    def evaluate(self, x, u):
        self.count += 1
        if self.count == self._at:
            os.kill(os.getpid(), signal.SIGINT)
        return self._fmu.evaluate(x, u)


@pytest.fixture(scope="module")
def fmu(tmp_path_factory):
    with FmuClient(build_fmu("dynamics", tmp_path_factory.mktemp("fmu"))) as client:
        yield client


@pytest.fixture
def heard():
    """Control-C raises, even in tests that run in the background of a shell, which ignores it there."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.parametrize("at", [1, 5, 20, 40])
def test_a_trim_is_stopped_wherever_it_is(fmu, heard, at):
    evaluator = Interrupted(fmu, at)
    with pytest.raises(KeyboardInterrupt):
        FmuTrimmer(evaluator).trim(10000.0, 118.5)
    assert evaluator.count >= at
    assert FmuTrimmer(fmu).trim(10000.0, 118.5).feasible  # the FMU is as good as before


def test_a_simulation_is_stopped(fmu, tmp_path):
    """A real Control-C while a process steps the pythonfmu FMU: the slave's own Python never sees it."""
    script = (
        "import signal, sys\nfrom gtm_fmu import FmuClient\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "with FmuClient(sys.argv[1]) as fmu:\n"
        "    try:\n        print('ready', flush=True)\n        fmu.simulate(1e4, 0.01, ['air.tas'])\n"
        "    except KeyboardInterrupt:\n"
        "        fmu.step(0.01)\n        print('stopped', [message.text for message in fmu.messages])\n"
    )
    command = [sys.executable, "-c", script, str(build_fmu("dynamics", tmp_path))]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as running:
        assert running.stdout.readline() == "ready\n"
        running.send_signal(signal.SIGINT)
        out, _ = running.communicate(timeout=60)
    assert (running.returncode, out) == (0, "stopped []\n")


def test_nothing_is_held_outside_the_main_thread():
    seen = []

    def work():
        with held_interrupt():
            seen.append(signal.getsignal(signal.SIGINT))

    before = signal.getsignal(signal.SIGINT)
    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert seen == [before]
