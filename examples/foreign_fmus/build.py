"""Two FMUs that are none of ours: van der Pol's oscillator, and the aircraft under other names.

python examples/foreign_fmus/build.py [--output .]

Writes VanDerPol.fmu, compiled from van_der_pol.c here, and Aircraft.fmu, a copy of GtmDynamicsNative.
"""

import argparse
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[1]))

from fmu_src.compiler import host_platform  # noqa: E402
from fmu_src.native_sources import standard_headers  # noqa: E402
from gtm_fmu import InputError  # noqa: E402
from study.fmus import build_fmu  # noqa: E402

STATES = {
    **{"state.u": "ub", "state.v": "vb", "state.w": "wb"},
    **{"state.p": "roll_rate", "state.q": "pitch_rate", "state.r": "yaw_rate"},
    **{"state.latitude": "lat", "state.longitude": "lon", "state.altitude": "height"},
    **{"state.phi": "bank", "state.theta": "pitch", "state.psi": "heading"},
}
CONTROLS = {
    "control.elevator": "elevator_cmd",
    "control.aileron": "aileron_cmd",
    "control.rudder": "rudder_cmd",
    "control.throttle": "power",
}
AIRCRAFT = STATES | {f"der({old})": f"der({new})" for old, new in STATES.items()} | CONTROLS
"""Our names, and those of Aircraft.fmu."""


def van_der_pol(folder: Path, has_slopes: bool = True) -> Path:
    """The oscillator; without slopes it says so and refuses them.

    Raises:
        InputError: no C compiler.
    """
    compiler = shutil.which("cc")
    if compiler is None:
        raise InputError("The oscillator is compiled and there is no C compiler: install one, for instance gcc.")
    description = (HERE / "van_der_pol.xml").read_text()
    if not has_slopes:
        description = description.replace(' providesDirectionalDerivative="true"', "")
    path = folder / "VanDerPol.fmu"
    with tempfile.TemporaryDirectory() as place:
        for name, content in standard_headers(2).items():
            Path(place, name).write_bytes(content)
        library, flags = Path(place, "VanDerPol.so"), [] if has_slopes else ["-DWITHOUT_SLOPES"]
        flags += ["-shared", "-fPIC", "-O1", "-I", place]
        subprocess.run([compiler, *flags, HERE / "van_der_pol.c", "-o", library, "-lm"], check=True)
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("modelDescription.xml", description)
            archive.write(library, f"binaries/{host_platform().folder(2)}/VanDerPol.so")
            archive.writestr("resources/none.txt", "")
    return path


def renamed(path: Path, copy: Path, names: dict[str, str]) -> Path:
    """A copy of an FMU whose variables have other names."""
    with zipfile.ZipFile(path) as source, zipfile.ZipFile(copy, "w") as target:
        for item in source.infolist():
            content = source.read(item)
            if item.filename == "modelDescription.xml":
                for old, new in names.items():
                    content = content.replace(f'name="{old}"'.encode(), f'name="{new}"'.encode())
            target.writestr(item, content)
    return copy


def main() -> int:
    """Build both; 2 for what cannot be built."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", type=Path, default=Path(), help="folder of both files")
    folder = parser.parse_args().output
    folder.mkdir(parents=True, exist_ok=True)
    try:
        print(van_der_pol(folder))
        with tempfile.TemporaryDirectory() as place:
            print(renamed(build_fmu("dynamics-native", place), folder / "Aircraft.fmu", AIRCRAFT))
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
