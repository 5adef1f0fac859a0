"""The GTM-T2 airframe of SPEC 2-9 in plain NumPy: one state at a time, slow, and as close to the text as code can be.

This is the independent check of the compiled core. Its constants and formulas are written here a second time on
purpose, from the specification alone: nothing of the airframe package is used but the numbers in its tables. The
tables are not folded: both rudder halves, both ailerons and all four elevator segments are looked up one by one.

State x = (u, v, w, p, q, r, lat, lon, h, phi, theta, psi): ft/s, rad/s, rad, rad, ft, rad. Controls u = (elevator,
aileron, rudder, throttle): deg, deg, deg, %. A table is anything with `axes` (the breakpoints of each axis) and
`values` (one more axis, the components).
"""

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

Array = np.ndarray
Tables = Mapping[str, Any]

# SPEC 1
KT_PER_FT_S = 0.592487
RATE_FT_S_PER_KT = 1.689  # inside the rate normalisation only; not 1 / KT_PER_FT_S
G = 32.17405  # ft/s^2
R_NAVIGATION = 6.37043246e6 / 0.3048  # ft
R_ATMOSPHERE = 20855531.5  # ft

# SPEC 3; the inertias are Ixx, Iyy, Izz, Ixz, Iyz, Ixy in slug ft^2, with the fuel increment at zero fuel used
S = 5.9018  # ft^2
CHORD = 0.9153  # ft
SPAN = 6.8488  # ft
CG = np.array([-(4.5462 + 0.2199 * 0.9153), -0.1416 / 12, -0.9761])  # ft, full fuel, gear up
MOMENT_REFERENCE = np.array([-(4.5462 + 0.25 * 0.9153), 0.0, -0.9401])  # ft
WEIGHT = 57.75  # lb
MASS = WEIGHT / G  # slug
INERTIAS = np.array([1.221 + 0.001076938008733, 4.655 + 0.002102173236731, 5.587 + 0.001301531989172, 0.274, 0, 0.006])

# SPEC 5.2, 5.4
RUDDER_WEIGHTS = {"RUDU": (0.5, 0.5, 0.5, 0.67, 0.67, 0.5), "RUDL": (0.5, 0.5, 0.5, 0.33, 0.33, 0.5)}
ELEVATOR_ARMS = {"ELLOB": -0.07, "ELLIB": -0.03, "ELRIB": 0.03, "ELROB": 0.07}

# SPEC 6
POSITION_LEFT = np.array([-51.903, -14.20, -7.71]) / 12  # ft
POSITION_RIGHT = np.array([-51.903, 14.20, -7.71]) / 12
MOUNTING_LEFT = np.radians([1.98, 2.22])  # pitch, yaw
MOUNTING_RIGHT = np.radians([1.95, -1.18])


def inertia_matrix(inertias: Array) -> Array:
    """J of SPEC 3 from Ixx, Iyy, Izz, Ixz, Iyz, Ixy."""
    Ixx, Iyy, Izz, Ixz, Iyz, Ixy = inertias
    return np.array([[Ixx, -Ixy, -Ixz], [-Ixy, Iyy, -Iyz], [-Ixz, -Iyz, Izz]])


@cache
def airframe_tables() -> Tables:
    """The tables the package ships, by their names in the database."""
    from gtm_fmu.airframe.tables import load_tables

    return load_tables()


def look_up(table: Any, *arguments: float) -> Array:
    """Piecewise multilinear, one axis after the other; the end intervals extrapolate linearly (SPEC 1)."""
    values = np.asarray(table.values)
    for breakpoints, argument in zip(table.axes, arguments, strict=True):
        i = interval(breakpoints, argument)
        f = (argument - breakpoints[i]) / (breakpoints[i + 1] - breakpoints[i])
        values = (1 - f) * values[i] + f * values[i + 1]
    return values


def interval(breakpoints: Array, argument: float) -> int:
    """Number of the interval that holds the argument; the first or last one when it lies outside."""
    for i in range(len(breakpoints) - 2):
        if argument < breakpoints[i + 1]:
            return i
    return len(breakpoints) - 2


