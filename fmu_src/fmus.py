"""The FMUs of the study, with what the surrogate carries."""

from collections.abc import Callable
from pathlib import Path

from fmu_src.packing.python_fmus import MODELS, NATIVE_MODELS, build
from surrogate.rudder.names import DEFAULT
from surrogate.rudder.surrogates import surrogate_files

__all__ = ["CARRIERS", "MODELS", "NATIVE_MODELS", "build_fmu"]

CARRIERS = "surrogate", "thrust-map"
"""How the names of those begin that carry a surrogate."""


def build_fmu(
    name: str,
    output: str | Path,
    surrogate: str | Path | None = None,
    all_platforms: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Build an FMU into a folder.

    Args:
        name: a key of `MODELS` or of `NATIVE_MODELS`.
        surrogate: a key of `surrogates.SURROGATES`, the file of a thrust map or the folder of two networks; default the
            rudder's thrust map that comes with the package. The thrust-map FMUs take a map of any control, or a key of
            `surrogates.OTHER_CONTROLS`. Other FMUs take no notice of it.
        all_platforms: a native FMU for all platforms, not only for this one.
        progress: called with the number of platforms that are finished and of all.

    Raises:
        InputError: an unknown name, a surrogate missing or damaged, or a folder that cannot be written.
    """
    files: list[Path] = []
    if name.startswith(CARRIERS):
        control = "rudder" if name.startswith("surrogate") else None
        files = surrogate_files(str(surrogate or DEFAULT), control)
    return build(name, output, files, all_platforms, progress)
