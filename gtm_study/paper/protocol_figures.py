"""Figures of the comparison of networks (paper Figs. 10, 17-19, 23, 28, 41)."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from gtm_fmu.envelopes.boundary import Boundary
from gtm_fmu.envelopes.envelope import FlightCondition
from gtm_study import style
from gtm_study.figures import captions
from gtm_study.paper import published
from surrogate.training.local_training import Growth

Pair = tuple[float, float]

MSE = "mean squared error on [0, 1]"
COLOURS = {
    "bayesian_regularization": style.BLUE,
    "levenberg_marquardt": style.ORANGE,
    "local_models": style.VERMILION,
}
MARKERS = dict(zip(COLOURS, style.MARKERS, strict=False))
NAMES = {
    "bayesian_regularization": "Bayesian regularisation",
    "levenberg_marquardt": "Levenberg-Marquardt",
    "local_models": "local model networks",
}
OUTPUTS = ("$V_{min}$", "$V_{max}$")
LINES = tuple(zip((style.BLACK, style.BLUE, style.VERMILION, style.GREEN), style.DASHES, strict=False))
"""Colour and dashes of the exact speeds and of the models'."""


def figures(results: dict[str, Any]) -> dict[str, Figure]:
    """All of them, the paper's from the first split."""
    networks, local = results["networks"], results["local_models"]
    first = {name: splits[0] for name, splits in networks.items()} | {"local_models": local[0]}
    return {
        "trainings": plot_rounds({name: first[name] for name in networks}, "Fig. 10"),
        "networks_and_local_models": plot_rounds(
            {name: first[name] for name in ("bayesian_regularization", "local_models")}, "Fig. 17"
        ),
        "local_models_by_output": plot_outputs(first["local_models"], "local model networks (Fig. 18)"),
        "networks_by_output": plot_outputs(first["bayesian_regularization"], "neural networks (Fig. 19)"),
        "squared_errors": plot_squared_errors(first),
        "splits": plot_splits(networks | {"local_models": local}),
        "data_sets": plot_data_sets(results["data_sets"]),
        "neurons": plot_neurons(results["neurons"]),
    }


def plot_rounds(methods: Mapping[Any, dict[str, Any]], title: str) -> Figure:
    """Errors of the networks of all rounds on the independent test data, the selected ones marked."""
    figure, axes = _figure()
    for name, part in methods.items():
        mse, best = np.array(part["mse_independent"]), part["selected"]
        axes.semilogy(
            np.arange(1, len(mse) + 1), mse, f"{MARKERS[name]}-", ms=4, color=COLOURS[name], label=NAMES[name]
        )
        axes.semilogy(
            best + 1,
            mse[best],
            MARKERS[name],
            ms=12,
            mfc="none",
            color=COLOURS[name],
            label=f"selected: {mse[best]:.2g}",
        )
    axes.set(xlabel="round", ylabel=f"{MSE}, independent test", title=f"As {title} of the paper")
    axes.xaxis.get_major_locator().set_params(integer=True)
    return _finished(figure, axes)


def plot_outputs(part: dict[str, Any], title: str) -> Figure:
    """The same for each output and their mean."""
    figure, axes = _figure()
    mse = np.array(part["mse_by_output"])
    rounds = np.arange(1, len(mse) + 1)
    for o, name in enumerate(OUTPUTS):
        axes.semilogy(rounds, mse[:, o], f"{'s^'[o]}--", ms=4, lw=0.8, color=style.PALETTE[o], label=name)
    axes.semilogy(rounds, mse.mean(axis=1), "ko-", ms=4, label="mean")
    axes.set(xlabel="round", ylabel=f"{MSE}, independent test", title=title)
    axes.xaxis.get_major_locator().set_params(integer=True)
    return _finished(figure, axes)


def plot_squared_errors(methods: dict[str, dict[str, Any]]) -> Figure:
    """Squared errors of V_max of the selected models at every independent case (Fig. 23)."""
    figure, axes = _figure()
    for name in ("bayesian_regularization", "local_models"):
        squares = np.array(methods[name]["squared_errors"])[:, 1]
        cases = np.arange(1, len(squares) + 1)
        drawn = {"color": COLOURS[name], "label": NAMES[name]}
        axes.plot(cases, squares, f"{MARKERS[name]}-", ms=3, lw=0.8, **drawn)
    axes.set(xlabel="case of the independent test data", ylabel="squared error of $V_{max}$ on [0, 1]")
    return _finished(figure, axes)


