"""Files that are written in one piece or not at all."""

import os
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from gtm_fmu.errors import InputError


def write_whole(path: Path, write: Callable[[Path], object]) -> None:
    """Let ``write`` make a file beside ``path``, and put that in its place.

    Raises:
        InputError: it cannot be written.
    """
    partial = path.with_name(f".{path.stem}.{os.getpid()}.partial{path.suffix}")
    try:
        write(partial)
        os.replace(partial, path)
    except OSError as error:
        reason = error.strerror or error
        raise InputError(f"Cannot write {path} ({reason}); choose a folder you may write to.") from None
    finally:
        with suppress(OSError):
            partial.unlink()
