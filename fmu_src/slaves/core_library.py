"""The compiled core in an FMU's resources. It runs in the Python of the host."""

import ctypes
import zlib
from operator import mul, truediv
from pathlib import Path

from .slave import TableSlave, platform_folder


def load_core(resources: str, model: str) -> ctypes.CDLL:
    """The core of this platform from the resources of a model's FMU."""
    folder = Path(resources, "core")
    here = platform_folder()
    library = next(iter(sorted(folder.glob(f"{here}/gtm_core.*"))), None)
    if library is None:
        inside = ", ".join(sorted(path.name for path in folder.glob("*"))) or "none"
        raise RuntimeError(
            f"{model} has no compiled core for this platform ({here}; inside: {inside}). Build the FMU on it with "
            "build_fmu.py."
        )
    try:
        checksum = zlib.crc32(library.read_bytes())
        if checksum not in _LOADED:
            _LOADED[checksum] = ctypes.CDLL(str(library))
        return _LOADED[checksum]
    except OSError as error:
        raise RuntimeError(f"The compiled core of {model} does not load ({error}): build the FMU anew.") from None


_LOADED: dict[int, ctypes.CDLL] = {}
"""By its checksum: a process keeps what it has loaded, so each unpacked copy would stay in memory and on disk."""


class Buffer:
    """An argument of the core in its units: some variables and their amounts of SI in one of the core's units."""

    def __init__(self, slave: TableSlave, group: str):
        """Make room for the values of a group of variables."""
        self.places = slave.group(group)
        self.names, self.scales = slave.names[self.places], slave.table["scales"][self.places]
        self.memory = (ctypes.c_double * len(self.scales))()
        self.address = ctypes.c_void_p(ctypes.addressof(self.memory))

    def load(self, values: list[float]) -> None:
        """Take values in SI."""
        self.memory[:] = list(map(truediv, values, self.scales))

    def read(self) -> list[float]:
        """Give values in SI."""
        return list(map(mul, self.memory[:], self.scales))
