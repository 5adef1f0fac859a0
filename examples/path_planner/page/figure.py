"""The picture of a plan and its flights for the documentation."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from examples.path_planner.page.page import Outcome
from gtm_fmu.files import write_whole

_PLAN, _FLOWN, _HEALTHY = "#0b5cad", "#c2410c", "#8a1c7c"
_KM = 1e-3


def draw(outcome: Outcome, path: Path) -> Path:
    """Plan view over terrain, and the turn rate inside what is left, into a PNG file."""
    figure = Figure(figsize=(11, 5), layout="constrained")
    plane, turn = figure.subplots(1, 2)
    scenario, plan, flown = outcome.scenario, outcome.plan, outcome.flown
    plane.plot(plan.east_m * _KM, plan.north_m * _KM, color=_PLAN, lw=4, alpha=0.5, label="planned for the failure")
    if outcome.healthy:
        track = outcome.healthy.east_m * _KM, outcome.healthy.north_m * _KM
        plane.plot(*track, "--", color=_HEALTHY, lw=1.5, label="planned for the aircraft in order")
    for review, colour, name in ((flown, _FLOWN, "flown"), (outcome.healthy_flight, _HEALTHY, "that plan, flown")):
        if review is not None:
            columns = review.flight.columns
            plane.plot(columns["east_m"] * _KM, columns["north_m"] * _KM, color=colour, lw=1.8, label=name)
            if not review.flight.is_complete:
                plane.plot(columns["east_m"][-1] * _KM, columns["north_m"][-1] * _KM, "x", color=colour, ms=9, mew=2.5)
    plane.set_aspect("equal", adjustable="datalim")
    figure.draw_without_rendering()
    north, east = (np.linspace(*limits, 120) for limits in (plane.get_ylim(), plane.get_xlim()))
    height = scenario.terrain.height(*np.meshgrid(north / _KM, east / _KM, indexing="ij"))
    if np.isfinite(height).any() and np.ptp(height[np.isfinite(height)]) > 1:
        plane.contourf(east, north, np.ma.masked_invalid(height), 9, cmap="Greys", alpha=0.45, zorder=0)
    plane.set_xlabel("east in km")
    plane.set_ylabel("north in km")
    plane.legend(loc="upper left", fontsize="small")
    if flown is not None:
        low, high = flown.turns_deg_s.T
        turn.fill_between(flown.time_s, low, high, color="#3f9b5b", alpha=0.25, label="turns that are left")
        columns = flown.flight.columns
        turn.plot(columns["time_s"], columns["turn_rate_deg_s"], color=_FLOWN, label="flown")
    if outcome.healthy:
        for k, segment in enumerate(outcome.healthy.segments):
            time, rate = (segment.start_s, segment.start_s + segment.duration_s), (segment.turn_rate_deg_s,) * 2
            turn.plot(time, rate, "--", color=_HEALTHY, label="planned for the aircraft in order" if k == 0 else None)
    turn.set_xlabel("time in s")
    turn.set_ylabel("turn rate in deg/s")
    turn.grid(alpha=0.3)
    if turn.get_legend_handles_labels()[0]:
        turn.legend(fontsize="small")
    write_whole(path, lambda draft: figure.savefig(draft, dpi=110, format="png"))
    return path
