"""The study from end to end: FMUs, trims, linear models, envelopes, networks, sensitivity, figures, table."""

import json
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import xarray as xr
from rich.console import Console

from fmu_src.fmus import build_fmu
from gtm_fmu.datasets import lattice as dataset
from gtm_fmu.datasets import off_lattice
from gtm_fmu.envelopes import maps as surveys
from gtm_fmu.envelopes.envelope import FlightCondition
from gtm_fmu.envelopes.thrust_map import ThrustMap
from gtm_fmu.errors import InputError
from gtm_fmu.files import writable_folder
from sensitivity import plot_bars
from study.figures import maps as survey_figures
from study.figures.families import family_page, plot_family
from study.files import save_figure, write_text
from study.paper import comparisons, every_failure, figures, published, report, rudder_sensitivity
from study.progress import stages
from surrogate import Network, Selection
from surrogate.plots import plot_error_histogram, plot_performance, plot_regression
from surrogate.rudder.emulator import RudderEmulator, train


def run(output: Path, seed: int = 0, console: Console | None = None) -> dict[str, Any]:
    """Run the study into a folder and return its results.

    Every file is written in one piece or not at all, so a stopped run leaves what was finished. The same seed gives the
    same results.

    Raises:
        InputError: the folder cannot be written, or torch is missing.
    """
    if find_spec("torch") is None:
        raise InputError("The study trains networks with torch, which is not here; run pip install 'gtm-fmu[train]'.")
    output = writable_folder(output)
    results: dict[str, Any] = {}
    with stages(console or Console(stderr=True)) as stage:
        with stage("FMU of the dynamics"):
            dynamics = build_fmu("dynamics", output)
        with stage("Trims over the FMU and in the core") as advance:
            results["trims"] = comparisons.compare_trims(dynamics, seed, advance)
        with stage("Envelopes of the lattice") as advance:
            data = dataset.lattice(progress=advance)
            dataset.save(data, output / "envelopes.zarr")
            results["envelopes"] = {"cases": int(data.feasible.size), "feasible": int(data.feasible.sum())}
        with stage("Envelopes of jammed rudders") as advance:
            save_figure(plot_family(comparisons.jam_family(advance)), output / "envelope_jams.png")
        with stage("Envelopes over flight path") as advance:
            volume = surveys.volume(advance)
            save_figure(plot_family(volume), output / "volume.png")
            write_text(family_page(volume), output / "volume.html")
        with stage("Highest speed over rudder limits") as advance:
            surface = surveys.limit_surface(FlightCondition(*comparisons.JAM_CONDITION), advance=advance)
            save_figure(survey_figures.plot_limit_surface(surface), output / "limits.png")
        with stage("Where an envelope exists") as advance:
            found = surveys.feasibility_map(advance=advance)
            save_figure(survey_figures.plot_feasibility(found), output / "feasibility.png")
        with stage("The paper's networks") as advance:
            speeds, throttle = train(dataset.samples(data), seed, advance)
            emulator = RudderEmulator(*(_documented(selection, data) for selection in (speeds, throttle)))
            test_set, thrust_map = off_lattice.load(), ThrustMap.load()
            by_networks = off_lattice.measured(emulator, test_set)
            results["off_lattice_test_set"] = {
                "thrust map (GtmSurrogate.fmu)": off_lattice.measured(thrust_map, test_set),
                "the paper's networks": by_networks,
            }
            emulator.with_provenance(off_lattice=by_networks).save(output)
            results["networks"] = comparisons.network_scores(speeds, throttle)
            save_figure(plot_regression(speeds), output / "regression.png")
            save_figure(plot_performance(speeds), output / "performance.png")
            save_figure(plot_error_histogram(speeds), output / "errors.png")
        with stage("The paper's networks against exact envelopes") as advance:
            truth = comparisons.compare_emulator(emulator, data, seed, advance)
            results["off_lattice"] = truth.scores
            save_figure(figures.plot_speeds(truth.jams), output / "emulator_jams.png")
        with stage("FMU of the surrogate"):
            surrogate = build_fmu("surrogate", output)
            results["surrogate_fmu"] = comparisons.compare_surrogate_fmu(surrogate, thrust_map, seed)
        with stage("Sensitivity"):
            networks = {"package's network": RudderEmulator.load(), "paper's network": emulator}
            results["sensitivity"], indices = rudder_sensitivity.results(thrust_map, networks, continued_by=emulator)
            results["failures"] = every_failure.results()
            chart = plot_bars(
                indices, published=published.VARIANCE_INDICES, published_label="paper", labels=figures.LABELS
            )
            save_figure(chart, output / "indices.png")
            everything = every_failure.indices(every_failure.EVERYTHING)
            save_figure(plot_bars(everything, labels=figures.LABELS), output / "failures.png")
        results["fmus"] = [dynamics.name, surrogate.name]
        write_text(json.dumps(results, indent=1, allow_nan=False), output / "results.json")
        write_text(report.study_report(results), output / "results.md")
    return results


def _documented(selection: Selection, data: xr.Dataset) -> Network:
    """The selected network with where its data come from beside how it was trained."""
    network = selection.network
    return replace(network, provenance={**data.attrs, **network.provenance})
