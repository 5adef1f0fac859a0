"""Flow about the aircraft: speed, angle of attack, sideslip and what follows from them (SPEC 2)."""

from __future__ import annotations

from typing import NamedTuple

from gtm_fmu.airframe.atmosphere import Atmosphere
from gtm_fmu.airframe.quantity import Quantity, ca
from gtm_fmu.units import KT_PER_FT_S


class AirData(NamedTuple):
    """True airspeed V in ft/s, alpha and beta in rad with their sines and cosines, and the air itself."""

    V: Quantity
    alpha: Quantity
    beta: Quantity
    sin_alpha: ca.SX
    cos_alpha: ca.SX
    sin_beta: ca.SX
    cos_beta: ca.SX
    air: Atmosphere

    @property
    def tas_kt(self) -> Quantity:
        """True airspeed in knots."""
        return KT_PER_FT_S * self.V

    @property
    def eas_kt(self) -> Quantity:
        """Equivalent airspeed in knots."""
        return self.tas_kt * self.air.sqrt_density_ratio

    @property
    def mach(self) -> Quantity:
        """Mach number (an output only: the model has no Mach effects)."""
        return self.V / self.air.sound_speed

    @property
    def dynamic_pressure(self) -> Quantity:
        """Dynamic pressure in lbf/ft^2."""
        return 0.5 * self.air.density * self.V**2


def from_velocity(velocity: ca.SX, air: Atmosphere) -> AirData:
    """Air data of a body-axis velocity (3) in ft/s relative to the air."""
    u, v, w = ca.vertsplit(velocity)
    in_plane = ca.sqrt(u**2 + w**2)
    V = ca.sqrt(u**2 + v**2 + w**2)
    return AirData(
        V=V,
        alpha=ca.SX(ca.atan2(w, u)),
        beta=ca.asin(v / V),
        sin_alpha=w / in_plane,
        cos_alpha=u / in_plane,
        sin_beta=v / V,
        cos_beta=in_plane / V,
        air=air,
    )


def from_angles(V: Quantity, alpha: Quantity, beta: Quantity, air: Atmosphere) -> AirData:
    """Air data of a speed in ft/s and the two flow angles in rad."""
    return AirData(V, alpha, beta, ca.sin(alpha), ca.cos(alpha), ca.sin(beta), ca.cos(beta), air)


def velocity(flow: AirData) -> ca.SX:
    """Body-axis velocity (3) in ft/s relative to the air: the inverse of `from_velocity`."""
    return flow.V * ca.vertcat(flow.cos_alpha * flow.cos_beta, flow.sin_beta, flow.sin_alpha * flow.cos_beta)
