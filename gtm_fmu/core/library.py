"""The shared library of the core, loaded with ctypes."""

import ctypes
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike


def library_path() -> Path:
    """Path of the compiled core.

    Raises:
        FileNotFoundError: the package was not built (a source folder used without installation).
    """
    folder = Path(__file__).parent
    for suffix in (".so", ".dylib", ".dll"):
        path = folder / f"gtm_core{suffix}"
        if path.exists():
            return path
    raise FileNotFoundError(
        f"No compiled core in {folder}: install the package first, for instance with `pip install .`."
    )


@cache
def library() -> ctypes.CDLL:
    """The loaded core."""
    return ctypes.CDLL(str(library_path()))


def address(array: np.ndarray) -> ctypes.c_void_p:
    """Pointer to a C-contiguous array; the caller keeps the array alive during the call."""
    return ctypes.c_void_p(array.ctypes.data)


def rows(values: ArrayLike, width: int, name: str) -> np.ndarray:
    """Values as a C-contiguous float array (.., width).

    Raises:
        ValueError: the last axis has another length.
    """
    array = np.ascontiguousarray(values, dtype=float)
    if array.ndim == 0 or array.shape[-1] != width:
        raise ValueError(f"{name} has shape {array.shape}; its last axis must have length {width}.")
    return array
