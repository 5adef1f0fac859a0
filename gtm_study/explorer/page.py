"""The page of the explorer: facts from the package, the compiled core and a surrogate of each kind, in one file."""

import base64
import gzip
import json
import re
from collections.abc import Mapping
from importlib.metadata import version
from importlib.resources import files
from string import Template
from typing import Any

import numpy as np

from gtm_fmu.aircraft import ranges
from gtm_fmu.aircraft.ranges import ALPHA_DEG, BETA_DEG, PHI_DEG, WIDEST
from gtm_fmu.airframe.damage import DAMAGE_CASES
from gtm_fmu.airframe.names import CONTROLS, TRIM_UNKNOWNS
from gtm_fmu.core import solver
from gtm_fmu.core.query import ANSWER
from gtm_fmu.core.sections import INTERVALS
from gtm_fmu.envelopes.envelope import THROTTLE_WITHOUT_LIMIT
from gtm_fmu.envelopes.feasibility import FULL_THROTTLE_PCT
from gtm_fmu.envelopes.thrust_map import ThrustMap
from gtm_fmu.trims.manoeuvre import HELD_TOLERANCE
from gtm_fmu.units import DEG_PER_RAD, KT_PER_FT_S, RAD_PER_DEG
from gtm_study.explorer.webassembly import core_module
from gtm_study.figures.envelopes import COLOURS
from gtm_study.figures.pages import page_style
from surrogate.exports.closed_form import closed_form
from surrogate.exports.javascript import javascript
from surrogate.models.network import Network
from surrogate.rudder.emulator import RudderEmulator

_UNIT = {"V": KT_PER_FT_S, **dict.fromkeys(("alpha", "beta", "psi_dot", "phi"), DEG_PER_RAD)}
_CONTROL_UNITS = {"elevator": "deg", "aileron": "deg", "rudder": "deg", "throttle": "%"}
_SECTION_TOLERANCE = 1e-4  # of an unknown's typical size; ends of sections are found to a tenth of that
_ENGINES = (("both", "both run"), ("left_out", "left out"), ("right_out", "right out"), ("both_out", "both out"))
_USUAL = {
    "damage_case": 0,
    "engines": "both",
    "fuel_used_lb": 0.0,
    "stabilizer_deg": 0.0,
    "gear": 0.0,
    "flap_deg": 0.0,
    "spoiler_deg": 0.0,
}
_EXAMPLES: tuple[tuple[str, dict[str, Any]], ...] = (
    ("healthy aircraft", {}),
    ("rudder jammed at 15 deg", {"rudder.lower": 15.0, "rudder.upper": 15.0}),
    ("rudder between -10 and 20 deg", {"rudder.lower": -10.0, "rudder.upper": 20.0}),
    ("elevator jammed at -2 deg", {"elevator.lower": -2.0, "elevator.upper": -2.0}),
    ("left engine out", {"engines": "left_out"}),
    ("a quarter of the left wing off", {"damage_case": "4"}),
    ("both engines out, gliding", {"engines": "both_out", "gamma_deg": -6.0}),
)


def _slider(name: str, label: str, unit: str, usual: float, span: tuple[float, float], step: float, group: str) -> dict:
    return {
        "name": name,
        "label": label,
        "unit": unit,
        "usual": usual,
        "least": span[0],
        "greatest": span[1],
        "step": step,
        "group": group,
    }


def _inputs() -> list[dict[str, Any]]:
    """What can be moved on the page, in its order."""
    inputs = [
        _slider("altitude_ft", "Altitude", "ft", 10000.0, ranges.ALTITUDE_FT, 250.0, "flight"),
        _slider("gamma_deg", "Flight-path angle", "deg", 0.0, (-15.0, 15.0), 0.25, "flight"),
    ]
    for control in CONTROLS:
        span, unit = WIDEST[f"{control}_{'pct' if control == 'throttle' else 'deg'}"], _CONTROL_UNITS[control]
        for end, usual, other in (("lower", span[0], "upper"), ("upper", span[1], "lower")):
            slider = _slider(f"{control}.{end}", f"{control.capitalize()}, {end}", unit, usual, span, 0.5, "limits")
            inputs.append(slider | {"pushes": f"{control}.{other}"})
    damage = [(str(number), case.name) for number, case in enumerate(DAMAGE_CASES)]
    inputs += [
        {"name": "damage_case", "label": "Damage", "usual": "0", "options": damage, "group": "airframe"},
        {"name": "engines", "label": "Engines", "usual": "both", "options": _ENGINES, "group": "airframe"},
        _slider("fuel_used_lb", "Fuel used", "lb", 0.0, (0.0, 11.0), 0.5, "airframe"),
        _slider("flap_deg", "Flaps", "deg", 0.0, (0.0, 30.0), 1.0, "airframe"),
        _slider("spoiler_deg", "Spoilers", "deg", 0.0, (0.0, 45.0), 1.0, "airframe"),
        _slider("stabilizer_deg", "Stabiliser", "deg", 0.0, (-5.0, 5.0), 0.25, "airframe"),
        _slider("gear", "Gear, 0 up to 1 down", "", 0.0, (0.0, 1.0), 0.1, "airframe"),
        _slider("tas_kt", "True airspeed", "kn", 120.0, (40.0, 260.0), 0.5, "chosen"),
        _slider("turn_rate_deg_s", "Turn rate", "deg/s", 0.0, (-15.0, 15.0), 0.1, "chosen"),
    ]
    return inputs


