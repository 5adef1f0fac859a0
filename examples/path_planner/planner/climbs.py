"""The same height gained steeply or shallowly: the margin at each moment, and what is short of it over the climb."""

from dataclasses import dataclass

import numpy as np

from examples.path_planner.planner.costs import Margins
from examples.path_planner.planner.plan import NoPathError
from examples.path_planner.planner.planning import safest_speed
from examples.path_planner.planner.scenario import Scenario
from examples.path_planner.planner.sources import ExactFmus
from examples.path_planner.planner.tracks import displacement

CLIMBS_DEG = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0)
_PARTS = 9


@dataclass(frozen=True)
class Climb:
    """A straight climb.

    Attributes:
        seconds: that it takes.
        margin_kt: least margin of the speed on the way.
        after_kt: least that the second failure leaves; None where it leaves nothing.
        after_v_min_kt, after_v_max_kt: speeds that it leaves at the start; NaN without any.
        short_kt_s: what is short of the margin that is wanted after the second failure, integrated over time.
    """

    gamma_deg: float
    seconds: float
    margin_kt: float
    after_kt: float | None
    after_v_min_kt: float
    after_v_max_kt: float
    short_kt_s: float


def climbs(scenario: Scenario, source: ExactFmus, height_ft: float, tas_kt: float | None = None) -> list[Climb]:
    """Of `CLIMBS_DEG` those that can be flown straight over a height from the start.

    Raises:
        NoPathError: none can.
    """
    speed = tas_kt or scenario.tas_kt or safest_speed(scenario, source)
    found = [_climb(scenario, source, height_ft, gamma, speed) for gamma in CLIMBS_DEG]
    possible = [climb for climb in found if climb is not None]
    if not possible:
        raise NoPathError(f"No straight climb is left at {speed:g} kn.")
    return possible


def _climb(scenario: Scenario, source: ExactFmus, height_ft: float, gamma: float, tas_kt: float) -> Climb | None:
    altitudes = scenario.start.altitude_ft + np.linspace(0.0, height_ft, _PARTS)
    rows = np.array([(h, gamma, tas_kt, 0.0) for h in altitudes])
    if not source.are_feasible(rows).all():
        return None
    margins = Margins(source, scenario.failure, scenario.cost)
    rate = float(displacement(np.float64(tas_kt), np.float64(gamma), np.float64(0.0), np.float64(1.0))[2])
    now = [margins.now_kt(h, gamma, tas_kt) for h in altitudes.tolist()]
    after = [margins.worst_after(h, gamma, tas_kt) for h in altitudes.tolist()]
    wanted = scenario.cost.wanted_kt
    # Where nothing is left, the shortfall is that of the cost: twice what is wanted.
    short = [2.0 * wanted if m is None else min(max(wanted - m, 0.0), 2.0 * wanted) for m in after]
    known = [m for m in after if m is not None]
    left = [source.speeds(float(altitudes[0]), gamma, variant) for each in margins.further.values() for variant in each]
    low, high = (np.nan, np.nan) if None in left else (max(x[0] for x in left if x), min(x[1] for x in left if x))
    return Climb(
        gamma,
        height_ft / rate,
        min(m for m in now if m is not None),
        None if len(known) < len(after) else min(known),
        float(low),
        float(high),
        float(np.trapezoid(short, dx=height_ft / rate / (_PARTS - 1))),
    )
