"""Generated C of every configuration: the airframe with its parameters as inputs, and the tables not folded."""

from collections.abc import Iterable, Mapping
from pathlib import Path

import casadi as ca
import numpy as np

from gtm_fmu.airframe import actuators, airdata, engines, motion, steady_manoeuvre
from gtm_fmu.airframe.aerodynamics import lookup_arguments
from gtm_fmu.airframe.atmosphere import Atmosphere, atmosphere
from gtm_fmu.airframe.configuration import PARAMETERS, RANGES, Parameters, unpacked
from gtm_fmu.airframe.configured_tables import STALL_ALPHA, STALL_BETA, ConfiguredTables, configured_tables
from gtm_fmu.airframe.damage import DAMAGE_CASES
from gtm_fmu.airframe.lookup_axes import lookup_axes
from gtm_fmu.airframe.mass import components, mass_properties
from gtm_fmu.airframe.names import (
    COEFFICIENTS,
    ELEVATOR,
    LOOKUPS,
    PHI,
    STATES,
    THROTTLE,
    TWO_THROTTLE_CONTROLS,
    TWO_THROTTLE_UNKNOWNS,
)
from gtm_fmu.airframe.surfaces import AERODYNAMIC, ALLOCATION, COMMANDED, ELEVATOR_ARMS, ELEVATOR_PART, PANELS
from gtm_fmu.airframe.tables import LATERAL, Table
from gtm_fmu.airframe.wind import RUNWAY_ALTITUDE_FT
from gtm_fmu.core import stored_tables
from gtm_fmu.core.c_source import axis_definition, function, slope_through_tables, table_definition, write_functions

PANEL_TABLES = {
    "dC6_ail": ("right_aileron", "aileron"),
    "dC6_rud": ("rudder", "rudder"),
    "dC6_spo": ("right_spoiler", "spoiler"),
}
"""Table and axis in C of each table of `surfaces.PANELS`."""


def parameter_function() -> ca.Function:
    """Parameters (27), mass, centre of gravity (3) and moments of inertia (6) of what a configuration sets."""
    fuel_used, gear, damage_case, has_shear, runway = (
        ca.SX.sym(name) for name in ("fuel_used", "gear", "damage_case", "has_shear", "runway")
    )
    running, wind, gust = ca.SX.sym("running", 2), ca.SX.sym("wind", 3), ca.SX.sym("gust", 3)
    factor, offset = ca.SX.sym("mass_factor"), ca.SX.sym("cg_offset", 3)
    mass = mass_properties(fuel_used, gear, damage_case).varied(factor, offset)
    parameters = Parameters(mass, damage_case != 0, running, wind, gust, has_shear, runway)
    moments = ca.vertcat(*components(mass.inertia))
    arguments = [fuel_used, gear, damage_case, running, wind, gust, has_shear, runway, factor, offset]
    return function("cas_configured_parameters", arguments, [parameters.packed(), mass.mass, mass.cg, moments])


def motion_functions() -> list[ca.Function]:
    """Those of `generate.airframe_functions` that concern a state, with parameters."""
    x, u, vector = (
        ca.SX.sym("x", len(STATES)),
        ca.SX.sym("u", len(TWO_THROTTLE_CONTROLS)),
        ca.SX.sym("parameters", PARAMETERS),
    )
    C, T = ca.SX.sym("C", len(COEFFICIENTS)), ca.SX.sym("T", len(COEFFICIENTS), len(LOOKUPS))
    parameters = unpacked(vector)
    mass, damaged, running = parameters.mass, parameters.damaged, parameters.running
    wind = parameters.wind_body(x[8], motion.attitude(x[9], x[10], x[11]))
    K = lookup_arguments(airdata.from_velocity(x[:3] - wind, atmosphere(x[8])), x[3:6], u[:3], damaged)
    dx = motion.state_derivatives(x, u, C, mass, wind, running)
    y = motion.outputs(x, u, C, mass, wind, running)
    xu = ca.vertcat(x, u)
    return [
        function("cas_configured_wind", [x, vector], [wind]),
        function("cas_configured_lookup", [x, u, vector], [K]),
        function("cas_configured_derivatives", [x, u, vector, C], [dx]),
        function("cas_configured_jacobian", [x, u, vector, C, T.T], [dx, slope_through_tables(dx, xu, C, T, K)]),
        function("cas_configured_outputs", [x, u, vector, C], [y]),
        function("cas_configured_outputs_jacobian", [x, u, vector, C, T.T], [y, slope_through_tables(y, xu, C, T, K)]),
    ]


def trim_functions() -> list[ca.Function]:
    """Those that concern a steady manoeuvre relative to the air, with parameters."""
    t, vector = ca.SX.sym("t", len(TWO_THROTTLE_UNKNOWNS)), ca.SX.sym("parameters", PARAMETERS)
    C, T = ca.SX.sym("C", len(COEFFICIENTS)), ca.SX.sym("T", len(COEFFICIENTS), len(LOOKUPS))
    gamma, rho, pressure_ratio, altitude = (ca.SX.sym(name) for name in ("gamma", "rho", "pr", "altitude"))
    condition, air = ca.vertcat(gamma, rho, pressure_ratio), Atmosphere(rho, pressure_ratio, ca.SX(1))
    parameters = unpacked(vector)
    steady = steady_manoeuvre.steady_manoeuvre(t, gamma, air)
    K = lookup_arguments(steady.flow, steady.rates, t[ELEVATOR:THROTTLE], parameters.damaged)
    F = steady_manoeuvre.trim_residual(t, gamma, air, C, parameters.mass, parameters.running)
    wind = parameters.wind_body(altitude, steady.attitude)
    state = ca.vertcat(steady.velocity + wind, steady.rates, 0, 0, altitude, t[PHI], steady.theta, 0)
    return [
        function("cas_configured_trim_lookup", [t, condition, vector], [K]),
        function("cas_configured_trim_residual", [t, condition, vector, C], [F]),
        function(
            "cas_configured_trim_jacobian", [t, condition, vector, C, T.T], [F, slope_through_tables(F, t, C, T, K)]
        ),
        function("cas_configured_trim_state", [t, gamma, altitude, vector], [state]),
    ]


