"""Figures of envelopes along an axis: jams laid over each other (paper Fig. 3), volumes (paper Figs. 1 and 2)."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.colors import LinearSegmentedColormap, to_hex
from matplotlib.figure import Figure

from gtm_fmu.aircraft.inputs import CONDITION
from gtm_fmu.envelopes.family import EnvelopeFamily, Member
from gtm_study.figures import captions
from gtm_study.figures.captions import Label
from gtm_study.figures.envelopes import add_strokes, line_style, margins, strokes
from gtm_study.figures.pages import page

_SIGNED = LinearSegmentedColormap.from_list("signed", ["#74b9e8", "#0072b2", "#000000", "#d55e00", "#f0a860"])
_WALL = "#8fa3b5"
_SPEEDS = 0.5 - 0.49999 * np.cos(np.linspace(0.0, np.pi, 81))  # shares of V_min .. V_max, dense at both ends


def plot_family(family: EnvelopeFamily) -> Figure:
    """A volume over altitude or flight path; jams in one plane."""
    return _plot_volume(family) if family.axis in CONDITION else _plot_jams(family)


def family_page(family: EnvelopeFamily) -> str:
    """The same as a page: a volume to turn about, or curves."""
    return _volume_page(family) if family.axis in CONDITION else _jams_page(family)


def _plot_jams(family: EnvelopeFamily) -> Figure:
    figure = Figure(figsize=(7.2, 5.6), layout="constrained")
    axes = figure.subplots()
    for member, colour in zip(family.members, _jam_colours(family), strict=True):
        label = _member_label(family, member)
        style: dict[str, Any] = {"color": colour, "lw": 1.8, "ls": "--" if member.value < 0 else "-"}
        if not member.boundary.outlines:
            axes.plot([], [], " ", label=label)
        for k, (rate, speed) in enumerate(member.boundary.outlines):
            axes.plot(rate, speed, label=None if k else label, **style)
    axes.set_xlabel(captions.TURN_RATE.tex)
    axes.set_ylabel(captions.SPEED.tex)
    axes.set_title(_title(family).replace("; ", "\n"), fontsize="medium")
    axes.grid(alpha=0.3)
    if any(member.boundary.outlines for member in family.members):
        margins(axes, [member.boundary for member in family.members])
    figure.legend(title=f"{captions.quantity(family.axis.name).tex} jammed at", loc="outside right upper")
    return figure


def _jams_page(family: EnvelopeFamily) -> str:
    import plotly.graph_objects as go

    figure = go.Figure()
    for member, colour in zip(family.members, _jam_colours(family), strict=True):
        x: list[float | None] = []
        y: list[float | None] = []
        for rate, speed in member.boundary.outlines:
            x, y = [*x, *rate.tolist(), None], [*y, *speed.tolist(), None]
        figure.add_scatter(
            x=x or [None],
            y=y or [None],
            mode="lines",
            line={"color": colour, "width": 3, "dash": "dash" if member.value < 0 else "solid"},
            name=_member_label(family, member),
            hovertemplate="%{y:.2f} kn, %{x:.2f} deg/s",
        )
    axes = {"xaxis_title": captions.TURN_RATE.html, "yaxis_title": captions.SPEED.html}
    return page(figure, _title(family), **axes)


def _plot_volume(family: EnvelopeFamily) -> Figure:
    figure = Figure(figsize=(6.4, 4.8))
    axes: Any = figure.add_axes((-0.02, 0.03, 0.8, 0.9), projection="3d", computed_zorder=False)
    for wall in _walls(family):
        axes.plot_surface(*wall, color=_WALL, alpha=0.3, lw=0, rcount=81, ccount=81, shade=False, zorder=1)
    for member in family.members:
        for stroke in strokes(member.boundary):
            place = np.full(len(stroke.tas_kt), member.value)
            style = line_style(stroke) | {"lw": 1.3, "ms": 4}
            axes.plot(stroke.turn_rate_deg_s, stroke.tas_kt, place, label=stroke.label.tex, **style, zorder=2)
    axes.set_xlabel(r"$\dot\psi$, deg/s")
    axes.set_ylabel("$V$, kn", labelpad=8)
    axes.set_zlabel(captions.with_units(captions.symbol(family.axis.name), family.axis.units).tex, labelpad=10)
    axes.view_init(elev=24, azim=-58)
    axes.set_box_aspect((1.1, 1.2, 1.0), zoom=0.92)
    for one in (axes.xaxis, axes.yaxis, axes.zaxis):
        one.set_major_locator(_round_ticks())
    figure.suptitle(_title(family).replace("; ", "\n"), fontsize="medium")
    once = dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
    if once:
        figure.legend(
            once.values(), once.keys(), title="held by", loc="upper right", fontsize="small", title_fontsize="small"
        )
    return figure


def _round_ticks() -> Any:
    from matplotlib.ticker import MaxNLocator

    return MaxNLocator(5)


def _volume_page(family: EnvelopeFamily) -> str:
    import plotly.graph_objects as go

    figure = go.Figure()
    for rate, speed, place in _walls(family):
        figure.add_surface(
            x=rate,
            y=speed,
            z=place,
            colorscale=[[0, _WALL], [1, _WALL]],
            opacity=0.4,
            showscale=False,
            hoverinfo="skip",
        )
    add_strokes(figure.add_scatter3d, [(s, {"z": m.value}) for m in family.members for s in strokes(m.boundary)])
    scene = {
        "xaxis_title": captions.TURN_RATE.html,
        "yaxis_title": captions.SPEED.html,
        "zaxis_title": _axis_label(family).html,
        "camera": {"eye": {"x": 1.7, "y": -2.3, "z": 1.2}},
        "aspectmode": "cube",
    }
    return page(figure, _title(family), scene=scene, margin={"b": 60})


def _walls(family: EnvelopeFamily) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Surfaces of the lowest and of the highest turn rate: turn rate, speed and place (members, speeds).

    They reach from one member to the next that has an envelope.
    """
    walls = []
    with_one = [bool(member.grid.feasible.any()) for member in family.members]
    edges = np.flatnonzero(np.diff([False, *with_one, False])).tolist()
    for start, stop in zip(edges[::2], edges[1::2], strict=True):
        rows = [_sides(member.boundary.outlines) for member in family.members[start:stop]]
        speed, low, high = (np.array(column) for column in zip(*rows, strict=True))
        place = np.repeat(family.values[start:stop, None], len(_SPEEDS), axis=1)
        walls += [(low, speed, place), (high, speed, place)]
    return walls


