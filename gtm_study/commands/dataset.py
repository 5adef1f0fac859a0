"""The command `gtm-fmu dataset`: envelopes of many cases, sampled over any axes, in a store on disk."""

import time
from collections.abc import Mapping
from itertools import chain
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
import typer
from rich.console import Console
from rich.table import Table

from gtm_fmu.aircraft.inputs import LIMITED, QUANTITIES, EngineOut
from gtm_fmu.aircraft.ranges import ALPHA_DEG, PHI_DEG
from gtm_fmu.datasets import paper
from gtm_fmu.datasets.axes import Axis, check_count, choices, failure_levels, levels, limit_levels, limits_span, span
from gtm_fmu.datasets.cases import CaseTable, Sampling
from gtm_fmu.errors import InputError
from gtm_study.commands.options import (
    DAMAGE_CASES,
    ENGINES,
    SETTINGS,
    TOLERANCES,
    Option,
    Pair,
    given_tolerances,
    pair,
    takes,
)

RANGES: dict[str, Pair] = {"altitude": paper.ALTITUDE_FT, "gamma": paper.GAMMA_DEG}
"""Where nothing else is given: the paper's ranges."""
CASES = 1000
_MANY = "Once for each of several."
_COUNT = Annotated[int | None, typer.Option(help="Its levels on a lattice, evenly spaced.")]

_MEANING = {
    "altitude": "Altitude in ft: range; default 0 30000.",
    "gamma": "Flight-path angle in deg: range; default -5 5.",
    **{name: f"{text.rstrip('.')}: range; default 0, not varied." for name, text in SETTINGS.items()},
    **{
        f"{name}_rate": f"Fastest motion of the {name} in deg/s, for simulations: range."
        for name in ("elevator", "aileron", "rudder")
    },
}


def _levels(name: str) -> str:
    return f"--{name.replace('_', '-')}-levels"


def _words(name: str) -> str:
    return name.replace("_", " ")


def _options() -> dict[str, Option]:
    """Range, limits that are held, and number of levels of every input."""
    options = {
        "damage_case": Option(Annotated[list[int] | None, typer.Option(help=f"{DAMAGE_CASES} {_MANY}")]),
        "engine_out": Option(Annotated[list[EngineOut] | None, typer.Option(help=f"{ENGINES} {_MANY}")]),
    }
    for name, text in _MEANING.items():
        options[QUANTITIES[name][0].label] = Option(Annotated[Pair | None, pair(text)])
        options[f"{name}_levels"] = Option(_COUNT)
    for name, (column, _) in LIMITED.items():
        spelt = f"{_words(name).capitalize()} in {column.units}"
        between = pair(f"{spelt}: pairs of limits between these; equal values are one jam. Default: not varied.")
        options[column.label] = Option(Annotated[Pair | None, between])
        options[f"{name}_levels"] = Option(_COUNT)
        options[f"held_{column.label}"] = Option(
            Annotated[Pair | None, pair(f"{spelt}: the same limits in all cases.")]
        )
    return options


class _Input(NamedTuple):
    """What was given for a quantity or a control."""

    between: Pair | None
    held: Pair | None
    levels: int | None

    @classmethod
    def of(cls, name: str, given: Mapping[str, Any]) -> "_Input":
        label = (QUANTITIES | LIMITED)[name][0].label
        return cls(given[label], given.get(f"held_{label}"), given[f"{name}_levels"])


