"""Trims, linear models and envelopes as a person reads them: rows of a quantity and its value, the answer first."""

from collections.abc import Mapping
from typing import Any

from gtm_fmu.envelopes.envelope import Envelope
from gtm_fmu.envelopes.multipliers import Sides, Slope
from gtm_fmu.trims.linearization import LinearModel
from gtm_fmu.trims.manoeuvre import Trim
from gtm_study.figures import captions

Rows = dict[str, Any]
_ANSWERS = ("feasible", "v_min_kt", "v_max_kt")
_KNOWN = ("converged", "feasible", "residual", "altitude_ft", "gamma_deg")  # at the ends of an envelope
_OF_SIDES = ("at_breakpoint", "stable_sides", "growth_sides_per_s")


def trim_rows(trim: Trim, described: Mapping[str, Any]) -> Rows:
    """Of a trim with its verdicts; one outside its limits says which they are."""
    rows = _with_sides(described)
    if trim.feasible:
        return rows
    return {"feasible": False, "why not": trim.shortfall} | {k: v for k, v in rows.items() if k != "limits_hit"}


def model_rows(model: LinearModel) -> Rows:
    """Of a linear model."""
    return _with_sides(model.to_dict())


def envelope_rows(envelope: Envelope, values: Mapping[str, Any]) -> Rows:
    """Of an envelope: the three numbers, then what was asked, then its trims."""
    at = captions.condition(envelope.altitude_ft, envelope.gamma_deg)
    rows = {name: values[name] for name in _ANSWERS} | {"condition": at, "failure": captions.failure(envelope.failure)}
    for name in ("guaranteed", "possible"):
        if name in values:
            rows |= {f"{name} speeds, kn": _between(values[name]), f"{name} by": _aircraft(values[name])}
    rows["speeds with a manoeuvre, kn"] = [f"{low:.2f} .. {high:.2f}" for low, high in values["intervals_kt"]]
    rows |= {name: values[name] for name in ("t_min_pct", "plot") if name in values}
    rows |= {
        f"slopes over {slope.name}, {slope.units}": _both_ends(slope) for slope in envelope.slopes if _moves(slope)
    }
    for name, title in (("at_v_min", "at V_min: "), ("at_v_max", "at V_max: "), ("nearest", "nearest manoeuvre: ")):
        if trim := getattr(envelope, name):
            rows |= {title + k: v for k, v in trim_rows(trim, values[name]).items() if k not in _KNOWN}
    return rows


def _between(ends: Mapping[str, Any]) -> str:
    return f"{ends['v_min_kt']:.2f} .. {ends['v_max_kt']:.2f}" if ends["feasible"] else "none"


def _aircraft(ends: Mapping[str, Any]) -> list[str]:
    """Of the aircraft and the gusts that hold the ends."""
    if not ends["feasible"]:
        return []
    told = []
    for title, end in (("V_min", ends["at_v_min"]), ("V_max", ends["at_v_max"])):
        parts = [f"{name} {value:+.3g}" for name, value in end["aircraft"].items()]
        if end["gust_alpha_deg"]:
            parts.append(f"gust {end['gust_alpha_deg']:.2f} deg and {end['gust_load_factor']:.2f} g")
        told.append(f"{title} {', '.join(parts) or 'as it is'}")
    return told


def _moves(slope: Slope) -> bool:
    return any(slope.v_min) or any(slope.v_max)


def _both_ends(slope: Slope) -> list[str]:
    return [f"{title} {_sides(end)}" for title, end in (("V_min", slope.v_min), ("V_max", slope.v_max))]


def _sides(slope: Sides) -> str:
    """One number, or two at a kink."""
    below, above = slope
    if slope.has_kink:
        return f"{below:+.4g} below, {above:+.4g} above"
    known = [value for value in slope if value is not None]
    return f"{known[0]:+.4g}" if known else "unknown"


def _with_sides(values: Mapping[str, Any]) -> Rows:
    """A row for each breakpoint that a trim lies on, in the place of their lists."""
    rows = {name: value for name, value in values.items() if name not in _OF_SIDES}
    for name, stable, growth in zip(*(values.get(name, ()) for name in _OF_SIDES), strict=True):
        sides = zip(("below", "above"), stable, growth, strict=True)
        rows[f"at the breakpoint {name}"] = [
            f"{side} {'stable' if is_stable else 'unstable'} ({rate:+.3g} 1/s)" for side, is_stable, rate in sides
        ]
    return rows
