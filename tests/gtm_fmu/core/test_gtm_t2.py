"""The GTM-T2 as it is handed to the solver: what its constants promise of its own tables and bounds."""

import numpy as np
import pytest

from gtm_fmu.aircraft.ranges import WIDEST
from gtm_fmu.airframe.lookup_axes import lookup_axes
from gtm_fmu.airframe.names import RUDDER, TRIM_UNKNOWNS, TWO_THROTTLE_UNKNOWNS, V
from gtm_fmu.core import solver
from gtm_fmu.core.configuration import Configuration
from gtm_fmu.core.library import library_path


def test_breakpoints_of_the_rudder_lie_between_its_pieces():
    """Optima lie on either side of them, so each piece is searched on its own."""
    borders = {end for piece in solver.rudder_pieces(*WIDEST["rudder_deg"]) for end in piece}
    breakpoints = lookup_axes().rudder_deg
    inside = breakpoints[(breakpoints > WIDEST["rudder_deg"][0]) & (breakpoints < WIDEST["rudder_deg"][1])]
    assert len(inside) > 2
    assert set(inside.tolist()) <= borders


@pytest.mark.parametrize("axis", ["elevator_deg", "aileron_deg", "rudder_deg"])
def test_breakpoints_are_those_of_the_tables(axis):
    """The inner ones: beyond the ends tables go on with the slope of the last interval (SPEC 1)."""
    unknown = TRIM_UNKNOWNS.index(axis.removesuffix("_deg"))
    points = getattr(lookup_axes(), axis)
    candidates = np.concatenate([points, 0.5 * (points[:-1] + points[1:])])
    y = np.tile(np.ones(len(TRIM_UNKNOWNS)), (len(candidates), 1))
    y[:, unknown] = candidates
    is_on = solver.on_breakpoints(y)[:, unknown]
    np.testing.assert_array_equal(is_on, np.isin(candidates, points[1:-1]))


def test_order_of_the_unknowns_in_c_is_that_of_the_names():
    """The header that the solver and native FMUs include."""
    header = (library_path().parent / "generated" / "unknowns.h").read_text()
    listed = header.split("enum {")[1].split("}")[0].split(",")
    names = [name.strip().lower() for name in listed]
    assert names == [*(name.lower() for name in TRIM_UNKNOWNS), "throttle_right"]
    assert (names[V], names[RUDDER]) == ("v", "rudder")
    assert (*TRIM_UNKNOWNS[:-1], "throttle_left", "throttle_right") == TWO_THROTTLE_UNKNOWNS


def test_the_number_of_throttles_is_said_not_guessed():
    """An array of another width is refused, whatever it could mean."""
    two = solver.Airframe(Configuration(), solver.TWO_THROTTLES)
    nine, ten = np.zeros(9), np.zeros(10)
    with pytest.raises(ValueError, match="must have length 10"):
        solver.envelope_end(0.0, 0.0, nine, nine, nine, two)
    with pytest.raises(ValueError, match="must have length 9"):
        solver.envelope_end(0.0, 0.0, ten, ten, ten)
    assert len(solver.scale()) == 9
    assert len(solver.scale(two)) == 10
    np.testing.assert_array_equal(solver.with_both_throttles(np.arange(9.0)), [*range(9), 8])
