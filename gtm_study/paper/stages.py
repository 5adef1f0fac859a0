"""The stages of the study: what each computes, draws and writes, what it needs, and from which level on it belongs."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import xarray as xr
from matplotlib.figure import Figure

from fmu_src.fmus import build_fmu
from gtm_fmu.datasets import lattice as lattices
from gtm_fmu.datasets import off_lattice, paper
from gtm_fmu.envelopes import maps
from gtm_fmu.envelopes.envelope import FlightCondition
from gtm_fmu.envelopes.thrust_map import ThrustMap
from gtm_fmu.progress import Advance
from gtm_study.explorer.page import explorer_page
from gtm_study.figures import maps as map_figures
from gtm_study.figures.families import family_page, plot_family
from gtm_study.files import save_figure, write_text
from gtm_study.paper import comparisons, every_failure, figures, published, rudder_sensitivity
from gtm_study.paper.rudder_grid import Cells
from sensitivity import plot_bars
from surrogate import Network, Schedule, Selection
from surrogate.plots import plot_error_histogram, plot_performance, plot_regression
from surrogate.rudder.emulator import RudderEmulator, train

LEVELS = ("quick", "paper", "full")
"""From the first minute and a half to everything; each holds the stages of those before it."""
USUAL_LEVEL = "paper"


@dataclass(frozen=True)
class Sizes:
    """How large the stages are: by default as in the paper."""

    altitudes_ft: tuple[float, ...] = paper.ALTITUDES_FT
    gammas_deg: tuple[float, ...] = paper.GAMMAS_DEG
    rudders_deg: tuple[float, ...] = paper.RUDDERS_DEG
    trims: int = 200
    jams_deg: tuple[float, ...] = comparisons.FIG_3_JAMS_DEG
    volume_gammas_deg: tuple[float, ...] = maps.GAMMAS_DEG
    map_altitudes_ft: tuple[float, ...] = maps.ALTITUDES_FT
    map_gammas_deg: tuple[float, ...] = maps.GAMMAS_DEG
    map_jam_step_deg: float = maps.JAM_STEP
    limit_step_deg: float = 1.0
    rounds: int = published.TRAINING_ROUNDS
    hidden: int = 10
    epochs: int | None = None
    """Of the networks at most; None: the trainer's own."""
    finer_cells: Cells = rudder_sensitivity.FINER_CELLS


@dataclass(frozen=True)
class Run:
    """What the stages of a run share."""

    folder: Path
    seed: int
    sizes: Sizes

    def lattice(self, advance: Advance | None = None) -> xr.Dataset:
        """The solved lattice, from its store."""
        sizes = self.sizes
        failures = lattices.rudder_failures(sizes.rudders_deg)
        table = lattices.lattice(sizes.altitudes_ft, sizes.gammas_deg, failures)
        return lattices.solved(self.folder / "envelopes.zarr", table, advance)


Written = list[Path]
"""Files of a stage, which enters them."""


@dataclass(frozen=True)
class Stage:
    """A part of the study; `run` gives results by their names, ready for JSON."""

    name: str
    title: str
    run: Callable[[Run, Advance, Written], dict[str, Any]]
    needs: tuple[str, ...] = ()
    level: str = LEVELS[0]


def _draw(run: Run, written: Written, **drawn: Figure) -> None:
    """Write figures by their names, as .svg and as .png."""
    for name, figure in drawn.items():
        for ending in (".svg", ".png"):
            written.append((run.folder / name).with_suffix(ending))
            save_figure(figure, written[-1])


def _build(run: Run, written: Written, name: str) -> Path:
    written.append(build_fmu(name, run.folder))
    return written[-1]


def _trims(run: Run, advance: Advance, written: Written) -> dict[str, Any]:
    fmu = _build(run, written, "dynamics")
    return comparisons.compare_trims(fmu, run.seed, run.sizes.trims, advance)


def _lattice(run: Run, advance: Advance, written: Written) -> dict[str, Any]:
    data = run.lattice(advance)
    written.append(run.folder / "envelopes.zarr")
    return {"cases": int(data.feasible.size), "feasible": int(data.feasible.sum())}


def _jams(run: Run, advance: Advance, written: Written) -> dict[str, Any]:
    _draw(run, written, envelope_jams=plot_family(comparisons.jam_family(run.sizes.jams_deg, advance)))
    return {}


