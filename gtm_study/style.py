"""One style for all figures of the study: colours that the colour-blind tell apart, and more than colour for grey.

Every figure brings its own white ground, so that it reads on a dark page too. Nothing of it depends on the user's
settings of matplotlib, and the same figure gives the same bytes.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

BLUE, ORANGE, BLACK, SKY, VERMILION, GREEN, PURPLE, GREY = (
    "#0072b2",
    "#e69f00",
    "#000000",
    "#56b4e9",
    "#d55e00",
    "#009e73",
    "#cc79a7",
    "#777777",
)
PALETTE = (BLUE, ORANGE, BLACK, SKY, VERMILION, GREEN, PURPLE)
"""Colours of Okabe and Ito, a dark one and a light one in turn."""
DASHES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (8, 2)), (0, (1, 3)))
MARKERS = "os^Dv<>"
"""A dash and a marker for each of the `PALETTE`."""
DPI = 110


def settings() -> dict[str, Any]:
    """What differs from matplotlib's defaults."""
    from cycler import cycler

    return {
        "axes.prop_cycle": cycler(color=PALETTE) + cycler(linestyle=DASHES),
        "figure.facecolor": "white",
        "savefig.facecolor": "white",
        "font.family": "DejaVu Sans",  # comes with matplotlib
        "grid.alpha": 0.3,
        "axes.axisbelow": True,
        "image.cmap": "cividis",
        "savefig.dpi": DPI,
        "svg.hashsalt": "gtm-fmu",
    }


@contextmanager
def figure_style() -> Iterator[None]:
    """Figures that are made and written within have the study's style."""
    from matplotlib import style

    with style.context(["default", settings()]):
        yield
