"""Extremes against dense grids of trims and against each other."""

import numpy as np
import pytest

from gtm_fmu import ControlLimits, Failure, envelope, performance
from gtm_fmu.airframe.names import PSI_DOT, V
from gtm_fmu.core import solver
from gtm_fmu.core.configuration import Configuration
from gtm_fmu.trims import manoeuvre

pytestmark = pytest.mark.slow

ALTITUDE_FT = 10000.0
JAM = Failure(ControlLimits(rudder_deg=(10, 10)))
FT_S_PER_KT = 1 / 0.592487


@pytest.fixture(scope="module")
def jam():
    return performance(ALTITUDE_FT, JAM)


def grid(gamma_deg: float, failure: Failure = JAM) -> np.ndarray:
    """Feasible trims (n, 9) at speeds every 2 ft/s and turn rates every 0.25 deg/s."""
    speed, rate = np.meshgrid(np.arange(105, 280, 2.0), np.radians(np.arange(-13, 8, 0.25)))
    n = speed.size
    lower, upper = (np.tile(bound, (n, 1)) for bound in manoeuvre.bounds(failure))
    lower[:, V] = upper[:, V] = speed.ravel()
    lower[:, PSI_DOT] = upper[:, PSI_DOT] = rate.ravel()
    found = solver.trims(np.full(n, ALTITUDE_FT), np.full(n, np.radians(gamma_deg)), lower, upper, failure.airframe)
    return found.y[found.status == solver.TRIMMED]


def test_speeds_and_turns_bound_a_dense_grid(jam):
    level = grid(0)
    radius = level[:, V] / np.abs(level[:, PSI_DOT]).clip(1e-9)
    rate = np.degrees(level[:, PSI_DOT])
    assert jam["turn_rate_left_deg_s"].value <= rate.min() <= jam["turn_rate_left_deg_s"].value + 0.5
    assert jam["turn_rate_right_deg_s"].value >= rate.max() >= jam["turn_rate_right_deg_s"].value - 0.5
    for side, word in ((-1, "left"), (1, "right")):
        least = radius[side * rate > 0].min()
        assert jam[f"turn_radius_{word}_ft"].value <= least <= 1.08 * jam[f"turn_radius_{word}_ft"].value
    whole = envelope(ALTITUDE_FT, 0, JAM)
    assert jam["v_min_kt"].value == pytest.approx(whole.v_min_kt, abs=1e-6)
    assert jam["v_max_kt"].value == pytest.approx(whole.v_max_kt, abs=1e-6)


def test_a_radius_is_that_of_its_turn(jam):
    for word in ("left", "right"):
        extreme = jam[f"turn_radius_{word}_ft"]
        turn = abs(np.radians(extreme.trim.turn_rate_deg_s))
        assert extreme.value == pytest.approx(extreme.trim.tas_kt * FT_S_PER_KT / turn, rel=1e-9)


def test_climbs_bound_dense_grids(jam):
    steepest, fastest = jam["steepest_climb_deg"].value, jam["fastest_climb_ft_min"].value
    assert not len(grid(steepest + 0.05))
    assert envelope(ALTITUDE_FT, steepest - 1e-3, JAM).feasible
    assert not envelope(ALTITUDE_FT, steepest + 1e-3, JAM).feasible
    rates = [60 * envelope(ALTITUDE_FT, gamma, JAM).v_max_kt * FT_S_PER_KT * np.sin(np.radians(gamma))
             for gamma in np.arange(9, 13.7, 0.2)]  # fmt: skip
    assert max(rates) <= fastest + 1e-6 <= 1.002 * max(rates)


def test_glides_need_no_thrust_and_bound_the_envelope_at_idle(jam):
    idle = ControlLimits(rudder_deg=(10, 10), throttle_pct=(0, 0))
    flattest, sink = jam["flattest_glide_deg"].value, jam["least_sink_ft_min"].value
    assert envelope(ALTITUDE_FT, flattest - 1e-3, idle).feasible
    assert not envelope(ALTITUDE_FT, flattest + 1e-3, idle).feasible
    sinks = [-60 * found.v_min_kt * FT_S_PER_KT * np.sin(np.radians(gamma))
             for gamma in np.arange(flattest, -9, -0.2)
             if (found := envelope(ALTITUDE_FT, float(gamma), idle)).feasible]  # fmt: skip
    assert min(sinks) >= sink - 1e-6
    gamma = jam["least_sink_ft_min"].trim.gamma_deg
    there = -60 * envelope(ALTITUDE_FT, gamma, idle).v_min_kt * FT_S_PER_KT * np.sin(np.radians(gamma))
    assert sink == pytest.approx(there, rel=1e-9)
    for name in ("flattest_glide_engines_out_deg", "least_sink_engines_out_ft_min"):
        assert jam[name].trim.failure.configuration.engine_running == (False, False)


def test_without_thrust_nothing_climbs():
    found = performance(ALTITUDE_FT, Failure(JAM.limits, Configuration(engine_running=(False, False))))
    assert found.straight_tas_kt == ()
    assert found["v_min_kt"].value is None
    assert found["fastest_climb_ft_min"].value is None
    assert found["steepest_climb_deg"].value == pytest.approx(found["flattest_glide_deg"].value, abs=1e-4)
    assert found.to_dict()["straight_flight"] is False
