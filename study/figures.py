"""Figures of the study, drawn from its own results."""

from collections.abc import Mapping

from matplotlib.figure import Figure

from gtm_fmu.envelope import Boundary
from study.comparisons import SpeedsOverJams

LABELS = {
    "altitude_ft": "$h$",
    "gamma_deg": r"$\gamma$",
    "rudder_lower_deg": r"$\delta_{r,min}$",
    "rudder_upper_deg": r"$\delta_{r,max}$",
    "v_min_kt": "$V_{min}$",
    "v_max_kt": "$V_{max}$",
}


def plot_jams(boundaries: Mapping[float, Boundary], altitude_ft: float, gamma_deg: float) -> Figure:
    """Envelopes over turn rate for rudder jams (keys in deg), the whole one at no jam included (paper Fig. 3)."""
    figure = Figure(figsize=(7, 6), layout="constrained")
    axes = figure.subplots()
    for deflection, boundary in sorted(boundaries.items()):
        if not len(boundary.tas_kt):
            axes.plot([], [], " ", label=rf"{deflection:g}$\degree$: none left")
            continue
        turn_rate = [*boundary.turn_rate_min_deg_s, *boundary.turn_rate_max_deg_s[::-1]]
        speed = [*boundary.tas_kt, *boundary.tas_kt[::-1]]
        axes.plot([*turn_rate, turn_rate[0]], [*speed, speed[0]], label=rf"{deflection:g}$\degree$")
    axes.set_xlabel(r"turn rate $\dot\psi$, deg/s")
    axes.set_ylabel("true airspeed $V$, kn")
    axes.set_title(rf"Rudder jammed at {altitude_ft:g} ft, $\gamma$ = {gamma_deg:g}$\degree$")
    axes.grid(alpha=0.3)
    figure.legend(title="rudder", loc="outside right upper")
    return figure


def plot_speeds(cut: SpeedsOverJams) -> Figure:
    """V_min and V_max over the jammed rudder deflection, exact (line) and emulated (dashes)."""
    figure = Figure(figsize=(7, 4.5), layout="constrained")
    axes = figure.subplots()
    for end, colour, name in ((0, "tab:blue", "$V_{min}$"), (1, "tab:red", "$V_{max}$")):
        axes.plot(cut.deflections_deg, cut.exact_kt[:, end], color=colour, label=f"{name} exact")
        axes.plot(cut.deflections_deg, cut.emulated_kt[:, end], "--", color=colour, label=f"{name} emulated")
    axes.set_xlabel(r"jammed rudder $\delta_r$, deg")
    axes.set_ylabel("true airspeed, kn")
    axes.set_title(rf"{cut.altitude_ft:g} ft, $\gamma$ = {cut.gamma_deg:g}$\degree$")
    axes.grid(alpha=0.3)
    axes.legend()
    return figure
