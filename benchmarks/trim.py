"""Trims per second of the core, beside JSBSim's, and milliseconds of a trim over evaluations of either FMU.

    python benchmarks/trim.py

The core solves cold: random flight conditions with a jammed rudder, those that have a trim inside the limits, on one
thread. JSBSim trims its own 737 (`do_trim`, full), at random speeds and altitudes that it can hold. Both in processor
time.
"""

import contextlib
import io
import os
import statistics
import sys
import tempfile
import time
from pathlib import Path

import jsbsim
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
from table import row, write

from fmu_src.fmus import build_fmu
from gtm_fmu.aircraft.client import FmuClient
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.core import solver
from gtm_fmu.trims import steady
from gtm_fmu.trims.fmu_trimmer import FmuTrimmer

CONDITIONS, FMU_TRIMS, JSBSIM_TRIMS = 200_000, 100, 60


def core_trims_per_second() -> float:
    """Feasible cold trims with a jammed rudder, the best of three runs."""
    rng = np.random.default_rng(0)
    low, high = (0.0, 60.0, -5.0, -12.0, -30.0), (36000.0, 190.0, 5.0, 12.0, 30.0)
    altitude_ft, tas_kt, gamma_deg, rate_deg_s, jam_deg = rng.uniform(low, high, (CONDITIONS, 5)).T
    rudder_deg = np.column_stack([jam_deg, jam_deg])
    found = steady.trims(altitude_ft, tas_kt, gamma_deg, rate_deg_s, rudder_deg=rudder_deg)
    kept = found.status == solver.TRIMMED
    taken = []
    for _ in range(3):
        start = time.process_time()
        again = steady.trims(
            altitude_ft[kept], tas_kt[kept], gamma_deg[kept], rate_deg_s[kept], rudder_deg=rudder_deg[kept]
        )
        taken.append(time.process_time() - start)
    assert (again.status == solver.TRIMMED).all()
    return kept.sum() / min(taken)


def jsbsim_trims_per_second() -> float:
    """Full trims of the 737 that comes with JSBSim."""
    rng = np.random.default_rng(0)
    aircraft = jsbsim.FGFDMExec(jsbsim.get_default_root_dir())
    aircraft.set_debug_level(0)
    aircraft.load_model("737")
    taken, found = 0.0, 0
    with open(os.devnull, "w") as nowhere, contextlib.redirect_stdout(nowhere):
        for altitude_ft, speed_kt in rng.uniform((5000, 220), (25000, 300), (JSBSIM_TRIMS, 2)):
            aircraft["ic/h-sl-ft"], aircraft["ic/vc-kts"], aircraft["ic/gamma-deg"] = altitude_ft, speed_kt, 0.0
            aircraft.run_ic()
            aircraft["propulsion/set-running"] = -1
            start = time.process_time()
            with contextlib.suppress(jsbsim.TrimFailureError):
                aircraft["simulation/do_simple_trim"] = 1
                found += 1
            taken += time.process_time() - start
    return found / taken


def fmu_trim_ms(name: str) -> float:
    """Median of cold trims over an FMU, half of them with a jammed rudder."""
    rng = np.random.default_rng(1)
    taken = []
    with tempfile.TemporaryDirectory() as folder, FmuClient(build_fmu(name, folder)) as client:
        trimmer = FmuTrimmer(client)
        while len(taken) < FMU_TRIMS:
            low, high = np.sort(rng.uniform(-25, 25, 2))
            limits = ControlLimits(rudder_deg=(low, low if len(taken) % 2 else high))
            question = (*rng.uniform((0, 90, -4, -4), (25000, 140, 3, 4)), limits)
            if not steady.trim(*question).feasible:
                continue
            start = time.perf_counter()
            assert trimmer.trim(*question).feasible
            taken.append(time.perf_counter() - start)
    return 1e3 * statistics.median(taken)


def main() -> None:
    core = core_trims_per_second()
    with contextlib.redirect_stderr(io.StringIO()):
        other = jsbsim_trims_per_second()
    python, native = fmu_trim_ms("dynamics"), fmu_trim_ms("dynamics-native")
    rows = [
        row(
            "cold feasible trims of the core, one thread",
            core,
            "1/s",
            "JSBSim do_trim of its 737, 1/s",
            other,
            core / other,
        ),
        row(
            "trim over the native FMU with its directional derivatives, median",
            native,
            "ms",
            "the same with differences over the pythonfmu FMU, ms",
            python,
            python / native,
        ),
    ]
    write("trim", rows)


if __name__ == "__main__":
    main()
