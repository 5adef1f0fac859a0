"""What the next degree costs, drawn: changes of V_min and V_max beside their slopes and the global indices."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from gtm_study import style
from gtm_study.figures import captions
from gtm_study.paper.advice import Advice, Move, moved

NARROWER, WIDER, SHARES = style.VERMILION, style.BLUE, (style.SKY, style.ORANGE)
HATCH = "///"
"""Of bars that narrow the envelope, and of the second share, which grey print tells from the others by it."""
ENDS = (("$V_{min}$", 1.0), ("$V_{max}$", -1.0))
"""The sign of a change that narrows the envelope."""


def plot_advice(found: Advice) -> Figure:
    """Bars: exact changes of both ends in kn by each move; diamonds: what the slopes here say; at right S^T."""
    moves, here, shares = found.moves[::-1], found.slopes.envelope, found.shares
    figure = Figure(figsize=(11.0, 1.6 + 0.34 * len(moves)), layout="constrained")
    panels = figure.subplots(1, 3, sharey=True)
    rows = list(range(len(moves)))
    speeds = (here.v_min_kt, here.v_max_kt)
    for k, (axes, (name, sign)) in enumerate(zip(panels, ENDS, strict=False)):
        for row, move in zip(rows, moves, strict=True):
            _draw(axes, row, move, k, sign, speeds[k])
        axes.axvline(0.0, color="black", linewidth=0.8)
        axes.set_title(f"{name}, now {speeds[k]:.1f} kn")
        axes.set_xlabel("change, kn")
        axes.use_sticky_edges = False  # a bar's foot would cut off what lies on it
        axes.margins(x=0.12)
    width = 0.8 / len(shares.outputs)
    for k, output in enumerate(shares.outputs):
        total = [shares.total.get(move.quantity.name, {}).get(output, 0.0) for move in moves]
        label = {"v_min_kt": "$V_{min}$", "v_max_kt": "$V_{max}$"}.get(output, "width")
        place = np.array(rows) + 0.4 - (k + 0.5) * width
        panels[2].barh(
            place, total, 0.95 * width, color=SHARES[k], hatch=("", HATCH)[k], edgecolor="white", label=label
        )
    if len(shares.outputs) > 1:
        panels[2].legend(frameon=False, loc="center right")
        panels[2].set(title="all such failures", xlabel="total index $S^T$")
    else:
        panels[2].set(title="all such failures", xlabel=f"total index $S^T$ of the {label}")
    panels[0].set_yticks(rows, list(map(moved, moves)))
    for axes in panels:
        axes.spines[["top", "right"]].set_visible(False)
        axes.tick_params(axis="y", length=0)
    figure.suptitle(f"{captions.condition(here.altitude_ft, here.gamma_deg)}, {captions.failure(here.failure)}")
    keys = [
        Patch(facecolor=NARROWER, hatch=HATCH, edgecolor="white", label="narrower"),
        Patch(facecolor=WIDER, label="wider"),
        Line2D([], [], linestyle="", marker="D", color="black", markerfacecolor="white", label="by the slope here"),
    ]
    figure.legend(handles=keys, loc="outside lower center", ncols=3, frameon=False)
    return figure


def _draw(axes: Axes, row: int, move: Move, end: int, sign: float, now_kt: float | None) -> None:
    """One bar with its diamond."""
    to = (move.change.v_min_kt, move.change.v_max_kt)[end]
    if to is None or now_kt is None:
        box = {"facecolor": "white", "edgecolor": "none", "pad": 1.0}
        axes.text(0.0, row, "no envelope left", va="center", ha="center", color=NARROWER, fontsize="small", bbox=box)
        return
    change = to - now_kt
    if sign * change > 0:
        axes.barh(row, change, 0.7, color=NARROWER, hatch=HATCH, edgecolor="white")
    else:
        axes.barh(row, change, 0.7, color=WIDER)
    step = move.change.to - move.quantity.value
    slope = move.slope(("v_min", "v_max")[end])
    if slope is not None:
        axes.plot(slope * step, row, "D", color="black", markerfacecolor="white", markersize=5)
