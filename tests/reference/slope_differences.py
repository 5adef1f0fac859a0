"""Slopes of an envelope by one-sided differences of exact solutions, beside those by multipliers."""

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from gtm_fmu.airframe.names import V
from gtm_fmu.envelopes.envelope import Envelope, FlightCondition
from gtm_fmu.envelopes.slopes import STEPS, Quantity, quantities
from gtm_fmu.units import KT_PER_FT_S

FEWER = (1.0, 0.03)
"""Parts of `STEPS`: where an end bends inside the longer step, the shorter one may not reach the bend."""
RELATIVE, ABSOLUTE_KT = 2e-3, 1e-6
"""Tolerances: of a slope, and of the speeds of two solutions of one end."""
FUEL_STEP_LB = 0.02


class Comparison(NamedTuple):
    """A slope and the difference nearest to it, in kn per unit; None where there are no solutions to differ."""

    name: str
    slope: float
    difference: float | None
    tolerance: float

    @property
    def agrees(self) -> bool:
        return self.difference is not None and abs(self.slope - self.difference) <= self.tolerance


def compared(found: Envelope) -> Iterator[Comparison]:
    """Each slope that `Envelope.slopes` has, to either side, of quantities that can be moved and of the fuel."""
    condition = FlightCondition(found.altitude_ft, found.gamma_deg, found.failure, found.alpha_deg, found.phi_deg)
    slopes = {slope.name: slope for slope in found.slopes}
    here = np.array([found.v_min_kt, found.v_max_kt])
    for quantity in quantities(condition):
        slope = slopes[quantity.name]
        unit = 1000.0 if quantity.name == "altitude" else 1.0
        for way, side in ((-1, "below"), (1, "above")):
            pair = [getattr(end, side) for end in (slope.v_min, slope.v_max)]
            yield from _sides(f"{quantity.name} {side}", pair, unit, _differences(condition, quantity, way, here))
    fuel = [slopes["fuel_used"].v_min.above, slopes["fuel_used"].v_max.above]
    half, whole = ((_ends(_burnt(condition, step)) - here) / step for step in (0.5 * FUEL_STEP_LB, FUEL_STEP_LB))
    yield from _sides("fuel_used above", fuel, 1.0, [(2 * half - whole, FUEL_STEP_LB)])


def _burnt(condition: FlightCondition, more_lb: float) -> FlightCondition:
    airframe = condition.failure.configuration
    airframe = replace(airframe, fuel_used_lb=airframe.fuel_used_lb + more_lb)
    return condition.changed(failure=replace(condition.failure, configuration=airframe))


def _ends(condition: FlightCondition) -> np.ndarray:
    found = condition.extremes()[:, V] * KT_PER_FT_S
    return found if len(found) == 2 else np.full(2, np.nan)


def _differences(
    condition: FlightCondition, quantity: Quantity, way: int, here: np.ndarray
) -> list[tuple[np.ndarray, float]]:
    """Slopes (2) extrapolated from two steps, and the step, for each of `FEWER`."""
    found = []
    for part in FEWER:
        step = way * part * STEPS[quantity.units]
        if quantity.toward(step) == quantity.value + step:
            ends = [_ends(quantity.moved(condition, quantity.value + share * step)) for share in (1.0, 0.5)]
            whole, half = (ends[0] - here) / step, (ends[1] - here) / (0.5 * step)
            found.append((2 * half - whole, abs(step)))
    return found


def _sides(name: str, pair: list, unit: float, differences: list[tuple[np.ndarray, float]]) -> Iterator[Comparison]:
    for k, (end, slope) in enumerate(zip(("V_min", "V_max"), pair, strict=True)):
        if slope is None:
            continue
        every = []
        for difference, step in differences:
            value = None if np.isnan(difference[k]) else float(difference[k])
            tolerance = RELATIVE * abs(value or 0.0) + ABSOLUTE_KT / step
            every.append(Comparison(f"{end} {name}", slope / unit, value, tolerance))
        if every:
            yield next((each for each in every if each.agrees), every[-1])
