"""The same plan by the exact FMUs and by maps in their place: what each chooses, and what the exact ones say of it."""

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

from examples.path_planner.planner.plan import NoPathError, Plan
from examples.path_planner.planner.planning import plan, safest_speed
from examples.path_planner.planner.scenario import Scenario
from examples.path_planner.planner.sources import EnvelopeSource, ExactFmus, MapFmu


@dataclass(frozen=True)
class Choice:
    """What a source leads to.

    Attributes:
        plan: None where it finds none.
        reason: why it finds none.
        seconds: of the whole search.
        infeasible_s: for how long the exact FMUs say that its manoeuvres cannot be flown.
        speeds_off_kt: the largest difference of its V_min or V_max from the exact ones; None without a plan.
        exact_margin_kt: least margin of its speeds to the exact ends; None without a plan.
    """

    source: str
    plan: Plan | None
    reason: str
    seconds: float
    infeasible_s: float
    speeds_off_kt: float | None
    exact_margin_kt: float | None


def compared(scenario: Scenario, exact: ExactFmus, others: Sequence[MapFmu]) -> list[Choice]:
    """The exact choice and those of others, all at the exact one's speed.

    Raises:
        NoPathError: the exact FMUs leave no steady flight.
    """
    same = replace(scenario, tas_kt=scenario.tas_kt or safest_speed(scenario, exact))
    return [_choice(same, source, exact) for source in (exact, *others)]


def _choice(scenario: Scenario, source: ExactFmus | MapFmu, exact: EnvelopeSource) -> Choice:
    began = time.perf_counter()
    try:
        found = plan(scenario, source, alternatives=False)
    except NoPathError as error:
        return Choice(source.name, None, str(error), time.perf_counter() - began, 0.0, None, None)
    seconds, infeasible_s = time.perf_counter() - began, 0.0
    off, margins = [0.0], []
    for segment in found.segments:
        asked = segment.altitude_ft, segment.gamma_deg, segment.tas_kt, segment.turn_rate_deg_s
        if not exact.answer(*asked).feasible:
            infeasible_s += segment.duration_s
        ends = exact.speeds(segment.altitude_ft, segment.gamma_deg, scenario.failure)
        if ends is not None:
            off += [abs(segment.v_min_kt - ends[0]), abs(segment.v_max_kt - ends[1])]
            margins.append(min(segment.tas_kt - ends[0], ends[1] - segment.tas_kt))
    return Choice(source.name, found, "", seconds, infeasible_s, max(off), min(margins, default=None))
