"""How far the aircraft is from symmetric: envelopes of rudder failures beside those of the mirrored ones.

python -m gtm_study.paper.asymmetry [CASES]

The centre of gravity lies 0.0118 ft left of the plane of symmetry, and the engines are toed differently (SPEC 3, 6).
"""

import argparse
import sys

import numpy as np
from rich.console import Console
from rich.table import Table

from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.core.configuration import Configuration
from gtm_fmu.datasets import off_lattice
from gtm_fmu.envelopes.envelope import FlightCondition
from gtm_fmu.errors import script

SHARES = {"median": 50, "90 %": 90, "largest": 100}


def differences(cases: int, configuration: Configuration | None = None) -> np.ndarray:
    """|V_min| and |V_max| apart in kn (n, 2) of the first ``cases`` off the lattice and their mirror images.

    Where one of the two has no envelope they are left out, so that n is smaller.
    """

    def ends(altitude_ft: float, gamma_deg: float, low: float, high: float) -> tuple[float, float]:
        failure = Failure(ControlLimits(rudder_deg=(low, high)), configuration or Configuration())
        found = FlightCondition(altitude_ft, gamma_deg, failure).envelope()
        if found.v_min_kt is None or found.v_max_kt is None:
            return np.nan, np.nan
        return found.v_min_kt, found.v_max_kt

    rows = off_lattice.inputs(off_lattice.case_table(cases=cases))
    apart = [np.subtract(ends(h, gamma, low, high), ends(h, gamma, -high, -low)) for h, gamma, low, high in rows]
    return np.abs(apart)[np.isfinite(apart).all(axis=1)]


@script
def main() -> None:
    """Print them; 2 for a number of cases that is none."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", nargs="?", type=int, default=400, help="cases off the lattice (400)")
    found = differences(parser.parse_args().cases)
    title = f"{len(found)} failures of the rudder and their mirror images"
    table = Table("kn", *SHARES, title=title, title_justify="left")
    for name, apart in zip(("V_min", "V_max"), found.T, strict=True):
        table.add_row(name, *(f"{value:.2f}" for value in np.percentile(apart, list(SHARES.values()))))
    Console().print(table)


if __name__ == "__main__":
    sys.exit(main())
