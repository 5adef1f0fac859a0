"""Rigid body over a flat earth: accelerations, kinematics and outputs (SPEC 7 and 8)."""

from __future__ import annotations

from typing import NamedTuple

from gtm_fmu.airframe import airdata
from gtm_fmu.airframe.aerodynamics import aerodynamic_loads
from gtm_fmu.airframe.airdata import AirData
from gtm_fmu.airframe.atmosphere import GRAVITY, atmosphere
from gtm_fmu.airframe.engines import Engine, both_engines, engine_loads
from gtm_fmu.airframe.mass import MassProperties
from gtm_fmu.airframe.quantity import Quantity, ca
from gtm_fmu.units import DEG_PER_RAD, M_PER_FT

NAVIGATION_RADIUS_FT = 6.37043246e6 / M_PER_FT  # SPEC 1, R_e
LOAD_FACTOR_G = 32.174  # ft/s^2, of the accelerometer readings only (SPEC 8)


class Attitude(NamedTuple):
    """Sines and cosines of the Euler angles."""

    sin_phi: ca.SX
    cos_phi: ca.SX
    sin_theta: ca.SX
    cos_theta: ca.SX
    sin_psi: ca.SX
    cos_psi: ca.SX


def attitude(phi: Quantity, theta: Quantity, psi: Quantity) -> Attitude:
    """Attitude of Euler angles in rad."""
    return Attitude(ca.sin(phi), ca.cos(phi), ca.sin(theta), ca.cos(theta), ca.sin(psi), ca.cos(psi))


def down(att: Attitude) -> ca.SX:
    """Unit vector (3) of gravity in body axes: the last column of the direction cosine matrix."""
    return ca.vertcat(-att.sin_theta, att.sin_phi * att.cos_theta, att.cos_phi * att.cos_theta)


def earth_velocity(velocity: ca.SX, att: Attitude) -> ca.SX:
    """North, east and down components (3) of a body-axis velocity (SPEC 2)."""
    u, v, w = ca.vertsplit(velocity)
    level = att.sin_phi * v + att.cos_phi * w
    forward = att.cos_theta * u + att.sin_theta * level
    right = att.cos_phi * v - att.sin_phi * w
    return ca.vertcat(
        att.cos_psi * forward - att.sin_psi * right,
        att.sin_psi * forward + att.cos_psi * right,
        att.cos_theta * level - att.sin_theta * u,
    )


def body_components(vector: ca.SX, att: Attitude) -> ca.SX:
    """Body-axis components (3) of a vector north, east, down: the inverse of `earth_velocity` (SPEC 2)."""
    north, east, down_ = ca.vertsplit(vector)
    ahead = att.cos_psi * north + att.sin_psi * east
    across = att.cos_psi * east - att.sin_psi * north
    below = att.sin_theta * ahead + att.cos_theta * down_
    return ca.vertcat(
        att.cos_theta * ahead - att.sin_theta * down_,
        att.cos_phi * across + att.sin_phi * below,
        att.cos_phi * below - att.sin_phi * across,
    )


def accelerations(
    velocity: ca.SX,
    rates: ca.SX,
    att: Attitude,
    flow: AirData,
    C: ca.SX,
    engines: tuple[Engine, Engine],
    mass: MassProperties,
) -> ca.SX:
    """Derivatives (6) of body velocity (ft/s^2) and body rates (rad/s^2) (SPEC 7)."""
    aero_force, aero_moment = aerodynamic_loads(C, flow, mass)
    thrust_force, thrust_moment = engine_loads(*engines, rates, mass)
    force = aero_force + thrust_force
    moment = aero_moment + thrust_moment
    linear = force / mass.mass + GRAVITY * down(att) - ca.cross(rates, velocity)
    angular = mass.inverse_inertia @ (moment - ca.cross(rates, mass.inertia @ rates))
    return ca.vertcat(linear, angular)


def state_derivatives(
    x: ca.SX, u: ca.SX, C: ca.SX, mass: MassProperties, wind: Quantity = 0, running: ca.SX | None = None
) -> ca.SX:
    """Derivatives (12) of the state x (12) with total coefficients C (6) (SPEC 7).

    Controls u are three surfaces and one throttle, or with ``running`` (2) given that of the left and of the right
    engine. The wind (3, ft/s) is in body axes.
    """
    velocity, rates = x[:3], x[3:6]
    latitude, altitude = x[6], x[8]
    att = attitude(x[9], x[10], x[11])
    flow = airdata.from_velocity(velocity - wind, atmosphere(altitude))
    north, east, sink = ca.vertsplit(earth_velocity(velocity, att))
    p, q, r = ca.vertsplit(rates)
    turning = q * att.sin_phi + r * att.cos_phi
    return ca.vertcat(
        accelerations(velocity, rates, att, flow, C, both_engines(u[3:], flow, running), mass),
        north / (NAVIGATION_RADIUS_FT + altitude),
        east / ((NAVIGATION_RADIUS_FT + altitude) * ca.cos(latitude)),
        -sink,
        p + att.sin_theta / att.cos_theta * turning,
        q * att.cos_phi - r * att.sin_phi,
        turning / att.cos_theta,
    )


def outputs(
    x: ca.SX, u: ca.SX, C: ca.SX, mass: MassProperties, wind: Quantity = 0, running: ca.SX | None = None
) -> ca.SX:
    """Outputs in the order of `names.OUTPUTS` (SPEC 8); arguments as those of `state_derivatives`."""
    velocity, rates = x[:3], x[3:6]
    att = attitude(x[9], x[10], x[11])
    flow = airdata.from_velocity(velocity - wind, atmosphere(x[8]))
    north, east, sink = ca.vertsplit(earth_velocity(velocity, att))
    track = ca.atan2(east, north) * DEG_PER_RAD
    left, right = both_engines(u[3:], flow, running)
    linear = accelerations(velocity, rates, att, flow, C, (left, right), mass)[:3]
    return ca.vertcat(
        flow.tas_kt,
        flow.eas_kt,
        flow.alpha * DEG_PER_RAD,
        flow.beta * DEG_PER_RAD,
        flow.mach,
        flow.dynamic_pressure,
        ca.atan2(-sink, ca.sqrt(north**2 + east**2)) * DEG_PER_RAD,
        ca.if_else(track < 0, track + 360, track),
        (linear + ca.cross(rates, velocity)) / LOAD_FACTOR_G - down(att),
        left.thrust,
        right.thrust,
        left.rotor_speed,
        right.rotor_speed,
    )
