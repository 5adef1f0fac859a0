"""The bar figure shows the numbers it was given."""

import matplotlib.pyplot as plt
import numpy as np

from sensitivity import Distribution, OrderedUniform, Uniform, plot_bars, variance_design, variance_indices

DISTRIBUTION = Distribution([Uniform("x", 0.0, 1.0), OrderedUniform(("L", "U"), 0.0, 1.0)])


def result():
    design = variance_design(DISTRIBUTION, 128, replicates=4)
    return variance_indices(design.evaluate(lambda x: np.column_stack([x.sum(axis=1), x.prod(axis=1)]), ["a", "b"]))


def test_bars_intervals_and_published_markers(tmp_path):
    indices = result()
    published = {"a": {"L": {"first": 0.31, "total": 0.42}, "U": {"first": 0.11}}}
    figure = plot_bars(indices, published=published, labels={"L": "lower", "b": "second"})
    assert [axes.get_title() for axes in figure.axes] == ["a", "second"]
    for j, axes in enumerate(figure.axes):
        heights = [patch.get_height() for patch in axes.patches]
        np.testing.assert_array_equal(heights, np.concatenate([indices.first.value[:, j], indices.total.value[:, j]]))
        drawn = np.array([segment[:, 1] for lines in axes.collections for segment in lines.get_segments()])
        np.testing.assert_array_equal(
            drawn[:, 0], np.concatenate([indices.first.lower[:, j], indices.total.lower[:, j]])
        )
        np.testing.assert_array_equal(
            drawn[:, 1], np.concatenate([indices.first.upper[:, j], indices.total.upper[:, j]])
        )
        assert [tick.get_text() for tick in axes.get_xticklabels()] == ["x", "lower", "U", "{lower,\nU}"]
    markers = [line.get_xydata().tolist() for line in figure.axes[0].lines if line.get_marker() == "D"]
    markers[0].sort()
    np.testing.assert_allclose(markers, [[[0.8, 0.31], [1.2, 0.42], [1.8, 0.11]]])
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["published", "$S$", "$S^T$"]
    figure.savefig(tmp_path / "indices.png")
    assert (tmp_path / "indices.png").read_bytes().startswith(b"\x89PNG")


def test_no_figure_is_left_open():
    plot_bars(result())
    assert plt.get_fignums() == []
