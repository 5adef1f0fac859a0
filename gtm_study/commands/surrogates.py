"""The commands `gtm-fmu surrogates`, which measures all surrogates off the lattice, and `thrust-map` and `networks`,
which make those of the package anew.
"""

import json
from pathlib import Path
from typing import Annotated, Literal

import typer

Surveyed = Literal["rudder", "aileron", "elevator"]


def surrogates(
    output: Annotated[Path, typer.Option(help="Folder of the exact cases and of the results.")] = Path(
        "build/surrogates"
    ),
    only: Annotated[
        str | None, typer.Option(metavar="TEXT", help="Only models whose name or part holds this, as 'thrust map'.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")] = False,
) -> None:
    """Surrogates beyond the paper's: fitted, and measured on exact cases off the lattice.

    Library models, networks, jam maps, thrust maps and trim maps; errors by the number of exact searches; other
    failures. All of it takes about twenty minutes of processor time the first time. What is finished is kept: the same
    command goes on where it was stopped.
    """
    from rich.console import Console

    from gtm_study.files import save_figure, write_text
    from gtm_study.progress import stages
    from gtm_study.research import surrogate_figures
    from gtm_study.research.surrogate_report import surrogates_report
    from gtm_study.research.surrogate_study import run
    from gtm_study.style import figure_style

    results = run(output, only)
    with figure_style(), stages(Console(stderr=True)) as stage:
        with stage("Surface of least thrust") as advance:
            save_figure(surrogate_figures.plot_surface(advance), output / "surrogate_surface.png")
        with stage("Speed across a fold") as advance:
            cut = surrogate_figures.fold_cut(advance)
            save_figure(surrogate_figures.plot_fold(cut), output / "surrogate_fold.png")
        if results.keys() & {"models", "curves"}:
            save_figure(surrogate_figures.plot_errors(results), output / "surrogate_errors.png")
        if "trim map" in results:
            save_figure(surrogate_figures.plot_trims(results), output / "surrogate_trims.png")
    text = surrogates_report(results)
    write_text(text, output / "surrogates.md")
    print(json.dumps(results, allow_nan=False) if as_json else f"{text}\nAll files are in {output}.")


def networks(
    output: Annotated[Path, typer.Option(help="Folder of the networks.")] = Path("build/networks"),
    data: Annotated[Path, typer.Option(help="Folder of the exact cases, which are kept there.")] = Path(
        "build/surrogates"
    ),
    device: Annotated[str, typer.Option(help="Where the networks are trained: cpu, cuda.")] = "cpu",
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")] = False,
) -> None:
    """Train the rudder's networks anew, as they come with the package, and measure them off the lattice.

    The exact cases take six minutes of processor time. Training takes two minutes of a graphics card (--device cuda),
    and hours without one.
    """
    from functools import partial

    from rich.console import Console

    from gtm_fmu.datasets import off_lattice
    from gtm_fmu.files import writable_folder
    from gtm_study.commands.printing import show
    from gtm_study.progress import stages
    from gtm_study.research.failure_sets import solved
    from surrogate.rudder import networks as rudder_networks

    folder = writable_folder(output)
    with stages(Console(stderr=True)) as stage:
        with stage("Exact cases") as advance:
            sets = solved(writable_folder(data), rudder_networks.tables(), advance)
        with stage("Networks") as advance:
            train = partial(rudder_networks.train_emulator, device=device, progress=advance)
            emulator = train(sets["training_cases"], sets["calibration_cases"])
    scores = off_lattice.measured(emulator, off_lattice.load())
    emulator.with_provenance(off_lattice=scores).save(folder)
    show({"output": str(output), **scores}, as_json, "Networks")


def thrust_map(
    control: Annotated[
        Literal["rudder", "aileron", "elevator"], typer.Option(help="The control that fails.")
    ] = "rudder",
    output: Annotated[Path | None, typer.Option(help="File of the map; default build/CONTROL_thrust_map.npz.")] = None,
    cases: Annotated[
        int, typer.Option(min=100, max=100_000, help="Exact random cases that measure the map of another control.")
    ] = 1500,
    workers: Annotated[int | None, typer.Option(min=1, max=1024, help="Threads; default one a core.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")] = False,
) -> None:
    """Solve a thrust map anew, as it comes with the package, and measure it off the lattice.

    The rudder's takes a minute of processor time; the aileron's and the elevator's a quarter of an hour, their exact
    cases included, which are kept beside the map. A run that was stopped goes on where it was.
    """
    from dataclasses import replace

    from rich.console import Console

    from gtm_fmu.datasets import off_lattice
    from gtm_fmu.envelopes.thrust_survey import NODES, survey
    from gtm_fmu.files import check_writable
    from gtm_study.commands.printing import show
    from gtm_study.progress import stages

    output = check_writable(output or Path(f"build/{control}_thrust_map.npz"))
    kept = check_writable(output.with_name(f"{output.name}.unfinished.npz"))
    with stages(Console(stderr=True)) as stage:
        with stage("Thrust map") as advance:
            solved = survey(NODES[control], control, progress=advance, workers=workers, kept=kept)
        if control == "rudder":
            truth = off_lattice.load()
        else:
            table = off_lattice.case_table((control,), cases)
            with stage("Exact cases") as advance:
                truth = off_lattice.solve(output.with_name(f"{control}_{cases}_cases.zarr"), table, advance, workers)
    scores = off_lattice.measured(solved, truth)
    parts = {part: scores[part] for part in off_lattice.PARTS}
    replace(solved, provenance=solved.provenance | {"off_lattice": parts}).save(output)
    show({"output": str(output), **scores}, as_json, "Thrust map")
