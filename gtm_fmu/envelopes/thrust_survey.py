"""Exact solutions that fill a thrust map: least thrust over speed with a control jammed."""

import json
import os
import zipfile
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.aircraft.ranges import ALTITUDE_FT, WIDEST, Range
from gtm_fmu.airframe import engines
from gtm_fmu.airframe.atmosphere import DENSITY_0, atmosphere
from gtm_fmu.airframe.names import THROTTLE, TRIM_UNKNOWNS, V
from gtm_fmu.airframe.provenance import provenance
from gtm_fmu.core import solver
from gtm_fmu.envelopes.envelope import THROTTLE_WITHOUT_LIMIT
from gtm_fmu.envelopes.thrust_map import ThrustMap, Tolerances
from gtm_fmu.errors import InputError
from gtm_fmu.files import write_whole
from gtm_fmu.trims import manoeuvre
from gtm_fmu.units import FT_S_PER_KT, KT_PER_FT_S, RAD_PER_DEG

FASTEST_KT = 200.0
"""Equivalent airspeed beyond every envelope: full thrust at sea level reaches 192 kn in a descent of 5 deg."""

_ROUNDING_DEG = 1e-6
_SINGLE_KT = 1e-3
"""Speeds no further apart are one, with one thrust: at the last deflection that any manoeuvre has."""


class Nodes(NamedTuple):
    """Where a map is solved: altitudes in ft, flight paths and deflections in deg, number of speeds.

    Where manoeuvres end before the last deflections do, the deflections lie between the ends in the same proportions.
    """

    altitudes_ft: Sequence[float] = ALTITUDE_FT
    gammas_deg: Sequence[float] = (-5.0, 0.0, 5.0)
    deflections_deg: Sequence[float] = (*np.arange(-30, -12, 0.5), *np.arange(-12, 12, 1.0), *np.arange(12, 30.5, 0.5))
    speeds: int = 97

    @property
    def curves(self) -> int:
        """Number of curves of thrust over speed."""
        return len(self.altitudes_ft) * len(self.gammas_deg) * len(self.deflections_deg)

    @property
    def solves(self) -> int:
        """Number of optimisations: of the slowest speed, the fastest, and each thrust between them."""
        return self.curves * self.speeds


NODES = {
    "rudder": Nodes(),
    "aileron": Nodes(deflections_deg=tuple(np.linspace(-20.0, 20.0, 81).tolist()), speeds=49),
    "elevator": Nodes(
        altitudes_ft=(0.0, 18000.0, 36089.0), deflections_deg=tuple(np.linspace(-30.0, 30.0, 97).tolist()), speeds=33
    ),
}
"""Those of the maps that come with the package."""
TOLERANCES = {"rudder": Tolerances(), "aileron": Tolerances(), "elevator": Tolerances(least_kt=0.02, reach_deg=0.5)}
"""Theirs, chosen on cases of their own. Near its least deflection an elevator leaves two ranges of speeds with a gap
between, and whether the faster one is there depends on the altitude."""


def gross_thrust_lbf(throttle_pct: float, altitude_ft: float) -> float:
    """Thrust of both engines before ram drag at a throttle position."""
    return float(gross_thrusts_lbf(throttle_pct, altitude_ft))


def gross_thrusts_lbf(throttle_pct: ArrayLike, altitude_ft: float) -> np.ndarray:
    """The same at throttle positions of any shape."""
    positions = np.asarray(throttle_pct, dtype=float)
    speed = engines.rotor_speed(ca.DM(positions.ravel()))
    thrust = 2.0 * engines.gross_thrust(speed, atmosphere(altitude_ft).pressure_ratio)
    return np.array(thrust).reshape(positions.shape)


def _bounds_at_any_thrust(limits: ControlLimits, altitude_ft: float) -> tuple[np.ndarray, np.ndarray]:
    lower, upper = manoeuvre.bounds(limits)
    upper[THROTTLE] = THROTTLE_WITHOUT_LIMIT
    upper[V] = FASTEST_KT / float(atmosphere(altitude_ft).sqrt_density_ratio) * FT_S_PER_KT
    return lower, upper


def reach(control: str, altitude_ft: float, gamma_deg: float, limits_deg: Range) -> Range:
    """Least and greatest deflection inside the limits that any manoeuvre has, at any thrust.

    Raises:
        InputError: there is none.
    """
    lower, upper = _bounds_at_any_thrust(ControlLimits(**{f"{control}_deg": limits_deg}), altitude_ft)
    unknown = TRIM_UNKNOWNS.index(control)
    ends = []
    for sign in (1.0, -1.0):
        objective = sign * np.eye(solver.NT)[unknown]
        found = solver.envelope_end(altitude_ft, gamma_deg * RAD_PER_DEG, lower, upper, objective)
        if found.status != solver.TRIMMED:
            raise InputError(f"At {altitude_ft:g} ft and {gamma_deg:g} deg there is no manoeuvre to map.")
        ends.append(float(np.clip(found.y[unknown], *limits_deg)))
    return ends[0], ends[1]


