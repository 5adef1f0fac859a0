"""The call-state machine of both standards: what is out of order is refused with a sentence and changes nothing."""

import ctypes
import math
from ctypes import byref, c_bool, c_double, c_int, c_size_t, c_void_p

import pytest

from tests.fmu_src.native_session import DISCARD, ERROR, OK, WARNING, doubles, references

pytestmark = pytest.mark.slow

VARIABLES, STATES = 66, 12
START = [50.0, 0, 2.6, 0, 0, 0, 0.66, -1.3, 243.84, 0, 0.05, 0]


CALLS = {
    "enter initialization": lambda s: s.enter_initialization(),
    "exit initialization": lambda s: s.call("ExitInitializationMode"),
    "get": lambda s: s.get([0])[0],
    "set": lambda s: s.set([24], [0.0]),
    "step": lambda s: s.step(0.0, 0.01),
    "event mode": lambda s: s.call("EnterEventMode"),
    "update": lambda s: s.update_discrete_states(),
    "continuous mode": lambda s: s.call("EnterContinuousTimeMode"),
    "completed": lambda s: s.completed_step(),
    "time": lambda s: s.call("SetTime", c_double(1.0)),
    "set states": lambda s: s.continuous("SetContinuousStates", START)[0],
    "derivatives": lambda s: s.continuous(s.derivatives_function, [0.0] * STATES)[0],
    "states": lambda s: s.continuous("GetContinuousStates", [0.0] * STATES)[0],
    "nominals": lambda s: s.continuous("GetNominalsOfContinuousStates", [0.0] * STATES)[0],
    "directional": lambda s: s.directional([12], [0], [1.0])[0],
    "terminate": lambda s: s.call("Terminate"),
    "logging": lambda s: s.call("SetDebugLogging", c_bool(True), c_size_t(0), c_void_p()),
    "reset": lambda s: s.call("Reset"),
}
READ = {"get", "directional", "logging", "reset"}
READ_STATES = READ | {"derivatives", "states", "nominals"}
READY = ("enter initialization", "exit initialization")
MODES = {
    "instantiated": ("cs", (), {"enter initialization", "set", "nominals", "logging", "reset"}),
    "initialization": ("me", READY[:1], READ_STATES | {"exit initialization", "set"}),
    "step": ("cs", READY, READ | {"set", "step", "terminate"}),
    "event": ("me", READY, READ_STATES | {"set", "update", "continuous mode", "time", "terminate"}),
    "continuous": (
        "me",
        (*READY, "continuous mode"),
        READ_STATES | {"set", "completed", "time", "set states", "event mode", "terminate"},
    ),
    "terminated": ("me", (*READY, "terminate"), READ_STATES),
}
"""Kind of instance, the way to the mode, what the standards allow there."""
ALLOWED_IN_ONE = ((2, "event", "event mode"), (3, "instantiated", "get"))
"""What only one version allows (FMI 2.0.5, 3.2.3; FMI 3.0, 2.3.2)."""


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("name", CALLS)
def test_call_in_mode(start, fmi, mode, name):
    kind, path, allowed = MODES[mode]
    session = start(kind, is_initialized=False)
    for step in path:
        assert CALLS[step](session) == OK
    is_allowed = name in allowed or (fmi, mode, name) in ALLOWED_IN_ONE
    assert CALLS[name](session) == (OK if is_allowed else ERROR)
    texts = session.texts()
    assert is_allowed == (texts == [])
    assert is_allowed or "must not be called in the state" in texts[0]


def test_refused_call_changes_nothing(start):
    session = start(is_initialized=False)
    session.initialize()
    session.step(0.0, 0.1)
    before = session.get(range(VARIABLES))[1]
    for name in ("event mode", "continuous mode", "set states", "enter initialization"):
        assert CALLS[name](session) == ERROR
    assert session.get(range(VARIABLES)) == (OK, before)
    assert session.step(0.1, 0.1) == OK


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"token": "{00000000-0000-0000-0000-000000000000}"}, "is not that of this FMU"),
        ({"token": ""}, "is not that of this FMU"),
        ({"token": "%s%n"}, "is not that of this FMU"),
        ({"name": b""}, "needs a name"),
        ({"name": None}, "needs a name"),
    ],
)
@pytest.mark.parametrize("kind", ["cs", "me"])
def test_instantiate_fails_cleanly(start, kind, arguments, sentence):
    session = start(kind, is_initialized=False, **arguments, is_logging=False)
    assert session.component.value is None
    ((status, _, text),) = session.messages
    assert status == ERROR
    assert sentence in text
    assert "%" not in text  # FMI 2.0 importers may take it for a format


