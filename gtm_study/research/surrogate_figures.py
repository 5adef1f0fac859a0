"""Figures of the surrogates: the surface of least thrust, V_max across a fold, errors by the number of searches."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from gtm_fmu.datasets.off_lattice import DEVIATIONS
from gtm_fmu.envelopes.envelope import FlightCondition
from gtm_fmu.envelopes.feasibility import FULL_THROTTLE_PCT
from gtm_fmu.envelopes.thrust_map import MapEnvelopes, ThrustMap
from gtm_fmu.envelopes.thrust_survey import gross_thrust_lbf, thrust_curve
from gtm_fmu.progress import Advance
from gtm_study import style
from surrogate.rudder.emulator import RudderEmulator
from surrogate.rudder.names import PAPER

SEVERAL_GOAL_KT = 2.0
"""At 95 %, of limits of several controls."""
GOAL_MSE = 2.5e-5
JAMS_DEG = (0.0, 12.0, 18.0, 24.0)
ALTITUDES_FT = (0.0, 10000.0, 20000.0, 30000.0)
SURFACE_SPEEDS = 40
FOLD = (28398.0, 2.1)
"""Altitude in ft and jam in deg where V_max jumps from 128 to 113 kn as the flight path steepens."""
FOLD_GAMMAS_DEG = tuple(np.arange(1.0, 3.3001, 0.05).tolist())


def plot_surface(advance: Advance) -> Figure:
    """Least gross thrust over equivalent airspeed at four altitudes, level flight: they fall on one curve a jam."""
    figure = Figure(figsize=(7.5, 5.0), layout="constrained")
    axes = figure.add_subplot()
    markers = dict(zip(ALTITUDES_FT, "ox+.", strict=True))
    for k, deflection in enumerate(JAMS_DEG):
        for altitude, marker in markers.items():
            slowest, fastest, *thrust = thrust_curve("rudder", altitude, 0.0, deflection, SURFACE_SPEEDS)
            speed = slowest + (fastest - slowest) * np.linspace(0, 1, SURFACE_SPEEDS) ** 2
            axes.plot(speed, thrust, marker, color=style.PALETTE[k], markersize=4, fillstyle="none")
        drawn: Any = {"color": style.PALETTE[k], "linestyle": style.DASHES[k]}
        axes.plot(speed, thrust, linewidth=0.9, label=f"{deflection:g} deg", **drawn)
        advance(k + 1, len(JAMS_DEG))
    for altitude, marker in markers.items():
        available = gross_thrust_lbf(FULL_THROTTLE_PCT, altitude)
        axes.axhline(available, color="grey", linewidth=0.8, linestyle="--")
        label = axes.annotate(
            f"full thrust at {altitude:g} ft ({marker})", (198, available + 0.4), ha="right", fontsize=8
        )
        label.set_bbox({"facecolor": "white", "edgecolor": "none", "pad": 1})
    axes.set(xlim=(52, 200), ylim=(5, 34), xlabel="Equivalent airspeed, kn", ylabel="Least gross thrust, lbf")
    axes.legend(title="Rudder jam")
    return figure


@dataclass(frozen=True)
class FoldCut:
    """Exact and predicted V_max in kn over flight-path angles in deg across a fold."""

    gammas_deg: np.ndarray
    exact_kt: np.ndarray
    mapped: MapEnvelopes
    network_kt: np.ndarray


def fold_cut(advance: Advance) -> FoldCut:
    """V_max at `FOLD` by the exact solver, the thrust map and the paper's networks."""
    altitude_ft, jam = FOLD
    emulator, exact, network = RudderEmulator.load(PAPER), [], []
    for k, gamma_deg in enumerate(FOLD_GAMMAS_DEG):
        exact.append(FlightCondition(altitude_ft, gamma_deg).envelope((jam, jam)).v_max_kt)
        network.append(emulator.predict_one(altitude_ft, gamma_deg, (jam, jam))["v_max_kt"])
        advance(k + 1, len(FOLD_GAMMAS_DEG))
    gammas = np.array(FOLD_GAMMAS_DEG)
    cases = np.column_stack([np.full(gammas.size, altitude_ft), gammas, np.full((gammas.size, 2), jam)])
    return FoldCut(
        gammas, np.array(exact, dtype=float), ThrustMap.load().predict(cases), np.array(network, dtype=float)
    )


