"""The example table is what its script writes, and the script is the lifting line."""

import numpy as np
import pytest

from examples.tables import wing


def test_file_is_what_the_script_writes(tmp_path):
    wing.write(tmp_path / "wing.csv")
    shipped = np.genfromtxt(wing.__file__.replace(".py", ".csv"), delimiter=",", skip_header=1)
    written = np.genfromtxt(tmp_path / "wing.csv", delimiter=",", skip_header=1)
    assert shipped.shape == (400, 5)
    np.testing.assert_allclose(written, shipped, rtol=1e-6)


def test_limits_of_the_lifting_line():
    """An endless wing lifts 2 pi per rad; of a wing of aspect ratio 2 half of that is left, by hand."""
    force = 1.225 / 2 * 20**2
    endless, _ = wing.lift_and_drag(1e9, -2 + np.degrees(0.1), 20)
    assert endless / (force * 1e6 * 0.3) == pytest.approx(2 * np.pi * 0.1, rel=1e-6)
    lift, drag = wing.lift_and_drag(600, -2 + np.degrees(0.1), 20)
    assert lift / (force * 0.6 * 0.3) == pytest.approx(np.pi * 0.1)
    assert drag / (force * 0.6 * 0.3) == pytest.approx(0.02 + np.pi * 0.1**2 / 2)
