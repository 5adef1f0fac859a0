"""A machine that is short of something: a full device, a closed pipe, few open files. One sentence each time."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

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
