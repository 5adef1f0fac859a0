"""Two FMUs that are none of ours: van der Pol's oscillator, and the aircraft under other names.

python examples/foreign_fmus/build.py [--output .]

Writes VanDerPol.fmu, compiled from van_der_pol.c here, and Aircraft.fmu, a copy of GtmDynamicsNative.
"""

import argparse
import sys
import tempfile
import zipfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[1]))

from fmu_src.fmus import build_fmu  # noqa: E402
from fmu_src.packing.archive import write_archive  # noqa: E402
from fmu_src.packing.compiler import host_binary  # noqa: E402
from fmu_src.packing.native_sources import standard_headers  # noqa: E402
from gtm_fmu.errors import script  # noqa: E402
from gtm_fmu.files import writable_folder  # noqa: E402

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
    source, description = (HERE / "van_der_pol.c").read_bytes(), (HERE / "van_der_pol.xml").read_text()
    if not has_slopes:
        source = b"#define WITHOUT_SLOPES\n" + source
        description = description.replace(' providesDirectionalDerivative="true"', "")
    built = host_binary("VanDerPol", {"van_der_pol.c": source} | standard_headers(2))
    members = {"modelDescription.xml": description.encode(), "resources/none.txt": b""}
    for platform, binary in built.items():
        members[f"binaries/{platform.folder(2)}/VanDerPol{platform.suffix}"] = binary
    return write_archive(folder / "VanDerPol.fmu", members)


def renamed(path: Path, copy: Path, names: dict[str, str]) -> Path:
    """A copy of an FMU whose variables have other names."""
    with zipfile.ZipFile(path) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    description = members["modelDescription.xml"]
    for old, new in names.items():
        description = description.replace(f'name="{old}"'.encode(), f'name="{new}"'.encode())
    return write_archive(copy, members | {"modelDescription.xml": description})


@script
def main() -> None:
    """Build both; 2 for what cannot be built."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", type=Path, default=Path(), help="folder of both files")
    arguments = parser.parse_args()
    folder = writable_folder(arguments.output)
    print(van_der_pol(folder))
    with tempfile.TemporaryDirectory() as place:
        print(renamed(build_fmu("dynamics-native", place), folder / "Aircraft.fmu", AIRCRAFT))


if __name__ == "__main__":
    sys.exit(main())
