"""What `gtm-fmu sensitivity` can ask: the aircraft's envelopes, models of one's own and FMUs."""

import hashlib
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from gtm_fmu.aircraft.inputs import CHOICES, INPUTS, LIMITED, QUANTITIES, limit_columns
from gtm_fmu.errors import InputError
from gtm_fmu.files import temporary_folder, writable_folder, write_whole
from sensitivity import Block, Distribution, Uniform

SPEEDS = ("v_min_kt", "v_max_kt")
AIRCRAFT = ("thrust-map", "exact", "network")
FEASIBLE = "feasible"
"""The Boolean variable of an FMU that says whether its outputs mean something, where it has one."""
REALS = ("Real", "Float64")
HAS_VALUE = "has_value"
"""The output that says whether there is an envelope, or whatever else a model gives."""
MOST_STEPS = 1_000_000
"""Communication steps of a simulation."""

FAST_BLOCK, QUICK_BLOCK, SLOW_BLOCK = 2**16, 4096, 64
"""Points at a time of a model that takes less than a microsecond, some ten of them, milliseconds."""

Values = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Model:
    """A model of named inputs.

    Attributes:
        values: maps points (n, inputs) to outputs (n, outputs), NaN where there is none.
        identity: what the outputs follow from beside the points.
        block: points at a time, some seconds of work at most.
        ranges: what the inputs vary over where nothing else is said.
    """

    name: str
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    values: Values
    identity: str
    block: int = FAST_BLOCK
    ranges: Distribution | None = None

    @property
    def is_slow(self) -> bool:
        """Whether a point takes milliseconds."""
        return self.block <= SLOW_BLOCK

    def over(self, distribution: Distribution) -> "Model":
        """The same, of points whose columns are those of the distribution.

        Raises:
            InputError: the inputs are others.
        """
        given, wanted = distribution.names, self.inputs
        if sorted(given) != sorted(wanted):
            raise InputError(
                f"The distribution is of {', '.join(given)}, but {self.name} takes {', '.join(wanted)}: describe these."
            )
        order = [given.index(name) for name in wanted]
        return replace(self, inputs=given, values=lambda points: self.values(points[:, order]))

    def only(self, outputs: Sequence[str]) -> "Model":
        """The same with some of the outputs.

        Raises:
            InputError: it has no such output.
        """
        absent = [name for name in outputs if name not in self.outputs]
        if absent:
            raise InputError(f"{self.name} has no output '{absent[0]}': choose from {', '.join(self.outputs)}.")
        columns = [self.outputs.index(name) for name in outputs]
        return replace(self, outputs=tuple(outputs), values=lambda points: self.values(points)[:, columns])

    def whether(self) -> "Model":
        """1 where there are outputs, 0 where there are none."""

        def values(points: np.ndarray) -> np.ndarray:
            return np.isfinite(self.values(points)).all(axis=1).astype(float)[:, np.newaxis]

        return replace(self, outputs=(HAS_VALUE,), values=values)

    def everywhere(self) -> "Model":
        """The same, with one sentence on the first point that has no outputs."""

        def values(points: np.ndarray) -> np.ndarray:
            found = self.values(points)
            missing = np.flatnonzero(~np.isfinite(found).all(axis=1))
            if missing.size:
                at = ", ".join(f"{name} = {x:.6g}" for name, x in zip(self.inputs, points[missing[0]], strict=True))
                raise InputError(
                    f"{self.name} has no outputs at {at}: choose --infeasible condition or output, or other ranges."
                )
            return found

        return replace(self, values=values)

    def telling(self, progress: Callable[[int], None]) -> "Model":
        """The same; `progress` is called with the number of points of each block that was evaluated."""

        def values(points: np.ndarray) -> np.ndarray:
            found = self.values(points)
            progress(len(points))
            return found

        return replace(self, values=values)

    def evaluate(self, points: np.ndarray) -> np.ndarray:
        """Outputs (n, outputs), block by block."""
        blocks = [self.values(points[start : start + self.block]) for start in range(0, len(points), self.block)]
        return np.concatenate(blocks) if blocks else np.empty((0, len(self.outputs)))


def kept_on_disk(model: Model, folder: Path) -> Model:
    """The same, with the outputs of every block in a file whose name is a hash of all that they follow from.

    A run that was stopped asks for the same blocks again, and takes them from there.
    """

    def values(points: np.ndarray) -> np.ndarray:
        said = f"{model.identity} {model.inputs} {model.outputs} {points.shape}".encode()
        path = folder / f"{hashlib.sha256(said + np.ascontiguousarray(points).tobytes()).hexdigest()}.npy"
        with suppress(OSError, ValueError, EOFError):  # missing or cut off: computed anew
            known = np.load(path, allow_pickle=False)
            if known.shape == (len(points), len(model.outputs)):
                return known
        found = model.values(points)

        def write(draft: Path) -> None:
            with draft.open("wb") as file:
                np.save(file, found, allow_pickle=False)

        write_whole(path, write)
        return found

    writable_folder(folder)
    return replace(model, values=values)


