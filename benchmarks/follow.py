"""V_min and V_max of a range of the rudder: sought, followed, and sought from many starts in every piece of the range.

    python benchmarks/follow.py [QUESTIONS [SEED]]

Questions are a random walk of altitude, flight path and the limits of the rudder (standard deviations of a step: 6 ft,
0.006 deg and 0.03 deg; one in 50 is a jump to anywhere), asked of the native FMU by FMPy (set, step, get) and of the
core. An answer that is followed is wrong when it falls short of the one that is sought, and that when it falls short of
the thorough search, by more than 0.01 kn. Processor times; medians, and 95 %.
"""

import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from rich.progress import track

sys.path.insert(0, str(Path(__file__).parent))
sys.path.insert(0, str(Path(__file__).parents[1]))
from table import row, write

from fmu_src import build
from gtm_fmu.aircraft.client import FmuClient
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.airframe.names import V
from gtm_fmu.core import solver
from gtm_fmu.core.followed import FollowedEnvelope
from gtm_fmu.trims import manoeuvre
from gtm_fmu.units import KT_PER_FT_S, M_PER_FT, RAD_PER_DEG
from tests.reference.random_walks import UNDAMAGED, WIDE, walk

WRONG_KT, CHECKED, JUMPS, SIZE = 0.01, 10, 0.02, 0.3
CASE, SI = ("altitude", "gamma", "rudder.lower", "rudder.upper"), np.array([M_PER_FT, 1, RAD_PER_DEG, RAD_PER_DEG])


def thorough(case: np.ndarray) -> np.ndarray:
    """Speeds of both ends in ft/s, zero where there is no envelope."""
    lower, upper = manoeuvre.bounds(ControlLimits(rudder_deg=tuple(case[2:])))
    ends = [
        solver.envelope_end(*case[:2], lower, upper, sign * np.eye(solver.NT)[V], is_thorough=True) for sign in (1, -1)
    ]
    return np.array([end.y[V] if end.status == solver.TRIMMED else 0.0 for end in ends])


def short_kt(found: np.ndarray, right: np.ndarray) -> float:
    """By how much an envelope is too narrow; all of it where it is missed."""
    return float(max(found[0] - right[0], right[1] - found[1]) * KT_PER_FT_S) if found[0] > 0 else right[1]


def ms(function, *arguments) -> tuple[float, np.ndarray]:
    """Processor time of a call and what it gives."""
    began = time.process_time()
    value = function(*arguments)
    return 1e3 * (time.process_time() - began), value


def main(questions: int = 1500, seed: int = 1) -> None:
    followed = FollowedEnvelope(*WIDE)
    times: dict[str, list[float]] = {name: [] for name in ("small", "jump", "sought", "thorough")}
    of_followed, of_sought = [], []
    previous = None
    with tempfile.TemporaryDirectory() as folder, FmuClient(build("envelope-native", Path(folder))) as fmu:

        def ask(case: np.ndarray) -> np.ndarray:
            fmu.set(CASE, case * SI)
            fmu.step(0.01)
            return fmu.get(("v_min", "v_max")) / M_PER_FT

        for number, case in enumerate(
            track(walk(np.random.default_rng(seed), questions, JUMPS, SIZE), "Walk", questions)
        ):
            taken, answer = ms(ask, case)
            of_seeking, right = ms(lambda case=case: followed.ends(case, UNDAMAGED, is_followed=False)[:, V])
            if right[0] > 0:
                is_small = previous is not None and abs(case[0] - previous[0]) < 200
                times["small" if is_small else "jump"].append(taken)
                times["sought"].append(of_seeking)
            of_followed.append(short_kt(answer, right))
            if number % CHECKED == 0:
                of_thorough, right = ms(thorough, case)
                of_sought.append(short_kt(followed.ends(case, UNDAMAGED, is_followed=False)[:, V], right))
                if right[0] > 0:
                    times["thorough"].append(of_thorough)
            previous = case
    peer = ("many starts in every piece, in the core; ms", float(np.median(times["thorough"])))
    rows = []
    for name, label in (("small", "inputs moved a little, FMU"), ("jump", "anywhere, FMU"), ("sought", "sought, core")):
        median = float(np.median(times[name]))
        rows.append(row(f"range of the rudder, {label}, median", median, "ms", *peer, peer[1] / median))
        rows.append(row(f"range of the rudder, {label}, 95 %", float(np.quantile(times[name], 0.95)), "ms"))
    for label, errors in (("followed, against sought", of_followed), ("sought, against many starts", of_sought)):
        wrong = np.array(errors) > WRONG_KT
        rows.append(row(f"{label}: wrong by more than {WRONG_KT} kn, of {len(errors)}", int(wrong.sum()), "answers"))
        rows.append(row(f"{label}: largest error", float(np.max(errors)), "kn"))
    write("follow", rows)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
