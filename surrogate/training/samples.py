"""Samples to train on or to predict: columns of a table, with their units."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gtm_fmu.errors import InputError
from surrogate.models.evaluation import Variable, check_names, check_result_names
from surrogate.training.tables import Lattice, Table, numbers, read_table

if TYPE_CHECKING:
    import pandas as pd  # slow to import

UNITS = ("ft", "m", "mm", "kt", "kn", "m_s", "deg", "rad", "deg_s", "rad_s", "pct", "s", "N", "Pa")
"""Units that the end of a column's name may tell, as in ``altitude_ft``."""
SPELLED = {"pct": "%", "m_s": "m/s", "deg_s": "deg/s", "rad_s": "rad/s"}
MOST_LEVELS = 32
"""Different words in a column that is an input; a column of more is taken for a mistake."""


@dataclass(frozen=True)
class Samples:
    """Rows of a table that have all their values.

    Attributes:
        inputs: names and units. A column of words is one input for each of its levels, ``NAME=LEVEL``, 1 or 0.
        X: inputs (n, d).
        Y: outputs (n, m).
        left_out: rows in which a value is missing, as outputs are where nothing exists.
    """

    inputs: tuple[Variable, ...]
    outputs: tuple[Variable, ...]
    X: np.ndarray
    Y: np.ndarray
    left_out: int

    def sha256(self) -> str:
        """Hash of names, units and numbers."""
        digest = hashlib.sha256(repr((self.inputs, self.outputs)).encode())
        for values in (self.X, self.Y):
            digest.update(np.ascontiguousarray(values).tobytes())
        return digest.hexdigest()


def read_samples(path: str | Path, inputs: Sequence[str], outputs: Sequence[str]) -> Samples:
    """Columns of a .csv or .parquet table, or of a .zarr data set.

    Args:
        path: file, or folder of a store.
        inputs: columns as ``name`` or ``name:unit``, or several of these with commas between. What is the name of a
            column as a whole is that column, whichever colons and commas it holds. Without a unit it is that of the
            data set or the one at the end of the name (``span_mm``), else none.
        outputs: the same.

    Raises:
        InputError: the file cannot be read, or a column is missing, given twice or does not hold what it should.
    """
    table = read_table(path)
    asked, learnt = ([v for spelling in group for v in _variables(spelling, table)] for group in (inputs, outputs))
    if not (asked and learnt):
        raise InputError("No inputs or no outputs were given: name at least one column of each.")
    names = [variable.name for variable in (*asked, *learnt)]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise InputError(f"The column '{twice}' was given twice: each can be one input or one output.")
    rows = table.rows(names)
    columns: dict[Variable, np.ndarray] = {}
    for variable in asked:
        columns |= _input(variable, rows[variable.name])
    try:
        check_names(columns, learnt)
        check_result_names(list(columns), learnt)
    except ValueError as error:
        raise InputError(str(error)) from None
    X, Y = np.column_stack([*columns.values()]), np.column_stack([_output(rows[name]) for name, _ in learnt])
    whole = np.isfinite(X).all(axis=1) & np.isfinite(Y).all(axis=1)
    if not whole.any():
        raise InputError(f"'{path}' has no row with all of {', '.join(names)}: give other columns.")
    return Samples(tuple(columns), tuple(learnt), X[whole], Y[whole], int((~whole).sum()))


def _variables(spelling: str, table: Table | Lattice) -> list[Variable]:
    """The columns that a spelling names: the longest name wins."""
    name, _, unit = spelling.rpartition(":")
    if spelling in table.names:
        return [Variable(spelling, _unit(spelling, table.units))]
    if name in table.names and "," not in unit:
        return [Variable(name, unit)]
    if spelling != spelling.strip():
        return _variables(spelling.strip(), table)
    if "," in spelling:
        return [v for part in spelling.split(",") if part.strip() for v in _variables(part, table)]
    missing = name if name and spelling.count(":") == 1 else spelling  # of more colons none tells a unit for sure
    raise InputError(f"'{table.path}' has no column '{missing}': it has {', '.join(table.names)}.")


