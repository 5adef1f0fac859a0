"""The archive of an FMU: equal members give equal bytes."""

import hashlib
import uuid
import zipfile
from pathlib import Path

from fmu_src.description.model_description import BUILD_DATE
from gtm_fmu.files import write_whole


def digest(members: dict[str, bytes]) -> str:
    """SHA-256 of names and contents."""
    result = hashlib.sha256()
    for name in sorted(members):
        result.update(f"{name}\0{len(members[name])}\0".encode())
        result.update(members[name])
    return result.hexdigest()


def content_id(members: dict[str, bytes]) -> str:
    """GUID (FMI 2.0) or instantiation token (FMI 3.0) of an FMU with these members."""
    return f"{{{uuid.UUID(digest(members)[:32])}}}"


def write_archive(path: Path, members: dict[str, bytes]) -> Path:
    """Write the archive in one piece or not at all: members sorted, one fixed time.

    Raises:
        InputError: it cannot be written.
    """

    def write(draft: Path) -> None:
        with zipfile.ZipFile(draft, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
            for member in sorted(members):
                info = zipfile.ZipInfo(member, BUILD_DATE)
                info.create_system, info.external_attr = 3, 0o644 << 16
                info.compress_type = zipfile.ZIP_DEFLATED
                archive.writestr(info, members[member], compresslevel=9)

    write_whole(path, write)
    return path