class Atmosphere(NamedTuple):
    """SPEC 2: degR, -, slug/ft^3, ft/s, -."""

    temperature: float
    pressure_ratio: float
    density: float
    speed_of_sound: float
    root_density_ratio: float


def atmosphere(h: float) -> Atmosphere:
    """First layer of the 1976 standard atmosphere at geometric height h in ft (SPEC 2)."""
    hg = min(max(R_ATMOSPHERE * h / (R_ATMOSPHERE + h), 0.0), 11000 / 0.3048)
    T0 = 288.15 * 1.8
    a = -6.5 * 1.8 / (1000 / 0.3048)
    R = 1716.55915670803
    T = T0 + a * hg
    pr = (T / T0) ** (-32.17405 / (R * a))
    rho = 2116.22 * pr / (R * T)
    return Atmosphere(T, pr, rho, np.sqrt(1.4 * R * T), np.sqrt(rho / 0.0023769))


class AirData(NamedTuple):
    """SPEC 2: ft/s, rad, rad, lbf/ft^2, kt, kt, -, -."""

    V: float
    alpha: float
    beta: float
    qbar: float
    tas: float
    eas: float
    mach: float
    pressure_ratio: float


def air_data(x: Array) -> AirData:
    """Air data in still air (SPEC 2)."""
    u, v, w = x[:3]
    air = atmosphere(x[8])
    V = np.sqrt(u**2 + v**2 + w**2)
    tas = KT_PER_FT_S * V
    return AirData(
        V=V,
        alpha=np.arctan2(w, u),
        beta=np.arcsin(v / V),
        qbar=0.5 * air.density * V**2,
        tas=tas,
        eas=tas * air.root_density_ratio,
        mach=V / air.speed_of_sound,
        pressure_ratio=air.pressure_ratio,
    )


def direction_cosines(phi: float, theta: float, psi: float) -> Array:
    """Earth to body, 3-2-1 order (SPEC 2)."""
    sf, cf = np.sin(phi), np.cos(phi)
    st, ct = np.sin(theta), np.cos(theta)
    ss, cs = np.sin(psi), np.cos(psi)
    return np.array(
        [
            [ct * cs, ct * ss, -st],
            [sf * st * cs - cf * ss, sf * st * ss + cf * cs, sf * ct],
            [cf * st * cs + sf * ss, cf * st * ss - sf * cs, cf * ct],
        ]
    )


def surface_bus(u: Array) -> dict[str, float]:
    """The surface signals that the four commands drive (SPEC 4) and the fixed stabiliser."""
    elevator, aileron, rudder, throttle = u
    return {
        **dict.fromkeys(("ELLOB", "ELLIB", "ELROB", "ELRIB"), elevator),
        "AILL": -aileron,
        "AILR": aileron,
        **dict.fromkeys(("RUDU", "RUDL"), rudder),
        "STAB": 0.0,
        **dict.fromkeys(("THROTL", "THROTR"), throttle),
    }


def longitudinal(c: Array) -> Array:
    """(CX, CZ, Cm) as a six-vector."""
    return np.array([c[0], 0.0, c[1], 0.0, c[2], 0.0])


def lateral(c: Array) -> Array:
    """(CY, Cl, Cn) as a six-vector."""
    return np.array([0.0, c[0], 0.0, c[1], 0.0, c[2]])


def rudder_half(table: Any, alpha: float, beta: float, d: float, weights: Sequence[float]) -> Array:
    """One half of the rudder; only negative deflections are tabulated (SPEC 5.2)."""
    s = -1 if d >= 0 else 1
    CX, CY, CZ, Cl, Cm, Cn = look_up(table, alpha, s * beta, -abs(d))
    return np.array([CX, s * CY, CZ, s * Cl, Cm, s * Cn]) * np.array(weights)


def rudder(table: Any, alpha: float, beta: float, upper: float, lower: float) -> Array:
    """Both halves of the rudder (SPEC 5.2)."""
    halves = zip((upper, lower), RUDDER_WEIGHTS.values(), strict=True)
    return sum((rudder_half(table, alpha, beta, d, weights) for d, weights in halves), np.zeros(6))


