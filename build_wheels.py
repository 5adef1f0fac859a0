"""Build the source archive and a wheel for each platform into a folder, all from this machine.

Zig compiles the libraries for the platforms that this machine is not; the wheels hold no machine code of Python's, so
one serves every version of it. Run it from a checkout: python build_wheels.py dist
"""

import argparse
import os
import shutil
import subprocess
import sys
import tarfile
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple


class Platform(NamedTuple):
    """A platform as Zig calls it, and as pip does."""

    target: str
    tag: str


PLATFORMS = (
    Platform("x86_64-linux-gnu.2.17", "manylinux_2_17_x86_64.manylinux2014_x86_64"),
    Platform("aarch64-linux-gnu.2.17", "manylinux_2_17_aarch64.manylinux2014_aarch64"),
    Platform("x86_64-linux-musl", "musllinux_1_1_x86_64"),
    Platform("aarch64-linux-musl", "musllinux_1_1_aarch64"),
    Platform("x86_64-macos.11.0", "macosx_11_0_x86_64"),
    Platform("aarch64-macos.11.0", "macosx_11_0_arm64"),
    Platform("x86_64-windows-gnu", "win_amd64"),
)


NO_SOURCES = (".git", ".venv", "build", "dist", "*.egg-info", "__pycache__", ".*_cache")


def build_sdist(folder: Path) -> Path:
    """The source archive in a folder, from a copy of this tree: metadata of the build would hide the installed ones."""
    with TemporaryDirectory() as scratch:
        tree = shutil.copytree(Path(__file__).parent, Path(scratch, "tree"), ignore=shutil.ignore_patterns(*NO_SOURCES))
        return folder / _built("sdist", folder, tree)


def build_wheel(sdist: Path, platform: Platform, folder: Path) -> Path:
    """The wheel of a platform, from the source archive alone."""
    names = {"GTM_FMU_ZIG_TARGET": platform.target, "GTM_FMU_WHEEL_PLATFORM": platform.tag}
    with TemporaryDirectory() as scratch, tarfile.open(sdist) as archive:
        archive.extractall(scratch, filter="data")
        return folder / _built("wheel", folder, next(Path(scratch).iterdir()), **names)


def _built(kind: str, folder: Path, tree: Path, **environment: str) -> str:
    """Name of the file that setuptools builds of a tree."""
    code = f"from setuptools import build_meta; print(build_meta.build_{kind}({str(folder)!r}))"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tree, env={**os.environ, **environment}, capture_output=True, text=True
    )
    if done.returncode:
        sys.exit(f"The build failed: {done.stderr.strip().splitlines()[-1]}")
    return done.stdout.splitlines()[-1]


def main() -> None:
    """Build all, or the platforms that are named."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="of the archive and the wheels")
    parser.add_argument("--only", nargs="+", default=[each.tag for each in PLATFORMS], help="tags of wheels")
    given = parser.parse_args()
    unknown = set(given.only) - {each.tag for each in PLATFORMS}
    if unknown:
        parser.error(
            f"there is no platform {', '.join(sorted(unknown))}; known are {', '.join(p.tag for p in PLATFORMS)}"
        )
    folder = given.folder.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    sdist = build_sdist(folder)
    print(f"{sdist.name}: {sdist.stat().st_size / 1e6:.2f} MB")
    for platform in PLATFORMS:
        if platform.tag in given.only:
            wheel = build_wheel(sdist, platform, folder)
            print(f"{wheel.name}: {wheel.stat().st_size / 1e6:.2f} MB", flush=True)


if __name__ == "__main__":
    main()
