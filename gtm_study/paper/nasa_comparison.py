"""Level trims and longitudinal modes beside the plots that NASA publishes with GTM_DesignSim.

python -m gtm_study.paper.nasa_comparison docs/images/nasa_trims_modes.png
"""

import argparse
import sys
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from gtm_fmu.errors import InputError
from gtm_fmu.files import check_writable
from gtm_fmu.trims import linearization, steady
from gtm_fmu.trims.manoeuvre import Trim
from gtm_study.files import save_figure
from gtm_study.style import figure_style

READINGS = Path(str(files("gtm_study.paper") / "data" / "nasa_plots"))
"""Folder of the values read off NASA's plots, and how well they are read."""
ALTITUDE_FT = 800.0
ALPHA_DEG = (-5.0, 30.0)
"""Wider than the study's bounds: NASA's trims go into the stall, up to 28 deg."""
_SIDE_DEG = 1e-6  # the published trims sit on breakpoints of alpha, where a slope has two sides


def trim_at_eas(eas_kt: float) -> Trim:
    """Level trim without sideslip at 800 ft, at an equivalent airspeed in kn."""
    return steady.trim(ALTITUDE_FT, eas_kt=eas_kt, alpha_deg=ALPHA_DEG)


def trim_at_alpha(alpha_deg: float) -> Trim:
    """Level trim without sideslip at 800 ft, at an angle of attack in deg."""
    return steady.trim(ALTITUDE_FT, angle_of_attack_deg=alpha_deg, alpha_deg=ALPHA_DEG)


def modes(alpha_deg: float) -> list[list[linearization.Mode]]:
    """Phugoid and short period just below and just above an angle of attack."""
    sides = (alpha_deg - _SIDE_DEG, alpha_deg + _SIDE_DEG)
    return [linearization.linearize(trim_at_alpha(side)).longitudinal_modes() for side in sides]


def readings(name: str) -> np.ndarray:
    """A table of `READINGS`."""
    return np.asarray(np.genfromtxt(READINGS / f"{name}.csv", delimiter=",", names=True))


def differences() -> dict[str, Any]:
    """Largest differences of this model's level trims and modes from NASA's readings, ready for JSON."""
    off: dict[str, list[float]] = {"elevator_deg": [], "throttle_pct": [], "eas_kt": []}
    trims, modal = readings("level_trim_vs_alpha"), readings("longitudinal_modes_vs_alpha")
    for row in trims:
        found = trim_at_alpha(float(row["alpha_deg"]))
        for name, values in off.items():
            values.append(abs(getattr(found, name) - float(row[name])))
    columns = {"phugoid_hz": 0, "sp_hz": 1}
    for row in modal:
        sides = modes(float(row["alpha_deg"]))
        for name, k in columns.items():
            nearest = min(abs(side[k].frequency_hz - float(row[name])) for side in sides)
            off.setdefault(name, []).append(nearest)
    largest = {name: float(np.nanmax(values)) for name, values in off.items()}
    return {"trims": len(trims), "modes": len(modal), "largest_difference": largest}


def plot_comparison() -> Figure:
    """NASA's readings (markers) on this model's curves."""
    by_alpha, by_mode = readings("level_trim_vs_alpha"), readings("longitudinal_modes_vs_alpha")
    figure = Figure(figsize=(10, 7), layout="constrained")
    panels = figure.subplots(2, 2)
    speeds = np.linspace(45.0, 135.0, 160)
    trims = [trim_at_eas(eas) for eas in speeds.tolist()]
    alphas = np.array([trim.alpha_deg for trim in trims])
    for axes, column, values, label in (
        (panels[0, 0], "eas_kt", speeds, "equivalent airspeed, kn"),
        (panels[0, 1], "elevator_deg", [trim.elevator_deg for trim in trims], "elevator, deg"),
        (panels[1, 0], "throttle_pct", [trim.throttle_pct for trim in trims], "throttle, %"),
    ):
        shown = by_alpha["alpha_deg"] <= alphas.max()
        axes.plot(alphas, values, label="this model")
        axes.plot(by_alpha["alpha_deg"][shown], by_alpha[column][shown], "o", mfc="none", label="NASA")
        axes.set_ylabel(label)
    shown = by_mode["alpha_deg"] <= 10.0
    inner = np.arange(2.1, 10.0, 0.1)
    found = [linearization.linearize(trim_at_alpha(alpha)).longitudinal_modes() for alpha in inner.tolist()]
    for k, column, name in ((0, "phugoid_hz", "phugoid"), (1, "sp_hz", "short period")):
        (line,) = panels[1, 1].plot(inner, [pair[k].frequency_hz for pair in found], "o^"[k], ms=3, label=name)
        panels[1, 1].plot(
            by_mode["alpha_deg"][shown], by_mode[column][shown], "o^"[k], ms=7, mfc="none", color=line.get_color()
        )
    panels[1, 1].set_yscale("log")
    panels[1, 1].set_ylabel("frequency, Hz (large: NASA)")
    for axes in panels.flat:
        axes.set_xlabel(r"angle of attack $\alpha$, deg")
        axes.grid(alpha=0.3)
        axes.legend()
    return figure


def main() -> int:
    """Draw the figure; 2 where the picture cannot be written."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("picture", type=Path, help="the .png to write")
    arguments = parser.parse_args()
    try:
        if arguments.picture.suffix != ".png":
            raise InputError(f"{arguments.picture} does not end in .png; name the picture so.")
        check_writable(arguments.picture)
        with figure_style():
            save_figure(plot_comparison(), arguments.picture)
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
