"""Wind and its growth with height (SPEC 10.6), in ft and ft/s."""

from __future__ import annotations

import numpy as np

from gtm_fmu.airframe.motion import Attitude, body_components
from gtm_fmu.airframe.quantity import Quantity, ca

RUNWAY_ALTITUDE_FT = 12.0
ROUGHNESS_FT = 0.15
REFERENCE_HEIGHT_FT = 20.0
LEAST_HEIGHT_FT, LARGEST_HEIGHT_FT = 1.0, 1000.0
GAIN_RATIO = 1.8


def shear_gain(height: Quantity) -> ca.SX:
    """Wind at a height in ft above the runway, as a part of the wind that is given."""
    held = ca.fmin(ca.fmax(height, LEAST_HEIGHT_FT), LARGEST_HEIGHT_FT)
    return ca.log(held / ROUGHNESS_FT) / (np.log(REFERENCE_HEIGHT_FT / ROUGHNESS_FT) * GAIN_RATIO)


def wind_body(steady: ca.SX, gust: ca.SX, has_shear: Quantity, height: Quantity, att: Attitude) -> ca.SX:
    """Velocity (3) of the air in body axes: steady wind (north, east, down), with or without shear, and gust (3)."""
    return ca.if_else(has_shear, shear_gain(height), 1) * body_components(steady, att) + gust
