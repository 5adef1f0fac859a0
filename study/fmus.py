"""The FMUs of the study, with the networks that the surrogate carries."""

from collections.abc import Callable
from importlib.resources import files
from pathlib import Path

from fmu_src.packaging import MODELS, NATIVE_MODELS, build
from study.emulator import SPEEDS_FILE, THROTTLE_FILE, RudderEmulator

__all__ = ["MODELS", "NATIVE_MODELS", "build_fmu"]


def build_fmu(
    name: str,
    output: str | Path,
    networks: str | Path | None = None,
    all_platforms: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Build an FMU into a folder.

    Args:
        name: a key of `MODELS` or of `NATIVE_MODELS`.
        networks: folder with the surrogate's networks; default: those that come with the package.
        all_platforms: a native FMU for all platforms, not only for this one.
        progress: called with the number of platforms that are finished and of all.

    Raises:
        InputError: an unknown name, networks missing or damaged, or a folder that cannot be written.
    """
    if not name.startswith("surrogate"):
        return build(name, output, all_platforms=all_platforms, progress=progress)
    folder = Path(str(files("study") / "data")) if networks is None else Path(networks)
    RudderEmulator.load(folder)
    return build(name, output, [folder / SPEEDS_FILE, folder / THROTTLE_FILE], all_platforms, progress)