def test_what_the_version_does_not_offer(start, fmi):
    if fmi == 2:
        session = start(is_initialized=False)
        assert session.library.fmi2Instantiate(b"one", 1, session.description.guid.encode(), b"", None, 0, 0) in (
            0,
            None,
        )
        session.initialize()
        assert session.call("CancelStep") == ERROR
        value = c_double()
        assert session.call("GetRealStatus", 2, byref(value)) == OK
        assert session.call("GetRealStatus", 0, byref(value)) == DISCARD
        assert session.call("GetStatus", 0, byref(c_int())) == DISCARD
        assert (
            session.call("SetRealInputDerivatives", references([24]), c_size_t(1), references([1]), doubles([1]))
            == ERROR
        )
        return
    assert start("cs with events", is_initialized=False).component.value is None
    session = start(is_initialized=False)
    session.initialize()
    for name in ("EnterConfigurationMode", "ExitConfigurationMode", "EnterStepMode", "EvaluateDiscreteStates"):
        assert session.call(name) == ERROR
    assert session.call("GetNumberOfVariableDependencies", 12, byref(c_size_t())) == ERROR
    assert session.call("GetClock", references([0]), c_size_t(1), c_void_p()) == ERROR
    assert len(session.texts()) == 6
    head = (b"one", session.description.guid.encode(), b"", c_bool(False), c_bool(True), c_void_p(), session.callback)
    assert session.library.fmi3InstantiateScheduledExecution(*head, c_void_p(), c_void_p(), c_void_p()) is None
    assert session.texts() == ["The FMU has no Scheduled Execution."]


@pytest.mark.parametrize("reference", [VARIABLES, 2**31, 2**32 - 1])
def test_unknown_value_reference(start, reference):
    session = start(is_initialized=False)
    session.initialize()
    before = session.get(range(VARIABLES))[1]
    assert session.get([0, reference])[0] == ERROR
    assert session.set([24, reference], [0.1, 0.1]) == ERROR
    assert session.directional([12], [reference], [1.0])[0] == ERROR
    assert session.directional([reference], [0], [1.0])[0] == ERROR
    texts = session.texts()
    assert len(texts) == 4
    assert all(f"no real variable with value reference {reference}" in text for text in texts)
    assert session.get(range(VARIABLES)) == (OK, before)


def test_variables_of_other_types(start, fmi):
    session = start(is_initialized=False)
    session.initialize()
    types = ("Integer", "Boolean", "String") if fmi == 2 else ("Float32", "Int8", "UInt64", "Boolean", "String")
    counts = (c_size_t(1),) if fmi == 3 else ()
    for name in types:
        for access in ("Get", "Set"):
            arguments = (references([0]), c_size_t(1), (ctypes.c_uint64 * 1)(), *counts)
            assert session.call(f"{access}{name}", *arguments) == ERROR
            assert len(session.texts()) == 1
            zero = tuple(c_size_t(0) for _ in counts)
            assert session.call(f"{access}{name}", None, c_size_t(0), None, *zero) == OK


@pytest.mark.parametrize("name", ["der(state.u)", "air.tas", "time"])
def test_computed_variables_cannot_be_set(start, name):
    session = start(is_initialized=False)
    session.initialize(is_exited=False)
    assert session.set([session.names[name]], [1.0]) == ERROR
    assert session.texts() == [f"{name} is computed by the FMU and cannot be set."]


def test_states_cannot_be_set_between_steps(start):
    session = start(is_initialized=False)
    assert session.set([0], [50.0]) == OK
    session.initialize()
    assert session.set([0], [60.0]) == ERROR
    assert session.get([0]) == (OK, [50.0])


