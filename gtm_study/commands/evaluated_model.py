"""A model of named inputs, evaluated in blocks: chosen outputs, outputs kept on disk or remembered."""

import hashlib
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from gtm_fmu.errors import InputError
from gtm_fmu.files import writable_folder, write_whole
from sensitivity import Distribution

HAS_VALUE = "has_value"
"""The output that says whether there is an envelope, or whatever else a model gives."""
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


def file_hash(path: Path) -> str:
    """SHA-256 of a file, in hexadecimal digits."""
    return hashlib.sha256(path.read_bytes()).hexdigest()
