"""The core compiled for browsers."""

from functools import cache
from importlib.resources import files

from fmu_src.packing.compiler import browser_binary
from fmu_src.packing.native_sources import core_files
from gtm_fmu.core.sources import WHOLE


@cache
def core_module() -> bytes:
    """The core, as a WebAssembly module without imports; its exports are the public functions of its headers.

    Raises:
        InputError: Zig is not installed, or it fails.
    """
    ours = (files("gtm_study.explorer") / "web" / "explorer.c").read_bytes()
    return browser_binary("core", {**core_files(WHOLE), "explorer.c": ours})
