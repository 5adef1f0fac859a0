"""The variables of GtmSurrogate with a thrust map behind them; the map as C and as data."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from json import dumps
from math import isfinite
from pathlib import Path

import numpy as np

from fmu_src.description.envelope_variables import ENVELOPE_FAULTS
from fmu_src.description.failure_variables import failure_inputs
from fmu_src.description.model_description import ModelDescription, Variable
from fmu_src.description.reference_results import reference_envelopes
from fmu_src.description.surrogate_variables import CASE, ENVELOPE, FLAGS, MARGINS, SPEED
from gtm_fmu.aircraft.ranges import Range
from gtm_fmu.conformal import EPSILON
from gtm_fmu.core.map_layout import GROUPS
from gtm_fmu.envelopes.thrust_map import ThrustMap
from gtm_fmu.errors import InputError

UNKNOWN_STD_KT = 1000.0
"""Standard deviation where nobody knows it."""
USAGE = (
    "V_min and V_max are the slowest and fastest true airspeed of a steady turn or straight flight at this altitude "
    "and flight-path angle with the {control} between {lower} and {upper}; equal limits are a jam. They are "
    "interpolated in a map of exact solutions. margin.slow and margin.fast say how far tas is inside.",
    "The inputs are some of GtmEnvelope's, and the outputs all of them, so that one can take the other's place while "
    "nothing else fails, and fold. Where fold is true a small change of thrust makes a speed jump or decides whether "
    "there is an envelope: there ask the exact GtmEnvelope. Where feasible is false there is no envelope, and the "
    "speeds are zero. Where in_domain is false the case is outside the map and the speeds are guesses. Nobody knows "
    f"how far they are off: the standard deviations are {UNKNOWN_STD_KT:g} kn then, more than any speed.",
    "v_min_safe is not below the exact V_min and v_max_safe not above the exact V_max, each with a probability of at "
    "least {confidence} over the exact cases that set their margins and one more of the same distribution: "
    "{calibrated}. What lies between them may have gaps, as near the ceiling. Where feasible_safe is false nothing is "
    f"promised: v_min_safe is {UNKNOWN_STD_KT:g} kn then and v_max_safe is zero, so that no speed passes for safe.",
    "Outputs follow the inputs at once, also in Initialization Mode. That takes microseconds for a jam and some tens "
    "of them for a wide range.",
    "Values that are not finite or outside their bounds and reversed limits are logged in one sentence; the "
    "step is discarded and all values stay as before it. No output is ever NaN.",
)
FOLD = replace(
    FLAGS[0], name="fold", description="Whether a small change of thrust makes an end jump or decides on feasible"
)
SAFE = (
    replace(ENVELOPE[0], name="v_min_safe", description="A speed that is not below the exact v_min"),
    replace(ENVELOPE[1], name="v_max_safe", description="A speed that is not above the exact v_max"),
    replace(FLAGS[0], name="feasible_safe", description="Whether v_min_safe and v_max_safe are promised"),
)
ARRAYS = ("density_ratio", "gamma_deg", "deflection_deg", "reach")
"""Attributes of a map that are handed to the core, in the order of `CoreMap`; the table follows."""
_NUMBERS_A_LINE = 16


def map_name(control: str) -> str:
    """Of the FMU with a map of a control, without the endings that say how it runs."""
    return "GtmThrustMap" if control == "rudder" else f"GtmThrustMap{control.capitalize()}"


def thrust_map_description(thrust_map: ThrustMap, name: str | None = None) -> ModelDescription:
    """The description of an FMU with a map; a rudder's has the inputs of `GtmSurrogate`."""
    control = thrust_map.control
    case = _case(control)
    names = tuple(variable.name for variable in case)
    feasible, in_domain = FLAGS
    domain = (thrust_map.altitude_ft, thrust_map.gamma_deg, thrust_map.deflection_deg, thrust_map.deflection_deg)
    lower, upper = ([float(end(values)) for values in domain] for end in (np.min, np.max))
    ranges = [
        f"{variable.name} {least:g} .. {greatest:g} {variable.display_unit}"
        for variable, least, greatest in zip(case, lower, upper, strict=True)
    ]

    def depending(*outputs: Variable) -> tuple[Variable, ...]:
        return tuple(
            replace(output, depends_on=(*names, *(name for name in output.depends_on if name == SPEED.name)))
            for output in outputs
        )

    about = {"control": control, "lower": names[2], "upper": names[3]}
    about |= {"confidence": f"{1 - EPSILON:.1%}", "calibrated": _calibrated(thrust_map)}
    usage = (text.format(**about) for text in USAGE)
    return ModelDescription(
        name=name or map_name(control),
        title=f"Steady flight envelope of the GTM-T2 with a failed {control}, by its thrust map",
        groups={
            "case": case,
            "speed": (SPEED,),
            "envelope": depending(*ENVELOPE),
            "flags": depending(feasible, replace(in_domain, description="Whether the case is inside the thrust map")),
            "margins": depending(*MARGINS),
            "folds": depending(FOLD),
            "safe": depending(*SAFE),
        },
        stop_time=1.0,
        step_size=0.1,
        usage=(*usage, f"The map covers {', '.join(ranges)}."),
        constants={"lower": lower, "upper": upper, "unknown_std_kt": UNKNOWN_STD_KT},
    )


