"""Figures of sensitivity results: bars with intervals, the plane of elementary effects, convergence, pairs."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from .design import Factor, factor_key

if TYPE_CHECKING:
    from .convergence import Convergence
    from .elementary_effects import ElementaryEffects
    from .interactions import Interactions
    from .result import Result

Published = Mapping[str, Mapping[str, Mapping[str, float]]]
"""Output name -> key of a row -> kind, as "first" -> value."""

LABELS = {
    "first": "$S$",
    "total": "$S^T$",
    "shares": "share",
    "effects": "Shapley effect",
    "full_first": "$S$ full",
    "full_total": "$S^T$ full",
    "independent_first": "$S$ independent",
    "independent_total": "$S^T$ independent",
    "mu": r"$\mu$",
    "mu_star": r"$\mu^*$",
    "sigma": r"$\sigma$",
    "median": "PAWN median",
    "largest": "PAWN largest",
    "mean": "PAWN mean",
}
COLOURS = ("#0072b2", "#e69f00", "#56b4e9", "#d55e00")
HATCHES = ("", "///", "...", "xxx")
MARKERS = "os^Dv<>P*X"


def plot_bars(
    result: "Result",
    *,
    kinds: tuple[str, ...] | None = None,
    published: Published | None = None,
    published_label: str = "published",
    labels: Mapping[str, str] | None = None,
) -> Figure:
    """Bars of a result's estimates with their intervals, one panel an output; open markers for published values.

    `labels` gives a short label for any input or output name; a group is shown as the set of its inputs' labels.

    Args:
        result: indices of any kind.
        kinds: which of the result's estimates; None: all.
        published: values to compare with, by output, input and kind.
        published_label: what the legend calls them.
        labels: a short label for any input or output name.
    """
    labels, kinds = labels or {}, kinds or result.kinds
    rows: tuple[Factor, ...] = (
        getattr(result, "factors", None)
        or getattr(result, "subsets", None)
        or tuple((name,) for name in result.row_names)
    )
    n_outputs = len(result.output_names)
    figure = Figure(figsize=(2.5 + max(3.0, 0.9 * len(rows)) * n_outputs, 4.2), layout="constrained")
    panels = figure.subplots(1, n_outputs, sharey=True, squeeze=False)[0]
    ticks = [_factor_label(row, labels) for row in rows]
    width = 0.8 / len(kinds)
    for j, (axes, output) in enumerate(zip(panels, result.output_names, strict=True)):
        known = []
        for k, kind in enumerate(kinds):
            at = np.arange(len(rows)) + (k + 0.5) * width - 0.4
            estimate = result.estimates[kind]
            colour, hatch = COLOURS[k % len(COLOURS)], HATCHES[k % len(HATCHES)]
            drawn: Any = {"color": colour, "hatch": hatch, "edgecolor": "white", "label": LABELS.get(kind, kind)}
            axes.bar(at, estimate.value[:, j], 0.95 * width, **drawn)
            axes.vlines(at, estimate.lower[:, j], estimate.upper[:, j], color="black", linewidth=1.5)
            for place, row in zip(at, rows, strict=True):
                values = (published or {}).get(output, {}).get(factor_key(row), {})
                if kind in values:
                    known.append((place, values[kind]))
        if known:
            axes.plot(*zip(*known, strict=True), "D", color="black", markerfacecolor="white", label=published_label)
        axes.set_xticks(np.arange(len(rows)), ticks)
        if max(map(len, ticks)) > 12:
            axes.tick_params(axis="x", labelrotation=30)
        axes.axhline(0.0, color="black", linewidth=0.8)
        axes.set_title(labels.get(output, output))
        axes.spines[["top", "right"]].set_visible(False)
    confidence = getattr(result, "confidence", 0.95)
    unit = "share of variance" if set(kinds) <= {"first", "total", "shares", "effects"} else "index"
    panels[0].set_ylabel(f"{unit}, {confidence:.0%} intervals" if confidence else unit)
    legend = {label: handle for axes in panels for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)}
    figure.legend(legend.values(), legend.keys(), loc="outside right upper", frameon=False)
    return figure


def plot_effects(effects: "ElementaryEffects", *, labels: Mapping[str, str] | None = None) -> Figure:
    """The plane of elementary effects (paper Figs 35-36): deviation over mean absolute effect, intervals as boxes.

    Args:
        effects: as `EffectsDesign.evaluate` gives them.
        labels: a short label for any input or output name.
    """
    labels = labels or {}
    n_outputs = len(effects.output_names)
    figure = Figure(figsize=(1.5 + 4.2 * n_outputs, 4.2), layout="constrained")
    panels = figure.subplots(1, n_outputs, squeeze=False)[0]
    for j, (axes, output) in enumerate(zip(panels, effects.output_names, strict=True)):
        for i, name in enumerate(effects.names):
            x, y = effects.mu_star, effects.sigma
            corner = (x.lower[i, j], y.lower[i, j])
            size = (x.upper[i, j] - x.lower[i, j], y.upper[i, j] - y.lower[i, j])
            colour = f"C{i}"
            axes.add_patch(Rectangle(corner, *size, facecolor=colour, alpha=0.25, edgecolor=colour))
            axes.plot(
                x.value[i, j], y.value[i, j], MARKERS[i % len(MARKERS)], color=colour, label=labels.get(name, name)
            )
        axes.set(xlabel=r"mean absolute effect $\mu^*$", ylabel=r"deviation $\sigma$", title=labels.get(output, output))
        axes.set_xlim(left=0.0)
        axes.set_ylim(0.0, max(axes.get_ylim()[1], 0.05 * float(effects.mu_star.upper[:, j].max())))  # rounding is none
        axes.spines[["top", "right"]].set_visible(False)
    handles, names = panels[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside right upper", frameon=False)
    return figure


def plot_convergence(steps: "Convergence", *, labels: Mapping[str, str] | None = None) -> Figure:
    """First and total indices over the number of evaluations with their intervals (paper Figs 39-40).

    Args:
        steps: as `convergence` gives them.
        labels: a short label for any input or output name.
    """
    labels = labels or {}
    last = steps.steps[-1]
    n_outputs = len(last.output_names)
    figure = Figure(figsize=(1.8 + 3.8 * n_outputs, 6.4), layout="constrained")
    panels: Any = figure.subplots(2, n_outputs, sharex=True, squeeze=False)
    evaluations = [step.design.n_evaluations for step in steps.steps]
    for row, j in np.ndindex(panels.shape):
        kind, output = ("first", "total")[row], last.output_names[j]
        axes = panels[row, j]
        for i, factor in enumerate(last.factors):
            estimates = [step.estimates[kind] for step in steps.steps]
            axes.fill_between(
                evaluations,
                [e.lower[i, j] for e in estimates],
                [e.upper[i, j] for e in estimates],
                color=f"C{i}",
                alpha=0.2,
                linewidth=0,
            )
            values = [e.value[i, j] for e in estimates]
            axes.plot(
                evaluations, values, f"{MARKERS[i % len(MARKERS)]}-", color=f"C{i}", label=_factor_label(factor, labels)
            )
        axes.set_xscale("log")
        axes.set_title(f"{LABELS[kind]} of {labels.get(output, output)}")
        axes.spines[["top", "right"]].set_visible(False)
        if row:
            axes.set_xlabel("evaluations")
    handles, names = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside right upper", frameon=False)
    return figure


def plot_pairs(found: "Interactions", *, labels: Mapping[str, str] | None = None) -> Figure:
    """A matrix an output: first-order shares on the diagonal, those of pairs beside it.

    Args:
        found: shares of inputs and of pairs.
        labels: a short label for any input or output name.
    """
    labels = labels or {}
    names = [subset[0] for subset in found.subsets if len(subset) == 1]
    n_outputs = len(found.output_names)
    figure = Figure(figsize=(1.0 + 4.0 * n_outputs, 4.0), layout="constrained")
    panels = figure.subplots(1, n_outputs, squeeze=False)[0]
    for j, (axes, output) in enumerate(zip(panels, found.output_names, strict=True)):
        matrix = np.full((len(names), len(names)), np.nan)
        for i, subset in enumerate(found.subsets):
            if len(subset) <= 2:
                row, column = names.index(subset[-1]), names.index(subset[0])
                matrix[row, column] = found.shares.value[i, j]
        image = axes.imshow(matrix, cmap="cividis", vmin=0.0)
        for row, column in zip(*np.nonzero(np.isfinite(matrix)), strict=True):
            value = matrix[row, column]
            dark = value < 0.5 * np.nanmax(matrix)
            axes.text(column, row, f"{value:.3f}", ha="center", va="center", color="white" if dark else "black")
        ticks = [labels.get(name, name) for name in names]
        axes.set_xticks(range(len(names)), ticks)
        axes.set_yticks(range(len(names)), ticks)
        axes.set_title(labels.get(output, output))
        figure.colorbar(image, ax=axes, label="share of variance")
    return figure


def _factor_label(factor: Factor, labels: Mapping[str, str]) -> str:
    shown = [labels.get(name, name) for name in factor]
    return shown[0] if len(shown) == 1 else "{" + ",\n".join(shown) + "}"
