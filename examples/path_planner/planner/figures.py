"""Figures of plans: paths over the terrain with what a second failure leaves, climbs compared, ground in reach."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from examples.path_planner.planner.climbs import Climb
from examples.path_planner.planner.landing import Footprint
from examples.path_planner.planner.plan import Plan
from examples.path_planner.planner.scenario import Scenario
from gtm_study.style import BLUE, DASHES, GREEN, MARKERS, PALETTE, VERMILION

_KM, _ROOM_M = 1e-3, 2500.0


def turn_case(scenario: Scenario, plans: Sequence[Plan]) -> Figure:
    """Paths seen from above, their altitude, and what the worst second failure leaves along each."""
    figure = Figure(figsize=(12, 6), layout="constrained")
    grid = figure.add_gridspec(2, 2, width_ratios=(1.1, 1))
    plane, height, margin = (figure.add_subplot(place) for place in (grid[:, 0], grid[0, 1], grid[1, 1]))
    _ground(plane, scenario, np.concatenate([p.north_m for p in plans]), np.concatenate([p.east_m for p in plans]))
    for plan, colour, dash in zip(plans, PALETTE, DASHES, strict=False):
        style: dict[str, Any] = {"color": colour, "linestyle": dash, "label": f"least in {plan.name}"}
        plane.plot(plan.east_m * _KM, plan.north_m * _KM, lw=2, **style)
        height.plot(plan.time_s, plan.altitude_ft, **style)
        after = [_worst(segment.second_failures_kt) for segment in plan.segments]
        edges = [*(segment.start_s for segment in plan.segments), plan.time_s[-1]]
        margin.stairs(after, edges, baseline=None, lw=2, **style)
        ground = scenario.terrain.height(plan.north_m, plan.east_m)
        height.fill_between(plan.time_s, ground, ground.min() - 200, color=colour, alpha=0.12, lw=0)
    plane.plot(scenario.start.east_m * _KM, scenario.start.north_m * _KM, "k^", ms=9)
    height.set(ylabel="altitude in ft", xlabel="time in s")
    margin.set(ylabel="margin after the second failure in kn", xlabel="time in s")
    margin.axhline(0, color="k", lw=0.8)
    plane.legend(loc="lower right")
    for axes in (height, margin):
        axes.grid()
    return figure


def climb_case(cases: Mapping[float, Sequence[Climb]], height_ft: float) -> Figure:
    """For each speed in kn, over the climb's angle: the least margin after the second failure, and what is short."""
    figure = Figure(figsize=(11, 4.5), layout="constrained")
    moment, whole = figure.subplots(1, 2)
    for (tas_kt, climbs), colour, marker in zip(cases.items(), (BLUE, VERMILION, GREEN), MARKERS, strict=False):
        gammas = [climb.gamma_deg for climb in climbs]
        style: dict[str, Any] = {"color": colour, "marker": marker, "linestyle": "-", "label": f"{tas_kt:g} kn"}
        moment.plot(gammas, [np.nan if c.after_kt is None else c.after_kt for c in climbs], **style)
        whole.plot(gammas, [climb.short_kt_s / 60.0 for climb in climbs], **style)
    moment.axhline(0, color="k", lw=0.8)
    moment.set(xlabel="flight-path angle in deg", ylabel="least margin after the second failure in kn")
    whole.set(
        xlabel="flight-path angle in deg",
        ylabel=f"short of the margin over {height_ft:.0f} ft in kn min",
        ylim=(0, None),
    )
    for axes in (moment, whole):
        axes.grid()
        axes.legend()
    return figure


def footprint_map(scenario: Scenario, footprint: Footprint, plan: Plan | None = None) -> Figure:
    """The ground that a glide reaches, the runways, and a path to one of them."""
    figure = Figure(figsize=(8, 7.5), layout="constrained")
    axes = figure.subplots()
    places = [(reach.runway.north_m, reach.runway.east_m) for reach in footprint.runways]
    north, east = (
        np.append(ends, [p[k] for p in places]) for k, ends in enumerate((footprint.north_m, footprint.east_m))
    )
    _ground(axes, scenario, north, east)
    outline = np.append(footprint.east_m, footprint.east_m[0]), np.append(footprint.north_m, footprint.north_m[0])
    axes.fill(*(line * _KM for line in outline), color=BLUE, alpha=0.15, lw=0)
    axes.plot(*(line * _KM for line in outline), color=BLUE, linestyle="-", label="in reach of a glide")
    if plan is not None:
        axes.plot(plan.east_m * _KM, plan.north_m * _KM, color=VERMILION, linestyle="--", lw=2, label=plan.name)
    for reach in footprint.runways:
        runway, heading = reach.runway, np.radians(reach.runway.heading_deg)
        ahead = np.array([0.0, 900.0])
        line = (runway.east_m + ahead * np.sin(heading)) * _KM, (runway.north_m + ahead * np.cos(heading)) * _KM
        axes.plot(*line, color="k", linestyle="-", lw=5, solid_capstyle="butt")
        told = f"{reach.excess_ft:+.0f} ft" if np.isfinite(reach.excess_ft) else "behind the ground"
        axes.annotate(f"{runway.name}: {told}", (line[0][0], line[1][0]), (6, -14), textcoords="offset points")
    axes.plot(scenario.start.east_m * _KM, scenario.start.north_m * _KM, "k^", ms=9)
    axes.legend(loc="upper right")
    return figure


def _ground(axes: Any, scenario: Scenario, north_m: np.ndarray, east_m: np.ndarray) -> None:
    ground = scenario.terrain
    span = [
        (max(each.min() - _ROOM_M, axis[0]), min(each.max() + _ROOM_M, axis[-1]))
        for each, axis in ((north_m, ground.north_m), (east_m, ground.east_m))
    ]
    axis_n, axis_e = (np.linspace(*ends, 160) for ends in span)
    heights = ground.height(*np.meshgrid(axis_n, axis_e, indexing="ij"))
    if np.ptp(heights) > 1.0:
        filled = axes.contourf(axis_e * _KM, axis_n * _KM, heights, 12, cmap="Greys", alpha=0.75)
        axes.figure.colorbar(filled, ax=axes, label="ground in ft", shrink=0.7)
    axes.set(xlabel="east in km", ylabel="north in km", aspect="equal")


def _worst(left: Mapping[str, float | None]) -> float:
    values = list(left.values())
    return np.nan if not values or None in values else min(v for v in values if v is not None)
