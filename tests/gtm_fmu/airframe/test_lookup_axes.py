"""The axes of the core's look-ups."""

from dataclasses import replace

import numpy as np
import pytest

from gtm_fmu.airframe.lookup_axes import MIRRORED, lookup_axes
from gtm_fmu.airframe.tables import load_tables


@pytest.fixture(scope="module")
def tables():
    return load_tables()


def test_axes_are_the_common_ones(tables):
    axes = lookup_axes()
    assert (axes.alpha[0], axes.alpha[-1]) == (-30, 90)
    for name in ("C6_bas", "dC6_rud", "dC6_ail", "dC3_ele", "dC6_spo", "dC3_lgr", "dC3_p", "dC3_q", "dC3_r", "dC6_w"):
        assert set(tables[name].axis("alpha")) <= set(axes.alpha)
    for name in ("dC6_rud", "dC6_ail", "dC3_ele", "dC6_spo"):
        np.testing.assert_array_equal(tables[name].axis("beta"), axes.beta)
    np.testing.assert_array_equal(axes.rudder_deg, [-45, -30, -10, 0, 10, 30, 45])
    np.testing.assert_array_equal(axes.aileron_deg, [-30, -20, -10, 0, 10, 20, 30])
    np.testing.assert_array_equal(axes.elevator_deg, [-30, -20, -10, 0, 10, 20])


@pytest.mark.parametrize(("name", "axis"), [(name, axis) for name, axes in MIRRORED.items() for axis in axes])
def test_mirror_rules_need_symmetric_axes(tables, name, axis):
    table = tables[name]
    axes = [points + 1.0 if each == axis else points for each, points in zip(table.axis_names, table.axes, strict=True)]
    with pytest.raises(ValueError, match=f"{name} needs an axis {axis} symmetric about zero"):
        lookup_axes({**tables, name: replace(table, axes=tuple(axes))})
