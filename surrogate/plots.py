"""Figures of a selection: regression, performance of all networks, histogram of errors (paper Figs. 12, 10, 13)."""

import numpy as np
from matplotlib.figure import Figure

from surrogate.protocol import Part, Selection

PANELS: dict[Part, str] = {
    "training": "Training",
    "test": "Test",
    "all": "Training and test",
    "independent": "Independent test",
}


def plot_regression(selection: Selection) -> Figure:
    """Outputs of the selected network against targets on [0, 1], with the fitted line, for each part of the data."""
    figure = Figure(figsize=(9, 9), layout="constrained")
    for axes, (part, title) in zip(figure.subplots(2, 2).flat, PANELS.items(), strict=True):
        targets, outputs = selection.targets_and_outputs(part)
        for variable, target, output in zip(selection.network.outputs, targets.T, outputs.T, strict=True):
            axes.plot(target, output, "o", ms=4, mfc="none", label=variable.name)
        slope, offset = np.polyfit(targets.ravel(), outputs.ravel(), 1)
        ends = np.array([0.0, 1.0])
        axes.plot(ends, ends, "k:", label="output = target")
        axes.plot(ends, slope * ends + offset, "k-", lw=1, label=f"output = {slope:.4f} target {offset:+.1g}")
        axes.set_title(f"{title}: R = {selection.correlation(part):.5f}")
        axes.set(xlabel="target", ylabel="output", aspect="equal")
        axes.legend(fontsize="small")
    return figure


def plot_performance(selection: Selection) -> Figure:
    """Mean squared error of every network on the independent test and the training part, the selected one marked."""
    figure = Figure(figsize=(8, 4.5), layout="constrained")
    axes = figure.subplots()
    independent, best = selection.mse["independent"], selection.selected
    numbers = np.arange(1, len(independent) + 1)
    axes.semilogy(numbers, independent, "o-", label="independent test")
    axes.semilogy(numbers, selection.mse["training"], "s--", ms=4, mfc="none", lw=0.8, label="training")
    selected = f"selected: network {best + 1}, {independent[best]:.3g}"
    axes.semilogy(best + 1, independent[best], "o", ms=14, mfc="none", color="tab:red", ls="none", label=selected)
    axes.set(xlabel="network", ylabel="mean squared error on [0, 1]", xticks=numbers)
    axes.grid(True, which="both", alpha=0.3)
    axes.legend()
    return figure


def plot_error_histogram(selection: Selection) -> Figure:
    """Errors (target - output) of the selected network on the independent test part, each output in its unit."""
    network, rows = selection.network, selection.split.independent
    errors = selection.Y[rows] - network.predict(selection.X[rows])
    figure = Figure(figsize=(4.5 * len(network.outputs), 4), layout="constrained")
    panels = figure.subplots(1, len(network.outputs), squeeze=False).flat
    for axes, variable, error in zip(panels, network.outputs, errors.T, strict=True):
        axes.hist(error, bins=20, edgecolor="white")
        axes.axvline(0.0, color="k", lw=1)
        axes.locator_params(axis="x", nbins=5)
        axes.set(xlabel=f"error of {variable.name} ({variable.unit})", ylabel="samples")
    return figure
