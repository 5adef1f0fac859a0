"""The folded tables of the study configuration against the unfolded ones, looked up as SPEC 5 says."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import RegularGridInterpolator

from gtm_fmu.airframe.folding import fold_ailerons, fold_rudder, folded_tables, resample
from gtm_fmu.airframe.tables import load_tables

MIRROR = np.array([1, -1, 1, -1, 1, -1])
"""Of CX CY CZ Cl Cm Cn in a mirrored aircraft."""


@pytest.fixture(scope="module")
def tables():
    return load_tables()


@pytest.fixture(scope="module")
def folded():
    return folded_tables()


def interpolator(axes, values):
    """Multilinear, extrapolated with the slope of the end interval (SPEC 1), by SciPy."""
    return RegularGridInterpolator(axes, values, bounds_error=False, fill_value=None)


@pytest.fixture(scope="module")
def points():
    """Random lookup arguments inside and outside every axis."""
    random = np.random.default_rng(5)
    spans = {"alpha": (-45, 100), "beta": (-60, 60), "surface": (-60, 60)}
    return {name: random.uniform(*span, 4000) for name, span in spans.items()} | {"rate": random.uniform(-2, 2, 4000)}


def assert_equal_lookups(actual, expected):
    assert np.abs(expected).max() > 0.1
    assert (np.abs(actual - expected) <= 1e-12 * np.maximum(1.0, np.abs(expected))).all()


def unfolded(table):
    lookup = interpolator(table.axes, table.values)
    return lambda *arguments: lookup(np.stack(np.broadcast_arrays(*arguments), axis=-1))


def test_axes_are_the_common_ones(tables, folded):
    assert (folded.alpha[0], folded.alpha[-1]) == (-30, 90)
    for name in ("C6_bas", "dC3_p", "dC3_q", "dC3_r", "dC6_w"):
        assert set(tables[name].axis("alpha")) <= set(folded.alpha)
    np.testing.assert_array_equal(folded.beta, tables["C6_bas"].axis("beta"))
    np.testing.assert_array_equal(folded.rudder_deg, [-45, -30, -10, 0, 10, 30, 45])
    np.testing.assert_array_equal(folded.aileron_deg, [-30, -20, -10, 0, 10, 20, 30])
    np.testing.assert_array_equal(folded.elevator_deg, [-30, -20, -10, 0, 10, 20])


def test_basic_lookup(tables, folded, points):
    actual = interpolator((folded.alpha, folded.beta), folded.basic)(np.stack([points["alpha"], points["beta"]], -1))
    assert_equal_lookups(actual, unfolded(tables["C6_bas"])(points["alpha"], points["beta"]))


def test_rudder_lookup_is_both_halves(tables, folded, points):
    """SPEC 5.2 as it stands: two halves, each by the mirror rule and with its own weights."""
    lookup = unfolded(tables["dC6_rud"])
    alpha, beta, d = points["alpha"], points["beta"], points["surface"]
    s = np.where(d >= 0, -1.0, 1.0)
    c = lookup(alpha, s * beta, -np.abs(d)) * np.where(MIRROR == -1, s[:, None], 1.0)
    upper, lower = np.array([0.5, 0.5, 0.5, 0.67, 0.67, 0.5]), np.array([0.5, 0.5, 0.5, 0.33, 0.33, 0.5])
    axes = (folded.alpha, folded.beta, folded.rudder_deg)
    actual = interpolator(axes, folded.rudder)(np.stack([alpha, beta, d], -1))
    assert_equal_lookups(actual, upper * c + lower * c)


def test_aileron_lookup_is_right_and_left(tables, folded, points):
    """SPEC 5.3 with AILL = -a, AILR = +a (SPEC 4)."""
    lookup = unfolded(tables["dC6_ail"])
    alpha, beta, a = points["alpha"], points["beta"], points["surface"]
    expected = lookup(alpha, beta, a) + MIRROR * lookup(alpha, -beta, -a)
    axes = (folded.alpha, folded.beta, folded.aileron_deg)
    assert_equal_lookups(interpolator(axes, folded.aileron)(np.stack([alpha, beta, a], -1)), expected)


def test_elevator_lookup_is_four_segments_at_zero_stabiliser(tables, folded, points):
    """SPEC 5.4: the stabiliser contribution and the four segments."""
    lookup = unfolded(tables["dC3_ele"])
    alpha, beta, e = points["alpha"], points["beta"], points["surface"]
    stabiliser = lookup(alpha, beta, 0.0, 0.0)
    expected = stabiliser + sum(0.25 * (lookup(alpha, beta, 0.0, e) - stabiliser) for _ in range(4))
    axes = (folded.alpha, folded.beta, folded.elevator_deg)
    assert_equal_lookups(interpolator(axes, folded.elevator)(np.stack([alpha, beta, e], -1)), expected)


@pytest.mark.parametrize("rate", ["p", "q", "r"])
def test_rate_lookup(tables, folded, points, rate):
    table = tables[f"dC3_{rate}"]
    alpha, hat = points["alpha"], points["rate"] * table.axis(f"{rate}hat").max()
    actual = interpolator((folded.alpha, getattr(folded, f"{rate}_hat")), getattr(folded, rate))
    assert_equal_lookups(actual(np.stack([alpha, hat], -1)), unfolded(table)(alpha, hat))


def test_rotary_lookup(tables, folded, points):
    arguments = points["alpha"], points["rate"] * 0.5, points["beta"]
    actual = interpolator((folded.alpha, folded.omega_hat, folded.beta), folded.omega)(np.stack(arguments, -1))
    assert_equal_lookups(actual, unfolded(tables["dC6_w"])(*arguments))


def test_folded_surfaces_mirror(folded):
    """A mirrored aircraft with mirrored commands has mirrored coefficients: both folded tables are their own image."""
    for values in (folded.rudder, folded.aileron):
        np.testing.assert_array_equal(values[:, ::-1, ::-1], MIRROR * values)


def test_resampling_keeps_breakpoints_and_end_slopes():
    values = resample(
        np.array([[1.0, 3.0, 4.0]]), np.array([0.0, 1.0, 3.0]), np.array([-1.0, 0.0, 2.0, 3.0, 5.0]), axis=1
    )
    np.testing.assert_array_equal(values, [[-1.0, 1.0, 3.5, 4.0, 5.0]])


@pytest.mark.parametrize(("fold", "name", "axis"), [(fold_rudder, "dC6_rud", 1), (fold_ailerons, "dC6_ail", 2)])
def test_mirror_rules_need_symmetric_axes(tables, fold, name, axis):
    axes = list(tables[name].axes)
    axes[axis] = axes[axis] + 1.0
    with pytest.raises(ValueError, match="symmetric about zero"):
        fold(replace(tables[name], axes=tuple(axes)))
