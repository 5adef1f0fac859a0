"""Figures of sensitivity indices."""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from .design import Factor
from .indices import Estimate, VarianceIndices

Published = Mapping[str, Mapping[str, Mapping[str, float]]]
"""Output name -> factor, its names joined with commas -> {"first": S, "total": ST}."""


def plot_indices(
    indices: VarianceIndices,
    *,
    published: Published | None = None,
    published_label: str = "published",
    labels: Mapping[str, str] | None = None,
) -> Figure:
    """Bars of S and ST with their intervals, one panel an output; open markers for published values.

    `labels` gives a short label for any input or output name; a group is shown as the set of its inputs' labels.
    """
    labels = labels or {}
    n_outputs, n_factors = len(indices.output_names), len(indices.factors)
    figure = Figure(figsize=(2.5 + max(3.0, 0.9 * n_factors) * n_outputs, 4.2), layout="constrained")
    panels = figure.subplots(1, n_outputs, sharey=True, squeeze=False)[0]
    positions = np.arange(n_factors)
    ticks = [_factor_label(factor, labels) for factor in indices.factors]
    for j, (axes, output) in enumerate(zip(panels, indices.output_names, strict=True)):
        for offset, kind, name, colour in ((-0.2, "first", "$S$", "#2a6f97"), (0.2, "total", "$S^T$", "#e09f3e")):
            estimate: Estimate = getattr(indices, kind)
            axes.bar(positions + offset, estimate.value[:, j], 0.38, color=colour, label=name)
            axes.vlines(positions + offset, estimate.lower[:, j], estimate.upper[:, j], color="black", linewidth=1.5)
            known = [
                (i + offset, values[kind])
                for i, factor in enumerate(indices.factors)
                if kind in (values := (published or {}).get(output, {}).get(",".join(factor), {}))
            ]
            if known:
                marker_label = published_label if kind == "first" else None
                axes.plot(*zip(*known, strict=True), "D", color="black", markerfacecolor="white", label=marker_label)
        axes.set_xticks(positions, ticks)
        if max(map(len, ticks)) > 12:
            axes.tick_params(axis="x", labelrotation=30)
        axes.axhline(0.0, color="black", linewidth=0.8)
        axes.set_title(labels.get(output, output))
        axes.spines[["top", "right"]].set_visible(False)
    panels[0].set_ylabel(f"share of variance, {indices.confidence:.0%} intervals")
    legend = {label: handle for axes in panels for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)}
    figure.legend(legend.values(), legend.keys(), loc="outside right upper", frameon=False)
    return figure


def _factor_label(factor: Factor, labels: Mapping[str, str]) -> str:
    shown = [labels.get(name, name) for name in factor]
    return shown[0] if len(shown) == 1 else "{" + ",\n".join(shown) + "}"
