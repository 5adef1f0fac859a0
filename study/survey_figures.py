"""Figures of surveys: the envelope's volume, V_max over rudder limits, and where an envelope exists."""

import numpy as np
from matplotlib.figure import Figure

from gtm_fmu.envelope import Boundary
from study.emulator import FULL_THROTTLE_PCT
from study.surveys import FeasibilityMap, LimitSurface, Volume


def plot_volume(volume: Volume) -> Figure:
    """Boundaries over turn rate and speed, stacked by flight-path angle (paper Figs. 1 and 2)."""
    figure = Figure(figsize=(7.5, 6.5), layout="constrained")
    axes = figure.add_subplot(projection="3d")
    for gamma_deg, boundary in zip(volume.gammas_deg, volume.boundaries, strict=True):
        rate, speed = _closed(boundary)
        if rate.size:
            colour = _colour(gamma_deg, volume)
            axes.plot(rate, speed, np.full(rate.size, gamma_deg), color=colour)
            axes.add_collection3d(_sheet(rate, speed, colour), zs=gamma_deg, zdir="z")
    axes.set_xlabel(r"$\dot\psi$, deg/s")
    axes.set_ylabel("$V$, kn")
    axes.set_zlabel(r"$\gamma$, deg")
    axes.set_title(_title(volume))
    return figure


def volume_page(volume: Volume) -> str:
    """The same as a page to turn about."""
    import plotly.graph_objects as go

    figure = go.Figure()
    for gamma_deg, boundary in zip(volume.gammas_deg, volume.boundaries, strict=True):
        rate, speed = _closed(boundary)
        figure.add_scatter3d(
            x=rate,
            y=speed,
            z=np.full(rate.size, gamma_deg),
            mode="lines",
            line={"width": 5},
            surfaceaxis=2,
            opacity=0.6,
            name=f"{gamma_deg:g} deg",
            hovertemplate="%{y:.1f} kn, %{x:.2f} deg/s<extra>flight path %{z:g} deg</extra>",
        )
    scene = {"xaxis_title": "turn rate, deg/s", "yaxis_title": "true airspeed, kn", "zaxis_title": "flight path, deg"}
    figure.update_layout(title=_title(volume), scene=scene, legend_title="flight path")
    return figure.to_html(include_plotlyjs=True)


def plot_limit_surface(surface: LimitSurface) -> Figure:
    """V_max over both rudder limits, with the jams along its edge (paper Fig. 33)."""
    figure = Figure(figsize=(7.5, 6), layout="constrained")
    axes = figure.add_subplot(projection="3d")
    upper, lower = np.meshgrid(surface.limits_deg, surface.limits_deg)
    axes.plot_surface(lower, upper, surface.v_max_kt, cmap="viridis", alpha=0.85, rcount=61, ccount=61)
    jams = np.diag(surface.v_max_kt)
    axes.plot(surface.limits_deg, surface.limits_deg, jams, color="red", lw=3, label="jams")
    axes.set_xlabel(r"$\delta_{r,min}$, deg")
    axes.set_ylabel(r"$\delta_{r,max}$, deg")
    axes.set_zlabel("$V_{max}$, kn")
    axes.set_title(f"{surface.altitude_ft:g} ft, flight path {surface.gamma_deg:g}\N{DEGREE SIGN}")
    axes.legend()
    return figure


def plot_feasibility(found: FeasibilityMap) -> Figure:
    """Largest jam of either sign that leaves an envelope, over altitude and flight-path angle."""
    figure = Figure(figsize=(10, 4.2), layout="constrained")
    jams = np.asarray(found.jams_deg)
    feasible = found.t_min_pct <= FULL_THROTTLE_PCT
    panels = figure.subplots(1, 2, sharey=True)
    for axes, sign, name in zip(panels, (-1, 1), ("negative", "positive"), strict=True):
        size = np.where(feasible & (sign * jams >= 0), sign * jams, -1.0).max(axis=2)
        drawn = axes.pcolormesh(found.gammas_deg, found.altitudes_ft, np.ma.masked_less(size, 0), vmin=0, vmax=30)
        axes.set_xlabel(r"flight-path angle $\gamma$, deg")
        axes.set_title(f"{name} jams")
        axes.set_facecolor("0.85")
    panels[0].set_ylabel("altitude, ft")
    figure.colorbar(drawn, ax=panels, label="largest jam with an envelope, deg (grey: none)")
    return figure


def _closed(boundary: Boundary) -> tuple[np.ndarray, np.ndarray]:
    """Turn rate and speed once around a boundary."""
    rate = np.concatenate([boundary.turn_rate_min_deg_s, boundary.turn_rate_max_deg_s[::-1]])
    speed = np.concatenate([boundary.tas_kt, boundary.tas_kt[::-1]])
    return np.append(rate, rate[:1]), np.append(speed, speed[:1])


def _sheet(rate: np.ndarray, speed: np.ndarray, colour):
    from matplotlib.collections import PolyCollection

    return PolyCollection([np.column_stack([rate, speed])], facecolors=[colour], alpha=0.25)


def _colour(gamma_deg: float, volume: Volume):
    from matplotlib import colormaps

    low, high = min(volume.gammas_deg), max(volume.gammas_deg)
    return colormaps["viridis"]((gamma_deg - low) / (high - low))


def _title(volume: Volume) -> str:
    low, high = volume.rudder_deg
    rudder = f"jammed at {low:g}" if low == high else f"{low:g} .. {high:g}"
    return f"rudder {rudder}\N{DEGREE SIGN}, {volume.altitude_ft:g} ft"
