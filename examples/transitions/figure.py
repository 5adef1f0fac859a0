"""The figure of transitions: their way through the steady envelope, and what they need of the limits over time."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from examples.transitions.transition import Transition
from gtm_fmu.envelopes.envelope import FlightCondition
from gtm_fmu.envelopes.sections import turn_rate_interval
from gtm_fmu.files import write_whole

_COLOURS = ("#d55e00", "#0072b2", "#cc79a7", "#009e73")
_SPEEDS, _NEAR = 41, 15  # a limit is drawn when a flight comes so near, in deg or %
_PANELS = {
    "phi_deg": "bank in deg",
    "aileron_demand": "aileron in deg",
    "throttle_demand": "throttle in %",
}


def draw(legs: Mapping[str, list[Transition]], path: Path) -> Path:
    """Draw transitions, each a list of legs by its name, into a PNG file.

    The envelope is that of the last target's altitude and flight path.
    """
    figure = Figure(figsize=(11, 6), layout="constrained")
    grid = figure.add_gridspec(len(_PANELS), 2, width_ratios=(1.1, 1))
    plane = figure.add_subplot(grid[:, 0])
    panels = {name: figure.add_subplot(grid[row, 1]) for row, name in enumerate(_PANELS)}
    _draw_envelope(plane, next(iter(legs.values()))[-1])
    for (name, each), colour in zip(legs.items(), _COLOURS, strict=False):
        _draw_way(plane, name, each, colour)
        _draw_history(panels, each, colour)
    for quantity, axes in panels.items():
        axes.set_ylabel(_PANELS[quantity])
        axes.grid(alpha=0.3)
    list(panels.values())[-1].set_xlabel("time in s")
    plane.set_xlabel("true airspeed in kn")
    plane.set_ylabel("turn rate in deg/s")
    plane.grid(alpha=0.3)
    plane.plot([], [], "--", color="grey", lw=1, label="a limit")
    figure.legend(loc="outside lower center", ncols=3)
    write_whole(path, lambda draft: figure.savefig(draft, dpi=110, format="png"))
    return path


def _draw_envelope(axes: Axes, last: Transition) -> None:
    trims = last.path.trims
    altitude, _, gamma, _ = (float(column[-1]) for column in trims.asked)
    failure, bounds = trims.failures[-1], trims.bounds_deg
    whole = FlightCondition(altitude, gamma, failure, *bounds).envelope()
    if whole.v_min_kt is None or whole.v_max_kt is None:
        return
    speeds = np.linspace(whole.v_min_kt + 0.02, whole.v_max_kt - 0.02, _SPEEDS)
    sections = [turn_rate_interval(altitude, speed, gamma, failure, *bounds).intervals for speed in speeds.tolist()]
    there = [(speed, found[0][0], found[-1][1]) for speed, found in zip(speeds, sections, strict=True) if found]
    speed, low, high = np.array(there).T
    axes.fill_between(speed, low, high, color="#8fa3b5", alpha=0.35, label="steady flight is possible")


def _draw_way(axes: Axes, name: str, legs: list[Transition], colour: str) -> None:
    for k, leg in enumerate(legs):
        tas, turn_rate = leg.path.trims.asked.tas_kt, leg.path.trims.asked.turn_rate_deg_s
        axes.plot(tas, turn_rate, ":", color=colour, lw=1.2)
        axes.plot(tas[[0, -1]], turn_rate[[0, -1]], "o", color=colour, ms=4)
        answer = "yes" if legs[-1].possible else "no"
        label = f"{name}: {answer}" if k == 0 else None
        flown = leg.flight or {"tas_kt": np.array([]), "turn_rate_deg_s": np.array([])}
        axes.plot(flown["tas_kt"], flown["turn_rate_deg_s"], color=colour, lw=2, label=label)
        if not leg.possible:
            here = (leg.flight["tas_kt"][-1], leg.flight["turn_rate_deg_s"][-1]) if leg.flight else None
            here = here or leg.path.manoeuvre(leg.path.refusal or 0)[::2]
            axes.plot(*here, "x", color=colour, ms=10, mew=2.5)


def _draw_history(panels: dict[str, Axes], legs: list[Transition], colour: str) -> None:
    begin = 0.0
    for leg in legs:
        if not leg.flight:
            return
        time_s = begin + leg.flight["time_s"]
        for name, axes in panels.items():
            axes.plot(time_s, leg.flight[name], color=colour)
            for limit in leg.limits[name]:
                if np.abs(leg.flight[name] - limit).min() < _NEAR:
                    axes.axhline(limit, color="grey", linestyle="--", lw=1)
            if not leg.possible:
                axes.plot(time_s[-1], leg.flight[name][-1], "x", color=colour, ms=8, mew=2)
        begin = float(time_s[-1])
