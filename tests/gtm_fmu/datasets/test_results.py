"""The columns of a data set beside the envelopes that they are made of."""

import numpy as np
import pytest

from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.airframe.provenance import provenance
from gtm_fmu.datasets import results
from gtm_fmu.envelopes.envelope import envelope
from gtm_fmu.errors import InputError
from tests.gtm_fmu.datasets.rudder_store import TABLE


@pytest.fixture(scope="module")
def found() -> dict[str, np.ndarray]:
    return results.evaluate(TABLE.rows(0, 6))


def test_columns_are_the_envelopes(found):
    assert found["feasible"].tolist() == [True] * 5 + [False]
    for k in range(6):
        deflection = TABLE.rows(k, k + 1)[0, 6]
        exact = envelope(20000.0, 0.0, ControlLimits(rudder_deg=(deflection, deflection)))
        assert found["t_min"][k] == exact.t_min_pct
        if not exact.feasible:
            continue
        assert (found["v_min"][k], found["v_max"][k]) == (exact.v_min_kt, exact.v_max_kt)
        for end, trim in (("v_min", exact.at_v_min), ("v_max", exact.at_v_max)):
            assert found[f"phi_at_{end}"][k] == trim.phi_deg
            assert found[f"throttle_at_{end}"][k] == trim.throttle_pct
            assert found[f"turn_rate_at_{end}"][k] == trim.turn_rate_deg_s
            assert results.limit_names(int(found[f"limits_at_{end}"][k])) == trim.limits_hit


def test_without_envelope(found):
    assert found["t_min"][5] > 100
    assert np.isnan([found[name][5] for name in ("v_min", "v_max", "beta_at_v_min", "rudder_at_v_max")]).all()
    assert found["limits_at_v_min"][5] == found["limits_at_v_max"][5] == 0


def test_every_control_counts():
    case = [10000.0, 0.0, -2.0, 2.0, -3.0, 20.0, -5.0, 5.0, 20.0, 90.0]
    exact = envelope(10000.0, 0.0, ControlLimits((-2, 2), (-3, 20), (-5, 5), (20, 90)))
    columns = results.evaluate(np.array([case]))
    assert (columns["v_min"][0], columns["v_max"][0]) == (exact.v_min_kt, exact.v_max_kt)
    assert exact.at_v_max.limits_hit != ()


def test_another_version_asks():
    other = {**provenance(), "gtm_fmu_version": "9.9"}
    with pytest.raises(InputError, match=r"differ from those of 9\.9 here; install the same on every worker"):
        results.evaluate(TABLE.rows(0, 1), asked_by=other)