def left_panel(table: Any, alpha: float, beta: float, d: float) -> Array:
    """A panel on the left from the table of the one on the right: the mirror rule (SPEC 5.3)."""
    CX, CY, CZ, Cl, Cm, Cn = look_up(table, alpha, -beta, d)
    return np.array([CX, -CY, CZ, -Cl, Cm, -Cn])


def ailerons(table: Any, alpha: float, beta: float, left: float, right: float) -> Array:
    """Both ailerons (SPEC 5.3)."""
    return look_up(table, alpha, beta, right) + left_panel(table, alpha, beta, left)


def stabiliser(table: Any, alpha: float, beta: float, stab: float) -> Array:
    """The stabiliser with the elevator at zero (SPEC 5.4)."""
    return longitudinal(look_up(table, alpha, beta, stab, 0.0))


def elevator_segment(table: Any, alpha: float, beta: float, stab: float, d: float, arm: float) -> Array:
    """A quarter of the elevator and what its arm adds in roll and yaw (SPEC 5.4)."""
    c = 0.25 * (look_up(table, alpha, beta, stab, d) - look_up(table, alpha, beta, stab, 0.0))
    dCX, dCZ, _ = c
    return longitudinal(c) + lateral(np.array([0.0, arm * dCZ, -arm * dCX]))


def stabiliser_and_elevator(table: Any, alpha: float, beta: float, bus: Mapping[str, float]) -> Array:
    """The stabiliser and all four segments of the elevator (SPEC 5.4)."""
    c = stabiliser(table, alpha, beta, bus["STAB"])
    for segment, arm in ELEVATOR_ARMS.items():
        c = c + elevator_segment(table, alpha, beta, bus["STAB"], bus[segment], arm)
    return c


class RateSplit(NamedTuple):
    """SPEC 5.5: the case, the rotation about the velocity vector and the residual rates, rad/s."""

    case: int
    omega: float
    p: float
    q: float
    r: float


def kalviste_split(alpha: float, beta: float, p: float, q: float, r: float) -> RateSplit:
    """Split of the body rates by the hybrid Kalviste method, angles in rad; case 2 comes first and wins (SPEC 5.5)."""
    ca, sa, cb, sb = np.cos(alpha), np.sin(alpha), np.cos(beta), np.sin(beta)
    if sa * cb != 0 and r != 0:
        omega = r / (sa * cb)
        p_o = p - omega * ca * cb
        if not (abs(p_o) > abs(p) or p_o * p < 0):
            return RateSplit(2, omega, p_o, q - omega * sb, 0.0)
    if ca * cb != 0 and p != 0:
        omega = p / (ca * cb)
        r_o = r - omega * sa * cb
        if not (abs(r_o) > abs(r) or r_o * r < 0):
            return RateSplit(1, omega, 0.0, q - omega * sb, r_o)
    return RateSplit(3, 0.0, p, q, r)


def rate_scale(tas: float) -> float:
    """Vk of SPEC 5.5 in ft/s, tas in kn."""
    return 2 * RATE_FT_S_PER_KT * min(max(tas, 1.0), 10000.0)


class NormalisedRates(NamedTuple):
    """SPEC 5.5: residual roll, pitch, yaw and the rotation about the velocity vector."""

    p_hat: float
    q_hat: float
    r_hat: float
    omega_hat: float


def normalised_rates(split: RateSplit, tas: float) -> NormalisedRates:
    """Arguments of the rate tables (SPEC 5.5), tas in kn."""
    Vk = rate_scale(tas)
    omega_hat = min(max(split.omega * SPAN / Vk, -0.5), 0.5)
    return NormalisedRates(split.p * SPAN / Vk, split.q * CHORD / Vk, split.r * SPAN / Vk, omega_hat)