def facts() -> dict[str, Any]:
    """Names, ranges and constants that the page takes from the package."""
    return {
        "unknowns": TRIM_UNKNOWNS,
        "controls": CONTROLS,
        "control_units": _CONTROL_UNITS,
        "highest_ft": ranges.ALTITUDE_FT[1],
        "answer": {name: place[1] for name, place in (ANSWER.fields or {}).items()},
        "intervals": {name: place[1] for name, place in (INTERVALS.fields or {}).items()},
        "section_tolerance": _SECTION_TOLERANCE,
        "shown_margins": ("alpha", "phi", *CONTROLS),
        "units_per_core_unit": _UNIT,
        "rad_per_deg": RAD_PER_DEG,
        "scale": solver.scale().tolist(),
        "held_tolerance": HELD_TOLERANCE,
        "throttle_without_limit": THROTTLE_WITHOUT_LIMIT,
        "full_throttle_pct": FULL_THROTTLE_PCT,
        "bounds": {
            "V": ranges.TAS_KT,
            "alpha": ALPHA_DEG,
            "beta": BETA_DEG,
            "psi_dot": ranges.TURN_RATE_DEG_S,
            "phi": PHI_DEG,
            **{name.split("_")[0]: span for name, span in WIDEST.items()},
        },
        "usual_configuration": _USUAL,
        "inputs": _inputs(),
        "examples": [{"label": label, "values": values} for label, values in _EXAMPLES],
        "colours": COLOURS,
    }


def explorer_page(shares: Mapping[str, str]) -> str:
    """The page, which asks no network for anything.

    Args:
        shares: a sentence on what matters over all failures of a kind, as `gtm_study.paper.advice.shares_by_kind`.

    Raises:
        InputError: Zig, which compiles the core for browsers, is missing.
    """
    from plotly.offline import get_plotlyjs

    web = files("gtm_study.explorer") / "web"
    text = {name: (web / name).read_text(encoding="utf-8") for name in _PARTS}
    emulator = RudderEmulator.load()
    networks = (_as_constant("speedsNetwork", emulator.speeds), _as_constant("throttleNetwork", emulator.throttle))
    return Template(text["explorer.html"]).substitute(
        css=page_style() + text["explorer.css"],
        version=version("gtm-fmu"),
        facts=_json({**facts(), "shares": dict(shares), "map": _map(ThrustMap.load())}),
        core=_packed(core_module()),
        worker="\n".join([*networks, text["core.js"], text["worker.js"]]),
        plotly=get_plotlyjs(),
        page="\n".join([text["controls.js"], text["aircraft.js"], text["explorer.js"]]),
    )


_PARTS = ("explorer.html", "explorer.css", "core.js", "worker.js", "controls.js", "aircraft.js", "explorer.js")


def _packed(content: bytes) -> str:
    """Bytes as a browser unpacks them: gzip, base64."""
    return base64.b64encode(gzip.compress(content, 9, mtime=0)).decode()


def _json(values: Any) -> str:
    """JSON that can stand inside a script element."""
    return json.dumps(values, allow_nan=False).replace("<", "\\u003c")


def _map(thrust_map: ThrustMap) -> dict[str, Any]:
    """A thrust map as the worker loads it into the core."""
    return {
        "densities": thrust_map.density_ratio.tolist(),
        "paths": thrust_map.gamma_deg.tolist(),
        "deflections": thrust_map.deflection_deg.tolist(),
        "reach": thrust_map.reach.ravel().tolist(),
        "table": _packed(np.asarray(thrust_map.table, dtype="<f4").tobytes()),
        "constants": [thrust_map.full_thrust_lbf, *thrust_map.tolerances],
    }


def _as_constant(name: str, network: Network) -> str:
    """A network's module as one constant of a script, with the module's exports."""
    module = javascript(closed_form(network))
    exported = re.findall(r"^export (?:const|function) (\w+)", module, re.MULTILINE)
    body = re.sub(r"^export ", "", module, flags=re.MULTILINE)
    return f"const {name} = (() => {{\n{body}\nreturn {{ {', '.join(exported)} }};\n}})();"