def plot_fold(cut: FoldCut) -> Figure:
    """The exact V_max, and what the models make of its jump."""
    figure = Figure(figsize=(7.5, 4.5), layout="constrained")
    axes = figure.add_subplot()
    mapped = cut.mapped
    axes.plot(
        cut.gammas_deg, cut.network_kt, color=style.ORANGE, linestyle="--", label="the paper's networks, on the lattice"
    )
    axes.errorbar(
        cut.gammas_deg,
        mapped.v_max_kt,
        DEVIATIONS * mapped.v_max_std_kt,
        color=style.BLUE,
        linestyle="-",
        label="thrust map, 95 %",
        capsize=2,
    )
    axes.plot(cut.gammas_deg, cut.exact_kt, "k.", label="exact")
    axes.plot(
        cut.gammas_deg[mapped.fold],
        mapped.v_max_kt[mapped.fold],
        "s",
        color=style.VERMILION,
        fillstyle="none",
        label="flagged",
    )
    axes.set(
        xlabel=r"$\gamma$, deg", ylabel=r"$V_{max}$, kn", title=f"{FOLD[0]:g} ft, rudder jammed at {FOLD[1]:g} deg"
    )
    axes.legend()
    return figure


def plot_errors(results: Mapping[str, Any]) -> Figure:
    """Mean square error off the lattice by the number of searches that a model was given."""
    figure = Figure(figsize=(7.5, 5.5), layout="constrained")
    axes = figure.add_subplot()
    for k, (name, points) in enumerate(results.get("curves", {}).items()):
        label = name if "thrust" in name else f"Gaussian process, {name}"
        axes.loglog(*_curve(points), f"{style.MARKERS[k]}-", markersize=4, color=style.PALETTE[k], label=label)
    models = results.get("models", {})
    for name, marker in (("thrusts", "s"), ("lattice", "x")):
        points = [model for key, model in models.items() if key.endswith(name) and key.startswith("Gaussian")]
        if points:
            label = "Gaussian process, thrusts by chance" if name == "thrusts" else "Gaussian process, paper's lattice"
            axes.loglog(*_curve(points), marker, color="k", fillstyle="none", label=label)
    if network := models.get("BR network 4-10-2, lattice"):
        axes.loglog(*_curve([network]), "*", color=style.VERMILION, markersize=9, label="BR 4-10-2, paper's lattice")
    axes.axhline(GOAL_MSE, color="grey", linestyle="--", linewidth=0.8)
    axes.annotate("goal", (0.01, GOAL_MSE * 1.1), xycoords=axes.get_yaxis_transform(), fontsize=8)
    axes.set(
        xlabel=r"Searches ($V_{min}$, $V_{max}$, $t_{min}$ of a case, or one thrust)",
        ylabel="Mean square error, 0..1 scale",
    )
    axes.legend(fontsize=8)
    axes.grid(alpha=0.3, which="both")
    return figure


def plot_trims(results: Mapping[str, Any]) -> Figure:
    """Errors at 95 % of the trim map by the number of its trims, and of what was learnt from cases."""
    figure = Figure(figsize=(7.5, 4.5), layout="constrained")
    axes = figure.add_subplot()
    others = results.get("other failures", {})
    for k, (failure, points) in enumerate(results["trim map"].items()):
        ordered = sorted(points, key=lambda point: point["trims"])
        trims, errors = ([point[name] for point in ordered] for name in ("trims", "percentile_95_kt"))
        axes.loglog(trims, errors, f"{style.MARKERS[k]}-", color=style.PALETTE[k], label=f"trim map: {failure}")
        learnt = [model["percentile_95_kt"] for model in others.get(failure, {}).values() if "searches" in model]
        if learnt:
            label = f"best of those learnt from 512 cases: {failure}"
            dashes: Any = style.DASHES[k + 1]
            axes.axhline(min(learnt), color=style.PALETTE[k], linestyle=dashes, linewidth=1, label=label)
    axes.axhline(SEVERAL_GOAL_KT, color="grey", linestyle=":", linewidth=1, label="goal")
    axes.set(xlabel="Trims of the map", ylabel="95 % of the errors below, kn")
    axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.yaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.legend(fontsize=8)
    axes.grid(alpha=0.3, which="both")
    return figure


def _curve(points: list[Mapping[str, Any]]) -> tuple[list[float], list[float]]:
    ordered = sorted(points, key=lambda point: point["searches"])
    return [point["searches"] for point in ordered], [point["all"]["mse"] for point in ordered]
