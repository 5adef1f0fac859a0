# %% [markdown]
# # Fly an FMU
#
# Load the aircraft's FMU in plain FMPy, start it in a trim, move the elevator, and look at the motion that follows.

# %%
import fmpy
import matplotlib.pyplot as plt
import numpy as np

from fmu_src.fmus import build_fmu
from gtm_fmu import trim

fmu = build_fmu("dynamics-native", "build/fmu")  # compiled C, a few seconds

# %% [markdown]
# What is in it? The model description names inputs, outputs and units.

# %%
description = fmpy.read_model_description(fmu)
for variable in description.modelVariables:
    if variable.causality == "input":
        print(variable.name, variable.start, variable.unit)

# %% [markdown]
# A flight begins in a trim: level, 10 000 ft, 100 kn. `start_values` has its states and controls by the names and
# in the units of the FMU, which are SI.

# %%
steady = trim(altitude_ft=10000, tas_kt=100)
start = steady.start_values()
print(steady.alpha_deg, steady.throttle_pct)  # 3.98 47.1: deg and %

# %% [markdown]
# The pilot pulls for half a second and pushes for another half: a doublet of 2 deg of elevator. FMPy takes inputs
# as a structured array over time.

# %%
pulse = np.radians(2.0)
times = [0.0, 1.0, 1.0, 1.5, 1.5, 2.0, 2.0, 60.0]
changes = [0.0, 0.0, -pulse, -pulse, pulse, pulse, 0.0, 0.0]
controls = [name for name in start if name.startswith("control.")]
commands = np.zeros(len(times), dtype=[("time", float), *((name, float) for name in controls)])
commands["time"] = times
for name in controls:
    commands[name] = start[name]
commands["control.elevator"] += changes
flight = fmpy.simulate_fmu(
    fmu,
    stop_time=60,
    output_interval=0.05,
    start_values=start,
    input=commands,
    output=["air.tas", "air.alpha", "path.gamma"],
)

# %% [markdown]
# The angle of attack swings back within two seconds: that is the short period. Speed and flight path exchange
# energy for much longer: the phugoid.

# %%
figure, axes = plt.subplots(3, 1, sharex=True, figsize=(7, 6), layout="constrained")
shown = {
    "air.alpha": (np.degrees, "angle of attack, deg"),
    "air.tas": (lambda speed: speed / 0.3048 * 0.592487, "true airspeed, kn"),
    "path.gamma": (np.degrees, "flight path, deg"),
}
for axis, (name, (convert, label)) in zip(axes, shown.items(), strict=True):
    axis.plot(flight["time"], convert(flight[name]))
    axis.set_ylabel(label)
    axis.grid(alpha=0.4)
axes[-1].set_xlabel("time, s")

# %% [markdown]
# How long is a phugoid? The time between the first two peaks of the flight path, and what the linear model says.

# %%
from gtm_fmu import linearize

path, time = flight["path.gamma"], flight["time"]
peaks = [k for k in range(1, len(path) - 1) if path[k - 1] < path[k] >= path[k + 1] and time[k] > 4]
print(time[peaks[1]] - time[peaks[0]])  # 27.1: s, flown
slow = min((value for value in linearize(steady).eigenvalues if value.imag > 0.05), key=lambda value: value.imag)
print(2 * np.pi / slow.imag)  # 27.4: s, by the linear model
