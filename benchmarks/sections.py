"""Milliseconds of a section of the envelope, beside the sweep of trims that JSBSim's users take in its place.

    python benchmarks/sections.py

JSBSim knows no sections. Its users call `do_trim` on a grid of 10 kt and 1 deg of flight path, wings level, and keep
the points that trim: so here with its own 737 at 15 000 ft. An interval of speeds is a row of that grid, an interval of
flight paths a column, each known to the grid's step. Ours are exact: of straight flight at random altitudes with a
jammed rudder, from Python with the trims at their ends, and by the core alone. Empty rows, columns and sections are
left out. All in processor time of one thread.
"""

import contextlib
import os
import statistics
import sys
import time
from collections.abc import Callable
from pathlib import Path

import jsbsim
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
from table import row, write

from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.aircraft.ranges import GAMMA_DEG, TAS_KT
from gtm_fmu.core import sections
from gtm_fmu.envelopes.sections import Section, climb_interval, speed_interval
from gtm_fmu.trims import manoeuvre
from gtm_fmu.units import FT_S_PER_KT, RAD_PER_DEG

SECTIONS = 300
ALTITUDE_FT = 15_000
SPEEDS_KT = np.arange(120, 381, 10)  # calibrated
PATHS_DEG = np.arange(-8, 13, 1)


def jsbsim_sweep() -> tuple[float, float, np.ndarray]:
    """Milliseconds of a row and of a column of the grid, and which of its points (paths, speeds) trim."""
    aircraft = jsbsim.FGFDMExec(jsbsim.get_default_root_dir())
    aircraft.set_debug_level(0)
    aircraft.load_model("737")
    is_trimmed = np.zeros((len(PATHS_DEG), len(SPEEDS_KT)), dtype=bool)
    taken = np.zeros(is_trimmed.shape)
    for (i, gamma_deg), (j, speed_kt) in ((a, b) for a in enumerate(PATHS_DEG) for b in enumerate(SPEEDS_KT)):
        aircraft["ic/h-sl-ft"], aircraft["ic/vc-kts"], aircraft["ic/gamma-deg"] = ALTITUDE_FT, speed_kt, gamma_deg
        aircraft["ic/phi-deg"] = 0.0
        aircraft.run_ic()
        aircraft["propulsion/set-running"] = -1
        start = time.process_time()
        with contextlib.suppress(jsbsim.TrimFailureError):
            aircraft["simulation/do_simple_trim"] = 1
            is_trimmed[i, j] = True
        taken[i, j] = time.process_time() - start
    has_row, has_column = is_trimmed.any(axis=1), is_trimmed.any(axis=0)
    return 1e3 * taken.sum(axis=1)[has_row].mean(), 1e3 * taken.sum(axis=0)[has_column].mean(), is_trimmed


def medians_ms(
    solve: Callable[..., Section], kind: int, low: tuple[float, float], high: tuple[float, float]
) -> tuple[float, float]:
    """From Python and by the core alone, of sections that are not empty.

    They are at random altitudes in ft and second values (flight paths in deg, speeds in kn), with the rudder jammed.
    """
    rng = np.random.default_rng(0)
    taken: list[float] = []
    by_core: list[float] = []
    while len(taken) < SECTIONS:
        altitude_ft, value = rng.uniform(low, high).tolist()
        jam = float(rng.uniform(-20, 20))
        limits = ControlLimits(rudder_deg=(jam, jam))
        start = time.process_time()
        found = solve(altitude_ft, value, limits=limits)
        end = time.process_time()
        if not found.intervals:
            continue
        taken.append(end - start)
        is_climb = kind == sections.CLIMBS
        tas_kt = (value, value) if is_climb else TAS_KT
        lower, upper = manoeuvre.bounds(limits, tas_kt=tas_kt, turn_rate_deg_s=(0.0, 0.0))
        within = np.array(GAMMA_DEG) * RAD_PER_DEG if is_climb else np.array(TAS_KT) * FT_S_PER_KT
        gamma = 0.0 if is_climb else value * RAD_PER_DEG
        start = time.process_time()
        sections.section(kind, altitude_ft, gamma, lower, upper, tuple(within))
        by_core.append(time.process_time() - start)
    return 1e3 * statistics.median(taken), 1e3 * statistics.median(by_core)


def main() -> None:
    with open(os.devnull, "w") as nowhere, contextlib.redirect_stdout(nowhere), contextlib.redirect_stderr(nowhere):
        of_row, of_column, is_trimmed = jsbsim_sweep()
    speeds, speeds_by_core = medians_ms(speed_interval, sections.SPEEDS, (0, -6), (25_000, 3))
    climbs, climbs_by_core = medians_ms(climb_interval, sections.CLIMBS, (0, 85), (25_000, 135))
    shape = f"{len(SPEEDS_KT)} speeds", f"{len(PATHS_DEG)} flight paths"
    rows = [
        row(
            "exact interval of speeds at a flight path, straight, jam, median",
            speeds,
            "ms",
            f"JSBSim do_trim of its 737 at {shape[0]} every 10 kt, mean, ms",
            of_row,
            of_row / speeds,
        ),
        row(
            "exact interval of flight paths at a speed, straight, jam, median",
            climbs,
            "ms",
            f"JSBSim do_trim of its 737 at {shape[1]} every 1 deg, mean, ms",
            of_column,
            of_column / climbs,
        ),
        row("the same interval of speeds by the core alone, median", speeds_by_core, "ms"),
        row("the same interval of flight paths by the core alone, median", climbs_by_core, "ms"),
        row("points of JSBSim's grid that trim", float(is_trimmed.sum()), f"of {is_trimmed.size}"),
    ]
    write("sections", rows)


if __name__ == "__main__":
    main()
