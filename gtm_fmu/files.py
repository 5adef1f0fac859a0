"""Files and folders that are written: in one piece or not at all, and never in the place of anything but a file.

A symbolic link is followed: it stays, and the file that it names is written. Folders, devices, pipes, sockets and
addresses of other machines are refused.
"""

import errno
import os
import re
import shutil
import stat
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from gtm_fmu.errors import InputError

_ADDRESS = re.compile(r"[A-Za-z][A-Za-z0-9+.-]+:")
_FULL = (errno.ENOSPC, errno.EDQUOT)
_LONGEST_SHOWN = 200


def write_whole(path: Path, write: Callable[[Path], object]) -> None:
    """Let ``write`` make a file beside ``path``, and put that in its place.

    Raises:
        InputError: it cannot be written, or what is there is no ordinary file.
    """
    place = _place(path)
    with _told(path):
        draft = _draft(place)
        try:
            write(draft)
            with suppress(FileNotFoundError):
                shutil.copymode(place, draft)
            os.replace(draft, place)
        finally:
            with suppress(OSError):
                draft.unlink()


def check_writable(path: str | Path) -> Path:
    """The path, if `write_whole` can write there, its folder made; to be asked before a long computation.

    Raises:
        InputError: it cannot be written, or what is there is no ordinary file.
    """
    path = Path(path)
    place = _place(path)
    folder = place.parent
    with _told(path):
        if not folder.parent.is_dir():  # a name with two folders that are missing is taken for a mistake
            raise FileNotFoundError(errno.ENOENT, f"there is no folder {_shown(folder.parent)}")
        folder.mkdir(exist_ok=True)
        _probe(_draft(place))
    return path


def check_kept(path: Path, *sources: Path) -> None:
    """Refuse to write a file that the same command reads, by whichever name, or into a store that it reads.

    Raises:
        InputError: it is one of them, or lies in one of them.
    """
    place = real_path(path)
    for source in sources:
        with suppress(OSError):
            if place.is_relative_to(real_path(source)) or place.samefile(source):
                raise InputError(f"{_shown(path)} is read by this command and is kept; name another file to write.")


def writable_folder(path: str | Path) -> Path:
    """The folder, made when missing.

    Raises:
        InputError: it cannot be made or written.
    """
    folder = Path(path)
    place = real_path(folder)
    with _told(folder):
        place.mkdir(parents=True, exist_ok=True)
        _probe(_draft(place / "folder"))
    return folder


@contextmanager
def temporary_folder() -> Iterator[Path]:
    """A folder to build in, removed at the end.

    Raises:
        InputError: there is no room for what is written to it.
    """
    try:
        with tempfile.TemporaryDirectory(prefix="gtm_fmu_") as folder:
            yield Path(folder)
    except OSError as error:
        if error.errno not in _FULL and "temporary directory" not in str(error):  # all of /tmp, /var/tmp ... are full
            raise
        place = tempfile.tempdir or os.environ.get("TMPDIR", "/tmp")
        raise InputError(
            f"There is no room in the temporary folder '{place}' ({error.strerror}): free some, or choose another one "
            "(environment variable TMPDIR)."
        ) from None


def real_path(path: Path) -> Path:
    """The absolute path at the end of all symbolic links.

    Raises:
        InputError: it is the address of another machine.
    """
    if len(path.parts) > 1 and _ADDRESS.fullmatch(path.parts[0]) and not os.path.lexists(path.parts[0]):
        raise InputError(f"{_shown(path)} is an address; only files and folders of this machine are written.")
    return Path(os.path.realpath(path))


def _place(path: Path) -> Path:
    """Where a file of that name is written."""
    place = real_path(path)
    with _told(path), suppress(FileNotFoundError):
        mode = path.stat().st_mode
        if stat.S_ISDIR(mode):
            raise InputError(f"{_shown(path)} is a folder; name a file in it.")
        if not stat.S_ISREG(mode):
            raise InputError(f"{_shown(path)} is {_kind(mode)}, which is not replaced; name an ordinary file.")
        if not os.access(place, os.W_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
    return place


def _kind(mode: int) -> str:
    kinds = {"a pipe": stat.S_ISFIFO, "a socket": stat.S_ISSOCK}
    return next((name for name, holds in kinds.items() if holds(mode)), "a device")


def _draft(place: Path) -> Path:
    return place.with_name(f".{place.stem[:30]}.{os.getpid()}.partial")


def _probe(draft: Path) -> None:
    draft.touch()
    draft.unlink()


@contextmanager
def _told(path: Path) -> Iterator[None]:
    """An error of the system as one sentence."""
    try:
        yield
    except (OSError, RecursionError) as error:  # the latter from a thousand folders that are all missing
        reason = getattr(error, "strerror", None) or error
        is_full = getattr(error, "errno", None) in _FULL
        advice = "make room, or choose another folder" if is_full else "choose a folder you may write to"
        raise InputError(f"Cannot write {_shown(path)} ({reason}); {advice}.") from None


def _shown(path: Path) -> str:
    text = str(path)
    return text if len(text) <= _LONGEST_SHOWN else f"{text[: _LONGEST_SHOWN // 2]}...{text[-_LONGEST_SHOWN // 2 :]}"
