"""Ends of an envelope whose manoeuvres keep alpha inside its bounds in a gust across the wings.

With a gust w alpha changes by atan(w / V), so that its bounds depend on the speed itself, and an end is a root:
V = V_min(bounds at V). They widen with V. So V_min(bounds at V) falls with V, and there is one root. V_max(bounds at V)
rises, and solution after solution from above comes down to its largest root.
"""

from collections.abc import Callable

import numpy as np

from gtm_fmu.airframe.names import V
from gtm_fmu.core import solver
from gtm_fmu.envelopes.envelope import FlightCondition
from gtm_fmu.envelopes.tolerances import Tolerances
from gtm_fmu.units import KT_PER_FT_S

_SAME_KT = 1e-4
_MOST_SOLUTIONS = 60

End = tuple[FlightCondition, np.ndarray]
"""A condition with the bounds of alpha at its end, and the unknowns of the manoeuvre there."""
_Kept = Callable[[float], End | None]


def end_in_gust(condition: FlightCondition, tolerances: Tolerances, sign: float) -> End | None:
    """V_min (``sign`` 1) or V_max (-1) of the manoeuvres that the gust leaves; None where it leaves none."""

    def kept(tas_kt: float) -> End | None:
        alpha_deg = tolerances.alpha_kept(condition.alpha_deg, tas_kt)
        if alpha_deg is None:
            return None
        narrowed = condition.changed(alpha_deg=alpha_deg)
        found = narrowed.end(sign)
        return (narrowed, found.y) if found.status == solver.TRIMMED else None

    still = condition.end(sign)
    if still.status != solver.TRIMMED:
        return None
    if not tolerances.gust_kt:
        return condition, still.y
    speed = float(still.y[V] * KT_PER_FT_S)
    if sign < 0:
        return _largest_root(kept, speed)
    fastest = condition.end(-1.0)
    return _only_root(kept, speed, float(fastest.y[V] * KT_PER_FT_S)) if fastest.status == solver.TRIMMED else None


def _largest_root(kept: _Kept, speed: float) -> End | None:
    """Of V = V_max(bounds of alpha at V), from above."""
    for _ in range(_MOST_SOLUTIONS):
        if (found := kept(speed)) is None:
            return None
        lower = float(found[1][V] * KT_PER_FT_S)
        if speed - lower < _SAME_KT:
            return found
        speed = lower
    return None


def _only_root(kept: _Kept, slowest: float, fastest: float) -> End | None:
    """Of V = V_min(bounds of alpha at V) between two speeds, by secants or halves."""
    low: tuple[float, float | None] = slowest, None
    high: tuple[float, float | None] = fastest, None
    speed = slowest
    for k in range(_MOST_SOLUTIONS):
        found = kept(speed)
        excess = float(found[1][V] * KT_PER_FT_S) - speed if found else None
        if found and excess is not None and abs(excess) < _SAME_KT:
            return found
        if excess is None or excess > 0:
            low = speed, excess
        else:
            high = speed, excess
        if k == 0:
            speed = slowest + excess if excess is not None else fastest
            continue
        if high[1] is None:
            if speed >= fastest:
                return None
            speed = fastest
        elif low[1] is None or k % 4 == 3:
            speed = 0.5 * (low[0] + high[0])
        else:
            speed = low[0] + (high[0] - low[0]) * low[1] / (low[1] - high[1])
    return None