def _calibrated(thrust_map: ThrustMap) -> str:
    """What the margins of a map follow from."""
    if thrust_map.safe is None:
        return "this map has none, and promises nothing"
    groups = (f"{count} {name}" for count, name in zip(thrust_map.safe.cases, GROUPS, strict=True))
    return f"random cases of the whole map, {', '.join(groups)}"


def _case(control: str) -> tuple[Variable, ...]:
    """Altitude, flight path and the limits of a control, named as in GtmEnvelope."""
    if control == "rudder":
        return tuple(replace(variable, bounded=True) for variable in CASE)
    limits = {variable.name: variable for variable in failure_inputs()}
    ends = (limits[f"limits.{control}.{end}"] for end in ("lower", "upper"))
    return (*_case("rudder")[:2], *(replace(end, bounded=True) for end in ends))


def map_faults(thrust_map: ThrustMap) -> tuple[str, ...]:
    """By fault, as in map_model.c."""
    lower, upper = (variable.name for variable in _case(thrust_map.control)[2:])
    return (*ENVELOPE_FAULTS[:2], f"The {thrust_map.control} limits are reversed: {lower} is above {upper}.")


def read_map(path: Path | None, only: str | None = None) -> ThrustMap:
    """A map from a file, or the rudder's that comes with the package; of one control ``only`` if that is given.

    Raises:
        InputError: missing, damaged or of another control.
    """
    thrust_map = ThrustMap.load() if path is None else ThrustMap.load(path)
    if only is not None and thrust_map.control != only:
        raise InputError(f"'{path}' is a thrust map of the {thrust_map.control}: give one of the {only}.")
    return thrust_map


def map_reference(thrust_map: ThrustMap) -> Callable[[ModelDescription], dict[str, bytes]]:
    """Expected results, by the map itself."""

    def find(altitude_ft: float, gamma_deg: float, limits_deg: Range) -> tuple[float, float, bool]:
        found = thrust_map.predict_one(altitude_ft, gamma_deg, limits_deg)
        return found["v_min_kt"] or 0.0, found["v_max_kt"] or 0.0, found["feasible"]

    return partial(reference_envelopes, find=find, control=thrust_map.control)


def map_resources(thrust_map: ThrustMap) -> dict[str, bytes]:
    """The map as `mapped_surrogate` reads it: numbers as JSON, the table as little-endian single precision."""
    numbers = {
        "sizes": [*thrust_map.table.shape[:3], thrust_map.table.shape[3] - 2],
        "arrays": [getattr(thrust_map, name).ravel().tolist() for name in ARRAYS],
        "constants": [thrust_map.full_thrust_lbf, *thrust_map.tolerances],
        "margins": [value if isfinite(value) else None for value in thrust_map.margins().ravel().tolist()],
    }
    return {"map.json": dumps(numbers).encode(), "map.f4": thrust_map.table.astype("<f4").tobytes()}


def _array(kind: str, name: str, numbers: np.ndarray, suffix: str = "") -> str:
    """C of an array, each number with the fewest digits that give its very bits."""
    digits = [f"{number!s}{suffix}" if isfinite(number) else "INFINITY" for number in numbers.ravel()]
    lines = (", ".join(digits[i : i + _NUMBERS_A_LINE]) for i in range(0, len(digits), _NUMBERS_A_LINE))
    return f"{kind} {name}[] = {{\n" + ",\n".join(lines) + "};\n"


def map_source(thrust_map: ThrustMap) -> dict[str, bytes]:
    """map.h and map.c: the map and its margins as constants of thrust_map.h."""
    densities, paths, deflections, numbers = thrust_map.table.shape
    ends, tolerances = 2, thrust_map.tolerances
    members = {
        "densities": densities,
        "paths": paths,
        "deflections": deflections,
        "speeds": numbers - ends,
        "density": "map_density",
        "gamma": "map_gamma",
        "deflection": "map_deflection",
        "reach": "map_reach",
        "table": "map_table",
        "full_thrust": thrust_map.full_thrust_lbf,
        "tolerance": tolerances.thrust_lbf,
        "tolerance_deviations": tolerances.thrust_deviations,
        "bend_share": tolerances.bend_share,
        "least_deviation": tolerances.least_kt,
        "reach_tolerance": tolerances.reach_deg,
    }
    arrays = (
        _array("static const double", "map_density", thrust_map.density_ratio),
        _array("static const double", "map_gamma", thrust_map.gamma_deg),
        _array("static const double", "map_deflection", thrust_map.deflection_deg),
        _array("static const double", "map_reach", thrust_map.reach),
        _array("static const float", "map_table", thrust_map.table, "f"),
        _array("const double", "map_margins", thrust_map.margins()),
    )
    given = "".join(f"    .{name} = {value},\n" for name, value in members.items())
    header = (
        "/* The thrust map. */\n#ifndef MAP_H\n#define MAP_H\n\n"
        '#include "thrust_map.h"\n\nextern const gtm_thrust_map map;\n'
        "extern const double map_margins[GTM_MAP_GROUPS * GTM_MAP_ENDS]; /* as in gtm_map_safe_ends */\n\n#endif\n"
    )
    source = (
        '#include "map.h"\n\n#include <math.h>\n\n'
        + "\n".join(arrays)
        + f"\nconst gtm_thrust_map map = {{\n{given}}};\n"
    )
    return {"map.h": header.encode(), "map.c": source.encode()}