def _sides(outlines: Sequence[tuple[np.ndarray, np.ndarray]]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Speeds from the lowest to the highest, and the lowest and highest turn rate of the outlines there."""
    ends = np.concatenate([speed for _, speed in outlines])
    speeds = ends.min() + np.ptp(ends) * _SPEEDS
    sides = np.array([[np.inf, -np.inf]] * len(speeds))
    for rate, speed in outlines:
        above = speed > speeds[:, None]
        row, k = np.nonzero(above[:, 1:] != above[:, :-1])
        at = rate[k] + (speeds[row] - speed[k]) / (speed[k + 1] - speed[k]) * (rate[k + 1] - rate[k])
        np.minimum.at(sides[:, 0], row, at)
        np.maximum.at(sides[:, 1], row, at)
    low, high = np.where(np.isfinite(sides), sides, np.nan).T
    return speeds, low, high


def _jam_colours(family: EnvelopeFamily) -> list[str]:
    """Blue for negative positions, orange for positive ones, lighter the larger."""
    values = family.values
    largest = np.abs(values).max() or 1.0
    return [to_hex(_SIGNED(0.5 + 0.5 * value / largest)) for value in values]


def _member_label(family: EnvelopeFamily, member: Member) -> str:
    text = captions.value(member.value, family.axis.units)
    return text if member.boundary.outlines else f"{text}: none left"


def _axis_label(family: EnvelopeFamily) -> Label:
    return captions.with_units(captions.quantity(family.axis.name), family.axis.units)


def _title(family: EnvelopeFamily) -> str:
    first = family.members[0].envelope
    held = {c.label: getattr(first, c.label) for c in CONDITION if c != family.axis}
    is_jammed = family.axis not in CONDITION
    failed = captions.failure(first.failure, family.axis if is_jammed else None)
    jammed = f"{family.axis.name.replace('_', ' ')} jammed" if is_jammed else ""
    parts = [part for part in (jammed, failed) if part and not (jammed and part == captions.NO_FAILURE)]
    return f"{', '.join(parts)}; {captions.condition(**held)}"
