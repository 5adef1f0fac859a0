"""Start values and the parameters start.*, which give states their initial values, in native FMUs of both standards."""

import math

import pytest

from tests.fmu_src.native_session import DISCARD, ERROR, OK

pytestmark = pytest.mark.slow


def test_start_values_in_instantiated(start, fmi):
    """FMI 3.0, 2.3.2, table of the state Instantiated: "Get variable start values"; FMI 2.0 forbids the call."""
    session = start(is_initialized=False)
    names = list(session.starts)
    if fmi == 2:
        assert session.get([session.names[name] for name in names])[0] == ERROR
        return
    assert session.get_named(*names) == [session.starts[name] for name in names]
    assert session.set_named(control__rudder=0.1) == OK
    assert session.get_named("control.rudder") == [0.1]
    assert session.get([session.names["air.tas"]])[0] == ERROR
    assert session.texts() == ["air.tas has no start value: it is computed from Initialization Mode on."]
    assert session.enter_initialization() == OK
    assert session.get_named("air.tas") == [pytest.approx(164.14225 * 0.3048)]


class TestStartParameters:
    """start.* give the states their initial values in importers that set nothing but parameters."""

    def test_changed_one_sets_its_state(self, start):
        session = start(is_initialized=False)
        assert session.set_named(start__altitude=3000.0) == OK
        assert session.enter_initialization() == OK
        assert session.get_named("state.altitude", "start.altitude") == [3000.0, 3000.0]
        assert session.set_named(start__altitude=2000.0) == OK
        assert session.call("ExitInitializationMode") == OK
        assert session.get_named("state.altitude") == [2000.0]
        assert session.set_named(start__altitude=1000.0) == ERROR
        assert session.texts() == ["start.altitude cannot be set in the present mode."]

    def test_unchanged_one_leaves_its_state(self, start):
        """Importers that set every parameter to its start value do not undo a state that was set itself."""
        session = start(is_initialized=False)
        assert session.set_named(state__altitude=3000.0) == OK
        assert session.set_named(start__altitude=session.starts["start.altitude"]) == OK
        session.initialize()
        assert session.get_named("state.altitude") == [3000.0]

    def test_refused_one_leaves_its_state(self, start):
        session = start(is_initialized=False)
        assert session.set_named(start__altitude=math.inf) == DISCARD
        assert session.set_named(start__altitude=session.starts["start.altitude"]) == OK
        session.initialize()
        assert session.get_named("state.altitude", "air.tas") == [243.84, pytest.approx(164.14225 * 0.3048)]

    def test_partial_derivatives(self, start):
        """Those of the state while it is initialized, zero afterwards, when the parameter is fixed."""
        session = start(is_initialized=False)
        session.initialize(is_exited=False)
        unknown, known, state = (session.names[name] for name in ("der(state.u)", "start.w", "state.w"))
        assert session.directional([unknown], [known], [1.0]) == session.directional([unknown], [state], [1.0])
        assert session.directional([unknown], [state], [1.0])[1] != [0.0]
        assert session.call("ExitInitializationMode") == OK
        assert session.directional([unknown], [known], [1.0]) == (OK, [0.0])
