# %% [markdown]
# # Ask the envelope while flying
#
# Two FMUs side by side, stepped by hand in plain FMPy: the aircraft, and the thrust map that tells its envelope.
# The rudder jams at 15 deg. A small controller keeps height and wings, and slows down; once a second it asks how
# slow it may fly, and does not go below V_min + 8 kn.

# %%
from math import radians

import fmpy
import matplotlib.pyplot as plt
import numpy as np
from fmpy.fmi2 import FMU2Slave

from fmu_src.fmus import build_fmu
from gtm_fmu import trim

KN = 0.3048 / 0.592487  # m/s


class Fmu:
    """An FMU for co-simulation whose variables go by their names."""

    def __init__(self, path, start):
        """Load it, with start values."""
        description = fmpy.read_model_description(path)
        self.references = {variable.name: variable.valueReference for variable in description.modelVariables}
        self.slave = FMU2Slave(
            guid=description.guid,
            unzipDirectory=fmpy.extract(path),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=description.modelName,
        )
        self.slave.instantiate()
        self.slave.setupExperiment()
        self.slave.enterInitializationMode()
        self.set(**start)
        self.slave.exitInitializationMode()

    def set(self, **values):
        """Real values by name."""
        self.slave.setReal([self.references[name] for name in values], list(values.values()))

    def get(self, *names):
        """Real values by name."""
        return self.slave.getReal([self.references[name] for name in names])


# %% [markdown]
# The aircraft starts in a level trim at 10 000 ft and 100 kn. From 5 s on its rudder is jammed.

# %%
steady = trim(altitude_ft=10000, tas_kt=100)
jam = {"limits.rudder.lower": radians(15), "limits.rudder.upper": radians(15), "failure.time": 5.0}
aircraft = Fmu(build_fmu("aircraft-native", "build/fmu"), steady.start_values() | jam)
envelope = Fmu(build_fmu("surrogate-native", "build/fmu"), {})

# %% [markdown]
# The controller: the throttle holds the speed, the elevator the height by way of the climb, the ailerons the bank
# that keeps the heading. Gains are chosen by hand. The FMU tells what is left of the rudder as
# `authority.rudder.*`, and these two numbers go to the envelope.

# %%
step = 0.05
controls = {name: steady.start_values()[f"control.{name}"] for name in ("elevator", "aileron", "throttle")}
sums = dict.fromkeys(controls, 0.0)
gains = {"throttle": (0.05, 0.005), "elevator": (-0.3, -0.6), "aileron": (-0.12, -0.3)}  # of the error, of its integral
least = {"throttle": 0.0, "elevator": radians(-30), "aileron": radians(-20)}
most = {"throttle": 1.0, "elevator": radians(20), "aileron": radians(20)}
wanted, slowest, asked_at, log = 100 * KN, 0.0, 0.0, []
measured = ("air.tas", "state.altitude", "path.gamma", "state.phi", "state.p", "state.q", "path.track", "air.beta")
for count in range(int(70 / step)):
    time = count * step
    tas, altitude, gamma, phi, p, q, track, beta = aircraft.get(*measured)
    if time >= asked_at:
        lower, upper = aircraft.get("authority.rudder.lower", "authority.rudder.upper")
        envelope.set(**{"altitude": altitude, "gamma": 0.0, "rudder.lower": lower, "rudder.upper": upper, "tas": tas})
        envelope.slave.doStep(currentCommunicationPoint=time, communicationStepSize=1.0)
        slowest, fastest = envelope.get("v_min", "v_max")
        asked_at += 1.0
    wanted = max(wanted - 0.5 * KN * step, slowest + 8 * KN)  # slower and slower, as long as that is safe
    climb = np.clip(0.01 * (3048.0 - altitude), -0.05, 0.05)
    turn = (track + np.pi) % (2 * np.pi) - np.pi  # the heading was north
    errors = {
        "throttle": (wanted - tas) / KN,
        "elevator": np.clip(0.8 * (climb - gamma), -0.15, 0.15) - q,
        "aileron": np.clip(np.clip(-0.8 * turn, -0.3, 0.3) + 1.9 * beta - phi, -0.3, 0.3) - p,
    }
    commands = {}
    for name, error in errors.items():
        now, later = gains[name]
        command = controls[name] + now * error + sums[name]
        if least[name] < command < most[name]:
            sums[name] += later * error * step
        commands[f"control.{name}"] = float(np.clip(command, least[name], most[name]))
    aircraft.set(**commands)
    log.append((time, tas / KN, wanted / KN, slowest / KN, np.degrees(phi), altitude / 0.3048))
    aircraft.slave.doStep(currentCommunicationPoint=time, communicationStepSize=step)

# %%
time, tas, wanted, slowest, bank, height = np.array(log).T
figure, axes = plt.subplots(3, 1, sharex=True, figsize=(7, 6), layout="constrained")
axes[0].plot(time, tas, label="flown")
axes[0].plot(time, wanted, "--", label="wanted")
axes[0].plot(time, slowest, "k", label="V_min, by the thrust map")
axes[0].set_ylabel("true airspeed, kn")
axes[0].legend()
axes[1].plot(time, bank)
axes[1].set_ylabel("bank, deg")
axes[2].plot(time, height)
axes[2].set(xlabel="time, s", ylabel="altitude, ft")
for axis in axes:
    axis.axvline(5, color="grey", linewidth=0.8)
    axis.grid(alpha=0.4)

# %% [markdown]
# The jam raises V_min, and the aircraft stops slowing down in time. Straight flight with the rudder at 15 deg needs
# a bank.

# %%
print(slowest[0], slowest[-1])
assert tas.min() > slowest.max() + 4
