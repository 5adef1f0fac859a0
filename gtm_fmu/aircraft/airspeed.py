"""Calibrated and equivalent airspeed of a true one and back, in the specification's atmosphere.

With the impact pressure q_c = p ((1 + M^2 / 5)^(7/2) - 1) of a flow at Mach number M and static pressure p, the
calibrated airspeed is the speed that has the same q_c at sea level; the equivalent one has the same dynamic pressure.
"""

import math

from gtm_fmu.airframe import atmosphere as air
from gtm_fmu.units import FT_S_PER_KT, KT_PER_FT_S

_SOUND_SPEED_0 = float(air.atmosphere(0.0).sound_speed)  # ft/s


def tas_of_eas(eas_kt: float, altitude_ft: float) -> float:
    """True airspeed in kn of an equivalent one in kn."""
    return eas_kt / float(air.atmosphere(altitude_ft).sqrt_density_ratio)


def tas_of_cas(cas_kt: float, altitude_ft: float) -> float:
    """True airspeed in kn of a calibrated one in kn."""
    here = air.atmosphere(altitude_ft)
    impact = _impact_pressure_ratio(cas_kt * FT_S_PER_KT / _SOUND_SPEED_0)
    return _mach(impact / float(here.pressure_ratio)) * float(here.sound_speed) * KT_PER_FT_S


def cas_of_tas(tas_kt: float, altitude_ft: float) -> float:
    """Calibrated airspeed in kn of a true one in kn."""
    here = air.atmosphere(altitude_ft)
    impact = _impact_pressure_ratio(tas_kt * FT_S_PER_KT / float(here.sound_speed))
    return _mach(impact * float(here.pressure_ratio)) * _SOUND_SPEED_0 * KT_PER_FT_S


def eas_of_tas(tas_kt: float, altitude_ft: float) -> float:
    """Equivalent airspeed in kn of a true one in kn."""
    return tas_kt * float(air.atmosphere(altitude_ft).sqrt_density_ratio)


def _impact_pressure_ratio(mach: float) -> float:
    """q_c / p."""
    return (1 + mach**2 / 5) ** 3.5 - 1


def _mach(impact_pressure_ratio: float) -> float:
    """The inverse."""
    return math.sqrt(5 * ((1 + impact_pressure_ratio) ** (2 / 7) - 1))
