"""What a configuration sets besides the state and the controls, as parameters of the airframe's expressions."""

from __future__ import annotations

from typing import NamedTuple

from gtm_fmu.airframe import mass, wind
from gtm_fmu.airframe.mass import MassProperties
from gtm_fmu.airframe.motion import Attitude
from gtm_fmu.airframe.quantity import ca

RANGES = {
    "fuel_used_lb": (0.0, 20.0),  # the tanks hold 11.48 lb, but the model does not stop there (SPEC 10.3)
    "stabilizer_deg": (-90.0, 90.0),
    "gear": (0.0, 1.0),
    "spoiler_deg": (-90.0, 90.0),
    "flap_deg": (-90.0, 90.0),
    "surface_gain": (0.0, 1.0),
    "surface_offset_deg": (-90.0, 90.0),
    "wind_ft_s": (-300.0, 300.0),
    "gust_ft_s": (-300.0, 300.0),
    "runway_altitude_ft": (-1500.0, 30000.0),
    "mass_factor": (0.5, 1.5),
    "cg_offset_ft": (-1.0, 1.0),
    "coefficient_factor": (0.5, 1.5),
}
"""Lowest and highest value, in the order of enum gtm_configuration_fault. Beyond is a slip of the pen: surfaces have no
other limits here, as controls have none (SPEC 10.1: trim and linearisation set positions directly)."""


class Parameters(NamedTuple):
    """Of the airframe's expressions, as numbers or symbols.

    Attributes:
        mass: mass properties.
        damaged: 1 with a damage case, else 0.
        running: (2) 1 for an engine that runs, left and right.
        steady_wind: (3) north, east, down in ft/s.
        gust: (3) body axes, ft/s.
        has_shear: 1 where the steady wind grows with height.
        runway_altitude: ft.
    """

    mass: MassProperties
    damaged: ca.SX
    running: ca.SX
    steady_wind: ca.SX
    gust: ca.SX
    has_shear: ca.SX
    runway_altitude: ca.SX

    def wind_body(self, altitude: ca.SX, att: Attitude) -> ca.SX:
        """Velocity (3) of the air in body axes (SPEC 10.6)."""
        return wind.wind_body(self.steady_wind, self.gust, self.has_shear, altitude - self.runway_altitude, att)

    def packed(self) -> ca.SX:
        """All of them in one vector (27)."""
        inertia, inverse = (mass.components(matrix) for matrix in (self.mass.inertia, self.mass.inverse_inertia))
        return ca.vertcat(self.mass.mass, self.mass.cg, *inertia, *inverse, *self[1:])


PARAMETERS = 27


def unpacked(vector: ca.SX) -> Parameters:
    """The inverse of `Parameters.packed`."""
    ends = [0, 1, 4, 10, 16, 17, 19, 22, 25, 26, PARAMETERS]
    mass_, cg, inertia, inverse, *rest = ca.vertsplit(vector, ends)
    matrices = (mass.symmetric(*ca.vertsplit(moments)) for moments in (inertia, inverse))
    return Parameters(MassProperties(mass_, cg, *matrices), *rest)
