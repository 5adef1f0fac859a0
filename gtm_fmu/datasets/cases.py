"""Cases of a data set: flight conditions and what a failure leaves of the aircraft, on a lattice or sampled.

A table of cases is never held whole (but for a Latin hypercube): any slice of its rows follows from the axes, the kind
of sampling and the seed alone.
"""

import hashlib
import math
from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property

import numpy as np

from gtm_fmu.aircraft.inputs import CONDITION, LIMITED, NAMES, Column, limit_columns
from gtm_fmu.airframe.names import CONTROLS
from gtm_fmu.datasets.axes import Axis, Levels, limit_levels
from gtm_fmu.errors import InputError

LARGEST_LATIN_HYPERCUBE = 20_000_000
"""Numbers in the largest one, cases times dimensions: its permutations have to be in memory all at once."""
LARGEST = 100_000_000
"""Cases of the largest data set: some hundred thousand chunks, a month of a hundred cores."""


class Sampling(StrEnum):
    """How cases are chosen."""

    LATTICE = "lattice"
    RANDOM = "random"
    LATIN_HYPERCUBE = "latin-hypercube"
    SOBOL = "sobol"


@dataclass(frozen=True)
class CaseTable:
    """Cases as rows of `columns`. Make one with `lattice` or `sampled`."""

    axes: tuple[Axis, ...]
    sampling: Sampling
    cases: int
    seed: int | None = None

    @classmethod
    def lattice(cls, axes: Iterable[Axis]) -> "CaseTable":
        """Every combination of levels; the last axis varies fastest. Controls without an axis keep their range.

        Args:
            axes: levels of each.

        Raises:
            InputError: an axis that has no levels, is missing or given twice; too many cases.
        """
        complete = _complete(axes)
        for axis in complete:
            if not isinstance(axis, Levels):
                raise InputError(f"{axis.name} has no levels; a lattice needs some on every axis.")
        cases = math.prod(cls(complete, Sampling.LATTICE, 0)._lattice_sizes)
        if cases > LARGEST:
            raise _too_large(cases)
        return cls(complete, Sampling.LATTICE, cases)

    @classmethod
    def sampled(cls, axes: Iterable[Axis], sampling: Sampling, cases: int, seed: int = 0) -> "CaseTable":
        """Cases by a seed; levels are drawn with equal probability. Controls without an axis keep their range.

        Args:
            axes: what varies, and how.
            sampling: how the cases are spread.
            cases: their number.
            seed: the same one gives the same cases.

        Raises:
            InputError: no case, too many, nothing that varies, a negative seed, an axis missing or given twice.
        """
        table = cls(_complete(axes), sampling, cases, seed)
        if cases < 1:
            raise InputError(f"{cases} cases were asked for; ask for at least one.")
        if cases > LARGEST:
            raise _too_large(cases)
        if seed < 0:
            raise InputError(f"The seed {seed} is negative; give 0 or more.")
        if not table._dimensions:
            raise InputError("Every input is held at one value; give at least one a range.")
        if sampling == Sampling.LATIN_HYPERCUBE and cases * table._dimensions > LARGEST_LATIN_HYPERCUBE:
            largest = LARGEST_LATIN_HYPERCUBE // table._dimensions
            raise InputError(f"A Latin hypercube of {cases} cases is too large; take up to {largest}, or sobol.")
        return table

    def __len__(self) -> int:
        return self.cases

    @property
    def columns(self) -> tuple[Column, ...]:
        """What describes a case: `inputs.INPUTS` and whatever else has an axis, in the order of `inputs.NAMES`."""
        return tuple(column for axis in self.axes for column in axis.columns)

    def rows(self, start: int, stop: int) -> np.ndarray:
        """Cases ``start`` to ``stop`` (stop - start, columns), the same in whatever slices they are asked for."""
        stop = min(stop, self.cases)
        if self.sampling == Sampling.LATTICE:
            index = np.unravel_index(np.arange(start, stop), self._lattice_sizes)
            return np.column_stack([axis.rows(k) for axis, k in zip(self._levels, index, strict=True)])
        ends = np.cumsum([axis.dimensions for axis in self.axes])
        parts = np.split(self._unit(start, stop), ends[:-1], axis=1)
        return np.column_stack([axis.at(part) for axis, part in zip(self.axes, parts, strict=True)])

    def block(self, largest: int) -> int:
        """Cases to cut off at a time, ``largest`` at most: on a lattice whole runs of its fastest axes.

        Cases that are cut off together then differ in little, and what they share is computed once.
        """
        whole = 1
        for size in reversed(self._lattice_sizes if self.sampling == Sampling.LATTICE else []):
            if whole * size > largest:
                break
            whole *= size
        return largest // whole * whole

    def describe(self) -> dict[str, str | int]:
        """How the table was made, as attributes of a data set; equal ones make equal tables."""
        made: dict[str, str | int] = {"sampling": str(self.sampling), "cases": self.cases}
        if self.seed is not None:
            made["seed"] = self.seed
        return made | {f"axis_{axis.name}": str(axis) for axis in self.axes}

    @property
    def _levels(self) -> list[Levels]:
        return [axis for axis in self.axes if isinstance(axis, Levels)]

    @property
    def _lattice_sizes(self) -> list[int]:
        return [len(axis) for axis in self._levels]

    @property
    def _dimensions(self) -> int:
        return sum(axis.dimensions for axis in self.axes)

    def _unit(self, start: int, stop: int) -> np.ndarray:
        """Points (stop - start, dimensions) of the unit cube."""
        d, n = self._dimensions, stop - start
        if self.sampling == Sampling.RANDOM:
            return np.random.Generator(np.random.PCG64(self.seed).advance(start * d)).random((n, d))
        if self.sampling == Sampling.LATIN_HYPERCUBE:
            return self._latin_hypercube[start:stop]
        from scipy.stats import qmc

        sequence = qmc.Sobol(d, rng=self.seed)
        if not start:  # SciPy wants a power of two of the sequence's beginning
            return sequence.random_base2((n - 1).bit_length())[:n]
        return sequence.fast_forward(start).random(n)

    @cached_property
    def _latin_hypercube(self) -> np.ndarray:
        from scipy.stats import qmc

        return qmc.LatinHypercube(self._dimensions, rng=self.seed).random(self.cases)


