"""Figures of the study, drawn from its own results."""

from matplotlib.figure import Figure

from gtm_study import style
from gtm_study.paper.comparisons import SpeedsOverJams

LABELS = {
    "altitude_ft": "$h$",
    "gamma_deg": r"$\gamma$",
    "rudder_lower_deg": r"$\delta_{r,min}$",
    "rudder_upper_deg": r"$\delta_{r,max}$",
    **{
        f"{control}_{side}_{unit}": rf"$\delta_{{{letter},{end}}}$"
        for control, letter, unit in (("elevator", "e", "deg"), ("aileron", "a", "deg"), ("throttle", "th", "pct"))
        for side, end in (("lower", "min"), ("upper", "max"))
    },
    "damage_case": "damage",
    "engine_out": "engine out",
    "has_envelope": "there is an envelope",
    "width_kt": "$V_{max} - V_{min}$",
    "v_min_kt": "$V_{min}$",
    "v_max_kt": "$V_{max}$",
}


def plot_speeds(cut: SpeedsOverJams) -> Figure:
    """V_min and V_max over the jammed rudder deflection, exact (line) and emulated (dashes)."""
    figure = Figure(figsize=(7, 4.5), layout="constrained")
    axes = figure.subplots()
    for end, colour, name in ((0, style.BLUE, "$V_{min}$"), (1, style.ORANGE, "$V_{max}$")):
        axes.plot(cut.deflections_deg, cut.exact_kt[:, end], "-", color=colour, label=f"{name} exact")
        axes.plot(cut.deflections_deg, cut.emulated_kt[:, end], "--", color=colour, label=f"{name} emulated")
    axes.set_xlabel(r"jammed rudder $\delta_r$, deg")
    axes.set_ylabel("true airspeed, kn")
    axes.set_title(rf"{cut.altitude_ft:g} ft, $\gamma$ = {cut.gamma_deg:g}$\degree$")
    axes.grid(alpha=0.3)
    axes.legend()
    return figure
