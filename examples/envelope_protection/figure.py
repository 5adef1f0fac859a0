"""The figure of the two flights."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from examples.envelope_protection.system import JAM_S
from gtm_fmu.units import M_PER_FT, M_S_PER_KT, RAD_PER_DEG

COLOURS = {"with protection": "tab:blue", "without protection": "tab:red"}
GROUND_FT, AILERON_DEG = 12.0, 20.0


def until_ground(flight: np.ndarray) -> np.ndarray:
    """A flight as long as it is above the runway, which the model does not know."""
    low = np.flatnonzero(flight["aircraft.state.altitude"] < GROUND_FT * M_PER_FT)
    return flight[: low[0]] if len(low) else flight


def draw(flights: dict[str, np.ndarray], path: Path) -> Path:
    """Draw airspeed and envelope, aileron, bank and altitude over time into a PNG file."""
    figure = Figure(figsize=(8, 9), layout="constrained")
    axes = figure.subplots(4, 1, sharex=True, height_ratios=(2.2, 1, 1, 1))
    speed, aileron, bank, altitude = axes
    longest = max(flights.values(), key=lambda flight: len(until_ground(flight)))
    known = longest[longest["autopilot.known_v_max"] > 0]
    slow, fast = (known[f"autopilot.known_{end}"] / M_S_PER_KT for end in ("v_min", "v_max"))
    speed.fill_between(known["time"], slow, fast, color="tab:green", alpha=0.15, label="steady envelope")
    planned = longest["autopilot.tas_planned"] / M_S_PER_KT
    speed.step(longest["time"], planned, color="black", linestyle=":", label="flight plan")
    for name, whole in flights.items():
        flight, colour = until_ground(whole), COLOURS[name]
        time = flight["time"]
        speed.plot(time, flight["aircraft.air.tas"] / M_S_PER_KT, color=colour, label=name)
        aileron.plot(time, flight["aircraft.surface.aileron"] / RAD_PER_DEG, color=colour)
        bank.plot(time, flight["aircraft.state.phi"] / RAD_PER_DEG, color=colour)
        altitude.plot(time, flight["aircraft.state.altitude"] / M_PER_FT, color=colour)
        if len(flight) < len(whole):
            cross = {"color": colour, "markersize": 10, "markeredgewidth": 2}
            altitude.plot(time[-1], GROUND_FT, "x", label="hits the ground", **cross)
            altitude.legend(loc="upper left")
    aileron.axhline(-AILERON_DEG, color="grey", linestyle="--")
    aileron.text(1, -AILERON_DEG + 0.8, "end of its travel", color="grey")
    labels = ("airspeed in kn", "aileron in deg", "bank in deg", "altitude in ft")
    for axis, label in zip(axes, labels, strict=True):
        axis.set_ylabel(label)
        axis.axvline(JAM_S, color="grey", linewidth=0.8)
        axis.grid(alpha=0.3)
    speed.set_ylim(40, 185)
    speed.text(JAM_S + 1, 176, "rudder jams at 20 deg", color="grey")
    speed.legend(loc="upper right", ncols=2)
    altitude.set_xlabel("time in s")
    figure.savefig(path, dpi=110)
    return path
