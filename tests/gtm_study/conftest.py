"""Asking the command line: in this process, or as a user does."""

import json
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

from fmu_src.fmus import build_fmu
from gtm_fmu.core.configuration import Configuration
from gtm_study.commands import cli

ENTRY_POINT = Path(sys.executable).with_name("gtm-fmu")


@dataclass(frozen=True)
class Answer:
    """What a command left."""

    code: int
    out: str
    err: str

    @property
    def json(self) -> dict:
        """The one object on standard output, which holds nothing else."""
        assert self.err == ""
        assert self.out.count("\n") == 1
        return json.loads(self.out)


@pytest.fixture(scope="module")
def fmus(tmp_path_factory) -> dict[str, Path]:
    """GtmDynamics and GtmSurrogate."""
    folder = tmp_path_factory.mktemp("fmus")
    return {name: build_fmu(name, folder) for name in ("dynamics", "surrogate")}


@pytest.fixture
def ask(monkeypatch, capsys):
    """A command of gtm-fmu, given in one string or in its parts, run in this process."""

    def run(*command) -> Answer:
        words = command[0].split() if len(command) == 1 else [str(word) for word in command]
        monkeypatch.setattr(sys, "argv", ["gtm-fmu", *words])
        capsys.readouterr()
        with pytest.raises(SystemExit) as end:
            cli.main()
        return Answer(end.value.code, *capsys.readouterr())

    return run


@pytest.fixture
def ask_installed(tmp_path):
    """The installed entry point, run in an empty folder."""

    def run(*words: str) -> Answer:
        done = subprocess.run([ENTRY_POINT, *words], cwd=tmp_path, capture_output=True, text=True, timeout=120)
        return Answer(done.returncode, done.stdout, done.stderr)

    return run


@pytest.fixture(scope="module")
def centred() -> Configuration:
    """The study's airframe with its centre of gravity on the plane of symmetry, 0.1416 in from where it is (SPEC 3)."""
    return Configuration(cg_offset_ft=(0.0, 0.1416 / 12, 0.0))
