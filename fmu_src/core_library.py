"""The compiled core in an FMU's resources. It runs in the Python of the host."""

import ctypes
from pathlib import Path

from .slave import platform_folder


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
    return ctypes.CDLL(str(library))
