"""FMUs that are none of ours: van der Pol's oscillator, and our aircraft under other names."""

import shutil
import subprocess
import zipfile
from pathlib import Path

import pytest

from fmu_src.compiler import host_platform
from fmu_src.native_sources import standard_headers

HERE = Path(__file__).parent


def van_der_pol(folder: Path, has_slopes: bool = True) -> Path:
    """The oscillator, compiled from its source here; without slopes it says so and refuses them."""
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("no C compiler: install gcc")
    for name, content in standard_headers(2).items():
        (folder / name).write_bytes(content)
    library, flags = folder / "VanDerPol.so", [] if has_slopes else ["-DWITHOUT_SLOPES"]
    command = [compiler, "-shared", "-fPIC", "-O1", "-I", folder, *flags, HERE / "van_der_pol.c", "-o", library, "-lm"]
    subprocess.run(command, check=True)
    description = (HERE / "van_der_pol.xml").read_text()
    if not has_slopes:
        description = description.replace(' providesDirectionalDerivative="true"', "")
    path = folder / "VanDerPol.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", description)
        archive.write(library, f"binaries/{host_platform().folder(2)}/VanDerPol.so")
        archive.writestr("resources/none.txt", "")
    return path


def renamed(path: Path, folder: Path, names: dict[str, str]) -> Path:
    """A copy of an FMU whose variables have other names."""
    copy = folder / "Renamed.fmu"
    with zipfile.ZipFile(path) as source, zipfile.ZipFile(copy, "w") as target:
        for item in source.infolist():
            content = source.read(item)
            if item.filename == "modelDescription.xml":
                for old, new in names.items():
                    content = content.replace(f'name="{old}"'.encode(), f'name="{new}"'.encode())
            target.writestr(item, content)
    return copy
