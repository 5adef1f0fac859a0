"""One instance of a native FMU by its raw C functions: every call gives back its status."""

import ctypes
from ctypes import byref, c_bool, c_double, c_int, c_int64, c_size_t, c_uint, c_void_p
from pathlib import Path

import fmpy
from fmpy.fmi2 import fmi2CallbackFunctions, fmi2CallbackLoggerTYPE, fmi2EventInfo
from fmpy.fmi3 import fmi3LogMessageCallback

OK, WARNING, DISCARD, ERROR = range(4)


def doubles(values):
    return (c_double * len(values))(*values)


def references(values):
    return (c_uint * len(values))(*values)


class Session:
    """What the versions share. `library` is the loaded FMU, `messages` its log: (status, category, text)."""

    fmi: int

    def __init__(self, folder: Path, kind: str, token: str | None = None, name: bytes | None = b"one", is_logging=True):
        self.kind = kind
        self.description = fmpy.read_model_description(folder, validate=False)
        binaries = [path for path in Path(folder, "binaries").rglob("*") if path.suffix in (".so", ".dll", ".dylib")]
        here = [path for path in binaries if path.parent.name in (fmpy.platform, fmpy.platform_tuple)]
        self.library = ctypes.CDLL(str(here[0]))
        self.names = {variable.name: variable.valueReference for variable in self.description.modelVariables}
        numbers = [v for v in self.description.modelVariables if v.start is not None and v.type != "Boolean"]
        self.starts = {variable.name: float(variable.start) for variable in numbers}
        self.messages: list[tuple[int, str, str]] = []
        given = self.description.guid if token is None else token
        self.component = c_void_p(self.instantiate(kind, given.encode(), name, is_logging))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.free()

    def free(self):
        self.call("FreeInstance")
        self.component = c_void_p(None)

    def call(self, function: str, *arguments) -> int:
        """fmi2<function> or fmi3<function> of the instance."""
        return getattr(self.library, f"fmi{self.fmi}{function}")(self.component, *arguments)

    def log(self, status, category, message):
        self.messages.append((status, category.decode(), message.decode()))

    def texts(self) -> list[str]:
        """Texts of the log, which is emptied."""
        texts = [text for _, _, text in self.messages]
        self.messages.clear()
        return texts

    def set_named(self, **values) -> int:
        """Set variables by their names, with ``__`` for a dot."""
        return self.set([self.names[name.replace("__", ".")] for name in values], list(values.values()))

    def get_named(self, *names) -> list[float]:
        status, values = self.get([self.names[name] for name in names])
        assert status == OK, self.messages
        return values

    def get_flags(self, *names) -> list[bool]:
        kind = c_int if self.fmi == 2 else c_bool
        values, n = (kind * len(names))(), c_size_t(len(names))
        counts = (n,) if self.fmi == 3 else ()
        asked = references([self.names[name] for name in names])
        assert self.call("GetBoolean", asked, n, values, *counts) == OK, self.messages
        return [bool(value) for value in values]

    def set_flag(self, name: str, value: bool) -> int:
        """Set a Boolean variable."""
        kind, n = c_int if self.fmi == 2 else c_bool, c_size_t(1)
        counts = (n,) if self.fmi == 3 else ()
        return self.call("SetBoolean", references([self.names[name]]), n, byref(kind(value)), *counts)

    def get_enumeration(self, name: str) -> tuple[int, int]:
        """Status and value of an enumeration."""
        kind, n = c_int if self.fmi == 2 else c_int64, c_size_t(1)
        value, counts = (kind * 1)(), (n,) if self.fmi == 3 else ()
        function = "GetInteger" if self.fmi == 2 else "GetInt64"
        return self.call(function, references([self.names[name]]), n, value, *counts), value[0]

    def continuous(self, function: str, values) -> tuple[int, list[float]]:
        """A function of continuous states: ContinuousStates and such."""
        buffer = doubles(values)
        return self.call(function, buffer, c_size_t(len(values))), list(buffer)

    def handle_event(self) -> bool:
        """Complete an integrator step of model exchange and do the event that it asks for; whether it did."""
        assert self.completed_step() == OK
        if self.event_flag.value:
            assert self.call("EnterEventMode") == self.update_discrete_states() == OK
            assert self.call("EnterContinuousTimeMode") == OK
        return bool(self.event_flag.value)

    def initialize(self, *, is_exited: bool = True) -> None:
        assert self.enter_initialization() == OK
        if is_exited:
            assert self.call("ExitInitializationMode") == OK


