# %% [markdown]
# # The study's numbers from Python
#
# What the study's report tells can be asked for directly. Here: the paper's lattice of 1232 rudder failures and
# flight conditions, solved exactly, beside what the paper says of it.

# %%
import numpy as np

from gtm_fmu import FlightCondition
from gtm_fmu.datasets import paper
from gtm_fmu.datasets.lattice import rudder_failures
from gtm_study.paper import published

failures = rudder_failures(paper.RUDDERS_DEG)
print(len(paper.ALTITUDES_FT), len(paper.GAMMAS_DEG), len(failures))  # 4 11 28

# %% [markdown]
# One altitude of the four: 308 envelopes. All failures of a flight condition share their searches, so ask a
# `FlightCondition` and not `envelope`.

# %%
altitude_ft = 10000
speeds = np.full((len(paper.GAMMAS_DEG), len(failures), 2), np.nan)
for i, gamma_deg in enumerate(paper.GAMMAS_DEG):
    condition = FlightCondition(altitude_ft, gamma_deg)
    for j, rudder_deg in enumerate(failures):
        found = condition.envelope(rudder_deg)
        if found.feasible:
            speeds[i, j] = found.v_min_kt, found.v_max_kt
feasible = np.isfinite(speeds[..., 0])
print(feasible.sum(), feasible.size)  # 286 308

# %% [markdown]
# The paper's Fig. 3 shows jams at -5 deg of flight path. Which of them leave an envelope, and which one?

# %%
import matplotlib.pyplot as plt

jams = [j for j, (lower, upper) in enumerate(failures) if lower == upper]
deflections = [failures[j][0] for j in jams]
figure, axis = plt.subplots(figsize=(7, 4), layout="constrained")
for gamma_deg, style in ((-5.0, "-"), (0.0, "--"), (5.0, ":")):
    of_jams = speeds[paper.GAMMAS_DEG.index(gamma_deg), jams]
    axis.plot(deflections, of_jams[:, 0], style, color="tab:blue", marker="o", label=f"V_min, {gamma_deg:g} deg")
    axis.plot(deflections, of_jams[:, 1], style, color="tab:red", marker="s", label=f"V_max, {gamma_deg:g} deg")
axis.set(xlabel="rudder jammed at, deg", ylabel="true airspeed, kn", title=f"{altitude_ft} ft")
figure.legend(loc="outside right upper", fontsize="small")
axis.grid(alpha=0.4)

# %% [markdown]
# Published numbers are in `published`, for comparison only. Is the best network of a surrogate of yours as good as
# the paper's? Errors there are mean squares of speeds mapped to 0 .. 1 over the data.

# %%
print(published.MSE_ANN[6], published.MSE_LMN[6])  # 9.4251e-05 0.00012278
print(published.FEASIBLE_CASES)  # 1102

# %% [markdown]
# How good is the thrust map on cases between the nodes of that lattice? 4096 random cases with exact answers come
# with the package, and any model with `predict` can be measured on them.

# %%
from gtm_fmu import ThrustMap
from gtm_fmu.datasets import off_lattice

measured = off_lattice.measured(ThrustMap.load(), off_lattice.load())
print(measured["all"]["percentile_95_kt"], measured["all"]["largest_kt"])  # 0.0475 0.611: kn
