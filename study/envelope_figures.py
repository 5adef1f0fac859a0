"""Figures of one flight condition's envelope: every steady manoeuvre, and the limits that end it."""

from collections.abc import Iterator
from itertools import groupby
from pathlib import Path

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from gtm_fmu.envelope import Boundary
from gtm_fmu.errors import InputError
from gtm_fmu.grid import EnvelopeGrid
from study.files import save_figure, write_text

LIMIT_COLOURS = {
    "alpha": "#d1495b",
    "throttle": "#e08e0b",
    "aileron": "#00798c",
    "elevator": "#8d6a9f",
    "rudder": "#3d3d3d",
    "phi": "#30638e",
}
_STABLE, _UNSTABLE = "#b7d7b0", "#f4d6a0"


def save_envelope(grid: EnvelopeGrid, boundary: Boundary, path: Path) -> None:
    """Write the envelope as a picture (.png) or as an interactive page (.html).

    Raises:
        InputError: another ending, or a folder that cannot be written.
    """
    if path.suffix == ".png":
        save_figure(plot_envelope(grid, boundary), path)
    elif path.suffix == ".html":
        write_text(envelope_page(grid, boundary), path)
    else:
        raise InputError(f"{path} ends in neither .png nor .html; name the picture or the page so.")


def plot_envelope(grid: EnvelopeGrid, boundary: Boundary) -> Figure:
    """Turn rate over speed: cells by stability, and the boundary in the colour of the limit that holds it."""
    figure = Figure(figsize=(7.5, 6), layout="constrained")
    axes = figure.subplots()
    if grid.feasible.any():
        kind = np.where(grid.stable, 0.0, 1.0)
        kind[~grid.accepted] = np.nan
        axes.pcolormesh(
            grid.turn_rate_deg_s, grid.tas_kt, kind, cmap=ListedColormap([_STABLE, _UNSTABLE]), vmin=0, vmax=1
        )
        axes.set_xlim(*_margins(boundary.turn_rate_min_deg_s, boundary.turn_rate_max_deg_s))
    for colour, label in ((_STABLE, "stable"), (_UNSTABLE, "unstable, controllable")):
        axes.plot([], [], "s", color=colour, label=label)
    named = set()
    for limit, rate, speed in _pieces(boundary):
        axes.plot(rate, speed, color=LIMIT_COLOURS[limit], lw=2, label=None if limit in named else f"{limit} limit")
        named.add(limit)
    axes.set_xlabel(r"turn rate $\dot\psi$, deg/s")
    axes.set_ylabel("true airspeed $V$, kn")
    axes.set_title(_title(grid).replace(" deg", "\N{DEGREE SIGN}"))
    axes.grid(alpha=0.3)
    if grid.feasible.any():
        axes.legend(loc="upper right", fontsize="small")
    else:
        axes.text(0.5, 0.5, "no steady manoeuvre is left", transform=axes.transAxes, ha="center")
    return figure


def envelope_page(grid: EnvelopeGrid, boundary: Boundary) -> str:
    """The same as a page that shows the trim under the pointer."""
    import plotly.graph_objects as go

    data = grid.to_dataset()
    figure = go.Figure()
    for cells, colour, label in (
        (grid.feasible & grid.stable, _STABLE, "stable"),
        (grid.accepted & ~grid.stable, _UNSTABLE, "unstable, controllable"),
    ):
        speed, rate = np.nonzero(cells)
        names = ("alpha", "beta", "phi", "elevator", "aileron", "rudder", "throttle")
        values = np.column_stack([data[name].values[cells] for name in names])
        hover = "".join(
            f"<br>{name} %{{customdata[{k}]:.2f}} {data[name].attrs['units']}" for k, name in enumerate(names)
        )
        figure.add_scatter(
            x=grid.turn_rate_deg_s[rate],
            y=grid.tas_kt[speed],
            customdata=values,
            mode="markers",
            marker={"symbol": "square", "size": 6, "color": colour},
            name=label,
            hovertemplate=f"%{{y:.0f}} kn, %{{x:.0f}} deg/s{hover}<extra>{label}</extra>",
        )
    for limit, rate, speed in _pieces(boundary):
        figure.add_scatter(
            x=rate, y=speed, mode="lines", line={"color": LIMIT_COLOURS[limit], "width": 3}, name=f"{limit} limit"
        )
    named: set[str] = set()
    for trace in figure.data:
        trace.showlegend = trace.name not in named
        named.add(trace.name)
    figure.update_layout(
        title=_title(grid),
        xaxis_title="turn rate, deg/s",
        yaxis_title="true airspeed, kn",
        template="plotly_white",
    )
    return figure.to_html(include_plotlyjs=True)


def _pieces(boundary: Boundary) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """Runs of the boundary that one limit holds: its name, turn rates and speeds; each run reaches the next one."""
    sides = (
        (boundary.turn_rate_min_deg_s, boundary.limits_min),
        (boundary.turn_rate_max_deg_s, boundary.limits_max),
    )
    for rates, limits in sides:
        held = [_leading(names) for names in limits]
        start = 0
        for limit, run in groupby(held):
            end = start + len(list(run))
            if limit:
                yield limit, rates[start : end + 1], boundary.tas_kt[start : end + 1]
            start = end


def _margins(low: np.ndarray, high: np.ndarray) -> tuple[float, float]:
    """Limits of an axis that shows both curves with a little room."""
    room = 0.05 * (np.nanmax(high) - np.nanmin(low)) + 0.5
    return float(np.nanmin(low) - room), float(np.nanmax(high) + room)


def _leading(names: tuple[str, ...]) -> str | None:
    """The limit that gives a point its colour: of several, the first in the order of the colours."""
    held = {name.split(".")[0] for name in names}
    return next((limit for limit in LIMIT_COLOURS if limit in held), None)


def _title(grid: EnvelopeGrid) -> str:
    low, high = grid.limits.rudder_deg
    rudder = f"rudder jammed at {low:g} deg" if low == high else f"rudder {low:g} .. {high:g} deg"
    return f"{rudder}, {grid.altitude_ft:g} ft, flight path {grid.gamma_deg:g} deg"
