"""The command `gtm-fmu dataset`: envelopes of many cases, sampled over any axes, in a store on disk."""

import time
from itertools import chain
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
import typer
from rich.console import Console
from rich.table import Table

from gtm_fmu.airframe.names import CONTROLS
from gtm_fmu.axes import Axis, failure_levels, levels, limit_levels, limits_span, span
from gtm_fmu.cases import CaseTable, Sampling
from gtm_fmu.errors import InputError
from gtm_fmu.manoeuvre import ALPHA_DEG, PHI_DEG

Pair = tuple[float, float]

RANGES: dict[str, Pair] = {"altitude": (0.0, 30000.0), "gamma": (-5.0, 5.0)}
"""Where nothing else is given: the paper's ranges."""
CASES = 1000

_BETWEEN = "Pairs of limits between these; equal values are one jam. Default: the full range, not varied."


def _between(name: str, text: str = _BETWEEN) -> Any:
    return typer.Option(metavar="LOWER UPPER", help=f"{name}: {text}")


def _held(name: str) -> Any:
    return typer.Option(metavar="LOWER UPPER", help=f"{name}: the same limits in all cases.")


def _count(name: str) -> Any:
    return typer.Option(help=f"{name}: number of levels of a lattice, evenly spaced.")


class _Input(NamedTuple):
    """What was given for altitude, gamma or a control."""

    between: Pair | None
    held: Pair | None
    levels: int | None


def dataset(
    store: Annotated[Path, typer.Argument(help="Folder of the zarr store; an unfinished one is continued.")],
    presets: Annotated[Literal["paper"] | None, typer.Option(help="The paper's lattice of 1232 cases.")] = None,
    sampling: Annotated[Sampling | None, typer.Option(help="How cases are chosen; default sobol.")] = None,
    cases: Annotated[int | None, typer.Option(help="Number of cases, but for a lattice; default 1000.")] = None,
    seed: Annotated[int | None, typer.Option(help="Start of all random numbers; default 0.")] = None,
    jam_share: Annotated[float | None, typer.Option(help="Share of jams among the failures, 0 to 1.")] = None,
    altitude_ft: Annotated[Pair | None, _between("Altitude in ft", "range; default 0 30000.")] = None,
    gamma_deg: Annotated[Pair | None, _between("Flight-path angle in deg", "range; default -5 5.")] = None,
    elevator_deg: Annotated[Pair | None, _between("Elevator in deg")] = None,
    aileron_deg: Annotated[Pair | None, _between("Aileron in deg")] = None,
    rudder_deg: Annotated[Pair | None, _between("Rudder in deg")] = None,
    throttle_pct: Annotated[Pair | None, _between("Throttle in %")] = None,
    held_elevator_deg: Annotated[Pair | None, _held("Elevator in deg")] = None,
    held_aileron_deg: Annotated[Pair | None, _held("Aileron in deg")] = None,
    held_rudder_deg: Annotated[Pair | None, _held("Rudder in deg")] = None,
    held_throttle_pct: Annotated[Pair | None, _held("Throttle in %")] = None,
    altitude_levels: Annotated[int | None, _count("Altitude")] = None,
    gamma_levels: Annotated[int | None, _count("Flight-path angle")] = None,
    elevator_levels: Annotated[int | None, _count("Elevator")] = None,
    aileron_levels: Annotated[int | None, _count("Aileron")] = None,
    rudder_levels: Annotated[int | None, _count("Rudder")] = None,
    throttle_levels: Annotated[int | None, _count("Throttle")] = None,
    alpha_deg: Annotated[Pair, _between("Angle of attack in deg", "bounds of every trim.")] = ALPHA_DEG,
    phi_deg: Annotated[Pair, _between("Bank angle in deg", "bounds of every trim.")] = PHI_DEG,
    workers: Annotated[int | None, typer.Option(help="Processes on this machine; default one a core.")] = None,
    scheduler: Annotated[str | None, typer.Option(metavar="ADDRESS", help="Your dask scheduler, tcp://...")] = None,
    export: Annotated[Path | None, typer.Option(metavar="FILE", help="Write a .csv or .parquet table too.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")] = False,
) -> None:
    """Envelopes of many cases: a lattice, or a random, Latin-hypercube or Sobol sample.

    Flight conditions and failures of any control vary. The store is read with xarray. The same command continues a run
    that was stopped, and ends with the same values. A lattice takes every pair of a control's levels in order.
    """
    from gtm_fmu.distribution import compute
    from gtm_fmu.export import check_export
    from gtm_fmu.export import export as write_table
    from gtm_fmu.store import slices
    from study import paper_lattice
    from study.cli import show
    from study.progress import stages

    chosen = (sampling, cases, seed, jam_share)
    inputs = {
        "altitude": _Input(altitude_ft, None, altitude_levels),
        "gamma": _Input(gamma_deg, None, gamma_levels),
        "elevator": _Input(elevator_deg, held_elevator_deg, elevator_levels),
        "aileron": _Input(aileron_deg, held_aileron_deg, aileron_levels),
        "rudder": _Input(rudder_deg, held_rudder_deg, rudder_levels),
        "throttle": _Input(throttle_pct, held_throttle_pct, throttle_levels),
    }
    if presets is None:
        table = _table(inputs, *chosen)
    elif any(option is not None for option in chain(chosen, *inputs.values())):
        raise InputError("The paper's lattice fixes every axis; leave out --presets or the other options of sampling.")
    else:
        table = paper_lattice.paper_lattice()
    if export:
        check_export(export)
    started = time.monotonic()
    with stages(Console(stderr=True)) as stage, stage(f"Envelopes of {len(table)} cases") as advance:
        computed = compute(store, table, alpha_deg, phi_deg, workers=workers, scheduler=scheduler, progress=advance)
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
    from study import paper_lattice

    table = Table("data set", "cases", "feasible", "paper", title="Cases with an envelope", title_justify="left")
    for row in counts:
        table.add_row(*map(str, row.values()))
    Console().print(table)
    print(paper_lattice.contradiction())


