"""Discrete outputs in model exchange change at events only, and the FMU asks for the events."""

import math
from pathlib import Path

import fmpy
import numpy as np
import pytest

from tests.fmu_src.native_session import OK, SESSIONS

pytestmark = pytest.mark.slow

EDGE = math.radians(5)  # of the flight paths that the thrust map and the networks know, docs/fmus.md
STEEP = 0.6  # rad, 34 deg: outside, and no throttle holds such a climb
MODELS = ("thrust-map", "surrogate", "envelope")


@pytest.fixture(scope="module")
def fmus(thrust_map_fmus, native_surrogates, envelope_fmus) -> dict:
    return {"thrust-map": thrust_map_fmus, "surrogate": native_surrogates, "envelope": envelope_fmus}


def test_call_by_call(fmi, fmus, tmp_path):
    folder = Path(fmpy.extract(fmus["thrust-map"][fmi], tmp_path))
    with SESSIONS[fmi](folder, "me") as session:
        session.initialize()
        session.set_named(gamma=0.0)
        assert session.call("EnterContinuousTimeMode") == OK
        assert session.get_flags("in_domain") == [True]
        assert not session.handle_event()
        session.set_named(gamma=STEEP)
        speeds = session.get_named("v_min", "v_max")
        assert session.get_flags("in_domain") == [True]
        assert session.handle_event()
        assert session.get_flags("in_domain") == [False]
        assert session.get_named("v_min", "v_max") == speeds
        assert not session.handle_event()
        session.set_named(gamma=0.0)
        session.set_named(gamma=STEEP)
        assert not session.handle_event()


def test_before_anything_is_read(fmi, fmus, tmp_path):
    """The Booleans of the first Continuous-Time Mode are those of the event before, also when nobody asked then."""
    folder = Path(fmpy.extract(fmus["thrust-map"][fmi], tmp_path))
    with SESSIONS[fmi](folder, "me") as session:
        session.initialize()
        assert session.call("EnterContinuousTimeMode") == OK
        session.set_named(gamma=STEEP)
        assert session.call("Terminate") == OK
        assert session.get_flags("in_domain") == [True]


@pytest.mark.parametrize("model", MODELS)
def test_fmpy(fmi, model, fmus):
    """The flight path climbs across the borders in a second; each sample holds what belongs to its inputs."""
    path = fmus[model][fmi]
    signals = np.array([(0.0, 0.0), (1.0, STEEP)], dtype=[("time", float), ("gamma", float)])
    output = ["gamma", "feasible", "in_domain", "v_max"]
    jam = {"rudder.lower": 0.0, "rudder.upper": 0.0}
    result = fmpy.simulate_fmu(
        path,
        fmi_type="ModelExchange",
        start_values=jam,
        input=signals,
        output=output,
        stop_time=1.0,
        output_interval=0.05,
    )
    last = np.append(np.diff(result["time"]) > 0, True)  # of a time: after the event
    result = result[last]
    assert len(result) == 21
    flag, expected = (
        ("feasible", result["v_max"] > 0) if model == "envelope" else ("in_domain", result["gamma"] <= EDGE)
    )
    assert set(expected.tolist()) == {False, True}
    np.testing.assert_array_equal(result[flag], expected)
    assert fmpy.read_model_description(path).modelExchange.needsCompletedIntegratorStep