def _volume(run: Run, advance: Advance, written: Written) -> dict[str, Any]:
    volume = maps.volume(run.sizes.volume_gammas_deg, advance)
    _draw(run, written, volume=plot_family(volume))
    written.append(run.folder / "volume.html")
    write_text(family_page(volume), written[-1])
    return {}


def _limits(run: Run, advance: Advance, written: Written) -> dict[str, Any]:
    condition = FlightCondition(*comparisons.JAM_CONDITION)
    surface = maps.limit_surface(condition, step=run.sizes.limit_step_deg, advance=advance)
    _draw(run, written, limits=map_figures.plot_limit_surface(surface))
    return {}


def _feasibility(run: Run, advance: Advance, written: Written) -> dict[str, Any]:
    sizes = run.sizes
    found = maps.feasibility_map(
        step=sizes.map_jam_step_deg,
        altitudes_ft=sizes.map_altitudes_ft,
        gammas_deg=sizes.map_gammas_deg,
        advance=advance,
    )
    _draw(run, written, feasibility=map_figures.plot_feasibility(found))
    return {}


def _networks(run: Run, advance: Advance, written: Written) -> dict[str, Any]:
    data, sizes = run.lattice(), run.sizes
    schedule = None if sizes.epochs is None else Schedule(epochs=sizes.epochs)
    samples = lattices.samples(data)
    speeds, throttle = train(samples, run.seed, advance, rounds=sizes.rounds, hidden=sizes.hidden, schedule=schedule)
    emulator = RudderEmulator(*(_documented(selection, data) for selection in (speeds, throttle)))
    scores = off_lattice.measured(emulator, off_lattice.load())
    written += emulator.with_provenance(off_lattice=scores).save(run.folder)
    _draw(
        run,
        written,
        regression=plot_regression(speeds),
        performance=plot_performance(speeds),
        errors=plot_error_histogram(speeds),
        emulator_jams=figures.plot_speeds(comparisons.speeds_over_jams(emulator)),
    )
    return comparisons.network_scores(speeds, throttle) | {"off_lattice": scores}


def _documented(selection: Selection, data: xr.Dataset) -> Network:
    """The selected network with where its data come from beside how it was trained."""
    network = selection.network
    return replace(network, provenance={**data.attrs, **network.provenance})


def _surrogate_fmu(run: Run, advance: Advance, written: Written) -> dict[str, Any]:
    fmu, thrust_map = _build(run, written, "surrogate"), ThrustMap.load()
    scores = off_lattice.measured(thrust_map, off_lattice.load())
    return comparisons.compare_surrogate_fmu(fmu, thrust_map, run.seed) | {"off_lattice": scores}


def _sensitivity(run: Run, advance: Advance, written: Written) -> dict[str, Any]:
    emulator = RudderEmulator.load(run.folder)
    networks = {"package's network": RudderEmulator.load(), "paper's network": emulator}
    found, indices = rudder_sensitivity.results(
        ThrustMap.load(), networks, continued_by=emulator, finer_cells=run.sizes.finer_cells
    )
    chart = plot_bars(indices, published=published.VARIANCE_INDICES, published_label="paper", labels=figures.LABELS)
    everything = every_failure.indices(every_failure.EVERYTHING)
    _draw(run, written, indices=chart, failures=plot_bars(everything, labels=figures.LABELS))
    return found | {"failures": every_failure.results()}


def _explorer(run: Run, advance: Advance, written: Written) -> dict[str, Any]:
    """The page, where there is a compiler for browsers."""
    if find_spec("ziglang") is None:
        return {"page": None, "why": "left out: it needs Zig, pip install 'gtm-fmu[cross]'"}
    written.append(run.folder / "explorer.html")
    write_text(explorer_page(), written[-1])
    return {"page": written[-1].name}


STAGES = (
    Stage("trims", "Trims over the FMU and in the core", _trims),
    Stage("lattice", "Envelopes of the lattice", _lattice),
    Stage("jams", "Envelopes of jammed rudders", _jams),
    Stage("volume", "Envelopes over flight path", _volume),
    Stage("limits", "Highest speed over rudder limits", _limits),
    Stage("surrogate-fmu", "FMU of the surrogate", _surrogate_fmu),
    Stage("explorer", "Page of the explorer", _explorer),
    Stage("networks", "The paper's networks", _networks, ("lattice",)),
    Stage("sensitivity", "Sensitivity", _sensitivity, ("networks",)),
    Stage("feasibility", "Where an envelope exists", _feasibility),
)
"""In the order in which they run; a stage needs only stages before it."""
