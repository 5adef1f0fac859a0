"""Mass, centre of gravity and inertia (SPEC 3, 10.4, 10.5), in slug, ft and slug ft^2."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gtm_fmu.airframe.atmosphere import GRAVITY
from gtm_fmu.airframe.damage import DAMAGE_CASES
from gtm_fmu.airframe.quantity import Quantity, ca

WING_AREA = 5.9018  # ft^2
MEAN_CHORD = 0.9153  # ft
SPAN = 6.8488  # ft
CHORD_LEADING_EDGE = 4.5462  # ft aft of the datum
WEIGHT_FULL_FUEL = 57.75  # lb
CG_FULL_FUEL = np.array([-(CHORD_LEADING_EDGE + 0.2199 * MEAN_CHORD), -0.1416 / 12, -0.9761])  # ft
MOMENT_REFERENCE = np.array([-(CHORD_LEADING_EDGE + 0.25 * MEAN_CHORD), 0.0, -0.9401])  # ft, of the aerodynamic data
INERTIA_FULL_FUEL = np.array([1.221, 4.655, 5.587, 0.274, 0.0, 0.006])  # Ixx Iyy Izz Ixz Iyz Ixy
AFT_TANK_LB = 5.74  # the aft tank empties first
AFT_TANK = np.array([-62.30, 0.0, -13.86]) / 12  # ft
FORWARD_TANK = np.array([-53.43, 0.0, -13.86]) / 12  # ft
FUEL_INERTIA = np.array(  # polynomials in fuel used, highest power first; their last terms count at no fuel used too
    [
        [0.000015212259037, -0.000108396795757, 0.001076938008733],
        [0.000032526556068, -0.000298176766717, 0.002102173236731],
        [-0.000019873124706, 0.000212146005908, 0.001301531989172],
    ]
)
GEAR_CG = np.array([-0.0025, 0.0, 0.0150])  # ft (SPEC 10.4)
GEAR_INERTIA = np.array([0.0441, 0.0, 0.006994, 0.0, 0.0, 0.0])
GEAR_DOWN = 0.5  # gear signal from which on the gear counts as down (SPEC 3)


class MassProperties(NamedTuple):
    """Mass in slug, centre of gravity in ft (frame of the airframe), inertia matrix in slug ft^2 and its inverse."""

    mass: Quantity
    cg: ca.DM | ca.SX
    inertia: ca.DM | ca.SX
    inverse_inertia: ca.DM | ca.SX

    def varied(self, factor: Quantity, cg_offset: Quantity) -> MassProperties:
        """Mass and inertia by a factor, and the centre of gravity moved by an offset (3) in ft."""
        inertia, inverse = self.inertia * factor, self.inverse_inertia / factor
        return MassProperties(self.mass * factor, self.cg + cg_offset, inertia, inverse)


def symmetric(
    ixx: Quantity, iyy: Quantity, izz: Quantity, ixz: Quantity, iyz: Quantity, ixy: Quantity
) -> ca.DM | ca.SX:
    """Inertia matrix (3, 3) of moments and products of inertia (SPEC 3)."""
    return ca.vertcat(ca.horzcat(ixx, -ixy, -ixz), ca.horzcat(-ixy, iyy, -iyz), ca.horzcat(-ixz, -iyz, izz))


def components(matrix: ca.DM | ca.SX) -> list:
    """Ixx Iyy Izz Ixz Iyz Ixy of an inertia matrix (3, 3): the inverse of `symmetric`."""
    return [matrix[0, 0], matrix[1, 1], matrix[2, 2], -matrix[0, 2], -matrix[1, 2], -matrix[0, 1]]


def mass_properties(fuel_used_lb: Quantity = 0.0, gear: Quantity = 0.0, damage_case: Quantity = 0) -> MassProperties:
    """Mass properties after burning ``fuel_used_lb``, with the gear at 0 (up) .. 1 (down), damaged or not (SPEC 3).

    Numbers give numbers, symbols give expressions. The moments ``W0 cg0`` are those of the whole aircraft, while the
    weight that divides them is without the lost part (SPEC 10.5).
    """
    gear_down = gear >= GEAR_DOWN

    def damaged(name: str) -> Quantity:
        return sum((damage_case == case) * ca.DM(getattr(damage, name)) for case, damage in enumerate(DAMAGE_CASES))

    weight = WEIGHT_FULL_FUEL - fuel_used_lb + damaged("weight_lb")
    aft, forward = ca.fmin(AFT_TANK_LB, fuel_used_lb), ca.fmax(0.0, fuel_used_lb - AFT_TANK_LB)
    burnt = aft * ca.DM(AFT_TANK) + forward * ca.DM(FORWARD_TANK)
    cg = (WEIGHT_FULL_FUEL * ca.DM(CG_FULL_FUEL) - burnt) / weight + gear_down * ca.DM(GEAR_CG) + damaged("cg_in") / 12
    fuel = ca.vertcat(*(ca.polyval(ca.DM(polynomial), fuel_used_lb) for polynomial in FUEL_INERTIA), 0, 0, 0)
    moments = ca.DM(INERTIA_FULL_FUEL) + fuel + gear_down * ca.DM(GEAR_INERTIA) + damaged("inertia")
    inertia = symmetric(*ca.vertsplit(moments))
    inverse = ca.inv_minor(inertia) if isinstance(inertia, ca.SX) else ca.DM(np.linalg.inv(inertia.full()))
    return MassProperties(weight / GRAVITY, cg, inertia, inverse)