def remembered(model: Model) -> Model:
    """The same, with no point asked for twice, unless to look it up takes longer than the model."""
    if model.block >= FAST_BLOCK:
        return model
    known: dict[bytes, np.ndarray] = {}

    def values(points: np.ndarray) -> np.ndarray:
        keys = [point.tobytes() for point in points]
        fresh = {key: k for k, key in enumerate(keys) if key not in known}
        if fresh:
            known.update(zip(fresh, model.values(points[list(fresh.values())]), strict=True))
        return np.array([known[key] for key in keys])

    return replace(model, values=values)


@contextmanager
def opened(
    name: str, inputs: Sequence[str], outputs: Sequence[str], stop_time_s: float | None, step_s: float = 0.01
) -> Iterator[Model]:
    """The model of a name (see `AIRCRAFT`), of a model's file or of an FMU, for inputs of a distribution.

    Args:
        inputs: of an FMU, or of the exact model other than the default; empty: the model's own.
        outputs: of an FMU or where some of a model's are wanted; empty: all.
        stop_time_s, step_s: an FMU is simulated until then in such steps, and its outputs are those at the end; None:
            those at the start.

    Raises:
        InputError: there is no such model, or it has no such input or output.
    """
    if name.endswith(".fmu"):
        with _fmu(Path(name), inputs, outputs, stop_time_s, step_s) as model:
            yield model
        return
    if stop_time_s is not None:
        raise InputError(f"--stop-time-s is for an FMU, but the model is '{name}': leave it out.")
    model = _aircraft(name, inputs) if name in AIRCRAFT else _of_file(name)
    yield model.only(outputs) if outputs else model


def _aircraft(name: str, inputs: Sequence[str]) -> Model:
    from surrogate.rudder.emulator import INPUTS as RUDDER
    from surrogate.rudder.surrogates import load_surrogate, surrogate_files

    if name == "exact":
        return _exact(tuple(inputs) or tuple(label for label, _ in RUDDER))
    surrogate = load_surrogate(name)
    identity = "".join(_hash(path) for path in surrogate_files(name))

    def values(points: np.ndarray) -> np.ndarray:
        found = surrogate.predict(points)
        return np.column_stack([getattr(found, speed) for speed in SPEEDS])

    return Model(
        f"the {name.replace('-', ' ')}",
        tuple(label for label, _ in RUDDER),
        SPEEDS,
        values,
        identity,
        QUICK_BLOCK if name == "thrust-map" else FAST_BLOCK,
    )


def _exact(labels: tuple[str, ...]) -> Model:
    """Envelopes by search; inputs are columns of a data set by their labels, as altitude_ft or elevator_lower_deg."""
    from gtm_fmu.core import library_path
    from gtm_fmu.datasets import results

    names = {column.label: column.name for column in INPUTS}
    names |= {column.label: column.name for column, _ in QUANTITIES.values()} | {name: name for name in CHOICES}
    names |= {end.label: end.name for control in LIMITED for end in limit_columns(control)}
    unknown = [label for label in labels if label not in names]
    if unknown or not {"altitude_ft", "gamma_deg"} <= set(labels):
        what = f"has no input '{unknown[0]}'" if unknown else "needs altitude_ft and gamma_deg"
        raise InputError(f"The exact envelope {what}: its inputs are {', '.join(names)}.")
    columns = tuple(names[label] for label in labels)

    def some(points: np.ndarray) -> np.ndarray:
        found = results.evaluate(points, inputs=columns)
        return np.column_stack([found["v_min"], found["v_max"]])

    def values(points: np.ndarray) -> np.ndarray:
        """In threads: the search is in C, which lets the others run."""
        with ThreadPoolExecutor(_cores()) as pool:
            parts = np.array_split(points, max(1, min(len(points), 8 * _cores())))
            return np.concatenate(list(pool.map(some, parts)))

    return Model("the exact envelope", labels, SPEEDS, values, _hash(library_path()), SLOW_BLOCK)


def _of_file(name: str) -> Model:
    from study.commands.models import load

    path = Path(name)
    if not path.is_file():
        raise InputError(f"--model was given as '{name}': give {', '.join(AIRCRAFT)}, a model's file or an FMU.")
    fitted = load(path)

    def values(points: np.ndarray) -> np.ndarray:
        try:
            return fitted.predict(points)
        except ValueError as error:
            raise InputError(str(error)) from None

    blocks: list[Block] = [
        Uniform(variable.name, lower, upper, variable.unit)
        for variable, (lower, upper) in zip(fitted.inputs, fitted.input_ranges.tolist(), strict=True)
    ]
    inputs, outputs = (tuple(variable.name for variable in group) for group in (fitted.inputs, fitted.outputs))
    return Model(f"'{path.name}'", inputs, outputs, values, _hash(path), ranges=Distribution(blocks))


