"""Distributions written down as data: a TOML or JSON file, or the dictionaries that these hold.

groups = [["load", "length"]]

[[inputs]]                       # uniform between bounds
name = "length"
unit = "m"
uniform = [1.9, 2.1]

[[inputs]]                       # any law of scipy.stats with its parameters
name = "load"
law = "gumbel_r"
parameters = {loc = 800, scale = 100}

[[inputs]]                       # two limits in order; a share of the cases may have both equal
names = ["low", "high"]
ordered = [-30, 30]
jam_share = 0.2

[[inputs]]                       # shares of a total
names = ["sand", "silt", "clay"]
simplex = 1.0

[[inputs]]                       # some cases of one law, others of another; a part may be a single point
name = "valve"
mixture = [{weight = 0.9, uniform = [0, 1]}, {weight = 0.1, at = 1}]

[[inputs]]                       # rows of a table; conditional draws from the nearest ones
names = ["wind", "waves"]
table = "weather.csv"

[[correlated]]                   # inputs from above; or rank_correlation
names = ["width", "height"]
correlation = 0.7                # of two; else the whole matrix
"""

import csv
import json
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy import stats

from .correlated import GaussianCopula
from .distributions import Array, Block, Distribution, Uniform
from .empirical import Empirical
from .marginals import Marginal, PointMass
from .mixtures import Mixture, ordered_with_jams
from .simplex import Simplex

Groups = tuple[tuple[str, ...], ...]
_NAMED = ("name", "names", "unit", "units")
_ENTRIES: dict[str, tuple[str, ...]] = {
    "uniform": (),
    "law": ("parameters",),
    "at": (),
    "ordered": ("jam_share",),
    "simplex": ("concentration",),
    "mixture": (),
    "table": ("columns", "neighbours"),
}
"""What tells the kind of an input, and what may stand beside it."""


