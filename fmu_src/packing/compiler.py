"""Compiling the sources of a native FMU: this platform with its own compiler, others with Zig's."""

import itertools
import logging
import os
import posixpath
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import psutil

from fmu_src.packing.archive import digest
from fmu_src.slaves.slave import platform_folder
from gtm_fmu.errors import InputError
from gtm_fmu.files import temporary_folder

FLAGS = ("-std=c99", "-O2", "-g0", "-fvisibility=hidden")
_ELF = ("-shared", "-Wl,-Bsymbolic", "-Wl,--build-id=none", "-Wl,-z,defs")
"""An FMU calls its own functions, whatever else a process has loaded."""
_WINDOWS = ("-shared", "-nostdlib", "-rtlib=compiler-rt", "-Wl,-e,DllMainCRTStartup")
"""With the C library of Windows itself and windows.c: Zig need not compile one, which takes minutes."""

LONGEST_S = 600
"""A compiler may take so long for one file; Zig's first build of a platform takes some seconds longer."""

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Platform:
    """A platform: what Zig calls it, its folder under ``binaries`` in FMI 2.0 (None: no name there) and 3.0."""

    target: str
    fmi2: str | None
    fmi3: str
    suffix: str = ".so"
    flags: tuple[str, ...] = ("-fPIC",)
    link_flags: tuple[str, ...] = _ELF
    libraries: tuple[str, ...] = ("-lm",)
    added: str | None = None
    """A C file beside this module that is linked with the sources."""

    def folder(self, fmi: int) -> str | None:
        """Name of the folder under ``binaries``."""
        return self.fmi2 if fmi == 2 else self.fmi3


PLATFORMS = (
    Platform("x86_64-linux-gnu.2.17", "linux64", "x86_64-linux"),
    Platform("x86_64-linux-musl", None, "x86_64-linux-musl"),
    Platform("aarch64-linux-gnu.2.17", "aarch64-linux", "aarch64-linux"),
    Platform("x86_64-windows-gnu", "win64", "x86_64-windows", ".dll", (), _WINDOWS, ("-lucrtbase",), "windows.c"),
    Platform("x86_64-macos", "darwin64", "x86_64-darwin", ".dylib", link_flags=("-shared",)),
    Platform("aarch64-macos", "aarch64-darwin", "aarch64-darwin", ".dylib", link_flags=("-shared",)),
)
"""Of the FMUs."""

BROWSER = Platform(
    "wasm32-wasi",
    None,
    "wasm32-wasi",
    ".wasm",
    flags=(),
    link_flags=("-mexec-model=reactor", "-Wl,--export-dynamic", "-Wl,--export=malloc", "-Wl,--strip-all"),
)
"""WebAssembly without a main program; it asks nothing of its host."""


def host_platform() -> Platform:
    """The platform that this process runs on.

    Raises:
        InputError: not one of `PLATFORMS`.
    """
    here = platform_folder()
    names = {name: platform for platform in reversed(PLATFORMS) for name in (platform.fmi2, platform.fmi3) if name}
    if here not in names:
        raise InputError(f"FMUs are not built for {here}: build on one of {', '.join(sorted(names))}.")
    return names[here]


def host_binary(name: str, sources: dict[str, bytes], libraries: Sequence[str] = ()) -> dict[Platform, bytes]:
    """The shared library for this platform, by its own compiler (environment variable CC, default cc).

    Args:
        libraries: flags for what it is linked with besides the C library and that of mathematics.

    Raises:
        InputError: no compiler, or the compiler fails.
    """
    platform = host_platform()
    try:
        return {platform: _compile(shlex.split(os.environ.get("CC", "cc")), platform, name, sources, libraries)}
    except FileNotFoundError:
        raise InputError(
            "An FMU needs a C compiler and none was found: install one (for instance gcc), or the extra "
            "`gtm-fmu[cross]` and build for all platforms."
        ) from None


