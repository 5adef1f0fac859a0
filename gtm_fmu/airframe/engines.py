"""The two small turbojets: thrust, rotor and their loads (SPEC 6)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gtm_fmu.airframe.airdata import AirData
from gtm_fmu.airframe.mass import WING_AREA, MassProperties
from gtm_fmu.airframe.quantity import Quantity, ca
from gtm_fmu.units import RAD_PER_DEG

SPEED_POLYNOMIAL = (0.000033035538475, -0.008354385314499, 1.191126728328792, 31.518959847101669)  # % rpm of %
THRUST_CUBIC = 0.000014847593013  # lbf per %^3 at sea level
THRUST_OFFSET = 0.412662356277121  # lbf at sea level
RAM_DRAG = 0.010  # of dynamic pressure times wing area
ROTOR_DIAMETER = 0.75 / 12  # ft
ROTOR_LENGTH = 6.25 / 12  # ft
ROTOR_DENSITY = 15.2  # slug/ft^3
ROTOR_INERTIA = np.pi * ROTOR_DIAMETER**4 / 32 * ROTOR_LENGTH * ROTOR_DENSITY
FULL_SPEED_RAD_S = 123000 * 2 * np.pi / 60
FUEL_FLOW_POLYNOMIAL = (0.000046800927870, -0.000779344124807, 0.122178501497750)  # lb/min of % rpm (SPEC 10.3)


class Mounting(NamedTuple):
    """Position in ft (reference frame of the airframe) and direction of thrust and rotor axis."""

    position: np.ndarray
    direction: np.ndarray


def _mounting(position_in: tuple[float, float, float], pitch_deg: float, yaw_deg: float) -> Mounting:
    pitch, yaw = pitch_deg * RAD_PER_DEG, yaw_deg * RAD_PER_DEG
    direction = np.array([np.cos(pitch) * np.cos(yaw), np.sin(yaw), -np.sin(pitch) * np.cos(yaw)])
    return Mounting(np.array(position_in) / 12, direction)


LEFT = _mounting((-51.903, -14.20, -7.71), pitch_deg=1.98, yaw_deg=2.22)
RIGHT = _mounting((-51.903, 14.20, -7.71), pitch_deg=1.95, yaw_deg=-1.18)


class Engine(NamedTuple):
    """Rotor speed in % rpm, net thrust in lbf, angular momentum in slug ft^2/s."""

    rotor_speed: ca.SX
    thrust: ca.SX
    angular_momentum: ca.SX


def rotor_speed(throttle: Quantity) -> ca.SX:
    """Rotor speed in % of an engine that runs, at a throttle position in % (SPEC 6)."""
    return ca.polyval(ca.DM(SPEED_POLYNOMIAL), throttle)


def gross_thrust(speed: Quantity, pressure_ratio: Quantity) -> Quantity:
    """Thrust of one engine in lbf before ram drag, from its rotor speed in % (SPEC 6)."""
    return (THRUST_CUBIC * speed**3 + THRUST_OFFSET) * pressure_ratio


def engine(throttle: Quantity, flow: AirData, running: Quantity = 1) -> Engine:
    """One engine at a throttle position in percent; net thrust never falls below zero (SPEC 6).

    With ``running`` 0 all its outputs are zero, its ram drag too (SPEC 10.2).
    """
    speed = running * rotor_speed(throttle)
    gross = gross_thrust(speed, flow.air.pressure_ratio)
    thrust = ca.fmax(0, gross - RAM_DRAG * flow.dynamic_pressure * WING_AREA)
    return Engine(speed, running * thrust, ROTOR_INERTIA * FULL_SPEED_RAD_S * speed / 100)


def fuel_flow(rotor_speed: Quantity, running: Quantity) -> ca.SX:
    """Fuel flow in lb/min; an engine that does not run burns nothing (SPEC 10.2, 10.3)."""
    return running * ca.polyval(ca.DM(FUEL_FLOW_POLYNOMIAL), rotor_speed)


def both_engines(throttles: ca.SX, flow: AirData, running: ca.SX | None = None) -> tuple[Engine, Engine]:
    """Left and right engine at throttle positions in percent, one for both or one each, ``running`` (2) or not."""
    if running is None:
        same = engine(throttles, flow)
        return same, same
    return engine(throttles[0], flow, running[0]), engine(throttles[1], flow, running[1])


def engine_loads(left: Engine, right: Engine, rates: ca.SX, mass: MassProperties) -> tuple[ca.SX, ca.SX]:
    """Force (3, lbf) and moment (3, ft lbf); the gyroscopic term carries the specification's sign (SPEC 6)."""
    force, moment, momentum = ca.SX.zeros(3), ca.SX.zeros(3), ca.SX.zeros(3)
    for side, mounting in ((left, LEFT), (right, RIGHT)):
        direction = ca.DM(mounting.direction)
        force += side.thrust * direction
        moment += ca.cross(ca.DM(mounting.position) - mass.cg, side.thrust * direction)
        momentum += side.angular_momentum * direction
    return force, moment + ca.cross(rates, momentum)
