"""Answers of the core about manoeuvres: trims of the solver, margins by hand, verdicts of the exact linear models."""

import ctypes

import numpy as np
import pytest

from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.airframe.names import BETA, OUTPUTS, PSI_DOT, RUDDER, V
from gtm_fmu.core import motion, query, solver
from gtm_fmu.core.configuration import Configuration
from gtm_fmu.core.library import library
from gtm_fmu.trims import manoeuvre
from gtm_fmu.trims.linearization import linearize
from gtm_fmu.trims.manoeuvre import Trim
from gtm_fmu.units import DEG_PER_RAD

THRUSTS = [OUTPUTS.index(name) for name in ("thrust_left", "thrust_right")]

FAILURES = {
    "jam": Failure(ControlLimits(rudder_deg=(5, 5))),
    "jam on a breakpoint": Failure(ControlLimits(rudder_deg=(10, 10))),
    "range": Failure(ControlLimits(rudder_deg=(-10, 5))),
    "healthy": Failure(),
    "damage and a jammed elevator": Failure(ControlLimits(elevator_deg=(1, 1)), Configuration(damage_case=3)),
    "left engine out": Failure(ControlLimits(), Configuration(engine_running=(False, True))),
    "throttles apart": Failure(throttle_left_pct=(0, 60)),
}


def asked(failure: Failure, count: int, seed: int, straight: bool = False):
    """Altitude, gamma and bounds that hold random speeds and turn rates."""
    rng = np.random.default_rng(seed)
    lower, upper = (np.tile(bound, (count, 1)) for bound in manoeuvre.bounds(failure))
    lower[:, V] = upper[:, V] = rng.uniform(110, 260, count)
    lower[:, PSI_DOT] = upper[:, PSI_DOT] = 0.0 if straight else rng.uniform(-0.2, 0.2, count)
    return rng.uniform(0, 15000, count), rng.uniform(-0.05, 0.05, count), lower, upper


def test_the_layout_is_that_of_the_core():
    size = library().gtm_answer_size
    size.restype = ctypes.c_long
    assert size() == query.ANSWER.itemsize


@pytest.mark.parametrize("straight", [True, False], ids=["straight", "turning"])
@pytest.mark.parametrize("name", FAILURES)
def test_verdicts_are_those_of_the_linear_model(name, straight):
    """Eigenvalues and singular values of LAPACK, on every side of the breakpoints."""
    failure = FAILURES[name]
    altitude, gamma, lower, upper = asked(failure, 60, 1, straight)
    answers = query.query(altitude, gamma, lower, upper, failure.airframe)
    feasible = np.flatnonzero(answers["status"] == solver.TRIMMED)
    assert len(feasible) > 3
    for k in feasible:
        y = answers["y"][k][: len(failure.airframe.unknowns)]
        model = linearize(Trim.of_unknowns(y, altitude[k], gamma[k] * DEG_PER_RAD, True, (), failure))
        assert (model.stable, model.controllable) == (answers["stable"][k], answers["controllable"][k])


@pytest.mark.parametrize("name", FAILURES)
def test_margins_are_distances_to_the_limits(name):
    failure = FAILURES[name]
    altitude, gamma, lower, upper = asked(failure, 100, 2)
    answers = query.query(altitude, gamma, lower, upper, failure.airframe)
    found = solver.trims(altitude, gamma, lower, upper, failure.airframe)
    unknowns = len(failure.airframe.unknowns)
    scale = solver.scale(failure.airframe)
    np.testing.assert_array_equal(answers["status"], found.status)
    for answer, y, low, high in zip(answers, found.y, lower, upper, strict=True):
        if answer["status"] == solver.NO_TRIM:
            assert answer["binding"] == -1
            assert not answer["margin"].any()
            continue
        np.testing.assert_allclose(answer["y"][:unknowns], y, rtol=1e-12)
        expected = np.stack([y - low, high - y], axis=1)
        np.testing.assert_allclose(answer["margin"][:unknowns], expected, rtol=0, atol=1e-12 * scale.max())
        is_met = (low == high) & (np.abs(y - low) <= 1e-9 * scale)
        scaled = np.where(is_met[:, None], np.inf, expected / scale[:, None])
        assert answer["least_margin"] == pytest.approx(scaled.min(), rel=1e-9, abs=1e-12)
        assert scaled[answer["binding"], answer["side"]] == pytest.approx(scaled.min(), rel=1e-9, abs=1e-12)
        assert (answer["least_margin"] >= -1e-7) == (answer["status"] == solver.TRIMMED)


def test_thrust_is_that_of_the_outputs():
    """Of the whole airframe at the trim, and with its throttle at its limits."""
    failure = FAILURES["jam"]
    altitude, gamma, lower, upper = asked(failure, 50, 3)
    answers = query.query(altitude, gamma, lower, upper, failure.airframe)
    for k in np.flatnonzero(answers["status"] == solver.TRIMMED):
        x, u = solver.trim_states(altitude[k], gamma[k], answers["y"][k, :9])
        controls = np.tile(u, (3, 1))
        controls[1:, 3] = 0, 100
        now, least, most = motion.outputs(np.tile(x, (3, 1)), controls)[:, THRUSTS].sum(axis=1)
        assert answers["thrust"][k] == pytest.approx(now, rel=1e-12)
        np.testing.assert_allclose(answers["thrust_margin"][k], [now - least, most - now], rtol=1e-9, atol=1e-9)


def test_an_engine_that_is_out_has_no_thrust():
    both = query.query(*asked(FAILURES["healthy"], 5, 4), FAILURES["healthy"].airframe)
    failure = Failure(configuration=Configuration(engine_running=(False, False)))
    altitude, gamma, lower, upper = asked(failure, 400, 5, straight=True)
    glides = query.query(altitude, gamma - 0.12, lower, upper, failure.airframe)
    assert both["thrust_margin"][:, 1].min() > 0
    assert (glides["status"] != solver.NO_TRIM).any()
    assert not glides["thrust"].any()
    assert not glides["thrust_margin"].any()


@pytest.mark.parametrize(
    "limits",
    [
        ControlLimits(rudder_deg=(-10, 5)),
        ControlLimits(rudder_deg=(12, 20)),
        ControlLimits(aileron_deg=(3, 5)),
        ControlLimits(rudder_deg=(-15, 10), throttle_pct=(30, 60)),
        ControlLimits(elevator_deg=(0, 3)),
    ],
    ids=str,
)
def test_a_manoeuvre_is_feasible_if_any_deflection_is(limits):
    """Every quarter of a degree of the rudder, each a jam: none is missed, none has less sideslip."""
    failure = Failure(limits)
    altitude, gamma, lower, upper = asked(failure, 60, 6)
    answers = query.query(altitude, gamma, lower, upper)
    feasible = answers["status"] == solver.TRIMMED
    deflections = np.linspace(*limits.rudder_deg, int(4 * np.ptp(limits.rudder_deg)) + 1)
    count = len(deflections)
    jam = [np.repeat(values, count, axis=0) for values in (altitude, gamma, lower, upper)]
    jam[2][:, RUDDER] = jam[3][:, RUDDER] = np.tile(deflections, len(altitude))
    found = solver.trims(*jam)
    trimmed = (found.status == solver.TRIMMED).reshape(-1, count)
    assert 5 < trimmed.any(axis=1).sum() < 60
    assert not np.any(trimmed.any(axis=1) & ~feasible)
    sideslip = np.where(trimmed, np.abs(found.y[:, BETA]).reshape(-1, count), np.inf).min(axis=1)
    assert np.all(np.abs(answers["y"][feasible, BETA]) <= sideslip[feasible] + 1e-9)
