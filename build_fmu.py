"""Build the FMUs of this project, for instance `python build_fmu.py dynamics -o build/fmu`."""

import argparse
import sys

from fmu_src.fmus import MODELS, NATIVE_MODELS, build_fmu
from gtm_fmu.errors import script
from surrogate.rudder.names import MODEL_HELP


@script
def main() -> None:
    """Build the FMUs that the command line names; 2 for bad input."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("name", choices=[*MODELS, *NATIVE_MODELS, "all"], help="the FMU to build")
    parser.add_argument("-o", "--output", default=".", metavar="DIR", help="folder of the FMU (default: here)")
    parser.add_argument("-m", "--model", help=f"the surrogate: {MODEL_HELP}")
    parser.add_argument(
        "--all-platforms", action="store_true", help="binaries of a native FMU for all platforms, by Zig"
    )
    arguments = parser.parse_args()
    names = [*MODELS, *NATIVE_MODELS] if arguments.name == "all" else [arguments.name]
    for name in names:
        everywhere = arguments.all_platforms and (name in NATIVE_MODELS or arguments.name != "all")
        print(build_fmu(name, arguments.output, arguments.model, all_platforms=everywhere))


if __name__ == "__main__":
    sys.exit(main())
