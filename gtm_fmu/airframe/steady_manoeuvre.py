"""A steady manoeuvre: theta and the body rates follow from the trim unknowns in closed form (SPEC 9)."""

from typing import NamedTuple

import casadi as ca

from gtm_fmu.airframe import airdata, motion
from gtm_fmu.airframe.airdata import AirData
from gtm_fmu.airframe.atmosphere import Atmosphere
from gtm_fmu.airframe.engines import both_engines
from gtm_fmu.airframe.mass import MassProperties


class SteadyManoeuvre(NamedTuple):
    """Body velocity (ft/s), body rates (rad/s), theta (rad) and flow of a steady manoeuvre."""

    velocity: ca.SX
    rates: ca.SX
    theta: ca.SX
    flow: AirData


def pitch_angle(gamma, phi, flow: AirData):
    """Pitch angle in rad that gives the flight-path angle gamma (paper eq. 24, SPEC 9)."""
    a = flow.cos_alpha * flow.cos_beta
    c = ca.sin(phi) * flow.sin_beta + ca.cos(phi) * flow.sin_alpha * flow.cos_beta
    s = ca.sin(gamma)
    square = ca.fmax(a**2 - s**2 + c**2, 1e-12)  # an iterate may pass where no pitch angle gives gamma
    return ca.atan2(a * c + s * ca.sqrt(square), a**2 - s**2)


def steady_manoeuvre(y, gamma, air: Atmosphere) -> SteadyManoeuvre:
    """The manoeuvre of trim unknowns y (order `names.TRIM_UNKNOWNS`) at gamma in rad (paper eqs 24-28)."""
    V, alpha, beta, psi_dot, phi = (y[i] for i in range(5))
    flow = airdata.from_angles(V, alpha, beta, air)
    theta = pitch_angle(gamma, phi, flow)
    rates = psi_dot * ca.vertcat(-ca.sin(theta), ca.cos(theta) * ca.sin(phi), ca.cos(theta) * ca.cos(phi))
    return SteadyManoeuvre(airdata.velocity(flow), rates, theta, flow)


def trim_residual(y, gamma, air: Atmosphere, C, mass: MassProperties, running=None):
    """The six accelerations (ft/s^2, rad/s^2) that a trim makes zero (paper eq. 6).

    With ``running`` (2) given the last two of y are the throttles of the left and of the right engine.
    """
    steady = steady_manoeuvre(y, gamma, air)
    att = motion.attitude(y[4], steady.theta, ca.SX(0))
    engines = both_engines(y[8:], steady.flow, running)
    return motion.accelerations(steady.velocity, steady.rates, att, steady.flow, C, engines, mass)
