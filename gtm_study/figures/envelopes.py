"""Figures of one flight condition's envelope: every steady manoeuvre, and the limits that end it."""

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path as Outline

from gtm_fmu.envelopes.boundary import Boundary, envelope_boundary
from gtm_fmu.envelopes.envelope import FlightCondition
from gtm_fmu.envelopes.grid import EnvelopeGrid, envelope_grid
from gtm_study import style
from gtm_study.figures import captions
from gtm_study.figures.captions import Label
from gtm_study.figures.pages import page
from gtm_study.files import save_picture

COLOURS = {
    "alpha": style.VERMILION,
    "throttle": style.BLUE,
    "aileron": style.GREEN,
    "elevator": style.PURPLE,
    "rudder": style.BLACK,
    "phi": style.ORANGE,
    "beta": style.SKY,
}
MARKERS = dict(zip(COLOURS, style.MARKERS, strict=True))
"""In the colour of a limit along its strokes, for grey print."""
STABLE, UNSTABLE, REJECTED = "#bcd9ee", "#fdf3dc", "#9a9a9a"
_CELLS = {"stable": STABLE, "unstable, controllable": UNSTABLE, "unstable, uncontrollable: not in it": REJECTED}


class Stroke(NamedTuple):
    """A piece of a boundary in the colour of a limit that holds it; of two limits the second is dashed on the first."""

    label: Label
    colour: str
    marker: str
    is_second: bool
    turn_rate_deg_s: np.ndarray
    tas_kt: np.ndarray


def strokes(boundary: Boundary) -> Iterator[Stroke]:
    """The boundary in the colours of its limits."""
    for around in boundary.polygons:
        for piece in around:
            held = [name.split(".")[0] for name in piece.limits]
            controls = [name for name in COLOURS if any(name == each.partition("_")[0] for each in held)]
            for k, name in enumerate(controls[:2]):
                yield Stroke(
                    captions.quantity(name), COLOURS[name], MARKERS[name], k > 0, piece.turn_rate_deg_s, piece.tas_kt
                )
            if not controls:
                label = Label("no limit", "no limit")
                yield Stroke(label, style.GREY, "", False, piece.turn_rate_deg_s, piece.tas_kt)


def line_style(stroke: Stroke) -> dict[str, Any]:
    """How matplotlib draws a stroke."""
    return {
        "color": stroke.colour,
        "linestyle": (0, (2.5, 2.5)) if stroke.is_second else "-",
        "lw": 2.4,
        "solid_capstyle": "butt",
        "dash_capstyle": "butt",
        "marker": stroke.marker,
        "ms": 6,
        "mec": "white",
        "mew": 0.6,
        "markevery": (0.06 if stroke.is_second else 0.0, 0.12),
    }


def save_envelope(condition: FlightCondition, path: Path) -> None:
    """Write the envelope of a flight condition as a picture (.png) or as an interactive page (.html).

    Raises:
        InputError: another ending, or a folder that cannot be written.
    """
    grid, boundary = envelope_grid(condition, turn_rate_step_deg_s=0.5), envelope_boundary(condition)
    save_picture(path, lambda: plot_envelope(grid, boundary), lambda: envelope_page(grid, boundary))


def plot_envelope(grid: EnvelopeGrid, boundary: Boundary) -> Figure:
    """Turn rate over speed: cells by stability, and the boundary in the colours of the limits that hold it."""
    figure = Figure(figsize=(7.6, 5.6), layout="constrained")
    axes = figure.subplots()
    if grid.feasible.any():
        colours = ListedColormap(list(_CELLS.values()))
        cells = axes.pcolormesh(grid.turn_rate_deg_s, grid.tas_kt, _kinds(grid), cmap=colours, vmin=-0.5, vmax=2.5)
        inside = Outline.make_compound_path(*(Outline(np.column_stack(outline)) for outline in boundary.outlines))
        cells.set_clip_path(PathPatch(inside, transform=axes.transData))
    for label, colour in _legend_of(grid):
        axes.plot([], [], "s", ms=9, color=colour, label=label)
    draw(axes, boundary)
    axes.set_xlabel(captions.TURN_RATE.tex)
    axes.set_ylabel(captions.SPEED.tex)
    axes.set_title(_title(grid).replace("; ", "\n"), fontsize="medium")
    axes.grid(alpha=0.3)
    axes.set_axisbelow(True)
    if boundary.polygons:
        margins(axes, [boundary])
        figure.legend(loc="outside right upper", fontsize="small", title="held by", title_fontsize="small")
    else:
        axes.text(0.5, 0.5, "no steady manoeuvre is left", transform=axes.transAxes, ha="center")
    return figure


