"""Generated C of the core: the airframe's CasADi functions and the aerodynamic tables.

Runs when the package is built (`setup.py`); nothing is compiled later.
"""

from collections.abc import Iterable, Mapping
from pathlib import Path

import casadi as ca

from gtm_fmu.airframe import airdata, linear_scales, motion, steady_manoeuvre
from gtm_fmu.airframe.actuators import SERVOS
from gtm_fmu.airframe.aerodynamics import lookup_arguments
from gtm_fmu.airframe.atmosphere import GRAVITY, Atmosphere, atmosphere
from gtm_fmu.airframe.configuration import PARAMETERS
from gtm_fmu.airframe.configured_tables import RATES
from gtm_fmu.airframe.damage import DAMAGE_CASES
from gtm_fmu.airframe.engines import engine
from gtm_fmu.airframe.lookup_axes import lookup_axes
from gtm_fmu.airframe.mass import WING_AREA, mass_properties
from gtm_fmu.airframe.names import (
    ACCELERATED,
    COEFFICIENTS,
    CONTROLS,
    ELEVATOR,
    LINEAR_STATES,
    LOOKUPS,
    OUTPUTS,
    PHI,
    STATES,
    THROTTLE,
    TRIM_UNKNOWNS,
    TWO_THROTTLE_CONTROLS,
    TWO_THROTTLE_UNKNOWNS,
)
from gtm_fmu.airframe.surfaces import AERODYNAMIC, COMMANDED, ELEVATOR_ARMS, FLAPS, PANELS, SPOILERS
from gtm_fmu.airframe.tables import Table, load_tables
from gtm_fmu.core import stored_tables
from gtm_fmu.core.c_source import axis_definition, function, slope_through_tables, write_functions
from gtm_fmu.core.generate_configured import configured_tables_source, generate_configured

STUDY_MASS = mass_properties()  # full fuel, no damage (SPEC 9)


def airframe_functions() -> list[ca.Function]:
    """CasADi functions of the core; C (6) and its slopes T (6, 9) come from the table kernel."""
    x, u = ca.SX.sym("x", len(STATES)), ca.SX.sym("u", len(CONTROLS))
    C = ca.SX.sym("C", len(COEFFICIENTS))
    T = ca.SX.sym("T", len(COEFFICIENTS), len(LOOKUPS))
    xu = ca.vertcat(x, u)
    K = lookup_arguments(airdata.from_velocity(x[:3], atmosphere(x[8])), x[3:6], u[:3])
    dx = motion.state_derivatives(x, u, C, STUDY_MASS)
    y = motion.outputs(x, u, C, STUDY_MASS)

    t, gamma, rho, pressure_ratio = ca.SX.sym("t", len(TRIM_UNKNOWNS)), *(ca.SX.sym(n) for n in ("gamma", "rho", "pr"))
    condition = ca.vertcat(gamma, rho, pressure_ratio)
    air = Atmosphere(rho, pressure_ratio, ca.SX(1))  # a trim does not ask for the speed of sound
    steady = steady_manoeuvre.steady_manoeuvre(t, gamma, air)
    K_trim = lookup_arguments(steady.flow, steady.rates, t[ELEVATOR:THROTTLE])
    F = steady_manoeuvre.trim_residual(t, gamma, air, C, STUDY_MASS)

    altitude = ca.SX.sym("altitude")
    V, throttle = ca.SX.sym("V"), ca.SX.sym("throttle")
    thrust = engine(throttle, airdata.from_angles(V, 0, 0, air)).thrust
    steady_state = ca.vertcat(steady.velocity, steady.rates, 0, 0, altitude, t[PHI], steady.theta, 0)

    def total_slope(result: ca.SX, arguments: ca.SX, wrt: ca.SX) -> ca.SX:
        return slope_through_tables(result, wrt, C, T, arguments)

    return [
        function("cas_lookup", [x, u], [K]),
        function("cas_derivatives", [x, u, C], [dx]),
        function("cas_jacobian", [x, u, C, T.T], [dx, total_slope(dx, K, xu)]),
        function("cas_outputs", [x, u, C], [y]),
        function("cas_outputs_jacobian", [x, u, C, T.T], [y, total_slope(y, K, xu)]),
        function("cas_trim_lookup", [t, condition], [K_trim]),
        function("cas_trim_residual", [t, condition, C], [F]),
        function("cas_trim_jacobian", [t, condition, C, T.T], [F, total_slope(F, K_trim, t)]),
        function("cas_trim_state", [t, gamma, altitude], [steady_state]),
        function("cas_trim_thrust", [V, throttle, condition], [thrust]),
    ]