@dataclass(frozen=True, eq=False)
class GivenCases:
    """Cases given row by row, such as the points of a design: values (n, columns) of some of `inputs.NAMES`.

    Raises:
        InputError: no row, too many, a column that is no input, missing or given twice, or a value that is no number.
    """

    columns: tuple[Column, ...]
    values: np.ndarray

    def __post_init__(self) -> None:
        """Check the columns, and hold the values unchangeable."""
        names = [column.name for column in self.columns]
        values = np.array(self.values, dtype=float)
        if values.ndim != 2 or values.shape[1] != len(names) or not len(values):
            raise InputError(f"Cases of the shape {values.shape} were given for {len(names)} columns; give one each.")
        if len(values) > LARGEST:
            raise _too_large(len(values))
        known = [name for name in NAMES if name not in LIMITED]
        known += [end.name for control in LIMITED for end in limit_columns(control)]
        for name in names:
            if name not in known or names.count(name) > 1:
                raise InputError(
                    f"There is no input {name!r}, or it was given twice; choose some of {', '.join(known)}."
                )
        for column in CONDITION:
            if column.name not in names:
                raise InputError(f"No {column.name} was given; give a column of it.")
        if not np.isfinite(values).all():
            raise InputError(
                f"Case {int(np.argmin(np.isfinite(values).all(axis=1)))} lacks a number; give every input."
            )
        values.setflags(write=False)
        object.__setattr__(self, "values", values)

    def __len__(self) -> int:
        return len(self.values)

    def rows(self, start: int, stop: int) -> np.ndarray:
        """Cases ``start`` to ``stop`` (stop - start, columns)."""
        return self.values[start:stop]

    def block(self, largest: int) -> int:
        """Cases to cut off at a time, ``largest`` at most."""
        return largest

    def describe(self) -> dict[str, str | int]:
        """Their number and hash, as attributes of a data set; equal ones are equal cases."""
        return {
            "sampling": "given",
            "cases": len(self),
            "cases_hash": hashlib.sha256(self.values.tobytes()).hexdigest(),
        }


Cases = CaseTable | GivenCases
"""What a data set can be computed of."""


def _too_large(cases: int) -> InputError:
    return InputError(f"A data set of {cases} cases is too large; take up to {LARGEST}.")


def _complete(axes: Iterable[Axis]) -> tuple[Axis, ...]:
    """Axes in the order of `inputs.NAMES`, with the undamaged range of each control that has none."""
    given: dict[str, Axis] = {}
    for axis in axes:
        if axis.name in given:
            raise InputError(f"{axis.name} was given twice; give each axis once.")
        given[axis.name] = axis
    for column in CONDITION:
        if column.name not in given:
            raise InputError(f"No {column.name} was given; give one value or a range.")
    for control in CONTROLS:
        given.setdefault(control, limit_levels(control, [LIMITED[control][1]]))
    return tuple(given[name] for name in NAMES if name in given)