class Session2(Session):
    """FMI 2.0."""

    fmi = 2
    derivatives_function = "GetDerivatives"
    state_functions = ("GetFMUstate", "SetFMUstate", "FreeFMUstate")
    serialize_functions = ("SerializedFMUstateSize", "SerializeFMUstate", "DeSerializeFMUstate")

    def instantiate(self, kind, token, name, is_logging):
        self.library.fmi2Instantiate.restype = c_void_p
        self.callbacks = fmi2CallbackFunctions()
        self.callbacks.logger = fmi2CallbackLoggerTYPE(lambda _c, _n, *message: self.log(*message))
        return self.library.fmi2Instantiate(
            name, c_int(kind == "cs"), token, b"file:///nowhere", byref(self.callbacks), 0, c_int(is_logging)
        )

    def enter_initialization(self, start=0.0, stop=None):
        status = self.call("SetupExperiment", 0, c_double(0), c_double(start), stop is not None, c_double(stop or 0))
        return status or self.call("EnterInitializationMode")

    def get(self, refs):
        values = doubles([0.0] * len(refs))
        return self.call("GetReal", references(refs), c_size_t(len(refs)), values), list(values)

    def set(self, refs, values):
        return self.call("SetReal", references(refs), c_size_t(len(refs)), doubles(values))

    def step(self, time, duration):
        return self.call("DoStep", c_double(time), c_double(duration), 0)

    def directional(self, unknowns, knowns, seed):
        result = doubles([0.0] * len(unknowns))
        n, m = c_size_t(len(unknowns)), c_size_t(len(knowns))
        arguments = (references(unknowns), n, references(knowns), m, doubles(seed), result)
        return self.call("GetDirectionalDerivative", *arguments), list(result)

    def update_discrete_states(self):
        return self.call("NewDiscreteStates", byref(fmi2EventInfo()))

    def completed_step(self):
        self.event_flag = c_int()
        return self.call("CompletedIntegratorStep", 1, byref(self.event_flag), byref(c_int()))


class Session3(Session):
    """FMI 3.0."""

    fmi = 3
    derivatives_function = "GetContinuousStateDerivatives"
    state_functions = ("GetFMUState", "SetFMUState", "FreeFMUState")
    serialize_functions = ("SerializedFMUStateSize", "SerializeFMUState", "DeserializeFMUState")

    def instantiate(self, kind, token, name, is_logging):
        self.callback = fmi3LogMessageCallback(lambda _, *message: self.log(*message))
        for function in ("ModelExchange", "CoSimulation", "ScheduledExecution"):
            getattr(self.library, f"fmi3Instantiate{function}").restype = c_void_p
        head = (name, token, b"/nowhere/", c_bool(False), c_bool(is_logging))
        if kind == "me":
            return self.library.fmi3InstantiateModelExchange(*head, c_void_p(), self.callback)
        own = (c_bool(kind == "cs with events"), c_bool(False), c_void_p(), c_size_t(0), c_void_p())
        return self.library.fmi3InstantiateCoSimulation(*head, *own, self.callback, c_void_p())

    def enter_initialization(self, start=0.0, stop=None):
        times = (c_double(start), c_bool(stop is not None), c_double(stop or 0))
        return self.call("EnterInitializationMode", c_bool(False), c_double(0), *times)

    def get(self, refs):
        values, n = doubles([0.0] * len(refs)), c_size_t(len(refs))
        return self.call("GetFloat64", references(refs), n, values, n), list(values)

    def set(self, refs, values):
        n = c_size_t(len(refs))
        return self.call("SetFloat64", references(refs), n, doubles(values), n)

    def step(self, time, duration):
        flags = [byref(c_bool()) for _ in range(3)]
        self.last_time = c_double()
        return self.call("DoStep", c_double(time), c_double(duration), c_bool(False), *flags, byref(self.last_time))

    def directional(self, unknowns, knowns, seed, function="GetDirectionalDerivative"):
        size = len(unknowns) if function == "GetDirectionalDerivative" else len(knowns)
        result = doubles([0.0] * size)
        n, m = c_size_t(len(unknowns)), c_size_t(len(knowns))
        tail = (doubles(seed), c_size_t(len(seed)), result, c_size_t(size))
        return self.call(function, references(unknowns), n, references(knowns), m, *tail), list(result)

    def adjoint(self, unknowns, knowns, seed):
        return self.directional(unknowns, knowns, seed, "GetAdjointDerivative")

    def update_discrete_states(self):
        return self.call("UpdateDiscreteStates", *(byref(c_bool()) for _ in range(5)), byref(c_double()))

    def completed_step(self):
        self.event_flag = c_bool()
        return self.call("CompletedIntegratorStep", c_bool(True), byref(self.event_flag), byref(c_bool()))


SESSIONS = {2: Session2, 3: Session3}
