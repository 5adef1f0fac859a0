"""The figures show the selection's own numbers."""

import numpy as np
import pytest

from surrogate import Growth
from surrogate.plots import (
    plot_error_histogram,
    plot_growth,
    plot_performance,
    plot_regression,
    plot_regularization,
    plot_training,
)


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
    figure = plot_error_histogram(selection, {"force": "$F$"})
    assert [axes.get_xlabel() for axes in figure.axes] == ["error of speed, m/s", "error of $F$, N"]
    rows = selection.split.independent
    errors = selection.Y[rows] - selection.network.predict(selection.X[rows])
    for axes, error in zip(figure.axes, errors.T, strict=True):
        assert sum(bar.get_height() for bar in axes.patches) == len(rows)
        assert axes.patches[0].get_x() == pytest.approx(error.min())


def test_training_shows_errors_on_the_scale_of_the_selection(selection):
    """History sums squares on [-1, 1], the selection means on [0, 1]."""
    [axes] = plot_training(selection).axes
    training = axes.get_lines()[0].get_ydata()
    assert training[-1] == pytest.approx(selection.mse["training"][selection.selected], rel=1e-9)
    assert axes.get_lines()[1].get_ydata()[0] == selection.mse["test"][selection.selected]


def test_regularization_shows_the_history(selection):
    history = selection.histories[0]
    for axes, values in zip(
        plot_regularization(history).axes, (history.gamma, history.alpha, history.beta, history.mu), strict=True
    ):
        np.testing.assert_array_equal(axes.get_lines()[0].get_ydata(), values)


def test_growth_marks_the_kept_network():
    mse = np.array([0.4, 0.1, 0.2])
    growth = Growth(np.array([3, 6, 9]), mse / 2, mse, mse, best=2, stop="validation")
    [axes] = plot_growth({"LOLIMOT": growth}).axes
    line, mark = axes.get_lines()
    np.testing.assert_array_equal(line.get_xydata(), np.column_stack([[3, 6, 9], mse]))
    np.testing.assert_array_equal(mark.get_xydata(), [[6, 0.1]])