@contextmanager
def _fmu(
    path: Path, inputs: Sequence[str], outputs: Sequence[str], stop_time_s: float | None, step_s: float
) -> Iterator[Model]:
    """An FMU; a case that it refuses, or calls not feasible, has no outputs."""
    if not inputs:
        raise InputError(f"'{path}' does not tell what its inputs vary over: give --distribution or --input.")
    if stop_time_s is not None and not (step_s > 0 and step_s <= stop_time_s <= MOST_STEPS * step_s):
        raise InputError(f"A simulation to {stop_time_s:g} s in steps of {step_s:g} s: give 1 to {MOST_STEPS} steps.")
    description = _description(path)
    types = {variable.name: variable for variable in description.modelVariables}
    if not outputs:
        outputs = [name for name, v in types.items() if v.causality == "output" and v.type in REALS]
    if not outputs:
        raise InputError(f"'{path}' has no outputs that are real numbers: name others with --outputs.")
    real = [name for name, v in types.items() if v.type in REALS]
    for name in (*inputs, *outputs):
        if name not in real:
            raise InputError(f"'{path}' has no real variable '{name}': it has {', '.join(real[:20])}.")
    has_verdict = FEASIBLE in types and types[FEASIBLE].type == "Boolean"
    case_of = _stepped if description.fmiVersion == "2.0" and description.coSimulation else _simulated
    if description.fmiVersion == "2.0" and stop_time_s is None:
        case_of = _stepped
    with case_of(path, tuple(inputs), tuple(outputs), has_verdict, stop_time_s, step_s) as case:

        def values(points: np.ndarray) -> np.ndarray:
            found = [case(point) for point in points]
            return np.array([np.full(len(outputs), np.nan) if each is None else each for each in found])

        block = QUICK_BLOCK if stop_time_s is None else 16
        identity = f"{_hash(path)} {tuple(outputs)} {stop_time_s} {step_s}"
        yield Model(f"'{path.name}'", tuple(inputs), tuple(outputs), values, identity, block)


Case = Callable[[np.ndarray], Sequence[float] | np.ndarray | None]


@contextmanager
def _stepped(
    path: Path,
    inputs: tuple[str, ...],
    outputs: tuple[str, ...],
    has_verdict: bool,
    stop_time_s: float | None,
    step_s: float,
) -> Iterator[Case]:
    """An FMU of FMI 2.0 at its start, or after steps of co-simulation: one instance for all cases."""
    from gtm_fmu.aircraft.client import FmuClient, FmuError

    steps = 0 if stop_time_s is None else round(stop_time_s / step_s)
    try:
        client = FmuClient(path)
    except FmuError as error:
        raise InputError(str(error)) from None

    def case(point: np.ndarray) -> np.ndarray | None:
        try:
            if steps:
                client.reset()
            client.set(inputs, point)
            for _ in range(steps):
                client.step(step_s)
            return None if has_verdict and not client.get_boolean(FEASIBLE) else client.get(outputs)
        except FmuError:
            with suppress(FmuError):
                client.reset()
            return None

    with client:
        yield case


@contextmanager
def _simulated(
    path: Path,
    inputs: tuple[str, ...],
    outputs: tuple[str, ...],
    has_verdict: bool,
    stop_time_s: float | None,
    step_s: float,
) -> Iterator[Case]:
    """Any other FMU, for model exchange or of FMI 1.0 or 3.0, after a simulation by FMPy."""
    import fmpy

    if stop_time_s is None:
        raise InputError(f"'{path}' is not of FMI 2.0, so it has to be simulated: give --stop-time-s.")
    recorded = [*outputs, FEASIBLE] if has_verdict else list(outputs)
    with temporary_folder() as folder:
        try:
            fmpy.extract(path, folder)
            description = fmpy.read_model_description(folder)
        except Exception as error:
            raise InputError(f"'{path}' cannot be unpacked ({error}): build it again.") from None

        def case(point: np.ndarray) -> list[float] | None:
            try:
                found = fmpy.simulate_fmu(
                    str(folder),
                    model_description=description,
                    start_values=dict(zip(inputs, point.tolist(), strict=True)),
                    output=recorded,
                    stop_time=stop_time_s,
                    step_size=step_s,
                    output_interval=step_s,
                    validate=False,
                )[-1]
            except Exception:  # whichever an FMU, its loader or the integrator raises
                return None
            return None if has_verdict and not found[FEASIBLE] else [float(found[name]) for name in outputs]

        yield case


def _description(path: Path) -> Any:
    """The description of an FMU of any version.

    Raises:
        InputError: there is none that can be read.
    """
    import fmpy

    if not path.is_file():
        raise InputError(f"There is no FMU '{path}': give a file that ends in .fmu.")
    try:
        return fmpy.read_model_description(path, validate=False)
    except Exception as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise InputError(f"'{path}' has no model description that can be read ({reason}): build it again.") from None


def _hash(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