def all_binaries(
    name: str, sources: dict[str, bytes], fmi: int, progress: Callable[[int, int], None] | None = None
) -> dict[Platform, bytes]:
    """The shared libraries for all `PLATFORMS`, by Zig; one that fails is left out, and the log says why.

    Args:
        progress: called with the number of platforms that are finished and of all.

    Raises:
        InputError: Zig is not installed, or no platform could be built.
    """
    _check_zig("Building for all platforms")
    named = [platform for platform in PLATFORMS if platform.folder(fmi)]
    for platform in PLATFORMS:
        if platform not in named:
            log.warning("%s is left out: FMI %d.0 has no name for it.", platform.target, fmi)

    def build(platform: Platform) -> bytes | InputError:
        try:
            return _compile([*_zig(platform), "-s"], platform, name, sources)
        except InputError as error:
            return error

    binaries, reason = {}, ""
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for done, (platform, built) in enumerate(zip(named, pool.map(build, named), strict=True), 1):
            if isinstance(built, bytes):
                binaries[platform] = built
            else:
                reason = str(built)
                log.warning("%s is left out: %s", platform.target, reason)
            if progress:
                progress(done, len(named))
    if not binaries:
        raise InputError(f"No platform could be built, the last one because: {reason}")
    return binaries


def browser_binary(name: str, sources: dict[str, bytes]) -> bytes:
    """A WebAssembly module that exports the functions which a shared library would.

    Raises:
        InputError: Zig is not installed, or it fails.
    """
    _check_zig("Compiling for a browser")
    return _compile(_zig(BROWSER), BROWSER, name, sources)


def _check_zig(purpose: str) -> None:
    if find_spec("ziglang") is None:
        raise InputError(f"{purpose} needs Zig: install the extra `gtm-fmu[cross]`.")


def _zig(platform: Platform) -> list[str]:
    return [sys.executable, "-m", "ziglang", "cc", "-target", platform.target]


def _compile(
    command: Sequence[str],
    platform: Platform,
    name: str,
    sources: dict[str, bytes],
    libraries: Sequence[str] = (),
) -> bytes:
    """One shared library; compiled with relative paths, so that nothing of this machine gets into it."""
    if platform.added:
        sources = sources | {platform.added: Path(__file__).with_name(platform.added).read_bytes()}
    paths = sorted(path for path in sources if path.endswith(".c"))
    with temporary_folder() as folder:
        for path, content in sources.items():
            Path(folder, path).parent.mkdir(parents=True, exist_ok=True)
            Path(folder, path).write_bytes(content)
        compiler = [*command, *FLAGS, *platform.flags]
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            objects = list(pool.map(lambda path: _object(compiler, path, sources, folder), paths))
        library = f"{name}{platform.suffix}"
        linked = [*objects, *platform.libraries, *libraries]
        _run([*compiler, *platform.link_flags, "-o", library, *linked], folder)
        return Path(folder, library).read_bytes()


def _object(compiler: Sequence[str], path: str, sources: dict[str, bytes], folder: Path) -> str:
    """The compiled file in the folder; kept in this process, since FMUs of the same model or core share most files."""
    name = Path(path).with_suffix(".o").name
    key = (shutil.which(compiler[0]) or "", *compiler, digest(with_includes(path, sources)))
    if key in _OBJECTS:
        Path(folder, name).write_bytes(_OBJECTS[key])
    else:
        _run([*compiler, "-I.", "-c", path, "-o", name], folder)
        _OBJECTS[key] = Path(folder, name).read_bytes()
    return name


_OBJECTS: dict[tuple[str, ...], bytes] = {}
_INCLUDE = re.compile(rb'^#include "([^"]+)"', re.MULTILINE)


def with_includes(path: str, sources: dict[str, bytes]) -> dict[str, bytes]:
    """A file and all of the sources that it includes, directly or not."""
    found, open_paths = {}, [path]
    while open_paths:
        at = open_paths.pop()
        found[at] = sources[at]
        named = (name.decode() for name in _INCLUDE.findall(sources[at]))
        paths = (path for name in named for path in (name, posixpath.join(posixpath.dirname(at), name)))
        open_paths += [path for path in paths if path in sources and path not in found]
    return found


def _run(command: Sequence[str], folder: Path) -> None:
    compiler = " ".join(itertools.takewhile(lambda word: word not in FLAGS, command))
    with subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE) as run:
        try:
            output = run.communicate(timeout=LONGEST_S)[1].decode(errors="replace")
        except subprocess.TimeoutExpired:
            for process in (*psutil.Process(run.pid).children(recursive=True), run):
                process.kill()
            raise InputError(
                f"The compiler {compiler} had not finished after {LONGEST_S} s and was stopped: try another one "
                "(environment variable CC)."
            ) from None
    if run.returncode:
        lines = output.strip().splitlines() or [f"exit code {run.returncode}"]
        first = next((line for line in lines if "error" in line), lines[0])
        raise InputError(f"The compiler {compiler} failed ({first}).")
