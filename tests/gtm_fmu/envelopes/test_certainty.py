"""V_min and V_max of random failures of any control against dense scans (the campaign: benchmarks/certainty.py)."""

import numpy as np
import pytest

from gtm_fmu.aircraft.limits import ControlLimits
from tests.reference.dense_scan import Case, Steps, errors, random_case

NEAR, FAR = Steps(1, 1, 2.5), Steps(4, 3, 5)


@pytest.mark.parametrize("seed", range(1, 6))
def test_random_failures(seed):
    rng = np.random.default_rng(seed)
    feasible = 0
    for _ in range(5):
        case = random_case(rng)
        found = case.envelope()
        feasible += found.feasible
        assert not errors(case, found, NEAR, FAR), case
    assert feasible


def test_the_scan_sees_errors():
    """It finds trims beyond an end that is not the last one, misses no envelope, and refuses an end that is no trim."""
    case = Case(8000.0, 0.5, ControlLimits(rudder_deg=(-4.0, 9.0)))
    narrower = Case(case.altitude_ft, case.gamma_deg, ControlLimits(rudder_deg=(2.0, 9.0), throttle_pct=(0.0, 60.0)))
    assert not errors(case, case.envelope(), NEAR, FAR)
    assert any("beyond" in error for error in errors(case, narrower.envelope(), NEAR, FAR))
    assert any("no trim" in error for error in errors(narrower, case.envelope(), NEAR, FAR))
    hopeless = Case(30000.0, 5.0, ControlLimits(rudder_deg=(30.0, 30.0))).envelope()
    assert any("missed" in error for error in errors(case, hopeless, NEAR, FAR))
