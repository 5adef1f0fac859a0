"""Sections of the envelope against dense rows of trims."""

import ctypes

import numpy as np
import pytest

from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.airframe.names import PSI_DOT, V
from gtm_fmu.core import sections, solver
from gtm_fmu.core.configuration import Configuration
from gtm_fmu.core.library import library
from gtm_fmu.trims import manoeuvre

FAILURES = {
    "jam": Failure(ControlLimits(rudder_deg=(-18, -18))),
    "range": Failure(ControlLimits(rudder_deg=(-10, 5))),
    "damage": Failure(ControlLimits(rudder_deg=(4, 4)), Configuration(damage_case=3)),
}
WITHIN = {sections.TURN_RATES: (-1.5, 1.5), sections.SPEEDS: (40.0, 590.0), sections.CLIMBS: (-0.78, 0.78)}
DENSE = {sections.TURN_RATES: (-0.5, 0.5), sections.SPEEDS: (90.0, 400.0), sections.CLIMBS: (-0.4, 0.4)}
RESOLUTION = {sections.TURN_RATES: 1e-6, sections.SPEEDS: 3e-4, sections.CLIMBS: 5e-7}


def test_the_layout_is_that_of_the_core():
    size = library().gtm_intervals_size
    size.restype = ctypes.c_long
    assert size() == sections.INTERVALS.itemsize


@pytest.mark.parametrize("kind", WITHIN)
@pytest.mark.parametrize("name", FAILURES)
def test_intervals_are_those_of_a_dense_row(name, kind):
    """Each of 300 trims along the section lies in an interval if and only if it is feasible."""
    failure, rng, found_some = FAILURES[name], np.random.default_rng(3), 0
    for _ in range(3):
        altitude, gamma, speed, rate = rng.uniform((0, -0.08, 115, -0.14), (15000, 0.05, 240, 0.14))
        lower, upper = manoeuvre.bounds(failure)
        if kind != sections.SPEEDS:
            lower[V] = upper[V] = speed
        if kind != sections.TURN_RATES:
            lower[PSI_DOT] = upper[PSI_DOT] = rate
        found = sections.section(kind, altitude, gamma, lower, upper, WITHIN[kind], failure.airframe)
        row = np.linspace(*DENSE[kind], 300)
        lowers, uppers, gammas = np.tile(lower, (300, 1)), np.tile(upper, (300, 1)), np.full(300, gamma)
        if kind == sections.CLIMBS:
            gammas = row.copy()
        else:
            column = V if kind == sections.SPEEDS else PSI_DOT
            lowers[:, column] = uppers[:, column] = row
        feasible = solver.trims(np.full(300, altitude), gammas, lowers, uppers, failure.airframe).status == 0
        claimed = np.zeros(300, dtype=bool)
        for low, high in found.ends:
            assert low <= high
            claimed |= (low <= row) & (row <= high)
        is_end = np.abs(row[:, None] - found.ends.ravel()).min(axis=1, initial=np.inf) <= RESOLUTION[kind]
        assert not np.any((claimed != feasible) & ~is_end)
        found_some += len(found.ends)
        if kind != sections.CLIMBS:
            np.testing.assert_allclose(found.y[..., column], found.ends, rtol=1e-12, atol=1e-12)
    assert found_some


def test_nothing_is_found_where_nothing_flies():
    lower, upper = manoeuvre.bounds(Failure())
    lower[V] = upper[V] = 60.0
    assert not len(sections.section(sections.TURN_RATES, 0.0, 0.0, lower, upper, (-1.5, 1.5)).ends)