def draw(axes: Axes, boundary: Boundary) -> None:
    """The boundary, each limit once in the legend."""
    named = set(axes.get_legend_handles_labels()[1])
    for stroke in strokes(boundary):
        label = None if stroke.label.tex in named else stroke.label.tex
        named.add(stroke.label.tex)
        axes.plot(stroke.turn_rate_deg_s, stroke.tas_kt, label=label, **line_style(stroke))


def margins(axes: Axes, boundaries: Iterable[Boundary]) -> None:
    """A little room around the curves."""
    points = np.hstack([np.array(outline) for boundary in boundaries for outline in boundary.outlines])
    low, high = points.min(axis=1), points.max(axis=1)
    room = 0.05 * (high - low) + (0.5, 1.0)
    axes.set_xlim(low[0] - room[0], high[0] + room[0])
    axes.set_ylim(low[1] - room[1], high[1] + room[1])


def envelope_page(grid: EnvelopeGrid, boundary: Boundary) -> str:
    """The same as a page that shows the trim under the pointer."""
    import plotly.graph_objects as go

    figure = go.Figure()
    kinds = _kinds(grid)
    if grid.feasible.any():
        data = grid.to_dataset()
        names = [str(name) for name, values in data.items() if "units" in values.attrs]
        rows = [f"{captions.quantity(n).html} %{{customdata[{k}]:.2f}} {data[n].units}" for k, n in enumerate(names)]
        figure.add_heatmap(
            x=grid.turn_rate_deg_s,
            y=grid.tas_kt,
            z=kinds,
            customdata=np.stack([data[name].values for name in names], axis=-1),
            colorscale=[[k / 3 + part, colour] for k, colour in enumerate(_CELLS.values()) for part in (0, 1 / 3)],
            zmin=-0.5,
            zmax=2.5,
            showscale=False,
            hoverongaps=False,
            name="",
            hovertemplate="<br>".join(["%{y:g} kn, %{x:g} deg/s", *rows]),
        )
    for label, colour in _legend_of(grid):
        marker = {"symbol": "square", "size": 12, "color": colour}
        figure.add_scatter(x=[None], y=[None], mode="markers", marker=marker, name=label)
    add_strokes(figure.add_scatter, [(stroke, {}) for stroke in strokes(boundary)])
    axes: dict[str, Any] = {"xaxis_title": captions.TURN_RATE.html, "yaxis_title": captions.SPEED.html}
    if boundary.polygons:
        rates = [rate for outline in boundary.outlines for rate in outline[0]]
        axes["xaxis_range"] = [min(rates) - 1, max(rates) + 1]
    else:
        figure.add_annotation(
            text="no steady manoeuvre is left", x=0.5, y=0.5, xref="paper", yref="paper", showarrow=False
        )
    return page(figure, _title(grid), **axes)


def add_strokes(add: Any, drawn: list[tuple[Stroke, dict[str, float]]]) -> None:
    """Strokes in plotly, one trace for each limit and style; the places of a stroke are constant in further axes."""
    kinds: dict[tuple[Label, bool], list[tuple[Stroke, dict[str, float]]]] = {}
    for stroke, place in drawn:
        kinds.setdefault((stroke.label, stroke.is_second), []).append((stroke, place))
    for label, is_second in sorted(kinds, key=lambda kind: kind[1]):
        x: list[float | None] = []
        y: list[float | None] = []
        further: dict[str, list[float | None]] = {}
        for stroke, place in kinds[label, is_second]:
            x += [*stroke.turn_rate_deg_s.tolist(), None]
            y += [*stroke.tas_kt.tolist(), None]
            for axis, at in place.items():
                further.setdefault(axis, []).extend([at] * len(stroke.tas_kt) + [None])
        add(
            x=x,
            y=y,
            **further,
            mode="lines",
            line={"color": kinds[label, is_second][0][0].colour, "width": 4, "dash": "dash" if is_second else "solid"},
            name=label.html,
            legendgroup=label.html,
            showlegend=not is_second or (label, False) not in kinds,
            hovertemplate="%{y:.2f} kn, %{x:.2f} deg/s" + "".join(f", %{{{axis}:g}}" for axis in further),
        )


def _kinds(grid: EnvelopeGrid) -> np.ndarray:
    """Number in `_CELLS` of each cell, NaN without a trim."""
    kinds = np.select([grid.stable, grid.controllable], [0.0, 1.0], 2.0)
    return np.where(grid.feasible, kinds, np.nan)


def _legend_of(grid: EnvelopeGrid) -> list[tuple[str, str]]:
    """Kinds of cells that there are, with their colours."""
    there = set(_kinds(grid)[grid.feasible].astype(int).tolist())
    return [item for k, item in enumerate(_CELLS.items()) if k in there]


def _title(grid: EnvelopeGrid) -> str:
    return f"{captions.failure(grid.failure)}; {captions.condition(grid.altitude_ft, grid.gamma_deg)}"