def actuator_functions() -> list[ca.Function]:
    """Those between commands and surfaces, and of the fuel (SPEC 10.1-10.3)."""
    count = len(actuators.SERVOS)
    positions, commands, rates = (ca.SX.sym(name, count) for name in ("positions", "commands", "rates"))
    elapsed, throttle, has_dead_band = (ca.SX.sym(name) for name in ("elapsed", "throttle", "has_dead_band"))
    z, running = ca.SX.sym("z", 2), ca.SX.sym("running", 2)
    return [
        function(
            "cas_servos", [positions, commands, elapsed, rates], [actuators.servos(positions, commands, elapsed, rates)]
        ),
        function(
            "cas_surfaces", [positions, has_dead_band], list(actuators.surface_positions(positions, has_dead_band))
        ),
        function("cas_settled_lag", [throttle], [actuators.settled_lag(throttle)]),
        function("cas_throttle_lag", [z, throttle, elapsed], list(actuators.throttle_lag(z, throttle, elapsed))),
        function("cas_fuel_flow", [throttle, running], [engines.fuel_flow(engines.rotor_speed(throttle), running)]),
    ]


def _initializer(values: Iterable[object]) -> str:
    return "{" + ", ".join(map(str, values)) + "}"


def _surface_definitions() -> list[str]:
    """C of the surface bus: panels, drives, elevator arms, lost surfaces."""
    panels = []
    for panel in PANELS:
        table, axis = PANEL_TABLES[panel.table]
        signs = [-1.0 if panel.is_left and name in LATERAL else 1.0 for name in COEFFICIENTS]
        weights = _initializer(weight * sign for weight, sign in zip(panel.weights, signs, strict=True))
        place = AERODYNAMIC.index(panel.surface)
        panels.append(f"{{gtm_{table}_table, &gtm_{axis}_axis, {place}, {int(panel.is_left)}, {weights}}}")
    drives = [f"{{{LOOKUPS.index(ALLOCATION[name].command)}, {ALLOCATION[name].sign}}}" for name in COMMANDED]
    has = [_initializer(int(name not in damage.lost) for name in AERODYNAMIC) for damage in DAMAGE_CASES]
    arms = (ELEVATOR_ARMS[name] for name in COMMANDED if name in ELEVATOR_ARMS)
    return [
        f"const gtm_panel gtm_panels[GTM_PANELS] = {_initializer(panels)};\n",
        f"const gtm_drive gtm_drives[GTM_COMMANDED] = {_initializer(drives)};\n",
        f"const double gtm_elevator_part = {ELEVATOR_PART};\n",
        f"const double gtm_elevator_arm[GTM_SEGMENTS] = {_initializer(arms)};\n",
        f"const unsigned char gtm_has_surface[GTM_DAMAGE_CASES][GTM_AERODYNAMIC] = {_initializer(has)};\n",
    ]


def _range_definitions(tables: ConfiguredTables) -> list[str]:
    """C of the ranges of a configuration and of the damaged rate tables."""
    return [
        *(f"const gtm_range gtm_{name}_range = {_initializer(ends)};\n" for name, ends in RANGES.items()),
        f"const double gtm_default_runway = {RUNWAY_ALTITUDE_FT};\n",
        f"const double gtm_fastest_servo = {actuators.RATE_LIMIT_DEG_S};\n",
        f"const gtm_range gtm_servo_range[] = {_initializer(map(_initializer, actuators.SERVOS.values()))};\n",
        f"const gtm_range gtm_rate_alpha[GTM_RATES] = {_initializer(map(_initializer, tables.rate_alpha))};\n",
    ]


def configured_tables_source(database: Mapping[str, Table]) -> str:
    """Content of configured_tables.c: surfaces, ranges, axes and tables, as `gtm/configured_table.c` has them."""
    tables, common = configured_tables(database), lookup_axes(database)
    stored = stored_tables.configured(database)
    looked_up = stored | {"right_aileron": stored_tables.folded(database)["aileron"]}
    axes = {
        "stabilizer": common.stabilizer_deg,
        "spoiler": common.spoiler_deg,
        "damage_alpha": tables.damage_alpha,
        "damage_beta": tables.damage_beta,
        "stall_alpha": STALL_ALPHA,
        "stall_beta": STALL_BETA,
    }
    values: dict[str, np.ndarray] = {
        "flap": tables.flap,
        "stall": tables.stall,
        "damage": tables.damage,
        "damage_scale": tables.damage_scale,
    }
    text = [f'#include "gtm/{header}.h"\n' for header in ("configured_table", "unfold")]
    text.extend([*_surface_definitions(), *_range_definitions(tables)])
    text.extend(axis_definition(name, axis) for name, axis in axes.items())
    text.extend(table_definition(name, table) for name, table in values.items())
    text.extend(each.definition(name) for name, each in stored.items())
    text.extend(each.table_definition(name, common) for name, each in looked_up.items())
    return "".join(text)


def generate_configured(folder: Path) -> None:
    """Write the generated C of every configuration into ``folder``."""
    write_functions(folder, "configured_airframe", [parameter_function(), *motion_functions(), *trim_functions()])
    write_functions(folder, "actuators", actuator_functions())