def atmosphere_function() -> ca.Function:
    """Density and pressure ratio at an altitude, apart from the airframe: the thrust map needs no more."""
    altitude = ca.SX.sym("altitude")
    at_altitude = atmosphere(altitude)
    return function("cas_atmosphere", [altitude], [at_altitude.density, at_altitude.pressure_ratio])


def tables_source(database: Mapping[str, Table]) -> str:
    """Content of tables.c: axes with their search cells, and tables as `gtm/table.c` has them."""
    common, stored = lookup_axes(database), stored_tables.folded(database)
    axes = {name: getattr(common, f"{name}_deg") for name in ("elevator", "aileron", "rudder")}
    axes |= {name: getattr(common, name) for name in ("alpha", "beta", "p_hat", "q_hat", "r_hat", "omega_hat")}
    text = [f'#include "gtm/{header}.h"\n' for header in ("table", "unfold")]
    text.extend(axis_definition(name, axis) for name, axis in axes.items())
    text.extend(each.definition(name) for name, each in stored.items())
    text.extend(each.table_definition(name, common) for name, each in stored.items())
    return "".join(text)


def table_sources() -> dict[str, str]:
    """The two largest of the generated files by their names; a wheel leaves them out, for they are made in a moment."""
    database = load_tables()
    return {
        "tables.c": tables_source(database),
        "configured_tables.c": configured_tables_source(database),
    }


def write_headers(folder: Path) -> None:
    """Write what the airframe's tables of names and surfaces say to C, and the constants that the solver is handed.

    order.h has sizes, and the order of states and of the arguments of look-ups; unknowns.h the places of a trim's
    unknowns, whose names have no prefix.
    """
    database = load_tables()
    arrays = {
        **{"NX": STATES, "NL": LINEAR_STATES, "NU": CONTROLS, "NY": OUTPUTS, "NC": COEFFICIENTS, "NK": LOOKUPS},
        **{"NF": ACCELERATED, "NT": TRIM_UNKNOWNS},
        **{"TWO_THROTTLE_NU": TWO_THROTTLE_CONTROLS, "TWO_THROTTLE_NT": TWO_THROTTLE_UNKNOWNS},
    }
    parts = {
        **{"AERODYNAMIC": AERODYNAMIC, "COMMANDED": COMMANDED, "SPOILERS": SPOILERS, "FLAPS": FLAPS},
        **{"PANELS": PANELS, "SEGMENTS": ELEVATOR_ARMS, "DAMAGE_CASES": DAMAGE_CASES, "RATES": RATES, "SERVOS": SERVOS},
    }
    counts = {name: len(values) for name, values in (arrays | parts).items()} | {"PARAMETERS": PARAMETERS}
    counts |= stored_tables.sizes(database, lookup_axes(database))
    places = (*TRIM_UNKNOWNS, *TWO_THROTTLE_UNKNOWNS[len(TRIM_UNKNOWNS) :])
    constants = {"WING_AREA": WING_AREA, "WEIGHT": float(STUDY_MASS.mass * GRAVITY), "GRAVITY": GRAVITY}
    constants["PBH_THRESHOLD"] = linear_scales.PBH_THRESHOLD
    scales = {"STATE_SCALE": linear_scales.STATE_SCALE, "INPUT_SCALE": linear_scales.INPUT_SCALE}
    sizes = (f"GTM_{name} = {count}" for name, count in counts.items())
    columns = ([f"{prefix}_{name.upper()}" for name in names] for prefix, names in (("X", STATES), ("K", LOOKUPS)))
    _write_header(folder / "order.h", [_enum(sizes), *map(_enum, columns)])
    _write_header(folder / "unknowns.h", [_enum(name.upper() for name in places)])
    defined = {name: repr(value) for name, value in constants.items()}
    defined |= {name: f"{{{', '.join(map(repr, values))}}}" for name, values in scales.items()}
    _write_header(folder / "constants.h", [f"#define GTM_{name} {value}" for name, value in defined.items()])


def _enum(names: Iterable[str]) -> str:
    return "enum {\n    " + ",\n    ".join(names) + "\n};"


def _write_header(path: Path, lines: list[str]) -> None:
    guard = f"GTM_{path.stem.upper()}_H"
    note = "/* Written when the package is built, from gtm_fmu/airframe. */"
    path.write_text("\n".join([note, f"#ifndef {guard}", f"#define {guard}", "", *lines, "", "#endif", ""]))


def generate(folder: Path) -> None:
    """Write all generated C into ``folder``."""
    folder.mkdir(parents=True, exist_ok=True)
    write_headers(folder)
    write_functions(folder, "airframe", airframe_functions())
    write_functions(folder, "atmosphere", [atmosphere_function()])
    for name, text in table_sources().items():
        (folder / name).write_text(text)
    generate_configured(folder)