def test_parameters_cannot_be_set_in_continuous_time(start):
    session = start("me", is_initialized=False)
    session.initialize()
    assert session.set_named(limits__rudder__upper=0.1) == OK
    session.call("EnterContinuousTimeMode")
    assert session.set_named(limits__rudder__upper=0.2) == ERROR
    assert session.set_named(control__rudder=0.05) == OK


def test_null_pointers(start, fmi):
    session = start("me", is_initialized=False)
    session.initialize()
    one, size = c_size_t(1), c_size_t(STATES)
    name, tail = ("Real", ()) if fmi == 2 else ("Float64", (one,))
    get, set_, _ = session.state_functions
    size_of, serialize, deserialize = session.serialize_functions
    assert session.call(f"Get{name}", None, one, doubles([0.0]), *tail) == ERROR
    assert session.call(f"Get{name}", references([0]), one, None, *tail) == ERROR
    assert session.call(f"Set{name}", references([24]), one, None, *tail) == ERROR
    assert session.call("GetContinuousStates", None, size) == ERROR
    assert session.call(session.derivatives_function, None, size) == ERROR
    assert session.call(get, None) == ERROR
    assert session.call(set_, None) == ERROR
    assert session.call(size_of, None, byref(c_size_t())) == ERROR
    assert session.call(serialize, None, None, one) == ERROR
    assert session.call(deserialize, None, one, byref(c_void_p())) == ERROR
    assert session.call("SetDebugLogging", c_bool(True), one, None) == ERROR
    assert len(session.texts()) == 11
    assert session.call("EnterContinuousTimeMode") == OK
    assert session.call("CompletedIntegratorStep", c_bool(True), None, None) == ERROR
    assert len(session.texts()) == 1
    session.component, kept = c_void_p(None), session.component
    for call in CALLS.values():
        assert call(session) == ERROR
    session.call("FreeInstance")
    assert session.messages == []
    session.component = kept


def test_counts(start, fmi):
    session = start("me", is_initialized=False)
    session.initialize()
    assert session.continuous("GetContinuousStates", [0.0] * 13)[0] == ERROR
    assert session.continuous("GetContinuousStates", [0.0] * 11)[0] == ERROR
    assert session.call("GetEventIndicators", None, c_size_t(0)) == OK
    assert session.call("GetEventIndicators", doubles([0.0]), c_size_t(1)) == ERROR
    if fmi == 3:
        count = c_size_t()
        assert session.call("GetNumberOfContinuousStates", byref(count)) == OK
        assert count.value == STATES
        assert session.call("GetNumberOfEventIndicators", byref(count)) == OK
        assert count.value == 0
        assert session.call("GetFloat64", references([0, 1]), c_size_t(2), doubles([0.0]), c_size_t(1)) == ERROR


class TestTime:
    def test_communication_point_and_stop_time(self, start):
        session = start(is_initialized=False)
        assert session.enter_initialization(start=5.0, stop=5.2) == OK
        session.call("ExitInitializationMode")
        assert session.step(0.0, 0.1) == ERROR
        assert session.step(5.0, 0.1) == OK
        assert session.step(5.0, 0.1) == ERROR
        assert session.step(5.1, 0.2) == ERROR
        assert session.step(5.1 + 1e-12, 0.1) == OK
        assert session.get_named("time") == [pytest.approx(5.2)]
        assert [text.split(",")[1] for text in session.texts()] == [
            " but the FMU is at 5 s.",
            " but the FMU is at 5.1 s.",
            " but the experiment stops at 5.2 s.",
        ]

    def test_times_in_messages_read_back(self, start):
        """Two times that differ look different: 0.05 s and what five steps of 0.01 s add up to."""
        session = start()
        time = 0.0
        for _ in range(6):
            assert session.step(time, 0.01) == OK
            time += 0.01
        assert session.step(0.05, 0.01) == ERROR
        late = 0.060000000001 + 1e-8
        assert session.step(late, 0.01) == ERROR
        assert session.step(time, -1e-300) == DISCARD
        assert session.texts() == [
            f"A step at 0.05 s was asked for, but the FMU is at {time!r} s.",
            f"A step at {late!r} s was asked for, but the FMU is at {time!r} s.",
            "A step of -1e-300 s was asked for, allowed is a finite one that is not negative. "
            f"The step at {time!r} s is refused.",
        ]

    @pytest.mark.parametrize("duration", [-0.1, math.nan, math.inf])
    def test_bad_step(self, start, duration):
        session = start(is_initialized=False)
        session.initialize()
        assert session.step(0.0, duration) == DISCARD
        assert "allowed is a finite one that is not negative" in session.texts()[0]
        assert session.step(0.0, 0.0) == OK

    def test_bad_times(self, start):
        session = start("me", is_initialized=False)
        assert session.enter_initialization(start=math.nan) == ERROR
        session.call("Reset")
        assert session.enter_initialization(start=1.0, stop=0.0) == ERROR
        session.call("Reset")
        session.initialize()
        assert session.call("SetTime", c_double(math.inf)) == ERROR


