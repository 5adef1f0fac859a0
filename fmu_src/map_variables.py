"""The variables of GtmThrustMapNative: the interface of GtmSurrogate with the thrust map behind it; the map as C."""

from dataclasses import replace

import numpy as np

from fmu_src.description import ModelDescription
from fmu_src.reference_results import Find
from fmu_src.surrogate_variables import CASE, ENVELOPE, FLAGS, MARGINS, SPEED
from gtm_fmu.thrust_map import ThrustMap

USAGE = (
    "V_min and V_max are the slowest and fastest true airspeed of a steady turn or straight flight at this altitude "
    "and flight-path angle with the rudder between rudder.lower and rudder.upper; equal limits are a jam. They are "
    "interpolated in a map of exact solutions. margin.slow and margin.fast say how far tas is inside.",
    "The interface is that of GtmSurrogate and GtmEnvelope, so that one can take the other's place, and fold. Where "
    "fold is true a small change of thrust makes a speed jump or decides whether there is an envelope: there ask the "
    "exact GtmEnvelope. Where feasible is false there is no envelope, and the speeds are zero. Where in_domain is "
    "false the case is outside the map, and the outputs are guesses.",
    "Outputs follow the inputs at once, also in Initialization Mode. That takes microseconds for a jam, some tens of "
    "them for a wide range, and 260 kB of stack.",
    "Values that are not finite or outside their bounds and reversed rudder limits are logged in one sentence; the "
    "step is discarded and all values stay as before it. No output is ever NaN.",
)
FOLD = replace(
    FLAGS[0], name="fold", description="Whether a small change of thrust makes an end jump or decides on feasible"
)
_NUMBERS_A_LINE = 16


def thrust_map_description(thrust_map: ThrustMap) -> ModelDescription:
    """The description of GtmThrustMap with a map of the rudder."""
    feasible, in_domain = FLAGS
    domain = (thrust_map.altitude_ft, thrust_map.gamma_deg, thrust_map.deflection_deg, thrust_map.deflection_deg)
    lower, upper = ([float(end(values)) for values in domain] for end in (np.min, np.max))
    ranges = [
        f"{variable.name} {least:g} .. {greatest:g} {variable.display_unit}"
        for variable, least, greatest in zip(CASE, lower, upper, strict=True)
    ]
    return ModelDescription(
        name="GtmThrustMap",
        title="Steady flight envelope of the GTM-T2 with a failed rudder, by its thrust map",
        groups={
            "case": tuple(replace(variable, bounded=True) for variable in CASE),
            "speed": (SPEED,),
            "envelope": ENVELOPE,
            "flags": (feasible, replace(in_domain, description="Whether the case is inside the thrust map")),
            "margins": MARGINS,
            "folds": (FOLD,),
        },
        stop_time=1.0,
        step_size=0.1,
        usage=(*USAGE, f"The map covers {', '.join(ranges)}."),
        constants={"lower": lower, "upper": upper},
    )


def map_envelope(thrust_map: ThrustMap) -> Find:
    """V_min and V_max in kn, zero without an envelope, and whether there is one."""

    def find(altitude_ft: float, gamma_deg: float, rudder_deg: tuple[float, float]) -> tuple[float, float, bool]:
        found = thrust_map.predict_one(altitude_ft, gamma_deg, rudder_deg)
        return found["v_min_kt"] or 0.0, found["v_max_kt"] or 0.0, found["feasible"]

    return find


def _array(kind: str, name: str, numbers: np.ndarray, suffix: str = "") -> str:
    """C of an array, each number with the fewest digits that give its very bits."""
    digits = [f"{number!s}{suffix}" for number in numbers.ravel()]
    lines = (", ".join(digits[i : i + _NUMBERS_A_LINE]) for i in range(0, len(digits), _NUMBERS_A_LINE))
    return f"static const {kind} {name}[] = {{\n" + ",\n".join(lines) + "};\n"


def map_source(thrust_map: ThrustMap) -> dict[str, bytes]:
    """map.h and map.c: the map as a constant of thrust_map.h."""
    densities, paths, deflections, numbers = thrust_map.table.shape
    ends, tolerances = 2, thrust_map.tolerances
    members = {
        "densities": densities,
        "paths": paths,
        "deflections": deflections,
        "speeds": numbers - ends,
        "density": "density",
        "gamma": "gamma",
        "deflection": "deflection",
        "table": "table",
        "full_thrust": thrust_map.full_thrust_lbf,
        "tolerance": tolerances.thrust_lbf,
        "tolerance_deviations": tolerances.thrust_deviations,
        "bend_share": tolerances.bend_share,
        "least_deviation": tolerances.least_kt,
    }
    arrays = (
        _array("double", "density", thrust_map.density_ratio),
        _array("double", "gamma", thrust_map.gamma_deg),
        _array("double", "deflection", thrust_map.deflection_deg),
        _array("float", "table", thrust_map.table, "f"),
    )
    given = "".join(f"    .{name} = {value},\n" for name, value in members.items())
    header = (
        "/* The map of the rudder. */\n#ifndef MAP_H\n#define MAP_H\n\n"
        '#include "thrust_map.h"\n\nextern const gtm_thrust_map map;\n\n#endif\n'
    )
    source = '#include "map.h"\n\n' + "\n".join(arrays) + f"\nconst gtm_thrust_map map = {{\n{given}}};\n"
    return {"map.h": header.encode(), "map.c": source.encode()}
