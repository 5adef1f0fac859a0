"""A steady manoeuvre: theta and the body rates follow from the trim unknowns in closed form (SPEC 9)."""

from __future__ import annotations

from typing import NamedTuple

from gtm_fmu.airframe import airdata, motion
from gtm_fmu.airframe.airdata import AirData
from gtm_fmu.airframe.atmosphere import Atmosphere
from gtm_fmu.airframe.engines import both_engines
from gtm_fmu.airframe.mass import MassProperties
from gtm_fmu.airframe.motion import Attitude
from gtm_fmu.airframe.names import THROTTLE, TRIM_UNKNOWNS
from gtm_fmu.airframe.quantity import Quantity, ca


class SteadyManoeuvre(NamedTuple):
    """Body velocity (ft/s), body rates (rad/s), theta (rad), attitude heading north, and flow of a steady manoeuvre."""

    velocity: ca.SX
    rates: ca.SX
    theta: ca.SX
    attitude: Attitude
    flow: AirData


def pitch_tangent(gamma: Quantity, sin_phi: ca.SX, cos_phi: ca.SX, flow: AirData) -> tuple[ca.SX, ca.SX]:
    """Legs, opposite and adjacent, of the pitch angle that gives the flight-path angle gamma (paper eq. 24, SPEC 9)."""
    a = flow.cos_alpha * flow.cos_beta
    c = sin_phi * flow.sin_beta + cos_phi * flow.sin_alpha * flow.cos_beta
    s = ca.sin(gamma)
    square = ca.fmax(a**2 - s**2 + c**2, 1e-12)  # an iterate may pass where no pitch angle gives gamma
    return a * c + s * ca.sqrt(square), a**2 - s**2


def steady_manoeuvre(y: ca.SX, gamma: Quantity, air: Atmosphere) -> SteadyManoeuvre:
    """The manoeuvre of trim unknowns y (order `names.TRIM_UNKNOWNS`) at gamma in rad (paper eqs 24-28)."""
    V, alpha, beta, psi_dot, phi = (y[TRIM_UNKNOWNS.index(name)] for name in ("V", "alpha", "beta", "psi_dot", "phi"))
    flow = airdata.from_angles(V, alpha, beta, air)
    sin_phi, cos_phi = ca.sin(phi), ca.cos(phi)
    opposite, adjacent = pitch_tangent(gamma, sin_phi, cos_phi, flow)
    length = ca.sqrt(opposite**2 + adjacent**2)
    att = Attitude(sin_phi, cos_phi, opposite / length, adjacent / length, ca.SX(0), ca.SX(1))
    rates = psi_dot * motion.down(att)
    return SteadyManoeuvre(airdata.velocity(flow), rates, ca.atan2(opposite, adjacent), att, flow)


def trim_residual(
    y: ca.SX, gamma: Quantity, air: Atmosphere, C: ca.SX, mass: MassProperties, running: ca.SX | None = None
) -> ca.SX:
    """The six accelerations (ft/s^2, rad/s^2) that a trim makes zero (paper eq. 6).

    With ``running`` (2) given the last two of y are the throttles of the left and of the right engine.
    """
    steady = steady_manoeuvre(y, gamma, air)
    engines = both_engines(y[THROTTLE:], steady.flow, running)
    return motion.accelerations(steady.velocity, steady.rates, steady.attitude, steady.flow, C, engines, mass)
