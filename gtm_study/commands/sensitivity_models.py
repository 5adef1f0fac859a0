"""What `gtm-fmu sensitivity` can ask: the aircraft's envelopes, models of one's own and FMUs."""

import os
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from gtm_fmu.aircraft.inputs import CHOICES, INPUTS, LIMITED, QUANTITIES, limit_columns
from gtm_fmu.errors import InputError
from gtm_study.commands.evaluated_fmus import evaluated_fmu
from gtm_study.commands.evaluated_model import FAST_BLOCK, QUICK_BLOCK, SLOW_BLOCK, Model, file_hash
from sensitivity import Block, Distribution, Uniform

SPEEDS = ("v_min_kt", "v_max_kt")
AIRCRAFT = ("thrust-map", "exact", "network")


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
        with evaluated_fmu(Path(name), inputs, outputs, stop_time_s, step_s) as model:
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
    identity = "".join(file_hash(path) for path in surrogate_files(name))

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

    return Model("the exact envelope", labels, SPEEDS, values, file_hash(library_path()), SLOW_BLOCK)


def _of_file(name: str) -> Model:
    from gtm_study.commands.models import load

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
    return Model(f"'{path.name}'", inputs, outputs, values, file_hash(path), ranges=Distribution(blocks))


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
