"""Aerodynamic forces and moments (SPEC 5); the tables themselves are looked up by the C kernel.

The airframe knows the total coefficients ``C`` (6, order `names.COEFFICIENTS`) only as the result of a look-up at the
arguments ``K`` (9, order `names.LOOKUPS`). Both are symbols of the generated functions.
"""

from __future__ import annotations

from typing import NamedTuple

from gtm_fmu.airframe.airdata import AirData
from gtm_fmu.airframe.mass import MEAN_CHORD, MOMENT_REFERENCE, SPAN, WING_AREA, MassProperties
from gtm_fmu.airframe.quantity import Quantity, ca
from gtm_fmu.units import DEG_PER_RAD

RATE_FT_S_PER_KT = 1.689  # of the rate normalisation only; not the inverse of KT_PER_FT_S (SPEC 1)
OMEGA_HAT_LIMIT = 0.5


class SplitRates(NamedTuple):
    """Rotation ``omega`` about the velocity vector and the oscillatory rest, in rad/s (SPEC 5.5)."""

    omega: ca.SX
    p: ca.SX
    q: ca.SX
    r: ca.SX


def kalviste_split(rates: ca.SX, flow: AirData, damaged: Quantity | None = None) -> SplitRates:
    """Split body rates (3, rad/s) by the hybrid Kalviste method: case 2 before case 1 before case 3 (SPEC 5.5).

    Where ``damaged`` is true they stay whole, as in case 3 (SPEC 10.5).
    """
    p, q, r = ca.vertsplit(rates)
    along_x = flow.cos_alpha * flow.cos_beta
    along_z = flow.sin_alpha * flow.cos_beta

    def shrinks(rest: ca.SX, rate: ca.SX) -> ca.SX:
        return ca.logic_and(ca.fabs(rest) <= ca.fabs(rate), rest * rate >= 0)

    # Divisors are guarded because the derivative of a branch not taken must be finite too.
    possible_1 = ca.logic_and(along_x != 0, p != 0)
    omega_1 = p / ca.if_else(along_x != 0, along_x, 1)
    r_1 = r - omega_1 * along_z
    case_1 = ca.logic_and(possible_1, shrinks(r_1, r))

    possible_2 = ca.logic_and(along_z != 0, r != 0)
    omega_2 = r / ca.if_else(along_z != 0, along_z, 1)
    p_2 = p - omega_2 * along_x
    case_2 = ca.logic_and(possible_2, shrinks(p_2, p))
    if damaged is not None:
        case_1, case_2 = (ca.logic_and(ca.logic_not(damaged), case) for case in (case_1, case_2))

    def choose(second: Quantity, first: Quantity, otherwise: Quantity) -> ca.SX:
        return ca.if_else(case_2, second, ca.if_else(case_1, first, otherwise))

    omega = choose(omega_2, omega_1, 0)
    return SplitRates(omega, p=choose(p_2, 0, p), q=q - omega * flow.sin_beta, r=choose(0, r_1, r))


def lookup_arguments(flow: AirData, rates: ca.SX, surfaces: ca.SX, damaged: Quantity | None = None) -> ca.SX:
    """Arguments K (9) of the tables: alpha and beta in deg, normalised rates, deflections (3) in deg (SPEC 5.5)."""
    split = kalviste_split(rates, flow, damaged)
    tas = ca.fmin(ca.fmax(flow.tas_kt, 1), 10000)
    doubled = 2 * RATE_FT_S_PER_KT * tas
    omega_hat = split.omega * SPAN / doubled
    return ca.vertcat(
        flow.alpha * DEG_PER_RAD,
        flow.beta * DEG_PER_RAD,
        split.p * SPAN / doubled,
        split.q * MEAN_CHORD / doubled,
        split.r * SPAN / doubled,
        ca.fmin(ca.fmax(omega_hat, -OMEGA_HAT_LIMIT), OMEGA_HAT_LIMIT),
        surfaces,
    )


def aerodynamic_loads(C: ca.SX, flow: AirData, mass: MassProperties) -> tuple[ca.SX, ca.SX]:
    """Force (3, lbf) and moment about the centre of gravity (3, ft lbf) of total coefficients C (SPEC 5)."""
    pressure_area = flow.dynamic_pressure * WING_AREA
    force = pressure_area * C[:3]
    moment = pressure_area * ca.vertcat(SPAN * C[3], MEAN_CHORD * C[4], SPAN * C[5])
    return force, moment + ca.cross(ca.DM(MOMENT_REFERENCE) - mass.cg, force)
