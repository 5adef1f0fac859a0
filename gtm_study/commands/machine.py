"""What a command needs of the machine, beside what the shell allows it (`ulimit`): said before it begins.

Libraries that run out of address space in the middle of their loading end the process, or fail in many words.
"""

import errno
import resource
from typing import NamedTuple

from gtm_fmu.errors import InputError


class Need(NamedTuple):
    """What a command takes at least, measured on two cores, with some room."""

    address_space_kb: int
    open_files: int


SMALL, LARGE = Need(1_000_000, 32), Need(2_500_000, 256)
LARGE_COMMANDS = ("train", "dataset", "protocol", "networks", "surrogates", "study")
"""These train with torch, or compute in processes of their own."""

_NO_MEMORY = (
    "failed to map segment",
    "cannot allocate memory",
    "can't allocate memory",
    "not enough memory",
    "can't start new thread",
)
"""What the loader of libraries, torch and Python's threads say, which raise no MemoryError."""


def check_limits(command: str) -> None:
    """Refuse a command that the limits of this process leave too little for.

    Raises:
        InputError: they do.
    """
    need = LARGE if command in LARGE_COMMANDS else SMALL
    address_space, open_files = (resource.getrlimit(kind)[0] for kind in (resource.RLIMIT_AS, resource.RLIMIT_NOFILE))
    if address_space not in (resource.RLIM_INFINITY, -1) and address_space < need.address_space_kb * 1024:
        raise InputError(
            f"`{command}` needs {need.address_space_kb} kB of address space and {address_space // 1024} are allowed; "
            f"raise the limit, as with `ulimit -v {need.address_space_kb}`."
        )
    if open_files not in (resource.RLIM_INFINITY, -1) and open_files < need.open_files:
        raise InputError(
            f"`{command}` needs {need.open_files} open files and {open_files} are allowed; raise the limit, as with "
            f"`ulimit -n {need.open_files}`."
        )


def shortage(error: BaseException | None) -> str | None:
    """One sentence where the error, or one that it came from, is for want of memory or of open files."""
    while error is not None:
        number = error.errno if isinstance(error, OSError) else None
        if number in (errno.EMFILE, errno.ENFILE):
            return "There are too few open files allowed; raise the limit, as with `ulimit -n 1024`."
        told = isinstance(error, ImportError | RuntimeError | SystemError | OSError)
        if (
            isinstance(error, MemoryError)
            or number == errno.ENOMEM
            or (told and any(words in str(error).lower() for words in _NO_MEMORY))
        ):
            return "There is not enough memory; ask for less at a time, or end other programs."
        error = error.__cause__ or error.__context__
    return None
