"""Figures of surveys: V_max over the limits of a control, and where an envelope exists."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from gtm_fmu.envelopes.maps import FeasibilityMap, LimitSurface
from gtm_study import style
from gtm_study.figures import captions
from gtm_study.figures.captions import Label
from gtm_study.figures.pages import page
from gtm_study.figures.tolerances import told

_JAMS = style.VERMILION
_SIDES = ((-1, "to negative positions"), (1, "to positive positions"))


def plot_limit_surface(surface: LimitSurface) -> Figure:
    """V_max over both limits, with the jams along its edge (paper Fig. 33)."""
    figure = Figure(figsize=(6.6, 4.8))
    axes: Any = figure.add_axes((0.02, 0.04, 0.82, 0.88), projection="3d", computed_zorder=False)
    upper, lower = np.meshgrid(surface.limits, surface.limits)
    axes.plot_surface(lower, upper, surface.v_max_kt, cmap="cividis", rcount=61, ccount=61, zorder=1)
    jams = np.diag(surface.v_max_kt)
    axes.plot(surface.limits, surface.limits, jams, color=_JAMS, lw=3, label="jams", zorder=2)
    for set_label, label in zip((axes.set_xlabel, axes.set_ylabel), _axis_labels(surface), strict=True):
        set_label(label.tex)
    axes.set_zlabel(captions.V_MAX.tex, labelpad=8)
    axes.view_init(elev=28, azim=-60)
    figure.suptitle(_surface_title(surface).replace("; ", "\n"), fontsize="medium")
    figure.legend(loc="upper right")
    return figure


def surface_page(surface: LimitSurface) -> str:
    """The same as a page to turn about."""
    import plotly.graph_objects as go

    lower, upper = (label.html for label in _axis_labels(surface))
    figure = go.Figure()
    figure.add_surface(
        x=surface.limits,
        y=surface.limits,
        z=surface.v_max_kt.T,  # plotly has a row for each y
        colorscale="Cividis",
        showscale=False,
        hovertemplate="%{x:g} .. %{y:g}: %{z:.2f} kn<extra></extra>",
    )
    figure.add_scatter3d(
        x=surface.limits,
        y=surface.limits,
        z=np.diag(surface.v_max_kt),
        mode="lines",
        line={"color": _JAMS, "width": 8},
        name="jams",
        showlegend=True,
        hovertemplate="jam at %{x:g}: %{z:.2f} kn<extra></extra>",
    )
    scene = {
        "xaxis_title": lower,
        "yaxis_title": upper,
        "zaxis_title": captions.V_MAX.html,
        "camera": {"eye": {"x": 1.9, "y": -2.3, "z": 1.2}},
    }
    return page(figure, _surface_title(surface), scene=scene, margin={"b": 60})


def plot_feasibility(found: FeasibilityMap) -> Figure:
    """Largest jam to either side that leaves an envelope, over altitude and flight-path angle."""
    figure = Figure(figsize=(9.0, 4.2), layout="constrained")
    sides = _map_sides(found)
    panels = figure.subplots(1, len(sides), sharey=True, squeeze=False)[0]
    for axes, (sign, name) in zip(panels, sides, strict=True):
        drawn = axes.pcolormesh(
            found.gammas_deg, found.altitudes_ft, found.largest(sign), cmap="cividis", vmin=0, vmax=_largest(found)
        )
        axes.set_xlabel(captions.with_units(captions.quantity("gamma"), "deg").tex)
        axes.set_title(name, fontsize="medium")
        axes.set_facecolor("0.85")
    panels[0].set_ylabel(captions.with_units(captions.quantity("altitude"), "ft").tex)
    figure.suptitle(_map_title(found).replace("; ", ", "), fontsize="medium")
    label = f"largest jam with an envelope, {found.control.units} (grey: none)"
    figure.colorbar(drawn, ax=panels, label=label)
    return figure


def feasibility_page(found: FeasibilityMap) -> str:
    """The same as a page that shows the jam under the pointer."""
    from plotly.subplots import make_subplots

    sides = _map_sides(found)
    figure = make_subplots(1, len(sides), shared_yaxes=True, subplot_titles=[name for _, name in sides])
    for column, (sign, _) in enumerate(sides, start=1):
        largest = found.largest(sign)
        figure.add_heatmap(
            x=found.gammas_deg,
            y=found.altitudes_ft,
            z=largest,
            coloraxis="coloraxis",
            hovertemplate=f"%{{y:g}} ft, %{{x:g}} deg: %{{z:g}} {found.control.units}<extra></extra>",
            row=1,
            col=column,
        )
        figure.update_xaxes(title_text=captions.with_units(captions.quantity("gamma"), "deg").html, col=column)
    figure.update_yaxes(title_text=captions.with_units(captions.quantity("altitude"), "ft").html, col=1)
    colours = {"colorscale": "Cividis", "cmin": 0, "cmax": _largest(found)}
    bar = {
        "orientation": "h",
        "yref": "container",
        "y": 0.02,
        "yanchor": "bottom",
        "thickness": 12,
        "title": f"largest jam, {found.control.units} (grey: none)",
    }
    return page(figure, _map_title(found), coloraxis=colours | {"colorbar": bar}, plot_bgcolor="#d9d9d9")


def _axis_labels(surface: LimitSurface) -> tuple[Label, Label]:
    """Of the lower and of the upper limit, in the paper's symbols."""
    control = surface.control
    lower, upper = (captions.symbol(control.name, end) for end in ("min", "max"))
    return captions.with_units(lower, control.units), captions.with_units(upper, control.units)


def _surface_title(surface: LimitSurface) -> str:
    condition = surface.condition
    failed = captions.failure(condition.failure, surface.control)
    at = captions.condition(condition.altitude_ft, condition.gamma_deg)
    limits = f"limits of the {surface.control.name} leave"
    return f"{surface.kind or ''} highest speed that {limits}; {_beside(failed)}{at}{_within(surface)}".strip()


def _map_title(found: FeasibilityMap) -> str:
    failed = captions.failure(found.failure, found.control)
    jam = f"where a jam of the {found.control.name} leaves a"
    envelope = f"{jam} {found.kind} envelope" if found.kind else f"{jam}n envelope"
    return f"{envelope}; {_beside(failed)}".rstrip(", ;") + _within(found)


def _within(found: LimitSurface | FeasibilityMap) -> str:
    return f", {told(found.tolerances)}" if found.tolerances else ""


def _beside(failed: str) -> str:
    return "" if failed == captions.NO_FAILURE else f"{failed}, "


def _map_sides(found: FeasibilityMap) -> list[tuple[int, str]]:
    """Sides that the control moves to."""
    return [side for side in _SIDES if min(found.jams) * side[0] > 0 or max(found.jams) * side[0] > 0]


def _largest(found: FeasibilityMap) -> float:
    sizes = np.abs(np.array(found.jams)[found.feasible.any(axis=(0, 1))])
    return float(sizes.max(initial=1.0))
