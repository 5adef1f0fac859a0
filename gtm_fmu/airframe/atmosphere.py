"""First layer of the 1976 standard atmosphere, in the specification's English units (SPEC 2)."""

from __future__ import annotations

from typing import NamedTuple

from gtm_fmu.airframe.quantity import Quantity, clip, sqrt
from gtm_fmu.units import M_PER_FT

EARTH_RADIUS_FT = 20855531.5  # SPEC 1, R_a; the navigation equations use another one
TROPOPAUSE_FT = 11000 / M_PER_FT
T0_DEGR = 288.15 * 1.8
LAPSE_DEGR_PER_FT = -6.5 * 1.8 / (1000 / M_PER_FT)
GAS_CONSTANT = 1716.55915670803  # ft^2/(s^2 degR)
PRESSURE_0_PSF = 2116.22
DENSITY_0 = 0.0023769  # slug/ft^3, reference of the density ratio
GRAVITY = 32.17405  # ft/s^2, constant with height; converts weight to mass too (SPEC 1)
HEAT_CAPACITY_RATIO = 1.4


class Atmosphere(NamedTuple):
    """Air at rest: density in slug/ft^3, pressure ratio, speed of sound in ft/s."""

    density: Quantity
    pressure_ratio: Quantity
    sound_speed: Quantity

    @property
    def sqrt_density_ratio(self) -> Quantity:
        """EAS over TAS."""
        return sqrt(self.density / DENSITY_0)


def atmosphere(altitude_ft: Quantity) -> Atmosphere:
    """Air at a geometric altitude in ft; geopotential height is held inside 0 .. 11 000 m (SPEC 2)."""
    geopotential = EARTH_RADIUS_FT * altitude_ft / (EARTH_RADIUS_FT + altitude_ft)
    height = clip(geopotential, 0, TROPOPAUSE_FT)
    temperature = T0_DEGR + LAPSE_DEGR_PER_FT * height
    pressure_ratio = (temperature / T0_DEGR) ** (-GRAVITY / (GAS_CONSTANT * LAPSE_DEGR_PER_FT))
    return Atmosphere(
        density=PRESSURE_0_PSF * pressure_ratio / (GAS_CONSTANT * temperature),
        pressure_ratio=pressure_ratio,
        sound_speed=sqrt(HEAT_CAPACITY_RATIO * GAS_CONSTANT * temperature),
    )
