"""Surveys of exact envelopes over many conditions, for figures of the whole picture."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import product

import numpy as np

from gtm_fmu.envelope import Boundary, FlightCondition
from gtm_fmu.failures import WIDEST, Range
from study.progress import Advance

GAMMAS_DEG = tuple(np.arange(-5.0, 5.5, 1.0).tolist())
ALTITUDES_FT = tuple(np.arange(0.0, 36001.0, 3000.0).tolist())
JAMS_DEG = tuple(np.arange(WIDEST["rudder_deg"][0], WIDEST["rudder_deg"][1] + 1, 2.0).tolist())
THREADS = 2  # the solver runs outside the interpreter's lock


@dataclass(frozen=True)
class Volume:
    """Boundaries of the envelope over flight-path angles in deg: the paper's three-dimensional envelope."""

    altitude_ft: float
    rudder_deg: Range
    gammas_deg: Sequence[float]
    boundaries: Sequence[Boundary]


def envelope_volume(altitude_ft: float, rudder_deg: Range, advance: Advance) -> Volume:
    """Boundaries at every flight-path angle of `GAMMAS_DEG` (paper Figs. 1 and 2)."""
    boundaries = []
    for k, gamma_deg in enumerate(GAMMAS_DEG):
        boundaries.append(FlightCondition(altitude_ft, gamma_deg).boundary(rudder_deg))
        advance(k + 1, len(GAMMAS_DEG))
    return Volume(altitude_ft, rudder_deg, GAMMAS_DEG, boundaries)


@dataclass(frozen=True)
class LimitSurface:
    """V_max (n, n) in kt over lower (rows) and upper (columns) rudder limits in deg; NaN below the diagonal of jams."""

    altitude_ft: float
    gamma_deg: float
    limits_deg: np.ndarray
    v_max_kt: np.ndarray


def limit_surface(altitude_ft: float, gamma_deg: float, advance: Advance, step_deg: float = 1.0) -> LimitSurface:
    """V_max over rudder limits (paper Fig. 33): the highest of all jams inside the limits, which is what they leave."""
    limits = np.arange(WIDEST["rudder_deg"][0], WIDEST["rudder_deg"][1] + step_deg / 2, step_deg)
    condition, jams = FlightCondition(altitude_ft, gamma_deg), np.full(limits.size, np.nan)
    for k, deflection in enumerate(limits.tolist()):
        v_max = condition.envelope((deflection, deflection)).v_max_kt
        jams[k] = np.nan if v_max is None else v_max
        advance(k + 1, limits.size)
    surface = np.full((limits.size, limits.size), np.nan)
    for k in range(limits.size):
        surface[k, k:] = np.fmax.accumulate(jams[k:])
    return LimitSurface(altitude_ft, gamma_deg, limits, surface)


@dataclass(frozen=True)
class FeasibilityMap:
    """Least throttle t_min (altitudes, gammas, jams) in % of a steady manoeuvre with a jammed rudder."""

    altitudes_ft: Sequence[float]
    gammas_deg: Sequence[float]
    jams_deg: Sequence[float]
    t_min_pct: np.ndarray


def feasibility_map(advance: Advance) -> FeasibilityMap:
    """t_min over altitude, flight-path angle and jam: an envelope exists where it is at most full throttle."""
    conditions = list(product(ALTITUDES_FT, GAMMAS_DEG))

    def least_throttle(condition: tuple[float, float]) -> list[float]:
        found = FlightCondition(*condition)
        values = [found.least_throttle((deflection, deflection)) for deflection in JAMS_DEG]
        return [np.nan if value is None else value for value in values]

    rows = []
    with ThreadPoolExecutor(THREADS) as pool:
        for row in pool.map(least_throttle, conditions):
            rows.append(row)
            advance(len(rows), len(conditions))
    shape = len(ALTITUDES_FT), len(GAMMAS_DEG), len(JAMS_DEG)
    return FeasibilityMap(ALTITUDES_FT, GAMMAS_DEG, JAMS_DEG, np.reshape(rows, shape))
