"""The file of an FMU: what is refused before any of it runs."""

import shutil
import tempfile
import zipfile
from pathlib import Path

import fmpy
from fmpy.model_description import ModelDescription

from gtm_fmu.errors import InputError

LARGEST_FMU_BYTES = 2**30
"""Unpacked."""


def read_description(path: Path) -> ModelDescription:
    """Description of an FMI 2.0 FMU.

    Raises:
        InputError: no such file, not an FMU, damaged, too large, or of another version.
    """
    if not path.is_file():
        raise InputError(f"There is no FMU '{path}': give a file that build_fmu.py has made.")
    try:
        _check_size(path)
        description = fmpy.read_model_description(path)
    except InputError:
        raise
    except zipfile.BadZipFile:
        raise InputError(f"'{path}' is not an FMU or is damaged: build it again.") from None
    except Exception as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise InputError(f"'{path}' has no valid model description ({reason}): build it again.") from error
    if description.fmiVersion != "2.0" or not (description.coSimulation or description.modelExchange):
        raise InputError(f"'{path}' is not an FMI 2.0 FMU, the only kind that is driven here.")
    return description


def _check_size(path: Path) -> None:
    """Refuse an archive that would fill the disk; `zipfile` unpacks no more of a member than the archive declares."""
    with zipfile.ZipFile(path) as archive:
        unpacked = sum(member.file_size for member in archive.infolist())
    allowed = min(LARGEST_FMU_BYTES, shutil.disk_usage(tempfile.gettempdir()).free)
    if unpacked > allowed:
        raise InputError(
            f"'{path}' unpacks to {unpacked / 1e6:.0f} MB, allowed is {allowed / 1e6:.0f} MB (1 GiB, or what the disk "
            "of the temporary folder has left): leave out what its simulation does not need."
        )


def check_for_pythonfmu(folder: Path, path: Path) -> None:
    """Refuse an unpacked FMU that would make the binary of pythonfmu 0.7.0 end this process.

    Raises:
        InputError: the folder's name is not plain ASCII, or the FMU lacks its slave.
    """
    if "%" in folder.as_uri().replace("%20", ""):
        raise InputError(f"The temporary folder '{folder}' must have a plain ASCII name: set TMPDIR.")
    if not (folder / "resources" / "slavemodule.txt").is_file():
        raise InputError(f"'{path}' is damaged (its slave is missing): build it anew.")