def dynamic_terms(air: AirData, omega: Array, tables: Tables) -> Array:
    """What the body rates add to the coefficients (SPEC 5.5)."""
    alpha, beta = np.degrees(air.alpha), np.degrees(air.beta)
    rates = normalised_rates(kalviste_split(air.alpha, air.beta, *omega), air.tas)
    return (
        lateral(look_up(tables["dC3_p"], alpha, rates.p_hat))
        + longitudinal(look_up(tables["dC3_q"], alpha, rates.q_hat))
        + lateral(look_up(tables["dC3_r"], alpha, rates.r_hat))
        + look_up(tables["dC6_w"], alpha, rates.omega_hat, beta)
    )


def coefficients(x: Array, u: Array, tables: Tables | None = None) -> Array:
    """CX, CY, CZ, Cl, Cm, Cn about the aerodynamic reference point (SPEC 5.1-5.5; 5.6 is off)."""
    tables = airframe_tables() if tables is None else tables
    air, bus = air_data(x), surface_bus(u)
    alpha, beta = np.degrees(air.alpha), np.degrees(air.beta)
    return (
        look_up(tables["C6_bas"], alpha, beta)
        + rudder(tables["dC6_rud"], alpha, beta, bus["RUDU"], bus["RUDL"])
        + ailerons(tables["dC6_ail"], alpha, beta, bus["AILL"], bus["AILR"])
        + stabiliser_and_elevator(tables["dC3_ele"], alpha, beta, bus)
        + dynamic_terms(air, x[3:6], tables)
    )


def aerodynamic_loads(C: Array, qbar: float, cg: Array) -> tuple[Array, Array]:
    """F in lbf, M about the cg in lbf ft (SPEC 5)."""
    F = qbar * S * C[:3]
    return F, qbar * S * np.array([SPAN, CHORD, SPAN]) * C[3:] + np.cross(MOMENT_REFERENCE - cg, F)


def rotor_speed(throttle: float) -> float:
    """N in % (SPEC 6)."""
    t = throttle
    return 0.000033035538475 * t**3 - 0.008354385314499 * t**2 + 1.191126728328792 * t + 31.518959847101669


def thrust(throttle: float, pressure_ratio: float, qbar: float) -> float:
    """Net thrust of one engine in lbf (SPEC 6)."""
    N = rotor_speed(throttle)
    return max(0.0, (0.000014847593013 * N**3 + 0.412662356277121) * pressure_ratio - 0.010 * qbar * S)


def angular_momentum(throttle: float) -> float:
    """H of one rotor in slug ft^2/s (SPEC 6)."""
    d, length = 0.75 / 12, 6.25 / 12
    Jr = (np.pi * d**4 / 32) * length * 15.2
    return Jr * rotor_speed(throttle) * 123000 / 100 * 2 * np.pi / 60


def engine_axis(mounting: Array) -> Array:
    """Direction of thrust and rotor for a mounting pitch and yaw angle (SPEC 6)."""
    t, y = mounting
    return np.array([np.cos(t) * np.cos(y), np.sin(y), -np.sin(t) * np.cos(y)])


def engine_loads(T: Sequence[float], H: Sequence[float], omega: Array, cg: Array) -> tuple[Array, Array]:
    """F in lbf, M about the cg in lbf ft of the left and the right engine (SPEC 6)."""
    (T_left, T_right), (H_left, H_right) = T, H
    e_left, e_right = engine_axis(MOUNTING_LEFT), engine_axis(MOUNTING_RIGHT)
    M = np.cross(POSITION_LEFT - cg, T_left * e_left) + np.cross(POSITION_RIGHT - cg, T_right * e_right)
    return T_left * e_left + T_right * e_right, M + np.cross(omega, H_left * e_left + H_right * e_right)


def forces_and_moments(x: Array, u: Array, tables: Tables | None = None) -> tuple[Array, Array]:
    """Aerodynamics and thrust: F in lbf, M about the cg in lbf ft (SPEC 5, 6)."""
    air, bus = air_data(x), surface_bus(u)
    F_aero, M_aero = aerodynamic_loads(coefficients(x, u, tables), air.qbar, CG)
    throttles = bus["THROTL"], bus["THROTR"]
    T = [thrust(throttle, air.pressure_ratio, air.qbar) for throttle in throttles]
    F_thrust, M_thrust = engine_loads(T, [angular_momentum(throttle) for throttle in throttles], x[3:6], CG)
    return F_aero + F_thrust, M_aero + M_thrust


