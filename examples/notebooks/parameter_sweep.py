# %% [markdown]
# # A parameter sweep
#
# The same flight with the rudder jammed at nine deflections. The FMU is unpacked and loaded once, and flown nine
# times: that is several times as fast as nine calls that start from the file.

# %%
import fmpy
import matplotlib.pyplot as plt
import numpy as np
from fmpy.fmi2 import FMU2Slave

from fmu_src.fmus import build_fmu
from gtm_fmu import trim

path = build_fmu("aircraft-native", "build/fmu")  # with servos, delays, and a failure at its time
description = fmpy.read_model_description(path)
folder = fmpy.extract(path)
fmu = FMU2Slave(
    guid=description.guid,
    unzipDirectory=folder,
    modelIdentifier=description.coSimulation.modelIdentifier,
    instanceName="sweep",
)
fmu.instantiate()

# %% [markdown]
# `limits.rudder.lower` and `limits.rudder.upper` are what the failure leaves of the rudder from `failure.time` on;
# both equal are a jam. The flight begins in a level trim at 10 000 ft and 100 kn, and all controls stay where they
# are.

# %%
start = trim(altitude_ft=10000, tas_kt=100).start_values()
jams_deg = np.linspace(-20, 20, 9)
flights = {}
for jam in np.radians(jams_deg):
    failure = {"failure.time": 1.0, "limits.rudder.lower": jam, "limits.rudder.upper": jam}
    flights[jam] = fmpy.simulate_fmu(
        folder,
        model_description=description,
        fmu_instance=fmu,
        stop_time=2.5,
        output_interval=0.05,
        start_values=start | failure,
        output=["state.phi", "air.beta"],
    )
    fmu.reset()
fmu.freeInstance()

# %% [markdown]
# Within half a second of a jam the aircraft slips, and it rolls to the side on which the rudder stands.

# %%
figure, axes = plt.subplots(1, 2, figsize=(8, 3.5), layout="constrained")
colours = plt.cm.coolwarm(np.linspace(0, 1, len(flights)))
for (jam, flight), colour in zip(flights.items(), colours, strict=True):
    for axis, name in zip(axes, ("air.beta", "state.phi"), strict=True):
        axis.plot(flight["time"], np.degrees(flight[name]), color=colour, label=f"{np.degrees(jam):.0f}")
for axis, label in zip(axes, ("sideslip, deg", "bank, deg"), strict=True):
    axis.set(xlabel="time, s", ylabel=label)
    axis.grid(alpha=0.4)
figure.legend(*axes[1].get_legend_handles_labels(), title="jam, deg", loc="outside right upper", fontsize="small")

# %%
banks = [np.degrees(flight["state.phi"][-1]) for flight in flights.values()]
print(banks[0], banks[4], banks[-1])
assert banks == sorted(banks, reverse=True)  # a rudder to the left rolls left

# %%
import shutil

shutil.rmtree(folder)
