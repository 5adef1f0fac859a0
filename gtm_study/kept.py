"""Finished parts of a long run, each kept in a folder under a hash of all that it follows from.

A run that was stopped, or that is given again, takes from there what is finished and still holds. (What stops within a
part has its own ways: a data set goes on with its store, a thrust map and indices with the blocks they had solved.)
"""

import hashlib
import json
import time
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

from gtm_fmu.airframe.provenance import provenance
from gtm_fmu.core import library_path
from gtm_fmu.errors import InputError
from gtm_fmu.files import writable_folder
from gtm_study.files import write_text

PACKAGES = ("gtm_fmu", "surrogate", "fmu_src", "sensitivity", "gtm_study")
_ROOT = Path(__file__).parents[1]
PARTS = "parts"
"""The folder of the finished parts, by which that of a run is known."""
_MADE = (".pyc", ".so", ".dll", ".dylib", ".o")


@cache
def code() -> str:
    """Hash of the packages: modules, pages, data, the compiled core and the numbers' libraries."""
    facts = json.dumps([provenance(), *(version(name) for name in ("numpy", "scipy"))])
    return hashlib.sha256(f"{facts}{hashed([*sources(_ROOT), library_path()])}".encode()).hexdigest()


def hashed(files: Iterable[Path]) -> str:
    """Hash of what is in some files."""
    digest = hashlib.sha256()
    for path in sorted(files):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def sources(root: Path) -> list[Path]:
    """All files of the packages but what Python and compilers make of them."""
    files = (path for name in PACKAGES for path in (root / name).rglob("*") if path.is_file())
    return [path for path in files if path.suffix not in _MADE and "__pycache__" not in path.parts]


class Part(NamedTuple):
    """A finished part.

    Attributes:
        values: what it computed, as JSON holds them.
        files: that it wrote, by their names in the folder.
        seconds: that it took.
    """

    values: dict[str, Any]
    files: tuple[str, ...]
    seconds: float


def check_run_folder(path: Path) -> None:
    """Refuse a folder that is neither new nor empty nor that of an earlier run; nothing is made.

    Raises:
        InputError: it holds what is not of a run.
    """
    with suppress(OSError):
        if not (path / PARTS).is_dir() and any(path.iterdir()):
            raise InputError(f"{path} holds files that are not of such a run; name a new or an empty folder.")


def run_folder(path: Path) -> Path:
    """The folder of a long run, made when missing.

    Raises:
        InputError: as `check_run_folder`, or it cannot be written.
    """
    check_run_folder(path)
    writable_folder(path / PARTS)
    return path


class Kept:
    """The kept parts of a run in a folder.

    Args:
        folder: made if it is not there; the parts are JSON files in ``parts``.
        facts: what all parts follow from, beside the code.
    """

    def __init__(self, folder: Path, **facts: Any):
        self.folder = folder
        self._parts = writable_folder(folder / PARTS)
        self._facts = facts

    def key(self, name: str, facts: Mapping[str, Any]) -> str:
        """Hash of what a part follows from."""
        said = json.dumps([code(), name, self._facts, dict(facts)], sort_keys=True, default=repr)
        return hashlib.sha256(said.encode()).hexdigest()

    def find(self, name: str, **facts: Any) -> Part | None:
        """A part that is finished and whose files are all there, as they were written; else None."""
        with suppress(OSError, ValueError, LookupError, TypeError, RecursionError):
            part = json.loads(self._path(name).read_text(encoding="utf-8"))
            if part["key"] == self.key(name, facts) and all(
                _size(self.folder / file) == size for file, size in part["files"].items()
            ):
                return Part(dict(part["values"]), tuple(part["files"]), float(part["seconds"]))
        return None

    def part(
        self, name: str, compute: Callable[[], dict[str, Any]], files: Callable[[], list[Path]] = list, **facts: Any
    ) -> dict[str, Any]:
        """The values of a part: kept ones, or computed and then kept.

        Args:
            name: of its file.
            compute: gives values that JSON can hold, and writes the part's files.
            files: which files it wrote; asked when it is finished.
            facts: what this part follows from.
        """
        kept = self.find(name, **facts)
        if kept is not None:
            return kept.values
        started = time.monotonic()
        values = compute()
        seconds = round(time.monotonic() - started, 1)
        sizes = {path.relative_to(self.folder).as_posix(): _size(path) for path in files()}
        part = {"key": self.key(name, facts), "files": sizes, "seconds": seconds, "values": values}
        write_text(json.dumps(part, allow_nan=False), self._path(name))
        return dict(json.loads(json.dumps(values)))

    def _path(self, name: str) -> Path:
        return self._parts / f"{name}.json"


def _size(path: Path) -> int:
    """Of a file in bytes, of a folder the number of its files."""
    return sum(1 for entry in path.rglob("*") if entry.is_file()) if path.is_dir() else path.stat().st_size
