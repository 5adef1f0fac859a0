"""V_max over altitude and flight path with a jammed rudder (paper Fig. 34)."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from gtm_fmu.datasets.paper import ALTITUDE_FT, GAMMA_DEG
from gtm_fmu.envelopes.envelope import FlightCondition
from gtm_fmu.progress import Advance
from gtm_study.figures import captions

JAM_DEG = 15.0


@dataclass(frozen=True)
class PathSurface:
    """Exact V_max (altitudes, gammas) in kn; NaN where there is no envelope."""

    altitudes_ft: np.ndarray
    gammas_deg: np.ndarray
    v_max_kt: np.ndarray


def path_surface(levels: tuple[int, int], advance: Advance) -> PathSurface:
    """V_max at so many levels of altitude and of flight path, evenly over the paper's ranges."""
    altitudes, gammas = (np.linspace(*ends, n) for ends, n in zip((ALTITUDE_FT, GAMMA_DEG), levels, strict=True))
    found = np.full(levels, np.nan)
    for i, altitude_ft in enumerate(altitudes.tolist()):
        for j, gamma_deg in enumerate(gammas.tolist()):
            v_max = FlightCondition(altitude_ft, gamma_deg).envelope((JAM_DEG, JAM_DEG)).v_max_kt
            found[i, j] = np.nan if v_max is None else v_max
        advance(i + 1, len(altitudes))
    return PathSurface(altitudes, gammas, found)


def summary(surface: PathSurface) -> dict[str, Any]:
    """What the surface says, ready for JSON.

    How much V_max falls over the flight paths at the lowest and at the highest altitude that has an envelope at all of
    them, and the largest fall between neighbouring levels, where V_max jumps.
    """
    v_max = surface.v_max_kt
    whole = np.flatnonzero(np.isfinite(v_max).all(axis=1))
    falls = {"along gamma": -np.diff(v_max, axis=1), "along altitude": -np.diff(v_max, axis=0)}
    return {
        "without_envelope": int(np.isnan(v_max).sum()),
        "points": int(v_max.size),
        "rises_with_gamma": int((np.diff(v_max, axis=1) > 0.0).sum()),
        "fall_over_gamma_kt": {
            f"{surface.altitudes_ft[k]:g}": float(v_max[k, 0] - v_max[k, -1]) for k in whole[[0, -1]]
        }
        if len(whole)
        else {},
        "largest_step_kt": {name: float(np.nanmax(fall)) for name, fall in falls.items()},
        "median_step_kt": {name: float(np.nanmedian(fall)) for name, fall in falls.items()},
    }


def plot_path_surface(surface: PathSurface) -> Figure:
    """The surface over both axes."""
    figure = Figure(figsize=(6.6, 4.8))
    axes: Any = figure.add_axes((0.02, 0.04, 0.82, 0.88), projection="3d")
    gamma, altitude = np.meshgrid(surface.gammas_deg, surface.altitudes_ft)
    axes.plot_surface(gamma, altitude / 1000.0, surface.v_max_kt, cmap="cividis", rcount=61, ccount=61)
    axes.set_xlabel(captions.with_units(captions.symbol("gamma"), "deg").tex)
    axes.set_ylabel("$h$, 1000 ft")
    axes.set_zlabel(captions.V_MAX.tex, labelpad=8)
    axes.view_init(elev=28, azim=-60)
    figure.suptitle(f"highest speed with the rudder jammed at {captions.value(JAM_DEG, 'deg')}", fontsize="medium")
    return figure
