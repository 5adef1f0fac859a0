"""The rest of the GTM-T2 airframe, SPEC 10.4-10.6 with 3 and 5.6, in plain NumPy on top of the plain model.

Every surface is set on the bus directly. Fuel, damage, wind and the engines are given; nothing here has a time.
Written from the specification alone, as the plain model is: see there for states, units and tables.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from tests.reference import plain_model
from tests.reference.plain_model import Array, Tables, lateral, longitudinal, look_up

# SPEC 4
SIGNALS = (
    *("ELLOB", "ELLIB", "ELROB", "ELRIB", "AILL", "AILR", "RUDU", "RUDL"),
    *("SPLLIB", "SPLLOB", "SPLRIB", "SPLROB", "FLAPLIB", "FLAPLOB", "FLAPRIB", "FLAPROB"),
    *("STAB", "GEAR", "BRAKE", "THROTL", "THROTR", "STEER"),
)

# SPEC 3
FORWARD_TANK, AFT_TANK = np.array([[-53.43, 0, -13.86], [-62.30, 0, -13.86]]) / 12  # ft
AFT_FUEL = 5.74  # lb
# d(Ixx, Iyy, Izz) per f^2 and per f; the part at f = 0 is in the plain model's inertias
FUEL_INERTIA = np.array(
    [
        [0.000015212259037, -0.000108396795757],
        [0.000032526556068, -0.000298176766717],
        [-0.000019873124706, 0.000212146005908],
    ]
)

# SPEC 10.4
GEAR_CG = np.array([-0.0025, 0, 0.0150])  # ft
GEAR_INERTIAS = np.array([0.0441, 0, 0.006994, 0, 0, 0])  # slug ft^2
SPOILER_WEIGHTS = {
    "IB": np.array([0.45, 0.45, 0.45, 0.26, 0.45, 0.26]),
    "OB": np.array([0.55, 0.55, 0.55, 0.74, 0.55, 0.74]),
}


class Damage(NamedTuple):
    """A row of SPEC 10.5: increments in lb, in and slug ft^2, and the lost surfaces."""

    weight: float
    cg: tuple[float, ...]
    inertias: tuple[float, ...]
    lost: tuple[str, ...]


DAMAGE = {
    0: Damage(0, (0, 0, 0), (0, 0, 0, 0, 0, 0), ()),
    1: Damage(
        -0.13, (0.126, 0, 0.028),
        (-0.00346, -0.06698, -0.06352, -0.01409, 0.00001, 0.00003), ("RUDU", "RUDL"),
    ),
    2: Damage(
        -1.31, (1.166, 0, 0.277),
        (-0.03507, -0.57604, -0.54102, -0.13113, 0.00006, 0.00024), ("RUDU", "RUDL"),
    ),
    3: Damage(
        -0.09, (0.014, 0.041, 0.001),
        (-0.01018, -0.00120, -0.01137, -0.00009, -0.00027, -0.00347), ("FLAPLOB",),
    ),
    4: Damage(
        -0.81, (0.148, 0.628, 0.032),
        (-0.25821, -0.01727, -0.27400, -0.00295, -0.01346, -0.05998), ("AILL",),
    ),
    5: Damage(
        -0.07, (0.065, 0.010, 0.004),
        (-0.00097, -0.03391, -0.03467, -0.00188, -0.00029, -0.00510), ("ELLOB", "ELLIB"),
    ),
    6: Damage(
        -0.59, (0.553, 0.088, 0.032),
        (-0.00918, -0.27315, -0.28049, -0.01559, -0.00265, -0.04370), ("STAB", "ELLOB", "ELLIB"),
    ),
}  # fmt: skip


@dataclass(frozen=True)
class Configuration:
    """All that the derivatives depend on but the state.

    Attributes:
        bus: the 22 signals of SPEC 4 by name; throttles after their lag.
        fuel_used: f in lb.
        damage_case: 0..6.
        wind: north, east, down and three body-axis gusts, ft/s.
        shear: whether the wind grows with height.
        h_runway: ft.
        engines_on: left, right.
        stall_asymmetry: whether SPEC 5.6 applies.
    """

    bus: Mapping[str, float]
    fuel_used: float = 0.0
    damage_case: int = 0
    wind: Sequence[float] = (0.0,) * 6
    shear: bool = True
    h_runway: float = 12.0
    engines_on: tuple[bool, bool] = (True, True)
    stall_asymmetry: bool = False


def allocated(u: ArrayLike) -> dict[str, float]:
    """The bus that the four commands drive, everything else at zero (SPEC 4)."""
    return {**dict.fromkeys(SIGNALS, 0.0), **plain_model.surface_bus(np.asarray(u, float))}


class MassProperties(NamedTuple):
    """SPEC 3: slug, ft, slug ft^2 (Ixx, Iyy, Izz, Ixz, Iyz, Ixy)."""

    mass: float
    cg: Array
    inertias: Array


def mass_properties(fuel_used: float, gear: float, damage_case: int) -> MassProperties:
    """With fuel, gear and damage (SPEC 3, 10.4, 10.5): the weight under `W0 cg0` holds the damage, W0 does not."""
    damage, f = DAMAGE[damage_case], fuel_used
    W = plain_model.WEIGHT - f + damage.weight
    aft, forward = min(AFT_FUEL, f), max(0.0, f - AFT_FUEL)
    cg = (plain_model.WEIGHT * plain_model.CG - aft * AFT_TANK - forward * FORWARD_TANK) / W
    inertias = plain_model.INERTIAS + np.array([*(FUEL_INERTIA @ [f**2, f]), 0, 0, 0])
    if gear >= 0.5:
        cg, inertias = cg + GEAR_CG, inertias + GEAR_INERTIAS
    return MassProperties(W / plain_model.G, cg + np.array(damage.cg) / 12, inertias + damage.inertias)


def shear_gain(height: float) -> float:
    """G at a height above the runway in ft (SPEC 10.6)."""
    return np.log(min(max(height, 1.0), 1000.0) / 0.15) / np.log(20 / 0.15) / 1.8


def wind_body(x: Array, configuration: Configuration) -> Array:
    """Velocity of the air in body axes, ft/s (SPEC 10.6)."""
    G = shear_gain(x[8] - configuration.h_runway) if configuration.shear else 1.0
    return G * plain_model.direction_cosines(*x[9:]) @ np.array(configuration.wind[:3]) + configuration.wind[3:]


def air_data(x: Array, configuration: Configuration) -> plain_model.AirData:
    """Air data of the velocity relative to the air (SPEC 2)."""
    return plain_model.air_data(np.concatenate([x[:3] - wind_body(x, configuration), x[3:]]))


def look_up_clipped(table: Any, *arguments: float) -> Array:
    """Piecewise multilinear inside the table; outside it the value at its edge."""
    inside = (np.clip(argument, axis[0], axis[-1]) for axis, argument in zip(table.axes, arguments, strict=True))
    return look_up(table, *inside)


def part(table: Any, axes: int, index: int) -> SimpleNamespace:
    """The table over its first axes only, at one position of the axis that follows them."""
    return SimpleNamespace(axes=table.axes[:axes], values=np.take(table.values, index, axis=axes))


def surfaces(alpha: float, beta: float, bus: Mapping[str, float], tables: Tables) -> dict[str, Array]:
    """The six-vector of each surface, angles in deg (SPEC 5.2-5.4, 10.4)."""
    c = {"STAB": plain_model.stabiliser(tables["dC3_ele"], alpha, beta, bus["STAB"])}
    for name, arm in plain_model.ELEVATOR_ARMS.items():
        c[name] = plain_model.elevator_segment(tables["dC3_ele"], alpha, beta, bus["STAB"], bus[name], arm)
    for name, weights in plain_model.RUDDER_WEIGHTS.items():
        c[name] = plain_model.rudder_half(tables["dC6_rud"], alpha, beta, bus[name], weights)
    c["AILL"] = plain_model.left_panel(tables["dC6_ail"], alpha, beta, bus["AILL"])
    c["AILR"] = look_up(tables["dC6_ail"], alpha, beta, bus["AILR"])
    for place, spoiler_weights in SPOILER_WEIGHTS.items():
        left, right = f"SPLL{place}", f"SPLR{place}"
        c[left] = spoiler_weights * plain_model.left_panel(tables["dC6_spo"], alpha, beta, bus[left])
        c[right] = spoiler_weights * look_up(tables["dC6_spo"], alpha, beta, bus[right])
    panels = tables["flaps"]
    for panel, per_degree in zip(panels.axes[0], panels.values, strict=True):
        c[panel.upper()] = per_degree * bus[panel.upper()]
    return c


def damaged_dynamic_terms(air: plain_model.AirData, omega: Array, damage_case: int, tables: Tables) -> Array:
    """What the body rates add to the coefficients of a damaged aircraft (SPEC 10.5)."""
    alpha = np.degrees(air.alpha)
    rates = omega * [plain_model.SPAN, plain_model.CHORD, plain_model.SPAN] / plain_model.rate_scale(air.tas)
    vectors = [
        embed(look_up_clipped(tables[name], alpha, rate))
        for name, embed, rate in zip(("dC3_p", "dC3_q", "dC3_r"), (lateral, longitudinal, lateral), rates, strict=True)
    ]
    factors = look_up_clipped(part(tables["dC6_damage.ddscale"], 1, damage_case - 1), alpha)
    increments = look_up(part(tables["dC6_damage.ddinc"], 1, damage_case - 1), alpha)
    C = (factors * vectors).sum(axis=0)
    C[1] += increments[:, 1] @ rates
    return C


def stall_roll(alpha: float, beta: float) -> float:
    """The roll asymmetry near the stall, angles in deg (SPEC 5.6)."""
    return 0.01 * np.interp(alpha, [12.5, 13.5, 14.5], [0, 1, 0]) * np.interp(beta, [-2, -1, 1, 2], [0, 1, 1, 0])


def coefficients(x: Array, configuration: Configuration, tables: Tables | None = None) -> Array:
    """CX, CY, CZ, Cl, Cm, Cn about the aerodynamic reference point (SPEC 5, 10.4, 10.5)."""
    tables = plain_model.airframe_tables() if tables is None else tables
    air, case = air_data(x, configuration), configuration.damage_case
    alpha, beta = np.degrees(air.alpha), np.degrees(air.beta)
    C = look_up(tables["C6_bas"], alpha, beta)
    for name, c in surfaces(alpha, beta, configuration.bus, tables).items():
        C = C + (name not in DAMAGE[case].lost) * c
    if configuration.bus["GEAR"] != 0:
        C = C + longitudinal(look_up(part(tables["dC3_lgr"], 1, 1), alpha))
    if case == 0:
        C = C + plain_model.dynamic_terms(air, x[3:6], tables)
    else:
        C = C + look_up_clipped(part(tables["dC6_damage.bas"], 2, case - 1), alpha, beta)
        C = C + damaged_dynamic_terms(air, x[3:6], case, tables)
    if configuration.stall_asymmetry:
        C = C + lateral(np.array([0, stall_roll(alpha, beta), 0]))
    return C


class Engines(NamedTuple):
    """Left and right: net thrust in lbf, angular momentum in slug ft^2/s, speed in %."""

    T: list[float]
    H: list[float]
    N: list[float]


def engines(air: plain_model.AirData, configuration: Configuration) -> Engines:
    """One that is switched off gives nothing (SPEC 6, 10.2)."""
    throttles = configuration.bus["THROTL"], configuration.bus["THROTR"]
    running = list(zip(configuration.engines_on, throttles, strict=True))
    return Engines(
        T=[on * plain_model.thrust(t, air.pressure_ratio, air.qbar) for on, t in running],
        H=[on * plain_model.angular_momentum(t) for on, t in running],
        N=[on * plain_model.rotor_speed(t) for on, t in running],
    )


def derivatives(x: ArrayLike, configuration: Configuration, tables: Tables | None = None) -> Array:
    """d x / d t of one state, shape (12,) (SPEC 7)."""
    x = np.asarray(x, float)
    air, bus = air_data(x, configuration), configuration.bus
    mass, cg, inertias = mass_properties(configuration.fuel_used, bus["GEAR"], configuration.damage_case)
    F_aero, M_aero = plain_model.aerodynamic_loads(coefficients(x, configuration, tables), air.qbar, cg)
    T, H, _ = engines(air, configuration)
    F_thrust, M_thrust = plain_model.engine_loads(T, H, x[3:6], cg)
    return plain_model.motion(x, F_aero + F_thrust, M_aero + M_thrust, mass, plain_model.inertia_matrix(inertias))


def outputs(x: ArrayLike, configuration: Configuration, tables: Tables | None = None) -> Array:
    """The 15 outputs of one state, in the order and units of `gtm_fmu.airframe.names.OUTPUTS` (SPEC 2, 6, 8)."""
    x = np.asarray(x, float)
    air = air_data(x, configuration)
    T, _, N = engines(air, configuration)
    return np.array([*plain_model.observed(x, derivatives(x, configuration, tables), air), *T, *N])