def _unit(name: str, units: dict[str, str]) -> str:
    if name in units:
        return units[name]
    found = re.search(rf"_({'|'.join(UNITS)})$", name)
    return SPELLED.get(found[1], found[1]) if found else ""


def _input(variable: Variable, column: pd.Series) -> dict[Variable, np.ndarray]:
    """Numbers (n,), or for words which of the levels each row has."""
    if (values := numbers(column)) is not None:
        return {variable: values}
    levels = sorted(set(map(str, column.dropna())))
    if any(map(_is_number, levels)):
        raise InputError(f"The column '{variable.name}' holds numbers and words: correct it, or choose another.")
    if not 1 < len(levels) <= MOST_LEVELS:
        raise InputError(
            f"The column '{variable.name}' holds words, of which an input has 2 to {MOST_LEVELS} different ones, but "
            f"these are {len(levels)}: choose another."
        )
    return {Variable(f"{variable.name}={level}", ""): _indicator(column, level) for level in levels}


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _indicator(column: pd.Series, level: str) -> np.ndarray:
    """1 where a column has the level, 0 where another, NaN where none (n,)."""
    return np.where(column.isna(), np.nan, (column.astype(str) == level).astype(float))


def _output(column: pd.Series) -> np.ndarray:
    if (values := numbers(column)) is None:
        raise InputError(f"The column '{column.name}' holds more than numbers: choose another output.")
    return values


def inputs_of_table(inputs: Sequence[Variable], table: Table | Lattice) -> tuple[np.ndarray, pd.DataFrame]:
    """The inputs (n, d) of a model in a table, and its rows.

    Raises:
        InputError: a column is missing, or a row lacks a value or has a level that the model does not know.
    """
    sources = [_source(variable.name, table) for variable in inputs]
    rows = table.rows_with_all(list(dict.fromkeys(name for name, _ in sources)))
    columns = []
    for name, level in sources:
        if level is None:
            values = _output(rows[name])
        else:
            known = [other for source, other in sources if source == name]
            strange = rows[name].notna() & ~rows[name].astype(str).isin(known)
            if strange.any():
                k = int(np.argmax(strange))
                raise InputError(
                    f"Row {k + 1} of '{table.path}' has the {name} '{rows[name].iloc[k]}', but the model learnt "
                    f"{', '.join(map(str, known))}: leave it out."
                )
            values = _indicator(rows[name], level)
        if not np.isfinite(values).all():
            k = int(np.argmin(np.isfinite(values)))
            given, remedy = (rows[name].iloc[k], "give a number") if level is None else ("nothing", "fill it in")
            raise InputError(f"Row {k + 1} of '{table.path}' has {given} for '{name}': {remedy}, or leave the row out.")
        columns.append(values)
    return np.column_stack(columns), rows


def _source(name: str, table: Table | Lattice) -> tuple[str, str | None]:
    """The column behind an input of a model, and the level where it is one of those of a column of words."""
    if name in table.names:
        return name, None
    for found in re.finditer("=", name):
        if name[: found.start()] in table.names:
            return name[: found.start()], name[found.end() :]
    raise InputError(f"'{table.path}' has no column '{name}': it has {', '.join(table.names)}.")


def input_given(item: str, names: Sequence[str]) -> dict[str, float]:
    """The inputs of a model that ``NAME=VALUE`` gives: one, or for ``NAME=LEVEL`` those of all levels.

    Raises:
        InputError: the value is no number, or no level that the model knows.
    """
    name, _, value = item.rpartition("=")
    if name in names:
        try:
            return {name: float(value)}
        except ValueError:
            raise InputError(f"--at was given as '{item}': give a number for {name}.") from None
    name = item.partition("=")[0]
    levels = [other for other in names if other.startswith(f"{name}=")]
    if item in levels:
        return {other: float(other == item) for other in levels}
    if levels and name != item:
        known = ", ".join(level.removeprefix(f"{name}=") for level in levels)
        raise InputError(f"--at was given as '{item}': the levels of {name} are {known}.")
    example = names[0] if "=" in names[0] else f"{names[0]}=1"
    raise InputError(
        f"--at was given as '{item}': give NAME=VALUE, for instance {example}, with one of {', '.join(names)}."
    )