def plot_splits(methods: dict[str, list[dict[str, Any]]]) -> Figure:
    """Errors of all rounds by split and method; splits with a corner of the lattice among the tests are marked."""
    figure, axes = _figure()
    for k, (name, splits) in enumerate(methods.items()):
        for s, part in enumerate(splits):
            x = s + 1 + 0.22 * (k - 1)
            mse = np.array(part["mse_independent"])
            axes.semilogy(np.full(len(mse), x), mse, MARKERS[name], ms=3, alpha=0.5, color=COLOURS[name])
            label = NAMES[name] if s == 0 else None
            axes.semilogy(x, mse.min(), MARKERS[name], ms=9, mew=2, mfc="none", color=COLOURS[name], label=label)
            if part["corners"] and k == 0:
                axes.annotate(
                    "corner case\nin the test", (s + 1, mse.max()), ha="center", va="bottom", fontsize="small"
                )
    axes.axhline(published.MSE_ANN[6], color="k", ls=":", label="paper, best network")
    axes.axhline(published.MSE_LMN[6], color="k", ls="--", lw=0.8, label="paper, best local model network")
    splits_shown = np.arange(1, len(next(iter(methods.values()))) + 1)
    axes.set(xlabel="split", xticks=splits_shown, ylabel=f"{MSE}, independent test")
    axes.margins(y=0.15)
    return _finished(figure, axes)


def plot_data_sets(data_sets: dict[int, list[dict[str, Any]]]) -> Figure:
    """Least errors on the independent test data by data set, median over splits, beside the paper's (Fig. 28)."""
    figure, axes = _figure()
    numbers = list(data_sets)
    for key, name, paper, marker in (
        ("network", "bayesian_regularization", published.MSE_ANN, "o"),
        ("local_models", "local_models", published.MSE_LMN, "s"),
    ):
        least = [np.median([min(part[key]["mse_independent"]) for part in data_sets[n]]) for n in numbers]
        axes.semilogy(numbers, least, f"{marker}-", color=COLOURS[name], label=f"{NAMES[name]}, here")
        axes.semilogy(
            numbers, [paper[n] for n in numbers], f"{marker}:", mfc="none", color=COLOURS[name], label="the paper's"
        )
    samples = [f"{n}\n({data_sets[n][0]['network']['samples']})" for n in numbers]
    axes.set_xticks(numbers, samples)
    axes.set(xlabel="data set (training samples here)", ylabel=f"{MSE}, independent test")
    return _finished(figure, axes)


def plot_best_growth(growth: Growth) -> Figure:
    """Errors of a local model network by its models as it grows, on both parts of its data (Fig. 20)."""
    figure, axes = _figure()
    models = np.arange(1, len(growth.parameters) + 1)
    axes.semilogy(models, growth.training_mse, "o-", ms=4, color=style.BLUE, label="training data")
    axes.semilogy(models, growth.validation_mse, "s--", ms=4, color=style.ORANGE, label="validation data")
    kept = f"kept: {growth.best} models, {growth.parameters[growth.best - 1]:.0f} parameters"
    axes.axvline(growth.best, color="k", ls=":", label=kept)
    axes.set(xlabel="local models", ylabel=MSE)
    axes.xaxis.get_major_locator().set_params(integer=True)
    return _finished(figure, axes)


def plot_outlier(
    condition: FlightCondition, exact_kt: Pair, estimates_kt: Mapping[str, Pair], boundary: Boundary
) -> Figure:
    """The envelope of a flight condition, and V_min and V_max as models estimate them (Figs. 24-27, 29-32)."""
    figure, axes = _figure()
    for rate, speed in boundary.outlines:
        axes.fill(rate, speed, color="0.85", lw=0)
        axes.plot(rate, speed, color="0.35", lw=1.2)
    for k, (name, speeds) in enumerate({"exact": exact_kt, **estimates_kt}.items()):
        line: dict[str, Any] = {"color": LINES[k][0], "ls": LINES[k][1], "lw": 1.8}
        for end, speed_kt in enumerate(speeds):
            label = f"{name}: {speeds[0]:.1f} .. {speeds[1]:.1f} kn" if end == 0 else None
            axes.axhline(speed_kt, label=label, **line)
    axes.set(xlabel=captions.TURN_RATE.tex, ylabel=captions.SPEED.tex)
    failed = captions.failure(condition.failure)
    axes.set_title(f"{captions.condition(condition.altitude_ft, condition.gamma_deg)}, {failed}", fontsize="medium")
    return _finished(figure, axes)


def plot_neurons(neurons: dict[str, Any]) -> Figure:
    """Errors by number of hidden neurons, a line an iteration (Fig. 41)."""
    figure, axes = _figure()
    mse = np.array(neurons["mse_independent"])
    axes.semilogy(neurons["neurons"], mse, "-", lw=0.8, color=style.BLUE, alpha=0.5)
    axes.semilogy(neurons["neurons"], np.median(mse, axis=1), "k-", lw=2, label="median")
    axes.set(xlabel="hidden neurons", ylabel=f"{MSE}, independent test", xticks=neurons["neurons"])
    return _finished(figure, axes)


def _figure() -> tuple[Figure, Any]:
    figure = Figure(figsize=(8, 4.8), layout="constrained")
    return figure, figure.subplots()


def _finished(figure: Figure, axes: Any) -> Figure:
    axes.grid(True, which="both", alpha=0.3)
    axes.legend(fontsize="small")
    return figure