def thrust_curve(control: str, altitude_ft: float, gamma_deg: float, deflection_deg: float, speeds: int) -> np.ndarray:
    """A row of `ThrustMap.table` (2 + speeds); NaN where nothing was found."""
    jam = ControlLimits(**{f"{control}_deg": (deflection_deg, deflection_deg)})
    eas_per_tas = float(atmosphere(altitude_ft).sqrt_density_ratio)
    lower, upper = _bounds_at_any_thrust(jam, altitude_ft)

    def least(unknown: int, sign: float, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        found = solver.envelope_end(altitude_ft, gamma_deg * RAD_PER_DEG, low, high, sign * np.eye(solver.NT)[unknown])
        return found.y if found.status == solver.TRIMMED else np.full(solver.NT, np.nan)

    ends = [least(V, sign, lower, upper) for sign in (1.0, -1.0)]
    row = np.full(2 + speeds, np.nan)
    slowest, fastest = row[:2] = [end[V] * KT_PER_FT_S * eas_per_tas for end in ends]
    row[2] = gross_thrust_lbf(ends[0][THROTTLE], altitude_ft)
    if np.isfinite(slowest) and not fastest - slowest >= _SINGLE_KT:
        row[1], row[2:] = slowest, row[2]
        return row
    for i in range(1, speeds):
        speed_kt = slowest + (fastest - slowest) * (i / (speeds - 1)) ** 2
        held = np.full(solver.NT, np.nan)
        held[V] = speed_kt / eas_per_tas * FT_S_PER_KT
        low, high = (np.where(np.isnan(held), bound, held) for bound in (lower, upper))
        found = gross_thrust_lbf(least(THROTTLE, 1.0, low, high)[THROTTLE], altitude_ft)
        row[2 + i] = found if np.isfinite(found) or i < speeds - 1 else gross_thrust_lbf(ends[1][THROTTLE], altitude_ft)
    return row


def survey(
    nodes: Nodes,
    control: str = "rudder",
    progress: Callable[[int, int], None] | None = None,
    workers: int | None = None,
    kept: Path | None = None,
) -> ThrustMap:
    """Solve a map. A thrust that was not found, at a gap between speeds, is interpolated over the deflections.

    Args:
        progress: called with the number of finished curves and of all.
        workers: threads; default one a core (the solver runs outside the interpreter's lock).
        kept: file that holds what is finished of this survey, flight condition by flight condition, until all is.

    Raises:
        InputError: the file cannot be written, or is of another survey.
    """
    conditions = [(altitude, gamma) for altitude in nodes.altitudes_ft for gamma in nodes.gammas_deg]
    deflections = np.asarray(nodes.deflections_deg, dtype=float)
    ends = deflections[0].item(), deflections[-1].item()
    reaches = np.array([reach(control, *condition, ends) for condition in conditions])
    is_whole = np.allclose(reaches, ends, rtol=0, atol=_ROUNDING_DEG)
    shares = (deflections - ends[0]) / (ends[1] - ends[0])
    asked = json.dumps([control, nodes, provenance()])
    solved = list(_read(kept, asked)) if kept else []
    curves = len(conditions) * len(deflections)
    with ThreadPoolExecutor(workers or os.cpu_count()) as pool:
        for (altitude, gamma), (least, greatest) in zip(conditions[len(solved) :], reaches[len(solved) :], strict=True):
            plane, before = [], len(solved) * len(deflections)
            solve = partial(thrust_curve, control, altitude, gamma, speeds=nodes.speeds)
            here = deflections if is_whole else least + (greatest - least) * shares
            for row in pool.map(solve, here.tolist()):
                plane.append(row)
                if progress:
                    progress(before + len(plane), curves)
            solved.append(np.array(plane))
            if kept:
                _write(kept, asked, solved)
    table = np.reshape(solved, (len(nodes.altitudes_ft), len(nodes.gammas_deg), len(deflections), -1))
    if kept:
        kept.unlink(missing_ok=True)
    return ThrustMap(
        control,
        (min(nodes.altitudes_ft), max(nodes.altitudes_ft)),
        np.array([float(atmosphere(altitude).density) / DENSITY_0 for altitude in nodes.altitudes_ft]),
        np.asarray(nodes.gammas_deg),
        deflections,
        _filled(table, deflections),
        gross_thrust_lbf(WIDEST["throttle_pct"][1], 0.0),
        TOLERANCES[control],
        provenance={
            **provenance(),
            "solves": nodes.solves,
            "interpolated": int(np.isnan(table).sum()),
        },
        reach_deg=None if is_whole else reaches.reshape(*table.shape[:2], 2),
    )


def _read(kept: Path, asked: str) -> np.ndarray:
    """Finished flight conditions (k, deflections, 2 + speeds) of the survey that is asked for."""
    if not kept.exists():
        return np.empty((0, 0, 0))
    try:
        with np.load(kept, allow_pickle=False) as content:
            if str(content["asked"]) != asked:
                raise ValueError("it is of another survey")
            return content["solved"]
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        raise InputError(f"{kept} cannot be continued ({error}); remove it to begin anew.") from None


def _write(kept: Path, asked: str, solved: list[np.ndarray]) -> None:
    def write(draft: Path) -> None:
        with draft.open("wb") as file:
            np.savez(file, asked=asked, solved=solved)

    write_whole(kept, write)


def _filled(table: np.ndarray, deflections: np.ndarray) -> np.ndarray:
    """The table (k, l, m, n) with what is missing interpolated along the deflections (m)."""
    filled = table.copy()
    for k, gamma, i in set(map(tuple, np.argwhere(np.isnan(table))[:, [0, 1, 3]].tolist())):
        known = np.isfinite(table[k, gamma, :, i])
        filled[k, gamma, :, i] = np.interp(deflections, deflections[known], table[k, gamma, known, i])
    return filled
