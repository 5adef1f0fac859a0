# %% [markdown]
# # Train your own surrogate and load its FMU
#
# A table of wings, whose lift and drag somebody has computed, becomes a network; the network becomes an FMU without
# Python inside. Nothing here is about aircraft of this package: take a table of your own.

# %%
import pandas as pd

wings = pd.read_csv("../tables/wing.csv")
print(len(wings), list(wings.columns))  # 400

# %% [markdown]
# The estimator follows scikit-learn's convention. Bayesian regularisation needs no validation data, and says how
# sure it is. A quarter of the rows is kept for a test.

# %%
from sklearn.model_selection import train_test_split

from surrogate import BayesianRegularizationRegressor

inputs, outputs = ["span_mm", "alpha_deg", "speed_m_s"], ["lift"]
training, test = train_test_split(wings, random_state=0)
model = BayesianRegularizationRegressor(8, restarts=1, random_state=0).fit(training[inputs], training[outputs])
predicted, deviation = model.predict(test[inputs], return_std=True)
errors = test["lift"].to_numpy() - predicted.ravel()
print(f"{abs(errors).max():.2f} N at most, lift reaches {wings['lift'].max():.0f} N")
assert abs(errors).max() < 0.01 * wings["lift"].max()

# %% [markdown]
# Look at it: error over lift, with the model's own two standard deviations.

# %%
import matplotlib.pyplot as plt

figure, axis = plt.subplots(figsize=(7, 3.5), layout="constrained")
axis.errorbar(test["lift"], errors, 2 * deviation.ravel(), fmt=".", elinewidth=0.7, color="tab:blue")
axis.set(xlabel="lift, N", ylabel="error and 2 standard deviations, N")
axis.grid(alpha=0.4)

# %% [markdown]
# A file keeps it; reading that file and evaluating the network needs no torch. Names and units travel with it.

# %%
from dataclasses import replace
from pathlib import Path

from surrogate import Variable, load_model

units = (Variable("span_mm", "mm"), Variable("alpha_deg", "deg"), Variable("speed_m_s", "m/s"))
network = replace(model.network_, inputs=units, outputs=(Variable("lift", "N"),))
Path("build").mkdir(exist_ok=True)
network.save("build/lift.json")
print(load_model("build/lift.json").predict([1200, 4, 25]))  # [60.5]: N; the formula behind the table gives 60.45

# %% [markdown]
# Now as an FMU, for any tool on this platform. The command line does the same:
# `gtm-fmu export build/lift.json --fmu --output build/Lift.fmu`.

# %%
import fmpy

from fmu_src.packing.model_fmu import build_model

path = build_model(network, "build/Lift.fmu")
wing = {"span_mm": 1200, "alpha_deg": 4, "speed_m_s": 25}
answer = fmpy.simulate_fmu(path, stop_time=0.1, start_values=wing, output=["lift", "lift_std"])[-1]
print(answer["lift"])  # 60.5
assert abs(answer["lift"] - network.predict([1200, 4, 25])[0]) < 1e-9
