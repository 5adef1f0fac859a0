"""The figures show the selection's own numbers."""

import numpy as np
import pytest

from surrogate.plots import plot_error_histogram, plot_performance, plot_regression


def test_regression_shows_every_sample_of_the_four_parts(selection, tmp_path):
    figure = plot_regression(selection)
    parts = ("training", "test", "all", "independent")
    for axes, part in zip(figure.axes, parts, strict=True):
        assert axes.get_title().endswith(f"R = {selection.correlation(part):.5f}")
        speed, force = axes.get_lines()[:2]
        assert len(speed.get_xdata()) == len(force.get_xdata()) == len(selection.split.rows(part, selection.selected))
        assert 0 <= speed.get_xdata().min() < speed.get_xdata().max() <= 1
    figure.savefig(tmp_path / "regression.png")


def test_performance_marks_the_least_error(selection):
    [axes] = plot_performance(selection).axes
    independent, _, mark = axes.get_lines()
    np.testing.assert_array_equal(independent.get_ydata(), selection.mse["independent"])
    np.testing.assert_array_equal(independent.get_xdata(), [1, 2, 3, 4, 5, 6])
    assert mark.get_ydata() == [min(selection.mse["independent"])]


def test_histogram_counts_every_independent_error_in_its_unit(selection):
    figure = plot_error_histogram(selection)
    assert [axes.get_xlabel() for axes in figure.axes] == ["error of speed (m/s)", "error of force (N)"]
    rows = selection.split.independent
    errors = selection.Y[rows] - selection.network.predict(selection.X[rows])
    for axes, error in zip(figure.axes, errors.T, strict=True):
        assert sum(bar.get_height() for bar in axes.patches) == len(rows)
        assert axes.patches[0].get_x() == pytest.approx(error.min())