def earth_velocity(x: Array) -> Array:
    """North, east and down velocity in ft/s (SPEC 2)."""
    return direction_cosines(*x[9:12]).T @ x[:3]


def motion(x: Array, F: Array, M: Array, mass: float, inertia: Array) -> Array:
    """d x / d t of one state, shape (12,), under gravity, other forces F and moments M about the cg (SPEC 7)."""
    p, q, r = omega = x[3:6]
    lat, _, h, phi, theta, _ = x[6:]
    Vn, Ve, Vd = earth_velocity(x)
    F_gravity = mass * G * direction_cosines(*x[9:]) @ np.array([0.0, 0.0, 1.0])
    return np.array(
        [
            *((F + F_gravity) / mass - np.cross(omega, x[:3])),
            *np.linalg.solve(inertia, M - np.cross(omega, inertia @ omega)),
            Vn / (R_NAVIGATION + h),
            Ve / ((R_NAVIGATION + h) * np.cos(lat)),
            -Vd,
            p + np.tan(theta) * (q * np.sin(phi) + r * np.cos(phi)),
            q * np.cos(phi) - r * np.sin(phi),
            (q * np.sin(phi) + r * np.cos(phi)) / np.cos(theta),
        ]
    )


def derivatives(x: ArrayLike, u: ArrayLike, tables: Tables | None = None) -> Array:
    """d x / d t of one state, shape (12,) (SPEC 7)."""
    x, u = np.asarray(x, float), np.asarray(u, float)
    return motion(x, *forces_and_moments(x, u, tables), MASS, inertia_matrix(INERTIAS))


def observed(x: Array, xdot: Array, air: AirData) -> list[float]:
    """The outputs that air data and motion give: all but those of the engines (SPEC 2, 8)."""
    Vn, Ve, Vd = earth_velocity(x)
    phi, theta = x[9:11]
    down = np.array([-np.sin(theta), np.cos(theta) * np.sin(phi), np.cos(theta) * np.cos(phi)])
    load = (xdot[:3] + np.cross(x[3:6], x[:3])) / 32.174 - down
    gamma, track = np.degrees([np.arctan2(-Vd, np.sqrt(Vn**2 + Ve**2)), np.arctan2(Ve, Vn)])
    alpha, beta = np.degrees([air.alpha, air.beta])
    return [air.tas, air.eas, alpha, beta, air.mach, air.qbar, gamma, track % 360, *load]


def outputs(x: ArrayLike, u: ArrayLike, tables: Tables | None = None) -> Array:
    """The 15 outputs of one state, in the order and units of `gtm_fmu.airframe.names.OUTPUTS` (SPEC 2, 6, 8)."""
    x, u = np.asarray(x, float), np.asarray(u, float)
    air, bus = air_data(x), surface_bus(u)
    left, right = bus["THROTL"], bus["THROTR"]
    T = [thrust(throttle, air.pressure_ratio, air.qbar) for throttle in (left, right)]
    return np.array([*observed(x, derivatives(x, u, tables), air), *T, rotor_speed(left), rotor_speed(right)])


def steady_state(h: float, V: float, gamma: float, psi_dot: float, alpha: float, beta: float, phi: float) -> Array:
    """State of a steady manoeuvre, lat = lon = psi = 0: ft, ft/s and rad, rad/s (SPEC 9)."""
    a = np.cos(alpha) * np.cos(beta)
    c = np.sin(phi) * np.sin(beta) + np.cos(phi) * np.sin(alpha) * np.cos(beta)
    s = np.sin(gamma)
    theta = np.arctan2(a * c + s * np.sqrt(a**2 - s**2 + c**2), a**2 - s**2)
    p = -psi_dot * np.sin(theta)
    q = psi_dot * np.cos(theta) * np.sin(phi)
    r = psi_dot * np.cos(theta) * np.cos(phi)
    velocity = V * np.array([a, np.sin(beta), np.sin(alpha) * np.cos(beta)])
    return np.array([*velocity, p, q, r, 0.0, 0.0, h, phi, theta, 0.0])
