"""Build the FMUs of this project: `python build_fmu.py dynamics -o build`."""

import argparse
import sys

from fmu_src.packaging import MODELS, build
from gtm_fmu.errors import InputError


def main() -> int:
    """Build the FMUs that the command line names; 2 for bad input."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("name", choices=[*MODELS, "all"], help="the FMU to build")
    parser.add_argument("-o", "--output", default=".", metavar="DIR", help="folder of the FMU (default: here)")
    arguments = parser.parse_args()
    try:
        for name in MODELS if arguments.name == "all" else [arguments.name]:
            print(build(name, arguments.output))
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
