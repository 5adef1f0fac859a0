"""How certain the ends of envelopes are: manoeuvres are sought beyond them, one by one, without the search for ends.

A manoeuvre that can be flown below V_min, above V_max, or where no envelope was found, would be a miss. Each is solved
by Newton's method at its own speed and turn rate.
"""

from typing import Any

import numpy as np

from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.datasets import off_lattice
from gtm_fmu.envelopes.envelope import FlightCondition
from gtm_fmu.envelopes.manoeuvres import manoeuvres
from gtm_fmu.progress import Advance

TOLERANCE_KT, REACH_KT, STEP_KT = 0.01, 15.0, 0.5
"""Beyond the ends: from, to, step."""
EVERY_KT = np.arange(50.0, 230.0, 2.0)
"""Speeds at which a missed envelope is sought."""
TURN_RATES_DEG_S = np.arange(-30.0, 30.1, 1.0)


def scan(cases: int, seed: int, advance: Advance) -> dict[str, Any]:
    """Count the manoeuvres beyond the ends of random cases: jams and restrictions of the rudder, half each."""
    rows = off_lattice.inputs(off_lattice.case_table(cases=cases, seed=seed + 100))
    beyond = np.concatenate([[TOLERANCE_KT], np.arange(STEP_KT, REACH_KT + STEP_KT / 2, STEP_KT)])
    feasible, asked, missed = 0, 0, []
    for k, (altitude_ft, gamma_deg, low, high) in enumerate(rows.tolist()):
        limits = ControlLimits(rudder_deg=(low, high))
        found = FlightCondition(altitude_ft, gamma_deg, limits).envelope()
        speeds = EVERY_KT
        if found.v_min_kt is not None and found.v_max_kt is not None:
            speeds = np.concatenate([found.v_min_kt - beyond, found.v_max_kt + beyond])
            feasible += 1
        answers = manoeuvres(altitude_ft, speeds[:, None], gamma_deg, TURN_RATES_DEG_S, limits)
        asked += len(answers)
        if answers.feasible.any():
            missed.append([altitude_ft, gamma_deg, low, high])
        advance(k + 1, len(rows))
    return {"cases": len(rows), "with_an_envelope": feasible, "manoeuvres": asked, "missed": missed}
