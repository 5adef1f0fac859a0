"""Envelopes followed over random walks, and from few starts, against the search from many starts in every piece."""

import time

import numpy as np
import pytest

from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.airframe.names import V
from gtm_fmu.core import solver
from gtm_fmu.core.followed import FollowedEnvelope
from gtm_fmu.trims import manoeuvre
from gtm_fmu.units import FT_S_PER_KT, RAD_PER_DEG
from tests.reference.random_walks import UNDAMAGED, WIDE, walk

TOLERANCE_FT_S = 0.01 * FT_S_PER_KT
pytestmark = pytest.mark.slow


def thorough(case: np.ndarray) -> np.ndarray:
    """Speeds of both ends in ft/s, zero where there is no envelope."""
    lower, upper = manoeuvre.bounds(ControlLimits(rudder_deg=tuple(case[2:])))
    objective = np.eye(solver.NT)[V]
    ends = [solver.envelope_end(*case[:2], lower, upper, sign * objective, is_thorough=True) for sign in (1, -1)]
    return np.array([end.y[V] if end.status == solver.TRIMMED else 0.0 for end in ends])


@pytest.fixture
def followed():
    return FollowedEnvelope(*WIDE)


def test_sought_from_few_starts(followed):
    """Neither end falls short of the thorough search's by more than the tolerance."""
    rng = np.random.default_rng(8)
    for _ in range(40):
        case = np.array([rng.uniform(0, 33000), rng.uniform(-5, 5) * RAD_PER_DEG, *np.sort(rng.uniform(-30, 30, 2))])
        slowest, fastest = thorough(case)
        found = followed.ends(case, UNDAMAGED, is_followed=False)[:, V]
        assert (found[0] > 0) == (slowest > 0)
        assert found[0] <= slowest + TOLERANCE_FT_S, case
        assert found[1] >= fastest - TOLERANCE_FT_S, case


def test_walks_with_jumps(followed):
    """What is followed is what is sought."""
    for case in walk(np.random.default_rng(3), 200, jumps=0.02):
        got = followed.ends(case, UNDAMAGED)[:, V]
        np.testing.assert_allclose(got, followed.ends(case, UNDAMAGED, is_followed=False)[:, V], atol=TOLERANCE_FT_S)


def test_following_takes_less_than_half(followed):
    """Of the processor time of searches, over 30 questions that differ little."""
    cases = list(walk(np.random.default_rng(5), 30, jumps=0, size=0.1))
    seconds = []
    for is_followed in (True, False):
        began = time.process_time()
        for case in cases:
            followed.ends(case, UNDAMAGED, is_followed)
        seconds.append(time.process_time() - began)
    assert seconds[0] < 0.5 * seconds[1]


def test_another_failure_is_sought(followed):
    """Engines out are no small change."""
    case, glide = np.array([10000.0, -5 * RAD_PER_DEG, -10.0, 20.0]), np.array(UNDAMAGED)
    followed.ends(case, UNDAMAGED)
    glide[18] = 0.0  # the left engine stands
    got = followed.ends(case, glide)
    assert got.tobytes() == FollowedEnvelope(*WIDE).ends(case, glide).tobytes()
