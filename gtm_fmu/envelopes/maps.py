"""Surveys of exact envelopes over many conditions, for figures of the whole picture."""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import pairwise, product
from typing import Literal, TypeVar

import numpy as np

from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.inputs import LIMITED, Column
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.aircraft.ranges import check_range
from gtm_fmu.airframe.names import CONTROLS
from gtm_fmu.core import solver
from gtm_fmu.envelopes.envelope import FlightCondition
from gtm_fmu.envelopes.family import EnvelopeFamily, envelope_family
from gtm_fmu.envelopes.feasibility import OPTIMUM_PCT, has_envelope
from gtm_fmu.envelopes.tolerances import Tolerances
from gtm_fmu.envelopes.tolerant_envelope import tolerant_envelope_of
from gtm_fmu.errors import InputError
from gtm_fmu.progress import Advance

FIG_1 = (0.0, (10.0, 10.0))  # altitude and rudder of paper Fig. 1
GAMMAS_DEG = tuple(np.arange(-5.0, 5.5, 1.0).tolist())
ALTITUDES_FT = tuple(np.arange(0.0, 36001.0, 3000.0).tolist())
JAM_STEP = 2.0
THREADS = 2  # the solver runs outside the interpreter's lock

Kind = Literal["guaranteed", "possible"]
"""Which envelopes a survey with tolerances is of."""

Given = TypeVar("Given")
Found = TypeVar("Found")


def volume(gammas_deg: Sequence[float] = GAMMAS_DEG, advance: Advance | None = None) -> EnvelopeFamily:
    """Envelopes over flight-path angles with the rudder jammed (paper Fig. 1)."""
    altitude_ft, rudder_deg = FIG_1
    condition = FlightCondition(altitude_ft, 0.0, ControlLimits(rudder_deg=rudder_deg))
    return envelope_family(condition, "gamma", gammas_deg, progress=advance)


@dataclass(frozen=True)
class LimitSurface:
    """V_max (n, n) in kn over lower (rows) and upper (columns) limits of a control; NaN where there is no envelope.

    The diagonal holds the jams; there are no limits below it.
    """

    condition: FlightCondition
    control: Column
    limits: np.ndarray
    v_max_kt: np.ndarray
    tolerances: Tolerances | None = None
    kind: Kind | None = None


def limit_surface(
    condition: FlightCondition,
    control: str = "rudder",
    step: float = 1.0,
    advance: Advance | None = None,
    tolerances: Tolerances | None = None,
    kind: Kind = "guaranteed",
) -> LimitSurface:
    """V_max over the limits of a control in steps of deg or % (paper Fig. 33).

    Limits leave the highest V_max of the jams at their ends and of the ranges of one step between them.

    Raises:
        InputError: no such control, or a step outside 0.1 .. 30.
    """
    column, limits = _positions(control, step)
    ranges = [*((at, at) for at in limits), *pairwise(limits)]

    def highest(allowed: tuple[float, float]) -> float:
        limited = condition.changed(failure=condition.failure.with_limits(column.label, allowed))
        if tolerances:
            speeds = tolerant_envelope_of(limited, tolerances).speeds_kt(kind)
            return np.nan if speeds is None else speeds[1]
        v_max = limited.envelope().v_max_kt
        return np.nan if v_max is None else v_max

    found = np.array(_each(highest, ranges, advance))
    jams, between = found[: len(limits)], np.append(found[len(limits) :], np.nan)
    surface = np.full((len(limits), len(limits)), np.nan)
    for k in range(len(limits)):
        surface[k, k:] = np.fmax.accumulate(np.fmax(jams[k:], np.append(np.nan, between[k:-1])))
    return LimitSurface(condition, column, np.array(limits), surface, *_kept(tolerances, kind))


@dataclass(frozen=True)
class FeasibilityMap:
    """Whether a jam of a control leaves an envelope (altitudes, gammas, jams), beside what else has failed."""

    failure: Failure
    control: Column
    altitudes_ft: Sequence[float]
    gammas_deg: Sequence[float]
    jams: Sequence[float]
    feasible: np.ndarray
    tolerances: Tolerances | None = None
    kind: Kind | None = None

    def largest(self, sign: int) -> np.ndarray:
        """Largest jam (altitudes, gammas) to one side, 1 or -1, that leaves an envelope; NaN if none does."""
        jams = np.asarray(self.jams)
        sizes = np.where(self.feasible & (sign * jams >= 0), sign * jams, -1.0).max(axis=2)
        return np.where(sizes < 0, np.nan, sizes)


def feasibility_map(
    failure: Failure | None = None,
    control: str = "rudder",
    step: float | None = None,
    altitudes_ft: Sequence[float] | None = None,
    gammas_deg: Sequence[float] | None = None,
    advance: Advance | None = None,
    tolerances: Tolerances | None = None,
    kind: Kind = "guaranteed",
) -> FeasibilityMap:
    """Where an envelope exists: t_min, the least throttle that trims with every other limit kept, decides.

    Raises:
        InputError: no such control, or a step, altitude or angle outside what is allowed.
    """
    failure = Failure.of(failure)
    column, jams = _positions(control, JAM_STEP if step is None else step)
    altitudes = ALTITUDES_FT if altitudes_ft is None else altitudes_ft
    gammas = GAMMAS_DEG if gammas_deg is None else gammas_deg
    conditions = [FlightCondition(*at, failure) for at in product(altitudes, gammas)]

    def exists(condition: FlightCondition) -> list[bool]:
        jammed = [failure.with_limits(column.label, (at, at)) for at in jams]
        return [_is_feasible(condition.changed(failure=what), tolerances, kind) for what in jammed]

    rows = _each(exists, conditions, advance)
    shape = len(altitudes), len(gammas), len(jams)
    return FeasibilityMap(failure, column, altitudes, gammas, jams, np.reshape(rows, shape), *_kept(tolerances, kind))


def _kept(tolerances: Tolerances | None, kind: Kind) -> tuple[Tolerances | None, Kind | None]:
    return (tolerances, kind) if tolerances else (None, None)


def _is_feasible(condition: FlightCondition, tolerances: Tolerances | None, kind: Kind) -> bool:
    if tolerances:
        return tolerant_envelope_of(condition, tolerances).speeds_kt(kind) is not None
    if condition.failure.airframe.throttles == solver.TWO_THROTTLES:  # which have no least one
        return condition.envelope().feasible
    t_min = condition.least_throttle()
    return t_min is not None and bool(has_envelope(t_min, condition.failure.upper[-1], OPTIMUM_PCT))


def _positions(control: str, step: float) -> tuple[Column, list[float]]:
    """A control and its positions from limit to limit."""
    if control not in CONTROLS:
        raise InputError(f"There is no control '{control}'; choose one of {', '.join(CONTROLS)}.")
    column, (lower, upper) = LIMITED[control]
    step = check_range(f"step in {column.units}", step, (0.1, 30.0))
    return column, np.arange(lower, upper + 0.5 * step, step).clip(max=upper).tolist()


def _each(solve: Callable[[Given], Found], given: Sequence[Given], advance: Advance | None) -> list[Found]:
    found: list[Found] = []
    with ThreadPoolExecutor(THREADS) as pool:
        for one in pool.map(solve, given):
            found.append(one)
            if advance:
                advance(len(found), len(given))
    return found
