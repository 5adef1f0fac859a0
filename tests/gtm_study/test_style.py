"""The style of the study's figures: told apart without colours, their own white ground, the same bytes again."""

import matplotlib
import matplotlib.image
import numpy as np
import pytest
from matplotlib.figure import Figure

from gtm_study.files import save_figure
from gtm_study.style import BLUE, PALETTE, VERMILION, figure_style
from tests.gtm_study.looks import alike, lightness


def lines(*looks: dict, count: int = 0) -> Figure:
    figure = Figure()
    axes = figure.subplots()
    for k, look in enumerate(looks or [{}] * count):
        axes.plot([0, 1], [0, k], label=f"{k}", **look)
    axes.set_xlabel(r"$\gamma$, deg")
    return figure


@pytest.mark.parametrize(("colour", "expected"), [("#ffffff", 100.0), ("#000000", 0.0), ("#777777", 50.03)])
def test_lightness_is_that_of_cie(colour, expected):
    assert lightness(colour) == pytest.approx(expected, abs=0.01)


def test_colours_alone_do_not_tell_apart():
    """Blue and vermilion are two greys that look the same; a dash or a marker makes the difference."""
    assert alike(lines({"color": BLUE}, {"color": VERMILION})) == [("0", "1")]
    assert alike(lines({"color": BLUE}, {"color": VERMILION, "ls": "--"})) == []
    assert alike(lines({"color": BLUE}, {"color": VERMILION, "marker": "o"})) == []
    assert alike(lines({"color": BLUE}, {"color": "#e69f00"})) == []


def test_lines_in_turn():
    with figure_style():
        assert alike(lines(count=len(PALETTE))) == []
    assert alike(lines(count=len(PALETTE))) != []  # matplotlib's own


@pytest.mark.parametrize("ending", ["svg", "png"])
def test_same_bytes_whatever_the_user_has_set(tmp_path, ending):
    paths = [tmp_path / f"{name}.{ending}" for name in ("one", "other")]
    for path, settings in zip(paths, ({}, {"font.size": 20, "savefig.dpi": 30, "axes.facecolor": "pink"}), strict=True):
        with matplotlib.rc_context(settings):
            with figure_style():
                figure = lines(count=3)
            save_figure(figure, path)
    assert paths[0].read_bytes() == paths[1].read_bytes()
    assert b"<dc:date>" not in paths[0].read_bytes()


def test_own_ground(tmp_path):
    """White and opaque, for a dark page."""
    with matplotlib.rc_context({"savefig.transparent": True}):
        save_figure(lines(count=2), tmp_path / "figure.png")
    pixels = matplotlib.image.imread(tmp_path / "figure.png")
    np.testing.assert_array_equal(pixels[0, 0], [1.0, 1.0, 1.0, 1.0])
    save_figure(lines(count=2), tmp_path / "figure.svg")
    assert 'style="fill: #ffffff"' in (tmp_path / "figure.svg").read_text()
