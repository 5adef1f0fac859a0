"""What can still be flown over speed, beside the healthy aircraft: sections of turn rate and of flight path."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure

from gtm_fmu.aircraft.ranges import Range
from gtm_fmu.envelopes.performance import Performance
from gtm_fmu.envelopes.sections import Section, climb_interval, turn_rate_interval
from gtm_study import style
from gtm_study.figures import captions
from gtm_study.figures.captions import Label
from gtm_study.figures.pages import page

_SPEEDS, _INSIDE_KT = 61, 0.02
_COLOURS = {"healthy": style.SKY, "failure": style.VERMILION}
_HATCHES = {"healthy": "", "failure": "///"}
_PATH = captions.with_units(captions.quantity("gamma"), "deg")


class _Band(NamedTuple):
    """Pieces of a section over speed: corners of each, as speeds (n) and values (n)."""

    pieces: list[tuple[np.ndarray, np.ndarray]]


def plot_performance(found: Mapping[str, Performance], alpha_deg: Range, phi_deg: Range) -> Figure:
    """Turn rates at the flight path asked for, and flight paths of straight flight, over true airspeed."""
    figure = Figure(figsize=(9.0, 4.4), layout="constrained")
    panels = figure.subplots(1, 2)
    for name, each in found.items():
        for axes, band in zip(panels, _bands(each, alpha_deg, phi_deg), strict=True):
            for k, corners in enumerate(band.pieces):
                label = _name(name, each) if k == 0 else None
                axes.fill(*corners, color=_COLOURS[name], hatch=_HATCHES[name], alpha=0.45, lw=1.5, label=label)
    for axes, quantity, title in zip(panels, (captions.TURN_RATE, _PATH), _titles(found), strict=True):
        axes.set_xlabel(captions.SPEED.tex)
        axes.set_ylabel(quantity.tex)
        axes.set_title(title, fontsize="medium")
        axes.grid(alpha=0.3)
    handles, labels = panels[0].get_legend_handles_labels()
    if handles:
        figure.legend(handles, labels, loc="outside lower center", ncols=2)
    return figure


def performance_page(found: Mapping[str, Performance], alpha_deg: Range, phi_deg: Range) -> str:
    """The same as a page."""
    from plotly.subplots import make_subplots

    figure = make_subplots(rows=1, cols=2, subplot_titles=_titles(found))
    for name, each in found.items():
        for column, band in enumerate(_bands(each, alpha_deg, phi_deg), 1):
            for k, (speed, value) in enumerate(band.pieces):
                figure.add_scatter(
                    x=speed,
                    y=value,
                    fill="toself",
                    mode="lines",
                    line={"color": _COLOURS[name]},
                    name=_name(name, each),
                    legendgroup=name,
                    showlegend=column == 1 and k == 0,
                    row=1,
                    col=column,
                )
    labels: tuple[Label, Label] = captions.TURN_RATE, _PATH
    axes: dict[str, Any] = {"yaxis_title": labels[0].html, "yaxis2_title": labels[1].html}
    axes |= {"xaxis_title": captions.SPEED.html, "xaxis2_title": captions.SPEED.html}
    healthy = found["healthy"]
    return page(figure, f"What can be flown; {captions.condition(healthy.altitude_ft)}", **axes)


def _name(name: str, each: Performance) -> str:
    return captions.failure(each.failure) if name == "failure" else captions.NO_FAILURE


def _titles(found: Mapping[str, Performance]) -> tuple[str, str]:
    healthy = found["healthy"]
    turns = captions.condition(healthy.altitude_ft, healthy.gamma_deg)
    return f"turns, {turns}", f"straight flight, {captions.condition(healthy.altitude_ft)}"


def _bands(each: Performance, alpha_deg: Range, phi_deg: Range) -> tuple[_Band, _Band]:
    """Of turn rates and of flight paths in straight flight."""
    ends = [each[name].value for name in ("v_min_kt", "v_max_kt")]
    if ends[0] is None or ends[1] is None:
        return _Band([]), _Band([])
    speeds = np.linspace(ends[0] + _INSIDE_KT, ends[1] - _INSIDE_KT, _SPEEDS)
    bounds = each.failure, alpha_deg, phi_deg
    at = each.altitude_ft
    turns = [turn_rate_interval(at, speed, each.gamma_deg, *bounds) for speed in speeds.tolist()]
    paths = [climb_interval(at, speed, 0.0, *bounds) for speed in speeds.tolist()]
    return _band(speeds, turns), _band(speeds, paths)


def _band(speeds: np.ndarray, sections: list[Section]) -> _Band:
    """A polygon of each run of intervals over neighbouring speeds that overlap, one with one."""
    runs: list[list[tuple[float, float, float]]] = []
    open_runs: list[list[tuple[float, float, float]]] = []
    for speed, section in zip(speeds.tolist(), sections, strict=True):
        going_on = []
        for low, high in section.intervals:
            before = [run for run in open_runs if run[-1][1] <= high and low <= run[-1][2]]
            after = [ends for ends in section.intervals if before and ends[0] <= before[0][-1][2] >= before[0][-1][1]]
            run = before[0] if len(before) == 1 and (len(after) == 1 or len(section.intervals) == 1) else []
            if not run:
                runs.append(run)
            run.append((speed, low, high))
            going_on.append(run)
        open_runs = going_on
    return _Band([_outline(np.array(run)) for run in runs])


def _outline(run: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Corners about rows of speed, lower and upper end."""
    speed, low, high = run.T
    return np.concatenate([speed, speed[::-1], speed[:1]]), np.concatenate([low, high[::-1], low[:1]])