def read_distribution(path: str | Path) -> tuple[Distribution, Groups]:
    """The distribution of a .toml or .json file, and its groups of inputs.

    Args:
        path: of the file.

    Raises:
        ValueError: the file cannot be read, or as `described_distribution`.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8")
        description = json.loads(text) if path.suffix == ".json" else tomllib.loads(text)
    except OSError as error:
        raise ValueError(f"Cannot read the distribution '{path}' ({error.strerror}): give another path.") from None
    except (ValueError, RecursionError) as error:
        kind = "JSON" if path.suffix == ".json" else "TOML"
        raise ValueError(f"The distribution '{path}' is no {kind} ({error}): correct it.") from None
    return described_distribution(description, path.parent)


def described_distribution(description: Any, folder: str | Path = ".") -> tuple[Distribution, Groups]:
    """The distribution of a description as in the head of this module, and its groups of inputs.

    Args:
        description: a mapping with the list ``inputs``, and maybe the lists ``correlated`` and ``groups``.
        folder: where files of tables are looked for.

    Raises:
        ValueError: something is missing, unknown, contradictory or no distribution.
    """
    if not isinstance(description, Mapping) or not _are_mappings(description.get("inputs")):
        raise ValueError("A distribution needs a list of inputs: give one [[inputs]] for each.")
    _check_known(description, ("inputs", "correlated", "groups"), "A distribution")
    blocks = [_block(entry, Path(folder)) for entry in description["inputs"]]
    correlated = description.get("correlated", [])
    if not _are_mappings(correlated, least=0):
        raise ValueError("What is correlated is a list: give one [[correlated]] for each set of inputs.")
    for entry in correlated:
        blocks = _joined(blocks, entry)
    distribution = Distribution(blocks)
    groups = description.get("groups", [])
    if not isinstance(groups, list) or not all(_are_words(group) for group in groups):
        raise ValueError("Groups are lists of names: give them as groups = [['a', 'b']].")
    for group in groups:
        distribution.check_names(group)
    return distribution, tuple(map(tuple, groups))


def scipy_law(name: str, parameters: Any = ()) -> Any:
    """A frozen distribution of `scipy.stats`, with its parameters by name or in order.

    Raises:
        ValueError: there is none of that name, or it does not take the parameters.
    """
    family = getattr(stats, str(name), None)
    if not isinstance(family, stats.rv_continuous | stats.rv_discrete):
        raise ValueError(f"scipy.stats has no law {name!r}: give one as norm, lognorm or gumbel_r.")
    named, ordered = (parameters, ()) if isinstance(parameters, Mapping) else ({}, parameters)
    try:
        law = family(*map(float, ordered), **{key: float(value) for key, value in named.items()})
        finite = bool(np.isfinite(law.ppf(0.5)))
    except (TypeError, ValueError) as error:
        raise ValueError(f"The law {name} does not take the parameters {parameters!r} ({error}).") from None
    if not finite:
        raise ValueError(f"The law {name} does not exist with the parameters {parameters!r}: give others.")
    return law


def _block(entry: Mapping[str, Any], folder: Path) -> Block:
    names, units = _names(entry), _units(entry)
    shown = ", ".join(names)
    kinds = [kind for kind in _ENTRIES if kind in entry]
    if len(kinds) != 1:
        given = " and ".join(kinds) or "nothing"
        raise ValueError(f"{shown} is described by {given}: give one of {', '.join(_ENTRIES)}.")
    kind = kinds[0]
    _check_known(entry, (*_NAMED, "weight", kind, *_ENTRIES[kind]), shown)
    if kind == "ordered" and len(names) != 2:
        raise ValueError(f"An ordered pair has two names, got {shown}: give names = ['low', 'high'].")
    if kind in ("uniform", "law") and len(names) != 1:
        raise ValueError(f"A {kind} describes one input, got {shown}: give each an entry of its own.")
    unit = units[0] if units else ""
    value = entry[kind]
    match kind:
        case "uniform":
            return Uniform(names[0], *_pair(value, shown), unit)
        case "law":
            return Marginal(names[0], scipy_law(value, entry.get("parameters", ())), unit)
        case "at":
            return PointMass(names, _numbers(value if isinstance(value, list) else [value], shown), units)
        case "ordered":
            share = _numbers([entry.get("jam_share", 0.0)], shown)[0]
            return ordered_with_jams((names[0], names[1]), *_pair(value, shown), share, unit)
        case "simplex":
            weights = _numbers(entry.get("concentration", []), shown)
            return Simplex(names, weights, _numbers([value], shown)[0], unit)
        case "mixture":
            return _mixture(value, entry, names, folder)
        case _:
            columns = entry.get("columns", list(names))
            neighbours = entry.get("neighbours", 0)
            return Empirical(names, read_columns(folder / str(value), columns), units, neighbours)


def _mixture(parts: Any, entry: Mapping[str, Any], names: tuple[str, ...], folder: Path) -> Mixture:
    if not _are_mappings(parts):
        raise ValueError(f"The mixture of {', '.join(names)} is a list: give two or more parts, each with its weight.")
    named = {key: entry[key] for key in _NAMED if key in entry}
    weights = _numbers([part.get("weight", np.nan) for part in parts], f"weights of {', '.join(names)}")
    return Mixture(tuple(_block(named | part, folder) for part in parts), weights)  # type: ignore[misc]


def _joined(blocks: Sequence[Block], entry: Mapping[str, Any]) -> list[Block]:
    """The blocks with some single inputs joined by a copula, in the place of the first."""
    _check_known(entry, ("names", "correlation", "rank_correlation"), "What is correlated")
    names = _names(entry)
    singles = {block.names[0]: block for block in blocks if isinstance(block, Uniform | Marginal)}
    if len(names) < 2 or (absent := [name for name in names if name not in singles]):
        raise ValueError(
            f"{', '.join(names)} cannot be correlated: name two or more inputs of a uniform or another law"
            + (f", which {', '.join(absent)} is not." if len(names) > 1 else ".")
        )
    kinds = {kind: _matrix(entry[kind], names) for kind in ("correlation", "rank_correlation") if kind in entry}
    copula = GaussianCopula([_marginal(singles[name]) for name in names], **kinds)
    found: list[Block] = []
    for block in blocks:
        if block.names[0] not in names:
            found.append(block)
        elif copula not in found:
            found.append(copula)
    return found


def _marginal(block: Uniform | Marginal) -> Marginal:
    if isinstance(block, Marginal):
        return block
    return Marginal(block.name, stats.uniform(block.lower, block.upper - block.lower), block.unit)


def _matrix(given: Any, names: Sequence[str]) -> Array:
    """A correlation (M, M), which for two inputs may be one number."""
    try:
        matrix = np.array(given, dtype=float)
    except (TypeError, ValueError):
        raise ValueError(f"The correlation of {', '.join(names)} is {given!r}: give a matrix of numbers.") from None
    return np.array([[1.0, float(matrix)], [float(matrix), 1.0]]) if matrix.ndim == 0 and len(names) == 2 else matrix


def read_columns(path: Path, columns: Sequence[str]) -> Array:
    """Columns of numbers (n, columns) of a .csv file whose first line names them.

    Raises:
        ValueError: it cannot be read, lacks a column or holds no numbers there.
    """
    try:
        with path.open(newline="", encoding="utf-8") as file:
            rows = csv.DictReader(file)
            absent = [name for name in columns if name not in (rows.fieldnames or ())]
            if absent:
                raise ValueError(f"it has no column {absent[0]!r}")
            return np.array([[float(row[name]) for name in columns] for row in rows]).reshape(-1, len(columns))
    except OSError as error:
        raise ValueError(f"Cannot read the table '{path}' ({error.strerror}): give another path.") from None
    except (ValueError, TypeError, csv.Error) as error:
        raise ValueError(f"The table '{path}' cannot be used ({error}): correct it.") from None


def _names(entry: Mapping[str, Any]) -> tuple[str, ...]:
    names = entry.get("names", [entry["name"]] if "name" in entry else None)
    if not _are_words(names) or ("name" in entry and "names" in entry):
        raise ValueError(f"An input is {dict(entry)!r}: give its name, or the names of several that belong together.")
    return tuple(names)


def _units(entry: Mapping[str, Any]) -> tuple[str, ...]:
    if "unit" in entry:
        return (str(entry["unit"]),) * len(_names(entry))
    units = entry.get("units", [])
    if units and (not _are_words(units) or len(units) != len(_names(entry))):
        raise ValueError(f"Units of {', '.join(_names(entry))} are {units!r}: give one for each name.")
    return tuple(units)


def _pair(value: Any, shown: str) -> tuple[float, float]:
    numbers = _numbers(value, shown)
    if len(numbers) != 2:
        raise ValueError(f"Bounds of {shown} are {value!r}: give two numbers, as [0, 1].")
    return numbers[0], numbers[1]


def _numbers(values: Any, shown: str) -> tuple[float, ...]:
    is_list = isinstance(values, list | tuple)
    if not is_list or not all(isinstance(v, int | float) and not isinstance(v, bool) for v in values):
        raise ValueError(f"{shown}: {values!r} are no numbers.")
    return tuple(map(float, values))


def _are_words(values: Any) -> bool:
    return isinstance(values, list | tuple) and bool(values) and all(isinstance(v, str) and v for v in values)


def _are_mappings(values: Any, least: int = 1) -> bool:
    return isinstance(values, list) and len(values) >= least and all(isinstance(v, Mapping) for v in values)


def _check_known(entry: Mapping[str, Any], known: Sequence[str], shown: str) -> None:
    unknown = sorted(set(map(str, entry)) - set(known))
    if unknown:
        raise ValueError(f"{shown} has the unknown entry {unknown[0]!r}: choose from {', '.join(known)}.")
