"""Can the aircraft get from one steady manoeuvre to another after a failure?

python examples/transitions/run.py
python examples/transitions/run.py --rudder-deg 15 15 --start 80 0 4.6 --target 80 0 0.4 --target 130 0 0.4

A manoeuvre is an airspeed in kn, a flight path in deg and a turn rate in deg/s. Several targets are legs, one after
another. Prints the answer for each leg, draws them, and ends with exit code 3 if one is not possible. Without a target
it draws the example of the documentation.
"""

import argparse
import sys
from itertools import pairwise
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from examples.transitions.figure import draw  # noqa: E402
from examples.transitions.path import DEFAULT_RATES, Manoeuvre, Rates  # noqa: E402
from examples.transitions.transition import Transition, transition  # noqa: E402
from gtm_fmu.aircraft.failures import Failure  # noqa: E402
from gtm_fmu.aircraft.limits import ControlLimits  # noqa: E402
from gtm_fmu.aircraft.ranges import WIDEST  # noqa: E402
from gtm_fmu.core.configuration import Configuration  # noqa: E402
from gtm_fmu.errors import InputError  # noqa: E402
from gtm_fmu.files import check_writable  # noqa: E402

JAM = Failure(ControlLimits(rudder_deg=(15, 15)))
TURN, STRAIGHTER, FAST = Manoeuvre(80, 0, 4.6), Manoeuvre(80, 0, 0.4), Manoeuvre(130, 0, 0.4)
EXAMPLES: dict[str, tuple[list[Manoeuvre], Rates]] = {
    "straight on": ([TURN, FAST], DEFAULT_RATES),
    "roll out first, then accelerate": ([TURN, STRAIGHTER, FAST], DEFAULT_RATES),
    "the same, three times as fast": ([TURN, STRAIGHTER, FAST], Rates(3.0, 3.0, 1.5)),
}
"""By name: a start and targets, and how fast the reference moves; at 10 000 ft with the rudder jammed at 15 deg."""


def legs(altitude_ft: float, stations: list[Manoeuvre], failure: Failure, rates: Rates) -> list[Transition]:
    """The transitions from each station to the next, up to the first that is not possible.

    Raises:
        InputError: as `transition`.
    """
    found: list[Transition] = []
    for start, target in pairwise(stations):
        found.append(transition(altitude_ft, start, target, failure, rates))
        if not found[-1].possible:
            break
        altitude_ft = float(found[-1].path.altitude_ft[-1])
    return found


def main() -> int:
    """Answer and draw; 2 for bad input, 3 for a transition that is not possible."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    manoeuvre = {"nargs": 3, "type": float, "metavar": ("TAS", "GAMMA", "TURN")}
    parser.add_argument("--altitude-ft", type=float, default=10000.0)
    parser.add_argument("--start", **manoeuvre, help="where the aircraft is")
    parser.add_argument("--target", action="append", **manoeuvre, help="where it is to go; may be given several times")
    for label in WIDEST:
        option = f"--{label.replace('_', '-')}"
        parser.add_argument(option, nargs=2, type=float, metavar=("LOWER", "UPPER"), help="what the failure leaves")
    parser.add_argument("--damage-case", type=int, default=0, help="0 none .. 6, as for gtm-fmu envelope")
    parser.add_argument("--rates", nargs=3, type=float, default=DEFAULT_RATES, help="kn/s, deg/s, deg/s^2")
    parser.add_argument("--output", type=Path, default=Path("build/transitions.png"), help="the figure")
    given = vars(parser.parse_args())
    try:
        check_writable(given["output"])
        found = _examples() if not given["target"] else _asked(given)
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    print(draw(found, given["output"]))
    return 0 if not given["target"] or next(iter(found.values()))[-1].possible else 3


def _examples() -> dict[str, list[Transition]]:
    found = {name: legs(10000.0, stations, JAM, rates) for name, (stations, rates) in EXAMPLES.items()}
    for name, each in found.items():
        print(f"{name}: {'yes' if each[-1].possible else f'no. {each[-1].reason}'}")
    return found


def _asked(given: dict) -> dict[str, list[Transition]]:
    if given["start"] is None:
        raise InputError("There is a target but no start: give --start TAS GAMMA TURN.")
    limits = ControlLimits(**{label: tuple(given[label]) for label in WIDEST if given[label]})
    failure = Failure(limits, Configuration(damage_case=given["damage_case"]))
    stations = [Manoeuvre(*each) for each in (given["start"], *given["target"])]
    found = legs(given["altitude_ft"], stations, failure, Rates(*given["rates"]))
    for leg, target in zip(found, stations[1:], strict=False):
        print(f"to {target}: {'yes' if leg.possible else f'no. {leg.reason}'}")
    return {"transition": found}


if __name__ == "__main__":
    sys.exit(main())
