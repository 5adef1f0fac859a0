"""Any FMU as a model: at its start, after steps of co-simulation, or after a simulation by FMPy."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gtm_fmu.errors import InputError
from gtm_fmu.files import temporary_folder
from gtm_study.commands.evaluated_model import QUICK_BLOCK, Model, file_hash

FEASIBLE = "feasible"
"""The Boolean variable of an FMU that says whether its outputs mean something, where it has one."""
REALS = ("Real", "Float64")
MOST_STEPS = 1_000_000
"""Communication steps of a simulation."""


@contextmanager
def evaluated_fmu(
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
    with case_of(_Run(path, tuple(inputs), tuple(outputs), has_verdict, stop_time_s, step_s)) as case:

        def values(points: np.ndarray) -> np.ndarray:
            found = [case(point) for point in points]
            return np.array([np.full(len(outputs), np.nan) if each is None else each for each in found])

        block = QUICK_BLOCK if stop_time_s is None else 16
        identity = f"{file_hash(path)} {tuple(outputs)} {stop_time_s} {step_s}"
        yield Model(f"'{path.name}'", tuple(inputs), tuple(outputs), values, identity, block)


Case = Callable[[np.ndarray], Sequence[float] | np.ndarray | None]


@dataclass(frozen=True)
class _Run:
    """What is asked of an FMU in each case; `has_verdict` where it has the variable `FEASIBLE`."""

    path: Path
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    has_verdict: bool
    stop_time_s: float | None
    """None: at its start, without a step."""
    step_s: float


@contextmanager
def _stepped(run: _Run) -> Iterator[Case]:
    """An FMU of FMI 2.0 at its start, or after steps of co-simulation: one instance for all cases."""
    from gtm_fmu.aircraft.client import FmuClient, FmuError

    steps = 0 if run.stop_time_s is None else round(run.stop_time_s / run.step_s)
    try:
        client = FmuClient(run.path)
    except FmuError as error:
        raise InputError(str(error)) from None

    def case(point: np.ndarray) -> np.ndarray | None:
        try:
            if steps:
                client.reset()
            client.set(run.inputs, point)
            for _ in range(steps):
                client.step(run.step_s)
            return None if run.has_verdict and not client.get_boolean(FEASIBLE) else client.get(run.outputs)
        except FmuError:
            with suppress(FmuError):
                client.reset()
            return None

    with client:
        yield case


@contextmanager
def _simulated(run: _Run) -> Iterator[Case]:
    """Any other FMU, for model exchange or of FMI 1.0 or 3.0, after a simulation by FMPy."""
    import fmpy

    if run.stop_time_s is None:
        raise InputError(f"'{run.path}' is not of FMI 2.0, so it has to be simulated: give --stop-time-s.")
    recorded = [*run.outputs, FEASIBLE] if run.has_verdict else list(run.outputs)
    with temporary_folder() as folder:
        try:
            fmpy.extract(run.path, folder)
            description = fmpy.read_model_description(folder)
        except Exception as error:
            raise InputError(f"'{run.path}' cannot be unpacked ({error}): build it again.") from None

        def case(point: np.ndarray) -> list[float] | None:
            try:
                found = fmpy.simulate_fmu(
                    str(folder),
                    model_description=description,
                    start_values=dict(zip(run.inputs, point.tolist(), strict=True)),
                    output=recorded,
                    stop_time=run.stop_time_s,
                    step_size=run.step_s,
                    output_interval=run.step_s,
                    validate=False,
                )[-1]
            except Exception:  # whichever an FMU, its loader or the integrator raises
                return None
            return None if run.has_verdict and not found[FEASIBLE] else [float(found[name]) for name in run.outputs]

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
