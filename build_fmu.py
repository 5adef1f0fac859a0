"""Build the FMUs of this project, for instance `python build_fmu.py dynamics -o build/fmu`."""

import argparse
import sys

from gtm_fmu.errors import InputError
from study.fmus import MODELS, build_fmu


def main() -> int:
    """Build the FMUs that the command line names; 2 for bad input."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("name", choices=[*MODELS, "all"], help="the FMU to build")
    parser.add_argument("-o", "--output", default=".", metavar="DIR", help="folder of the FMU (default: here)")
    parser.add_argument("-n", "--networks", metavar="DIR", help="folder of a study, for the networks of the surrogate")
    arguments = parser.parse_args()
    try:
        for name in MODELS if arguments.name == "all" else [arguments.name]:
            print(build_fmu(name, arguments.output, arguments.networks))
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
