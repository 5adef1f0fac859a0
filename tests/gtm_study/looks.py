"""Whether what the legend of a figure names can be told apart without its colours."""

from itertools import combinations
from typing import Any

from matplotlib.collections import PathCollection, PolyCollection
from matplotlib.colors import to_rgb
from matplotlib.container import BarContainer, ErrorbarContainer
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

LIGHTER = 10.0
"""Least difference of CIE lightness (0..100) at which greys are told apart."""


def lightness(colour: Any) -> float:
    """CIE L* of a colour on white."""
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in to_rgb(colour)]
    y = sum(weight * c for weight, c in zip((0.2126, 0.7152, 0.0722), linear, strict=True))
    return 116 * y ** (1 / 3) - 16 if y > 216 / 24389 else y * 24389 / 27


def look(handle: Any) -> tuple[tuple, float]:
    """All of its look but the colour, and how light that is."""
    if isinstance(handle, (BarContainer, ErrorbarContainer)):
        handle = handle[0]
    if isinstance(handle, Line2D):
        dashes = handle.get_linestyle() if handle.get_linestyle() != "--" else str(handle._dash_pattern)
        return ("line", dashes, handle.get_marker(), handle.get_fillstyle()), lightness(handle.get_color())
    if isinstance(handle, (PathCollection, PolyCollection)):
        return ("area", handle.get_hatch()), lightness(handle.get_facecolor()[0])
    return ("patch", handle.get_hatch()), lightness(handle.get_facecolor())


def alike(figure: Figure) -> list[tuple[str, str]]:
    """Pairs of names in a legend that nothing but their hue tells apart."""
    found = []
    for axes in figure.axes:
        named = [(label, *look(handle)) for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)]
        for (one, *first), (other, *second) in combinations(named, 2):
            if one != other and first[0] == second[0] and abs(first[1] - second[1]) < LIGHTER:
                found.append((one, other))
    return found
