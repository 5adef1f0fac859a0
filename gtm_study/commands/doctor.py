"""`gtm-fmu doctor`: what is here of all that the commands can use, and what a missing part would need."""

import json
import os
import shlex
import shutil
import sys
from importlib.metadata import version
from importlib.util import find_spec
from typing import Annotated, NamedTuple

import psutil
import typer

from gtm_fmu.core.library import library_path
from gtm_fmu.extras import advice
from gtm_study.commands.command import NO_SOLUTION
from gtm_study.report.browser import BROWSERS


class Part(NamedTuple):
    """Something that commands use: what for, where it is (None: missing), and how to get it."""

    name: str
    purpose: str
    found: str | None
    advice: str


def _module(name: str, purpose: str) -> Part:
    found = version(name) if find_spec(name) else None
    return Part(name, purpose, found, advice(name) or f"pip install {name}")


def _program(names: tuple[str, ...], purpose: str, package: str) -> Part:
    found = next((path for name in names if (path := shutil.which(name))), None)
    return Part(names[0], purpose, found, f"apt-get install {package}")


def _core() -> Part:
    try:
        found = str(library_path())
    except FileNotFoundError:
        found = None
    return Part("compiled core", "everything", found, "pip install . (needs a C compiler), or a wheel")


def parts() -> list[Part]:
    """All of them, the indispensable ones first."""
    compiler = shlex.split(os.environ.get("CC", "cc"))[0]
    return [
        Part("Python", "everything", sys.version.split()[0], ""),
        _core(),
        _program((compiler,), "native FMUs for this platform", "gcc"),
        _module("ziglang", "FMUs for all platforms, the explorer"),
        _module("xarray", "data sets, maps, sensitivity, study"),
        _module("torch", "train, study, networks, protocol"),
        _module("onnx", "export as ONNX"),
        _module("sympy", "export as SymPy"),
        _module("pyarrow", "tables as Parquet"),
        _program(BROWSERS, "the study as PDF, tests of pages", "chromium"),
        _program(("wine64", "wine", "/usr/lib/wine/wine64"), "tests of Windows FMUs", "wine64"),
        _program(("qemu-aarch64-static", "qemu-aarch64"), "tests of FMUs for ARM", "qemu-user-static"),
        _program(("clang",), "tests with sanitizers", "clang"),
        _program(("node",), "tests of exported JavaScript", "nodejs"),
        *(_module(name, "tests of importers") for name in ("ecospy", "libcosimpy", "jsbsim")),
    ]


def doctor(
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")] = False,
) -> None:
    """What is here: the core, compilers, browsers, libraries; and what a missing part would need.

    The exit code is 0 if trims, envelopes and predictions work, else 3.
    """
    found = parts()
    cores, memory_gib = os.cpu_count(), psutil.virtual_memory().total / 2**30
    if as_json:
        machine = {"cores": cores, "memory_gib": round(memory_gib, 1)}
        print(
            json.dumps({"version": version("gtm-fmu"), "machine": machine, "parts": [part._asdict() for part in found]})
        )
    else:
        print(f"gtm-fmu {version('gtm-fmu')} on {cores} cores with {memory_gib:.1f} GiB of memory")
        for part in found:
            print(f"  {part.name:20} {part.found or f'missing, for {part.purpose}: {part.advice}'}")
    if not any(part.name == "compiled core" and part.found for part in found):
        raise typer.Exit(NO_SOLUTION)
