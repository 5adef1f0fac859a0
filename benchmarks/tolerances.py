"""Whether any aircraft within the tolerances passes a guaranteed or a possible end, and what these ends cost.

    python benchmarks/tolerances.py [CASES [SEED]]

Random failures of the rudder (jams and narrow ranges) and of the elevator, with 5 % of mass, 2 % of the chord for the
centre of gravity and 5 % of each coefficient. Each is solved exactly at random corners of the box of aircraft and at
random places inside it.
"""

import statistics
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
from table import row, write

from gtm_fmu import ControlLimits, Failure, FlightCondition, Tolerances, TolerantEnvelope, envelope, tolerant_envelope
from gtm_fmu.airframe.names import V
from gtm_fmu.units import KT_PER_FT_S

TOLERANCES = Tolerances(mass_tolerance=0.05, cg_tolerance=0.02, aero_tolerance=0.05)
PLACES, SAME_KT = 25, 0.001
COSTS = {
    "as it is": Tolerances(),
    "mass": Tolerances(mass_tolerance=0.05),
    "gust": Tolerances(gust_kt=5),
    "all": Tolerances(gust_kt=5, mass_tolerance=0.05, cg_tolerance=0.01, aero_tolerance=0.05),
}
WIDTHS_DEG = {"jam": 0.0, "range of 8 deg": 8.0}


def random_case(rng: np.random.Generator) -> tuple[float, float, ControlLimits]:
    """Altitude in ft, flight path in deg and limits: a jam, a narrow range, or a jam of the elevator."""
    altitude_ft, gamma_deg, position = rng.uniform((0, -5, -25), (30_000, 3, 25)).tolist()
    kind = rng.integers(3)
    if kind == 0:
        return altitude_ft, gamma_deg, ControlLimits(elevator_deg=(position / 4,) * 2, rudder_deg=(-10, 10))
    wide = float(rng.uniform(1, 9)) if kind == 1 else 0.0
    return altitude_ft, gamma_deg, ControlLimits(rudder_deg=(position, min(position + wide, 30.0)))


def passed_by_kt(found: TolerantEnvelope, places: np.ndarray) -> tuple[float, bool]:
    """By how much the aircraft at places (n, 10) pass the ends at most, and whether one has no envelope against it."""
    nominal, most, is_broken = found.nominal, 0.0, False
    for place in places:
        failure = TOLERANCES.moved(nominal.failure, tuple(place))
        ends = FlightCondition(nominal.altitude_ft, nominal.gamma_deg, failure).extremes()[:, V] * KT_PER_FT_S
        if len(ends) < 2:
            is_broken |= found.guaranteed is not None
            continue
        if sure := found.speeds_kt("guaranteed"):
            most = max(most, ends[0] - sure[0], sure[1] - ends[1])
        if possible := found.speeds_kt("possible"):
            most = max(most, possible[0] - ends[0], ends[1] - possible[1])
        else:
            is_broken = True
    return float(most), is_broken


def costs(cases: int = 8, seed: int = 0) -> list[dict]:
    """What an envelope takes by what is not known, median of random conditions."""
    conditions = np.random.default_rng(seed).uniform((0, -4, -15), (20_000, 2, 10), (cases, 3)).tolist()
    rows = []
    for tolerated, tolerances in COSTS.items():
        for failed, width_deg in WIDTHS_DEG.items():
            taken = []
            for altitude_ft, gamma_deg, lower_deg in conditions:
                limits = ControlLimits(rudder_deg=(lower_deg, lower_deg + width_deg))
                start = time.process_time()
                if tolerances == Tolerances():
                    envelope(altitude_ft, gamma_deg, limits)
                else:
                    tolerant_envelope(altitude_ft, gamma_deg, limits, tolerances)
                taken.append(time.process_time() - start)
            rows.append(row(f"envelope of a {failed}, {tolerated}, median of {cases}", statistics.median(taken), "s"))
    return rows


def main(cases: int = 60, seed: int = 7) -> None:
    rng = np.random.default_rng(seed)
    taken, at_corners, inside, broken = [], [], [], 0
    for _ in range(cases):
        altitude_ft, gamma_deg, limits = random_case(rng)
        start = time.process_time()
        found = tolerant_envelope(altitude_ft, gamma_deg, Failure(limits), TOLERANCES)
        taken.append(time.process_time() - start)
        for passed, places in (
            (at_corners, rng.choice([-1.0, 1.0], (PLACES, 10))),
            (inside, rng.uniform(-1, 1, (PLACES, 10))),
        ):
            most, is_broken = passed_by_kt(found, places)
            passed.append(most)
            broken += is_broken
    rows = [
        row("guaranteed and possible envelope of a failure, all tolerances, median", statistics.median(taken), "s"),
        row(f"of {cases} failures, ends passed by a random corner", float(np.sum(np.array(at_corners) > SAME_KT)), ""),
        row("by at most", max(at_corners), "kn"),
        row(
            f"of {cases} failures, ends passed by a random place inside", float(np.sum(np.array(inside) > SAME_KT)), ""
        ),
        row("by at most", max(inside), "kn"),
        row("envelopes guaranteed or impossible against an exact solution", float(broken), ""),
        *costs(),
    ]
    write("tolerances", rows)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