@takes(_options() | TOLERANCES)
def dataset(
    store: Annotated[Path, typer.Argument(help="Folder of the zarr store; an unfinished one is continued.")],
    presets: Annotated[Literal["paper"] | None, typer.Option(help="The paper's lattice of 1232 cases.")] = None,
    sampling: Annotated[Sampling | None, typer.Option(help="How cases are chosen; default sobol.")] = None,
    cases: Annotated[int | None, typer.Option(help="Number of cases, but for a lattice; default 1000.")] = None,
    seed: Annotated[int | None, typer.Option(help="Start of all random numbers; default 0.")] = None,
    jam_share: Annotated[float | None, typer.Option(help="Share of jams among the failures, 0 to 1.")] = None,
    alpha_deg: Annotated[Pair, pair("Angle of attack in deg: bounds of every trim.")] = ALPHA_DEG,
    phi_deg: Annotated[Pair, pair("Bank angle in deg: bounds of every trim.")] = PHI_DEG,
    workers: Annotated[int | None, typer.Option(help="Processes on this machine; default one a core.")] = None,
    scheduler: Annotated[str | None, typer.Option(metavar="ADDRESS", help="Your dask scheduler, tcp://...")] = None,
    export: Annotated[Path | None, typer.Option(metavar="FILE", help="Write a .csv or .parquet table too.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")] = False,
    **given: Any,
) -> None:
    """Envelopes of many cases: a lattice, or a random, Latin-hypercube or Sobol sample.

    Flight conditions and failures of any kind vary. The store is read with xarray. The same command continues a run
    that was stopped, and ends with the same values. A lattice takes every pair of a control's levels in order.
    With tolerances every case has its guaranteed and its possible V_min and V_max too: 6 times the work with one of
    them, 140 times with all.
    """
    from gtm_fmu.datasets.distribution import compute
    from gtm_fmu.datasets.export import check_export
    from gtm_fmu.datasets.export import export as write_table
    from gtm_fmu.datasets.lattice import lattice
    from gtm_fmu.datasets.store import slices
    from gtm_study.commands.printing import show
    from gtm_study.paper import lattice as paper_lattice
    from gtm_study.progress import stages

    chosen = (sampling, cases, seed, jam_share)
    tolerances = given_tolerances(given)
    given = {name: value for name, value in given.items() if name not in TOLERANCES}
    if presets is None:
        table = _table(given, *chosen)
    elif any(option not in (None, []) for option in (*chosen, *given.values())):
        raise InputError("The paper's lattice fixes every axis; leave out --presets or the other options of sampling.")
    else:
        table = lattice()
    if export:
        check_export(export, store)
    started = time.monotonic()
    with stages(Console(stderr=True)) as stage, stage(f"Envelopes of {len(table)} cases") as advance:
        computed = compute(
            store,
            table,
            alpha_deg,
            phi_deg,
            workers=workers,
            scheduler=scheduler,
            progress=advance,
            tolerances=tolerances,
        )
    values: dict[str, Any] = {"store": str(store), "cases": len(table), "computed": computed}
    values["seconds"] = time.monotonic() - started
    values["feasible"] = sum(int(part.feasible.sum()) for part in slices(store, ["feasible"]))
    if export:
        values["export"] = str(write_table(store, export))
    if presets is None:
        show(values, as_json, "Data set")
    elif as_json:
        values |= {"counts": paper_lattice.counts(store), "note": paper_lattice.contradiction()}
        show(values, as_json, "Data set")
    else:
        show(values, as_json, "Data set")
        _show_counts(paper_lattice.counts(store))


def _show_counts(counts: list[dict[str, int]]) -> None:
    from gtm_study.paper import lattice as paper_lattice

    table = Table("data set", "cases", "feasible", "paper", title="Cases with an envelope", title_justify="left")
    for row in counts:
        table.add_row(*map(str, row.values()))
    Console().print(table)
    print(paper_lattice.contradiction())


def _table(
    given: Mapping[str, Any], sampling: Sampling | None, cases: int | None, seed: int | None, jam_share: float | None
) -> CaseTable:
    """The table that the options describe."""
    inputs = {name: _Input.of(name, given) for name in (*_MEANING, *LIMITED)}
    chosen = [choices("damage_case", given["damage_case"])] if given["damage_case"] else []
    if given["engine_out"]:
        chosen.append(choices("engine_out", [list(EngineOut).index(engine) for engine in given["engine_out"]]))
    if sampling == Sampling.LATTICE:
        if any(option is not None for option in (cases, seed, jam_share)):
            raise InputError("A lattice follows from its levels; leave --cases, --seed and --jam-share out.")
        return CaseTable.lattice(chain(chosen, *(_lattice_axes(*item) for item in inputs.items())))
    for name, one in inputs.items():
        if one.levels is not None:
            raise InputError(f"{_levels(name)} is for a lattice; leave it out, or take --sampling lattice.")
    if jam_share is not None and all(inputs[control].between is None for control in LIMITED):
        raise InputError("--jam-share has no failure to share in; give the range of a control, as --rudder-deg -30 30.")
    axes = chain(chosen, *(_sampled_axes(name, one, jam_share or 0.0) for name, one in inputs.items()))
    return CaseTable.sampled(axes, sampling or Sampling.SOBOL, CASES if cases is None else cases, seed or 0)


def _sampled_axes(name: str, given: _Input, jam_share: float = 0.0) -> list[Axis]:
    """The axis of an input; none for one that is left as it is on the undamaged aircraft."""
    if given.held is not None:
        if given.between is not None or given.levels is not None:
            raise InputError(f"The limits of the {_words(name)} are either held or varied; give one of both.")
        return [limit_levels(name, [given.held])]
    if (between := given.between or RANGES.get(name)) is None:
        return []
    return [span(name, *between) if name in QUANTITIES else limits_span(name, *between, jam_share)]


def _lattice_axes(name: str, given: _Input) -> list[Axis]:
    axes = _sampled_axes(name, given)
    between, count = given.between or RANGES.get(name), given.levels
    if given.held is not None or (between is None and count is None):
        return axes
    if between is None:
        raise InputError(f"{_levels(name)} has no range; give the lowest and highest value too.")
    lower, upper = between
    if count is None and lower < upper:
        raise InputError(f"A lattice needs the number of levels of {_words(name)}; give {_levels(name)}.")
    count = 1 if count is None else count
    if count < 1:
        raise InputError(f"The lattice is empty: {count} levels of {_words(name)}; give at least one.")
    if (count == 1) != (lower == upper):
        raise InputError(f"{count} levels of {_words(name)} do not span {lower:g} .. {upper:g}; give another number.")
    check_count(name, count)
    positions = np.linspace(lower, upper, count).tolist()
    return [levels(name, positions) if name in QUANTITIES else failure_levels(name, positions)]
