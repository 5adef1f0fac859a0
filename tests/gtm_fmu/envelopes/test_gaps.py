"""Gaps in the speeds of an envelope: near the ceiling the thrust required has humps over speed."""

import numpy as np
import pytest

from gtm_fmu.core import solver
from gtm_fmu.envelopes.envelope import FlightCondition
from gtm_fmu.units import FT_S_PER_KT, RAD_PER_DEG

GAPPED = [(30000.0, 1.0, 0.0), (27000.0, 2.5, 2.1), (28000.0, 2.25, 10.0)]


def any_trim(condition: FlightCondition, tas_kt: float, rudder_deg: float) -> bool:
    """Whether one of the cold trims at 0.25 deg of bank lies inside every bound."""
    banks = np.arange(-30.0, 30.01, 0.25) * RAD_PER_DEG
    held = np.column_stack([np.full(banks.size, tas_kt * FT_S_PER_KT), banks, np.full(banks.size, rudder_deg)])
    y = solver.cold_starts(condition.altitude_ft, condition.gamma_deg * RAD_PER_DEG, held)
    lower, upper = condition.bounds
    return bool(((y >= lower - 1e-9) & (y <= upper + 1e-9)).all(axis=1).any())


@pytest.mark.parametrize(("altitude_ft", "gamma_deg", "rudder_deg"), GAPPED)
def test_gap_is_found_where_a_scan_finds_no_trim(altitude_ft, gamma_deg, rudder_deg):
    condition = FlightCondition(altitude_ft, gamma_deg)
    intervals = condition.intervals((rudder_deg, rudder_deg))
    assert len(intervals) == 2
    (low, gap_start), (gap_end, high) = intervals
    whole = condition.envelope((rudder_deg, rudder_deg))
    assert (low, high) == (whole.v_min_kt, whole.v_max_kt)  # the outer ends, as the paper defines them
    for share in (0.1, 0.5, 0.9):
        assert not any_trim(condition, gap_start + share * (gap_end - gap_start), rudder_deg)
        assert any_trim(condition, low + share * (gap_start - low), rudder_deg)
        assert any_trim(condition, gap_end + share * (high - gap_end), rudder_deg)


def test_gap_ends_are_exact():
    condition = FlightCondition(*GAPPED[0][:2])
    (_, gap_start), (gap_end, _) = condition.intervals((0.0, 0.0))
    banks = np.arange(-2.0, 2.0, 0.25)  # the least thrust is near wings level without a failure

    def least_throttle(tas_kt: float) -> float:
        held = np.column_stack([np.full(banks.size, tas_kt * FT_S_PER_KT), banks * RAD_PER_DEG, np.zeros(banks.size)])
        y = solver.cold_starts(condition.altitude_ft, condition.gamma_deg * RAD_PER_DEG, held)
        return float(y[:, -1].min())

    for edge, outward in ((gap_start, -1), (gap_end, 1)):
        assert least_throttle(edge + 0.1 * outward) < 100.0 < least_throttle(edge - 0.1 * outward)


def test_ordinary_envelope_has_one_interval_and_an_empty_one_none():
    condition = FlightCondition(10000.0, 0.0)
    whole = condition.envelope((-10.0, 20.0))
    assert condition.intervals((-10.0, 20.0)) == ((whole.v_min_kt, whole.v_max_kt),)
    assert FlightCondition(30000.0, 5.0).intervals((30.0, 30.0)) == ()