def _table(
    inputs: dict[str, _Input], sampling: Sampling | None, cases: int | None, seed: int | None, jam_share: float | None
) -> CaseTable:
    """The table that the options describe."""
    if sampling == Sampling.LATTICE:
        if any(option is not None for option in (cases, seed, jam_share)):
            raise InputError("A lattice follows from its levels; leave --cases, --seed and --jam-share out.")
        return CaseTable.lattice(chain.from_iterable(_lattice_axes(*item) for item in inputs.items()))
    for name, given in inputs.items():
        if given.levels is not None:
            raise InputError(f"--{name}-levels is for a lattice; leave it out, or take --sampling lattice.")
    if jam_share is not None and all(inputs[control].between is None for control in CONTROLS):
        raise InputError("--jam-share has no failure to share in; give the range of a control, as --rudder-deg -30 30.")
    axes = chain.from_iterable(_sampled_axes(name, given, jam_share or 0.0) for name, given in inputs.items())
    return CaseTable.sampled(axes, sampling or Sampling.SOBOL, CASES if cases is None else cases, seed or 0)


def _sampled_axes(name: str, given: _Input, jam_share: float = 0.0) -> list[Axis]:
    """The axis of an input; none for a control that is left at its full range."""
    if given.held is not None:
        if given.between is not None or given.levels is not None:
            raise InputError(f"The limits of the {name} are either held or varied; give one of both.")
        return [limit_levels(name, [given.held])]
    if name in RANGES:
        return [span(name, *(given.between or RANGES[name]))]
    return [] if given.between is None else [limits_span(name, *given.between, jam_share)]


def _lattice_axes(name: str, given: _Input) -> list[Axis]:
    axes = _sampled_axes(name, given)
    between, count = given.between or RANGES.get(name), given.levels
    if given.held is not None or (between is None and count is None):
        return axes
    if between is None:
        raise InputError(f"--{name}-levels has no range; give the lowest and highest position too.")
    lower, upper = between
    if count is None and lower < upper:
        raise InputError(f"A lattice needs the number of levels of {name}; give --{name}-levels.")
    count = 1 if count is None else count
    if count < 1:
        raise InputError(f"The lattice is empty: {count} levels of {name}; give at least one.")
    if (count == 1) != (lower == upper):
        raise InputError(f"{count} levels of {name} do not span {lower:g} .. {upper:g}; give another number.")
    positions = np.linspace(lower, upper, count).tolist()
    return [levels(name, positions) if name in RANGES else failure_levels(name, positions)]
