"""Figures of trainings and selections: paper Figs. 10-16 and 20-22."""

from collections.abc import Mapping
from itertools import cycle
from types import MappingProxyType
from typing import Literal

import numpy as np
from matplotlib.figure import Figure

from surrogate.training.least_squares import History
from surrogate.training.local_training import Growth
from surrogate.training.selection import Part, Selection

MARKERS = "os^Dv<>"
NO_LABELS: Mapping[str, str] = MappingProxyType({})
PANELS: dict[Part, str] = {
    "training": "Training",
    "test": "Test",
    "all": "Training and test",
    "independent": "Independent test",
}


def plot_regression(selection: Selection, labels: Mapping[str, str] = NO_LABELS) -> Figure:
    """Outputs of the selected network against targets on [0, 1], with the fitted line, for each part of the data.

    Args:
        labels: what stands for an output in the legend, by its name.
    """
    figure = Figure(figsize=(9, 9), layout="constrained")
    for axes, (part, title) in zip(figure.subplots(2, 2).flat, PANELS.items(), strict=True):
        targets, outputs = selection.targets_and_outputs(part)
        drawn = zip(selection.network.outputs, targets.T, outputs.T, cycle(MARKERS), strict=False)
        for variable, target, output, marker in drawn:
            axes.plot(target, output, marker, ms=4, mfc="none", label=labels.get(variable.name, variable.name))
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
    axes.semilogy(best + 1, independent[best], "o", ms=14, mfc="none", color="black", ls="none", label=selected)
    axes.set(xlabel="network", ylabel="mean squared error on [0, 1]", xticks=numbers)
    axes.grid(True, which="both", alpha=0.3)
    axes.legend()
    return figure


def plot_error_histogram(selection: Selection, labels: Mapping[str, str] = NO_LABELS) -> Figure:
    """Errors (target - output) of the selected network on the independent test part, each output in its unit.

    Args:
        labels: what stands for an output at its axis, by its name.
    """
    network, rows = selection.network, selection.split.independent
    errors = selection.Y[rows] - network.predict(selection.X[rows])
    figure = Figure(figsize=(4.5 * len(network.outputs), 4), layout="constrained")
    panels = figure.subplots(1, len(network.outputs), squeeze=False).flat
    for axes, variable, error in zip(panels, network.outputs, errors.T, strict=True):
        axes.hist(error, bins=20, edgecolor="white")
        axes.axvline(0.0, color="k", lw=1)
        axes.locator_params(axis="x", nbins=5)
        axes.set(xlabel=f"error of {labels.get(variable.name, variable.name)}, {variable.unit}", ylabel="samples")
    return figure


def plot_training(selection: Selection) -> Figure:
    """Errors of the selected network by epoch on the training and test part (paper Figs. 11, 14).

    The test part stops a training without regularisation early; with it nobody sees the test part, and its error is
    known at the end only.
    """
    history, m = selection.histories[selection.selected], selection.Y.shape[1]
    rows = selection.split.training[selection.selected], selection.split.test[selection.selected]
    figure = Figure(figsize=(7, 4.5), layout="constrained")
    axes = figure.subplots()
    # A mean square on [-1, 1] is four times that on [0, 1].
    training, test = (
        sse / (4 * m * len(part)) for sse, part in zip((history.sse, history.validation_sse), rows, strict=True)
    )
    axes.semilogy(training, "-", label="training")
    if test.any():
        axes.semilogy(test, "--", label="test, which stops the training")
    else:
        axes.axhline(selection.mse["test"][selection.selected], color="C1", ls=":", label="test, at the end")
    axes.axvline(history.best_epoch, color="k", ls="-.", lw=0.8, label=f"kept: epoch {history.best_epoch}")
    axes.set(xlabel="epoch", ylabel="mean squared error on [0, 1]")
    axes.grid(alpha=0.3)
    axes.legend()
    return figure


def plot_regularization(history: History) -> Figure:
    """Effective parameters, alpha, beta and mu by epoch of a training with Bayesian regularisation."""
    figure = Figure(figsize=(7, 7), layout="constrained")
    panels = figure.subplots(4, 1, sharex=True)
    named = {"gamma": r"$\gamma$", "alpha": r"$\alpha$", "beta": r"$\beta$", "mu": r"$\mu$"}
    for axes, (name, label) in zip(panels, named.items(), strict=True):
        draw = axes.plot if name == "gamma" else axes.semilogy
        draw(getattr(history, name))
        axes.set_ylabel(label)
        axes.grid(alpha=0.3)
    panels[-1].set_xlabel("epoch")
    return figure


def plot_growth(growths: Mapping[str, Growth], part: Literal["training", "validation"] = "validation") -> Figure:
    """Errors by number of parameters as local model networks grow, the kept ones marked (paper Figs. 20-22)."""
    figure = Figure(figsize=(8, 5), layout="constrained")
    axes = figure.subplots()
    for marker, (name, growth) in zip(cycle(MARKERS), growths.items(), strict=False):
        mse = growth.training_mse if part == "training" else growth.validation_mse
        (line,) = axes.loglog(growth.parameters, mse, f"{marker}-", ms=4, lw=1, label=name)
        axes.loglog(growth.parameters[growth.best - 1], mse[growth.best - 1], "x", ms=11, mew=2, color=line.get_color())
    axes.set(xlabel="parameters", ylabel=f"mean squared error on [0, 1], {part} data")
    axes.grid(True, which="both", alpha=0.3)
    axes.legend(fontsize="small")
    return figure
