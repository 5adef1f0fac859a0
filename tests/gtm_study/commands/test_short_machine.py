"""A machine that is short of something: a full device, a closed pipe, few open files. One sentence each time."""

import os
import re
import resource
import subprocess
import sys
from pathlib import Path

import pytest

from gtm_study.commands import machine

pytestmark = pytest.mark.slow

COMMAND = Path(sys.executable).with_name("gtm-fmu")
AT = "--altitude-ft 10000"


def run(command: str, **options):
    options = {"stderr": subprocess.PIPE, "text": True, "timeout": 120} | options
    return subprocess.run([COMMAND, *command.split()], **options)


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="there is no /dev/full here")
@pytest.mark.parametrize(
    "command", ["--help", "--version", f"envelope {AT} --rudder-deg 10 10 --json", f"predict {AT}"]
)
def test_full_device(command):
    with open("/dev/full", "w") as full:
        done = run(command, stdout=full)
    assert done.returncode == 2
    assert done.stderr.startswith("gtm-fmu: ")
    assert "(No space left on device)" in done.stderr
    assert done.stderr.count("\n") == 1


def test_reader_that_has_seen_enough():
    """As `gtm-fmu ... | head -0`: the process ends in silence."""
    read, write = os.pipe()
    os.close(read)
    with os.fdopen(write, "w") as pipe:
        done = run(f"envelope {AT} --rudder-deg 10 10 --json", stdout=pipe)
    assert "Traceback" not in done.stderr
    assert done.stderr.count("\n") <= 1


def test_few_open_files(tmp_path):
    """`ulimit -n 32` leaves too few for a cluster of workers."""
    script = f"ulimit -n 32; {COMMAND} dataset {tmp_path}/s.zarr --cases 2 --rudder-deg -10 10"
    done = subprocess.run(["bash", "-c", script], capture_output=True, text=True, timeout=120)
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert done.stderr.strip().splitlines()[-1].startswith("gtm-fmu: ")


EVERY = {
    "trim": f"{AT} --tas-kt 118.5",
    "linearize": f"{AT} --tas-kt 118.5",
    "envelope": AT,
    "predict": AT,
    "build": "dynamics",
    "train": "table.csv --inputs a --outputs y --output o.json",
    "export": "model.json --c --output o.c",
    "dataset": "o.zarr --cases 2",
    "map limits": f"{AT} --plot o.png",
    "thrust-map": "",
    "protocol": "",
    "networks": "",
    "surrogates": "",
    "study": "",
}


@pytest.mark.parametrize("limit", ["-v 600000", "-n 16"])
@pytest.mark.parametrize("command", ["train", "envelope"])
def test_a_limit_of_the_shell(tmp_path, limit, command):
    script = f"ulimit {limit}; {COMMAND} {command} {EVERY[command]}"
    done = subprocess.run(["bash", "-c", script], capture_output=True, text=True, timeout=120, cwd=tmp_path)
    assert done.returncode == 2
    assert re.fullmatch(rf"gtm-fmu: `{command}` needs \d+ .* are allowed; .*`ulimit {limit[:2]} \d+`\.\n", done.stderr)


@pytest.mark.parametrize("command", EVERY)
@pytest.mark.parametrize("kind", [resource.RLIMIT_AS, resource.RLIMIT_NOFILE])
def test_every_command_begins_with_its_limits(ask, monkeypatch, tmp_path, command, kind):
    monkeypatch.chdir(tmp_path)
    plenty = resource.RLIM_INFINITY, resource.RLIM_INFINITY
    monkeypatch.setattr(machine.resource, "getrlimit", lambda asked: (16, 16) if asked == kind else plenty)
    answer = ask(f"{command} {EVERY[command]}")
    assert (answer.code, answer.out) == (2, "")
    assert f"`{command.split()[-1]}` needs" in answer.err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("error", "sentence"),
    [
        (MemoryError(), "not enough memory"),
        (ImportError("libtorch_cpu.so: failed to map segment from shared object"), "not enough memory"),
        (RuntimeError("can't start new thread"), "not enough memory"),
        (OSError(12, "Cannot allocate memory"), "not enough memory"),
        (OSError(24, "Too many open files"), "too few open files"),
    ],
)
def test_a_shortage_in_the_middle(ask, monkeypatch, error, sentence):
    def short(*_, **__):
        raise ValueError("something else") from error

    monkeypatch.setattr("gtm_study.commands.envelope.given_failure", short)
    answer = ask(f"envelope {AT}")
    assert (answer.code, answer.out) == (2, "")
    assert sentence in answer.err
    assert answer.err.count("\n") == 1


def test_workers_need_open_files(ask, monkeypatch, tmp_path):
    monkeypatch.setattr(resource, "getrlimit", lambda _: (256, 256))
    monkeypatch.setattr("gtm_study.commands.command.check_limits", lambda _: None)
    answer = ask("dataset", tmp_path / "a.zarr", "--cases", 4, "--workers", 100)
    assert answer.code == 2
    assert "100 workers need 1632 open files and 256 are allowed" in answer.err


@pytest.mark.parametrize("command", ["--help", "--version", f"predict {AT}", f"trim {AT} --tas-kt 118.5"])
def test_closed_standard_output(command):
    done = subprocess.run(["bash", "-c", f"{COMMAND} {command} >&-"], capture_output=True, text=True, timeout=120)
    assert done.returncode == 2
    assert re.fullmatch(r"gtm-fmu: Standard output is closed; [^\n]+\n", done.stderr)


def test_closed_standard_error():
    """Nothing that was meant for it goes to standard output."""
    done = subprocess.run(["bash", "-c", f"{COMMAND} trim --bad 2>&-"], capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stdout) == (2, "")


@pytest.mark.parametrize("option", ["--splits", "--data-set-splits", "--rounds", "--jobs"])
def test_no_more_work_than_can_end(ask, monkeypatch, tmp_path, option):
    monkeypatch.chdir(tmp_path)
    answer = ask(f"protocol {option} 1000000000")
    assert (answer.code, answer.out) == (2, "")
    assert f"'{option}': 1000000000 is not in the range" in answer.err
    assert not list(tmp_path.iterdir())
