"""Mass, centre of gravity and inertia (SPEC 3), in slug, ft and slug ft^2."""

from typing import NamedTuple

import numpy as np

from gtm_fmu.airframe.atmosphere import GRAVITY

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


class MassProperties(NamedTuple):
    """Mass in slug, centre of gravity in ft (reference frame of the airframe), inertia matrix in slug ft^2."""

    mass: float
    cg: np.ndarray
    inertia: np.ndarray


def mass_properties(fuel_used_lb: float = 0.0) -> MassProperties:
    """Mass properties of the undamaged aircraft, gear up, after burning ``fuel_used_lb`` (SPEC 3)."""
    weight = WEIGHT_FULL_FUEL - fuel_used_lb
    burnt = min(AFT_TANK_LB, fuel_used_lb) * AFT_TANK + max(0.0, fuel_used_lb - AFT_TANK_LB) * FORWARD_TANK
    cg = (WEIGHT_FULL_FUEL * CG_FULL_FUEL - burnt) / weight
    ixx, iyy, izz, ixz, iyz, ixy = INERTIA_FULL_FUEL + np.append(
        [np.polyval(polynomial, fuel_used_lb) for polynomial in FUEL_INERTIA], np.zeros(3)
    )
    inertia = np.array([[ixx, -ixy, -ixz], [-ixy, iyy, -iyz], [-ixz, -iyz, izz]])
    return MassProperties(weight / GRAVITY, cg, inertia)
