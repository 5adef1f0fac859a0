"""What may be asked of the aircraft: ranges of controls, flight conditions and manoeuvres, and their checks."""

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from gtm_fmu.airframe.actuators import RATE_LIMIT_DEG_S
from gtm_fmu.airframe.atmosphere import TROPOPAUSE_FT
from gtm_fmu.airframe.names import STATES
from gtm_fmu.errors import InputError
from gtm_fmu.units import M_PER_FT, RAD_PER_DEG

Range = tuple[float, float]

WIDEST: dict[str, Range] = {
    "elevator_deg": (-30.0, 30.0),
    "aileron_deg": (-20.0, 20.0),
    "rudder_deg": (-30.0, 30.0),
    "throttle_pct": (0.0, 100.0),
}
"""Limits of the undamaged aircraft, in the order of `names.CONTROLS` (SPEC 9)."""

FASTEST_DEG_S = RATE_LIMIT_DEG_S
"""Rate limit of every aerodynamic surface of the undamaged aircraft (SPEC 10.1)."""

ALPHA_DEG: Range = (-5.0, 10.5)
PHI_DEG: Range = (-30.0, 30.0)
"""Bounds of the study on alpha and phi (SPEC 9, paper Fig. 8)."""

WIDEST_ALPHA_DEG: Range = (-20.0, 40.0)
WIDEST_PHI_DEG: Range = (-80.0, 80.0)
BETA_DEG: Range = (-45.0, 45.0)
"""Widest bounds that may be asked for; sideslip as far as the aerodynamic tables go."""

ALTITUDE_FT: Range = (0.0, math.floor(TROPOPAUSE_FT))
GAMMA_DEG: Range = (-45.0, 45.0)
TAS_KT: Range = (20.0, 350.0)
TURN_RATE_DEG_S: Range = (-90.0, 90.0)
"""What may be asked: the atmosphere's first layer, and speeds, paths and turns that hold every trim of the model."""

STATE_SI = np.where(np.isin(STATES, ("u", "v", "w", "altitude")), M_PER_FT, 1.0)
CONTROL_SI = np.array([RAD_PER_DEG, RAD_PER_DEG, RAD_PER_DEG, 0.01])
"""SI units in one of the airframe's, of the states and the controls."""


def check_range(name: str, value: float, allowed: Range, advice: str = "give a value inside") -> float:
    """The value as a float.

    Raises:
        InputError: not a finite number inside ``allowed``.
    """
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise InputError(f"{name} {value!r} is not a number; give one from {allowed[0]:g} to {allowed[1]:g}.") from None
    if not allowed[0] <= number <= allowed[1]:
        raise InputError(f"{name} {number:g} is outside {allowed[0]:g} .. {allowed[1]:g}; {advice}.")
    return number


def check_values(name: str, values: ArrayLike, allowed: Range) -> np.ndarray:
    """The values as a float array of the same shape.

    Raises:
        InputError: not numbers, or one of them not finite or not inside ``allowed``.
    """
    try:
        numbers = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise InputError(f"{name} is no array of numbers; give some from {allowed[0]:g} to {allowed[1]:g}.") from None
    outside = numbers[~((allowed[0] <= numbers) & (numbers <= allowed[1]))]
    if outside.size:
        raise InputError(
            f"{name}: {outside.size} of {numbers.size} values are outside {allowed[0]:g} .. {allowed[1]:g}, "
            f"the first is {outside[0]:g}; give values inside."
        )
    return numbers


def check_pair(name: str, pair: Iterable[float], widest: Range) -> Range:
    """Lower and upper bound as floats.

    Raises:
        InputError: not two numbers, reversed, or not inside ``widest``.
    """
    try:
        if isinstance(pair, str | bytes):  # "12" is no pair of 1 and 2
            raise TypeError
        lower, upper = pair
    except (TypeError, ValueError):
        raise InputError(f"{name} {pair!r} is not a pair; give two numbers, lower and upper bound.") from None
    lower, upper = check_range(name, lower, widest), check_range(name, upper, widest)
    if lower > upper:
        raise InputError(f"{name} {lower:g} {upper:g} are reversed; give the lower one first.")
    return lower, upper