class TestLog:
    def switch(self, session, is_on, *categories):
        names = (ctypes.c_char_p * len(categories))(*(category.encode() for category in categories))
        return session.call("SetDebugLogging", c_bool(is_on), c_size_t(len(categories)), names)

    def statuses(self, session):
        """Of the messages of a command outside its limits and of a refused value; each is told anew."""
        session.set_named(control__rudder=0.0)
        session.step(session.time, 0.01)
        session.set_named(control__rudder=1.0)
        session.step(session.time + 0.01, 0.01)
        session.time += 0.02
        session.set_named(control__elevator=math.nan)
        session.set_named(control__elevator=0.0)
        statuses = [status for status, *_ in session.messages]
        session.messages.clear()
        return statuses

    def test_declared_categories_are_accepted(self, start):
        session = start(is_initialized=False)
        declared = [category.name for category in session.description.logCategories]
        assert "logStatusFatal" in declared
        for category in declared:
            assert self.switch(session, True, category) == OK
        assert session.texts() == []

    def test_named_categories_change(self, start, fmi):
        """In FMI 3.0 they alone change (2.3.1); in FMI 2.0 only they are told when on, and none when off (2.1.5)."""
        session = start()
        session.time = 0.0
        assert self.statuses(session) == [WARNING, DISCARD]
        self.switch(session, False, "logStatusWarning")
        assert self.statuses(session) == ([DISCARD] if fmi == 3 else [])
        self.switch(session, True, "logStatusWarning")
        assert self.statuses(session) == ([WARNING, DISCARD] if fmi == 3 else [WARNING])
        self.switch(session, False)
        assert self.statuses(session) == []
        self.switch(session, True, "logAll")
        assert self.statuses(session) == [WARNING, DISCARD]

    def test_number_sign_is_doubled(self, start):
        """# is the escape character of messages (FMI 2.0.5, 2.1.5; FMI 3.0, 2.3.1)."""
        session = start(is_initialized=False, token="{#1#}")
        assert session.component.value is None
        assert "The token {##1##} is not that" in session.texts()[0]

    @pytest.mark.parametrize("start_of_token", ["", "x"])
    def test_cut_texts_are_utf8(self, start, start_of_token):
        session = start(is_initialized=False, token=start_of_token + "\u00fc" * 300)
        assert session.texts()[0].startswith(f"The token {start_of_token}\u00fc\u00fc")

    def test_categories(self, start):
        session = start(is_initialized=False)
        assert self.switch(session, False) == OK
        assert self.switch(session, True, "logStatusDiscard") == OK
        session.initialize()
        session.set_named(control__rudder=1.0)
        assert session.step(0.0, 0.01) == OK
        assert session.texts() == []
        assert session.set_named(control__rudder=math.nan) == DISCARD
        assert [category for _, category, _ in session.messages] == ["logStatusDiscard"]
        assert self.switch(session, True, "events") == ERROR
        assert session.texts()[-1] == "There is no log category events."

    def test_only_errors_without_logging(self, start):
        session = start(is_initialized=False, is_logging=False)
        session.initialize()
        assert session.set_named(control__rudder=math.nan) == DISCARD
        assert session.messages == []
        assert CALLS["time"](session) == ERROR
        assert [status for status, *_ in session.messages] == [ERROR]

    def test_warning_has_its_category(self, start):
        session = start(is_initialized=False)
        session.initialize()
        session.set_named(control__rudder=1.0)
        session.step(0.0, 0.01)
        assert [(status, category) for status, category, _ in session.messages] == [(WARNING, "logStatusWarning")]
