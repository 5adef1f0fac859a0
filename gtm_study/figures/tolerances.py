"""Guaranteed, nominal and possible speeds along an axis: three bands, told apart by shade, hatch and line."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from gtm_fmu.aircraft.inputs import CONDITION
from gtm_fmu.envelopes.tolerances import Tolerances
from gtm_fmu.envelopes.tolerant_family import KINDS, TolerantFamily
from gtm_study import style
from gtm_study.figures import captions
from gtm_study.figures.captions import Label
from gtm_study.figures.pages import page

_LOOKS: dict[str, dict[str, Any]] = {
    "possible": {"facecolor": "#e6e6e6", "edgecolor": style.GREY, "ls": ":", "hatch": ""},
    "nominal": {"facecolor": "#b5d9f0", "edgecolor": style.BLACK, "ls": "--", "hatch": ""},
    "guaranteed": {"facecolor": "#3f8fc4", "edgecolor": style.BLACK, "ls": "-", "hatch": "///"},
}
_DASHES = {":": "dot", "--": "dash", "-": "solid"}


def plot_tolerances(family: TolerantFamily) -> Figure:
    """The bands over altitude, flight path or jam."""
    figure = Figure(figsize=(7.2, 4.8), layout="constrained")
    axes = figure.subplots()
    speeds = family.speeds_kt
    for kind, looks in _LOOKS.items():
        low, high = speeds[:, KINDS.index(kind)].T
        axes.fill_between(family.values, low, high, label=kind, lw=1.4, **looks)
    axes.set_xlabel(_axis_label(family).tex)
    axes.set_ylabel(captions.SPEED.tex)
    axes.set_title(_title(family).replace("; ", "\n"), fontsize="medium")
    axes.grid(alpha=0.3)
    figure.legend(loc="outside lower center", ncols=len(_LOOKS))
    return figure


def tolerances_page(family: TolerantFamily) -> str:
    """The same as a page that shows the speeds under the pointer."""
    import plotly.graph_objects as go

    figure, speeds = go.Figure(), family.speeds_kt
    for kind, looks in _LOOKS.items():
        both = speeds[:, KINDS.index(kind)]
        line = {"color": looks["edgecolor"], "dash": _DASHES[looks["ls"]], "width": 1.5}
        for side, name in ((0, "V_min"), (1, "V_max")):
            figure.add_scatter(
                x=family.values,
                y=[None if np.isnan(speed) else speed for speed in both[:, side]],
                mode="lines",
                line=line,
                fill="tonexty" if side else None,
                fillcolor=looks["facecolor"],
                name=kind,
                legendgroup=kind,
                showlegend=bool(side),
                hovertemplate=f"%{{x:g}} {family.axis.units}: {kind} {name} %{{y:.2f}} kn<extra></extra>",
            )
    axes = {"xaxis_title": _axis_label(family).html, "yaxis_title": captions.SPEED.html}
    return page(figure, _title(family), **axes)


def _axis_label(family: TolerantFamily) -> Label:
    return captions.with_units(captions.quantity(family.axis.name), family.axis.units)


def _title(family: TolerantFamily) -> str:
    first = family.members[0].nominal
    held = {c.label: getattr(first, c.label) for c in CONDITION if c != family.axis}
    is_jammed = family.axis not in CONDITION
    failed = captions.failure(first.failure, family.axis if is_jammed else None)
    parts = [f"{family.axis.name.replace('_', ' ')} jammed"] if is_jammed else []
    parts += [failed] if not (is_jammed and failed == captions.NO_FAILURE) else []
    return f"{', '.join(parts)}; {captions.condition(**held)}, {told(family.tolerances)}"


def told(tolerances: Tolerances) -> str:
    """Tolerances in a title."""
    parts = [f"gust {tolerances.gust_kt:g} kn"] if tolerances.gust_kt else []
    for name, part, of in (("mass", "mass", ""), ("cg", "cg", " of the chord"), ("aero", "coefficients", "")):
        if value := getattr(tolerances, f"{name}_tolerance"):
            parts.append(f"{part} \N{PLUS-MINUS SIGN}{100 * value:g} %{of}")
    return ", ".join(parts)
