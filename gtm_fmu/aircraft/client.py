"""An FMU driven by FMPy: load, set, get, evaluate state derivatives, step, simulate.

All values are in the FMU's own units, which are SI. Calls go through buffers that are made once for each set of names.
"""

import atexit
import ctypes
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import fmpy
import numpy as np
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import (
    FMU2Model,
    FMU2Slave,
    defaultCallbacks,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
    fmi2Discard,
)
from numpy.typing import ArrayLike

from gtm_fmu.aircraft.fmu_file import check_for_pythonfmu, read_description
from gtm_fmu.errors import InputError
from gtm_fmu.interrupt import held_interrupt


class FmuError(RuntimeError):
    """A call that the FMU refused; the message is the FMU's own."""


class LogMessage(NamedTuple):
    """A line of the FMU's log; status as in FMI: 0 ok, 1 warning, 2 discard, 3 error, 4 fatal."""

    status: int
    category: str
    text: str


class _Buffer:
    """Value references of some real variables and room for their values."""

    def __init__(self, references: Sequence[int]):
        self.count = len(references)
        self.references = (ctypes.c_uint * self.count)(*references)
        self.memory = (ctypes.c_double * self.count)()
        self.values = np.ctypeslib.as_array(self.memory)


class FmuClient:
    """One instance of an FMI 2.0 FMU, in Initialization Mode until the first step.

    An FMU for model exchange only evaluates derivatives too, but takes no steps. States and derivatives are those of
    the FMU's `<Derivatives>`, controls its inputs, unless they are named: an FMU with other names serves as well. Use
    it as a context manager, or call `close`: the unpacked FMU lies in a temporary folder.

    Attributes:
        states, derivatives, controls: names of the arguments and results of `evaluate`, in order.
        jacobian: exact slopes of the derivatives, a function (see `_jacobian`); None if the FMU has no directional
            derivatives.
        messages: the FMU's log so far.
        time_s: the communication point.
        instance: FMPy's object of the instance, for calls that are not here.
    """

    def __init__(
        self,
        path: str | Path,
        *,
        states: Sequence[str] | None = None,
        derivatives: Sequence[str] | None = None,
        controls: Sequence[str] | None = None,
        start_values: Mapping[str, float] | None = None,
    ):
        """Unpack and instantiate the FMU.

        Raises:
            InputError: no such file, not an FMU, of another kind, or a name that it does not have.
            FmuError: the FMU does not instantiate.
        """
        self.messages: list[LogMessage] = []
        self.time_s = 0.0
        self._is_open = self._is_stepping = False
        self.description = read_description(Path(path))
        self._interface = self.description.coSimulation or self.description.modelExchange
        variables = self.description.modelVariables
        self._references, self._booleans = (
            {variable.name: variable.valueReference for variable in variables if variable.type == kind}
            for kind in ("Real", "Boolean")
        )
        self._enumerations = {variable.name: variable for variable in variables if variable.type == "Enumeration"}
        rates = [unknown.variable for unknown in self.description.derivatives]
        inputs = [v.name for v in variables if v.causality == "input" and v.type == "Real"]
        self.derivatives = tuple([rate.name for rate in rates] if derivatives is None else derivatives)
        self.states = tuple([rate.derivative.name for rate in rates] if states is None else states)
        self.controls = tuple(inputs if controls is None else controls)
        self._buffers: dict[tuple[str, ...], _Buffer] = {}
        self._known, self._rates = self._buffer(self.states + self.controls), self._buffer(self.derivatives)
        self.jacobian = self._jacobian if self._interface.providesDirectionalDerivative else None
        self._start_values = dict(start_values or {})
        self._buffer(tuple(self._start_values))
        self._folder = tempfile.TemporaryDirectory(prefix="gtm_fmu_")
        try:
            self._load(Path(path))
            self._instantiate()
        except BaseException:
            self._folder.cleanup()
            raise

    def __enter__(self) -> "FmuClient":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Free the instance and remove the unpacked files; a second call does nothing."""
        if self._is_open:
            self._is_open = False
            if self._is_stepping:
                with suppress(FMICallException):
                    self.instance.terminate()
            if self._release:
                self._release()
                atexit.unregister(self._release)
            self.instance.freeInstance()
            self._folder.cleanup()

    def reset(self) -> None:
        """Back to the start values, in Initialization Mode."""
        self._call("reset", "fmi2Reset")
        self._initialize()

    def set(self, names: Sequence[str], values: ArrayLike) -> None:
        """Set real variables.

        Args:
            names: of the variables.
            values: (n,) in the FMU's units, one for each name.

        Raises:
            InputError: an unknown name.
            FmuError: a value that the FMU refuses.
        """
        buffer = self._buffer(tuple(names))
        buffer.values[:] = values
        self._write(buffer)

    def get(self, names: Sequence[str]) -> np.ndarray:
        """Values of real variables, as a new array.

        Args:
            names: of the variables.

        Raises:
            InputError: an unknown name.
            FmuError: outputs that the FMU cannot compute.
        """
        buffer = self._buffer(tuple(names))
        self._read(buffer)
        return buffer.values.copy()

    def get_boolean(self, name: str) -> bool:
        """Value of the Boolean variable ``name``.

        Raises:
            InputError: an unknown name.
        """
        reference, value = self._boolean(name), (ctypes.c_int * 1)()
        self._call("get", "fmi2GetBoolean", reference, 1, value)
        return bool(value[0])

    def set_boolean(self, name: str, value: bool) -> None:
        """Set the Boolean variable ``name`` to ``value``.

        Raises:
            InputError: an unknown name.
            FmuError: a value that the FMU refuses.
        """
        reference, values = self._boolean(name), (ctypes.c_int * 1)(bool(value))
        self._call("set", "fmi2SetBoolean", reference, 1, values)

    def is_boolean(self, name: str) -> bool:
        """Whether the FMU has a Boolean variable of this name."""
        return name in self._booleans

    def get_item(self, name: str) -> str:
        """Name of the value of the enumeration ``name``.

        Raises:
            InputError: an unknown name.
        """
        if name not in self._enumerations:
            raise InputError(f"The FMU has no enumeration '{name}': it has {_listed(self._enumerations)}.")
        variable = self._enumerations[name]
        reference, value = (ctypes.c_uint * 1)(variable.valueReference), (ctypes.c_int * 1)()
        self._call("get", "fmi2GetInteger", reference, 1, value)
        return next(item.name for item in variable.declaredType.items if int(item.value) == value[0])

    def _boolean(self, name: str) -> ctypes.Array:
        if name not in self._booleans:
            raise InputError(f"The FMU has no Boolean variable '{name}': it has {_listed(self._booleans)}.")
        return (ctypes.c_uint * 1)(self._booleans[name])

    def reference(self, name: str) -> int:
        """Value reference of a real variable.

        Raises:
            InputError: an unknown name.
        """
        if name not in self._references:
            raise InputError(f"The FMU has no real variable '{name}': it has {_listed(self._references)}.")
        return self._references[name]

    def evaluate(self, x: ArrayLike, u: ArrayLike) -> np.ndarray:
        """State derivatives (n,) at states x (n,) and controls u (m,), without a step.

        Raises:
            FmuError: a state without derivatives, or a step was already taken (`reset` first).
        """
        if self._is_stepping:
            raise FmuError("States can only be set before the first step: call reset first.")
        values = self._known.values
        values[: len(self.states)] = x
        values[len(self.states) :] = u
        self._write(self._known)
        self._read(self._rates)
        return self._rates.values.copy()

    def _jacobian(
        self, x: ArrayLike, u: ArrayLike, columns: Sequence[int] | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """State derivatives (n,) and their slopes (n, k) in ``columns`` of states and controls, default all n + m.

        Raises:
            FmuError: as `evaluate`.
        """
        rates = self.evaluate(x, u)
        columns = range(self._known.count) if columns is None else columns
        slopes = np.empty((len(columns), len(rates)))
        known, seed, out = (ctypes.c_uint * 1)(), (ctypes.c_double * 1)(1.0), self._rates
        at = out.references, out.count, known, 1, seed, out.memory
        for slope, column in zip(slopes, columns, strict=True):
            known[0] = self._known.references[column]
            self._call("differentiate", "fmi2GetDirectionalDerivative", *at)
            slope[:] = out.values
        return rates, slopes.T

    def si_factors(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """What the declared units of states, controls and derivatives are in SI; 1 where none is declared."""
        factors = {unit.name: unit.baseUnit.factor for unit in self.description.unitDefinitions if unit.baseUnit}
        units = {v.name: v.unit or getattr(v.declaredType, "unit", None) for v in self.description.modelVariables}
        states, controls, rates = (
            np.array([float(factors.get(units[name], 1.0)) for name in names])
            for names in (self.states, self.controls, self.derivatives)
        )
        return states, controls, rates

    def nominal(self, names: Sequence[str]) -> np.ndarray:
        """Nominal values (n,) of the real variables ``names``, 1 where none is declared.

        Raises:
            InputError: an unknown name.
        """
        self._buffer(tuple(names))
        declared = {variable.name: variable.nominal for variable in self.description.modelVariables}
        return np.array([float(declared[name] or 1.0) for name in names])

    def step(self, duration_s: float) -> None:
        """One communication step.

        Args:
            duration_s: its length in s.

        Raises:
            FmuError: the FMU refuses the step, and all values are as before it; or it is for model exchange only.
        """
        if self.description.coSimulation is None:
            raise FmuError(f"{self.description.modelName} is for model exchange only: it takes no steps of its own.")
        if not self._is_stepping:
            self._call("initialization", "fmi2ExitInitializationMode")
            self._is_stepping = True
        with held_interrupt():
            self._call("step", "fmi2DoStep", self.time_s, duration_s, 0)
        self.time_s += duration_s

    def simulate(
        self,
        stop_time_s: float,
        step_s: float,
        record: Sequence[str],
        commands: Callable[[float], Mapping[str, float]] | None = None,
    ) -> dict[str, np.ndarray]:
        """Steps of equal length from the present time on.

        Args:
            stop_time_s: when to end, in s.
            step_s: length of a step, in s.
            record: names of real variables.
            commands: values of inputs by name, set at the beginning of each step, as a function of time in s.

        Returns:
            ``time`` and the recorded variables, (n + 1,) each.

        Raises:
            InputError: a step that is not above 0, or an unknown name.
            FmuError: the FMU refuses a step.
        """
        if not (step_s > 0 and np.isfinite(stop_time_s)):
            raise InputError(f"Steps of {step_s} s to {stop_time_s} s cannot be taken: give a positive step.")
        start_s = self.time_s
        count = max(0, round((stop_time_s - start_s) / step_s))
        with held_interrupt():
            rows = [self.get(record)]
        for i in range(count):
            with held_interrupt():
                if commands is not None:
                    given = commands(self.time_s)
                    self.set(tuple(given), list(given.values()))
                self.step(step_s)
                self.time_s = start_s + (i + 1) * step_s
                rows.append(self.get(record))
        columns = np.array(rows).T
        return {"time": start_s + step_s * np.arange(count + 1)} | dict(zip(record, columns, strict=True))

    def _load(self, path: Path) -> None:
        try:
            fmpy.extract(path, self._folder.name)
            self.instance = (FMU2Slave if self.description.coSimulation else FMU2Model)(
                guid=self.description.guid,
                unzipDirectory=self._folder.name,
                modelIdentifier=self._interface.modelIdentifier,
                instanceName=self.description.modelName,
            )
        except Exception as error:
            raise InputError(f"'{path}' does not load on this platform ({error}): build it here.") from error
        # The binary of pythonfmu 0.7.0 would use its interpreter when the process ends, after that is gone.
        self._release = getattr(self.instance.dll, "finalizePythonInterpreter", None)
        if self._release:
            atexit.register(self._release)
            check_for_pythonfmu(Path(self._folder.name), path)

    def _instantiate(self) -> None:
        # Without FMPy's logger proxy: it serves one instance of a process only, the last one.
        self._callbacks = fmi2CallbackFunctions()
        self._callbacks.logger = fmi2CallbackLoggerTYPE(self._log)
        self._callbacks.allocateMemory = defaultCallbacks.allocateMemory
        self._callbacks.freeMemory = defaultCallbacks.freeMemory
        try:
            self.instance.instantiate(callbacks=self._callbacks, loggingOn=True)
        except Exception as error:
            reason = self.messages[-1].text if self.messages else str(error)
            raise FmuError(f"{self.description.modelName} does not instantiate: {reason}") from error
        self._component = ctypes.c_void_p(self.instance.component)
        self._is_open = True
        self._initialize()

    def _initialize(self) -> None:
        """Initialization Mode at time zero, with the start values that were given."""
        self.time_s, self._is_stepping = 0.0, False
        self._call("setup", "fmi2SetupExperiment", 0, 0.0, 0.0, 0, 0.0)
        if self._start_values:
            self.set(tuple(self._start_values), list(self._start_values.values()))
        self._call("initialization", "fmi2EnterInitializationMode")

    def _buffer(self, names: tuple[str, ...]) -> _Buffer:
        if names not in self._buffers:
            unknown = [name for name in names if name not in self._references]
            if unknown:
                raise InputError(f"The FMU has no real variable '{unknown[0]}': it has {_listed(self._references)}.")
            self._buffers[names] = _Buffer([self._references[name] for name in names])
        return self._buffers[names]

    def _write(self, buffer: _Buffer) -> None:
        self._call("set", "fmi2SetReal", buffer.references, buffer.count, buffer.memory)

    def _read(self, buffer: _Buffer) -> None:
        self._call("get", "fmi2GetReal", buffer.references, buffer.count, buffer.memory)

    def _call(self, action: str, function: str, *arguments: object) -> None:
        """Call a function of the FMU; raise what it logged when it refuses."""
        if not self._is_open:
            raise FmuError("The FMU is closed: open it again.")
        known = len(self.messages)
        status = getattr(self.instance.dll, function)(self._component, *arguments)
        if status >= fmi2Discard:
            refusals = [message.text for message in self.messages[known:] if message.status >= fmi2Discard]
            raise FmuError(refusals[-1] if refusals else f"The FMU refused to {action} (FMI status {status}).")

    def _log(self, _component: object, _instance: object, status: int, category: bytes, message: bytes) -> None:
        self.messages.append(LogMessage(status, (category or b"").decode(), (message or b"").decode()))


def _listed(names: Iterable[str]) -> str:
    """The first few names."""
    names = list(names)
    return ", ".join(names[:6]) + (", ..." if len(names) > 6 else "") if names else "none"
