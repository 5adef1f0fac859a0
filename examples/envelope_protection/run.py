"""A rudder jams in a climbing turn; the autopilot flies its plan with and without protection of the envelope.

python examples/envelope_protection/run.py [--output build/envelope_protection] [--tools FMPy ecospy libcosimpy]
                                              [--envelope envelope-native]

Builds the three FMUs, wires them in SSP archives, flies them in each tool, compares the flights and draws them.
"""

import argparse
import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from pythonfmu import FmuBuilder
from rich.console import Console

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from examples.envelope_protection.figure import draw  # noqa: E402
from examples.envelope_protection.importers import IMPORTERS  # noqa: E402
from examples.envelope_protection.system import write_ssp  # noqa: E402
from fmu_src.fmus import build_fmu  # noqa: E402
from gtm_fmu.errors import InputError  # noqa: E402
from gtm_study.progress import stages  # noqa: E402

FLIGHTS = {"with protection": True, "without protection": False}
ENVELOPES = ("envelope-native", "envelope", "surrogate-native", "surrogate", "thrust-map-native")
"""What can tell V_min and V_max: the exact solver or the thrust map, in C or in Python."""
PACKAGES = {"FMPy": "fmpy", "ecospy": "ecospy", "libcosimpy": "libcosimpy"}


def build(folder: Path, envelope: str = ENVELOPES[0]) -> dict[str, Path]:
    """The FMUs and the archives of both flights, by the flight; ``envelope`` is one of `ENVELOPES`.

    Raises:
        InputError: an FMU that cannot be built, or the folder.
    """
    fmus = {"aircraft": build_fmu("aircraft-native", folder), "envelope": build_fmu(envelope, folder)}
    fmus["autopilot"] = folder / "Autopilot.fmu"
    FmuBuilder.build_FMU(Path(__file__).with_name("autopilot.py"), dest=fmus["autopilot"])
    return {
        flight: write_ssp(folder / f"{flight.replace(' ', '_')}.ssp", fmus, is_protected)
        for flight, is_protected in FLIGHTS.items()
    }


def fly(tool: str, ssp: Path, seconds: float | None = None) -> np.ndarray:
    """The flight of an archive in a tool, by the names of `importers.RECORDED`, dots as underscores.

    Raises:
        RuntimeError: the tool fails; with what it printed last.
    """
    table = ssp.with_name(f"{ssp.stem}_{tool}.csv")
    command = [sys.executable, "-m", "examples.envelope_protection.importers", tool, str(ssp), str(table)]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])}
    ended = subprocess.run(
        [*command, *([] if seconds is None else [str(seconds)])], capture_output=True, text=True, env=environment
    )
    if ended.returncode:
        printed = (ended.stderr or ended.stdout).strip().splitlines() or ["without a word"]
        raise RuntimeError(f"{tool} cannot fly {ssp.name} (exit code {ended.returncode}): {printed[-1]}")
    return np.genfromtxt(table, delimiter=",", names=True, deletechars="", replace_space="_")


def difference(flight: np.ndarray, other: np.ndarray) -> float:
    """Largest difference of two flights at the same times, relative to the larger of one and the value."""
    _, here, there = np.intersect1d(flight["time"].round(6), other["time"].round(6), return_indices=True)
    names = flight.dtype.names or ()
    return max(np.abs((flight[n][here] - other[n][there]) / np.fmax(1, np.abs(flight[n][here]))).max() for n in names)


def compare(archives: dict[str, Path], tools: list[str], stage) -> dict[str, np.ndarray]:
    """Fly in each tool; say how the flights differ, and give those of the first tool that flies.

    A tool that is not installed, or fails, is named with the reason and left out.
    """
    flights: dict[str, np.ndarray] = {}
    for flight, ssp in archives.items():
        for tool in tools:
            if find_spec(PACKAGES[tool]) is None:
                print(f"{flight}: {tool} is not installed")
                continue
            try:
                with stage(f"{flight}, {tool}"):
                    found = fly(tool, ssp)
            except RuntimeError as error:
                print(f"{flight}: left out, {error}")
                continue
            if flight in flights:
                print(f"{flight}: {tool} differs by {difference(flights[flight], found):.1e}")
            else:
                print(f"{flight}: flown by {tool}")
                flights[flight] = found
    return flights


def main() -> int:
    """Build, fly, compare, draw; 2 for what cannot be built, 3 where no tool flies."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", type=Path, default=Path("build/envelope_protection"), help="folder of all files")
    parser.add_argument("--tools", nargs="+", choices=IMPORTERS, default=list(IMPORTERS), help="the first one is drawn")
    parser.add_argument("--envelope", choices=ENVELOPES, default=ENVELOPES[0], help="what tells V_min and V_max")
    arguments = parser.parse_args()
    console = Console(stderr=True)
    try:
        with stages(Console(stderr=True, quiet=not console.is_terminal)) as stage:
            with stage("Build"):
                archives = build(arguments.output, arguments.envelope)
            flights = compare(archives, arguments.tools, stage)
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    if len(flights) < len(archives):
        print("No tool has flown both archives: install one of those named above.", file=sys.stderr)
        return 3
    print(draw(flights, arguments.output / "envelope_protection.png"))
    return 0


if __name__ == "__main__":
    sys.exit(main())
