"""The commands `gtm-fmu surrogates`, all surrogates measured off the lattice, and `gtm-fmu thrust-map`, the best."""

import json
from pathlib import Path
from typing import Annotated

import typer


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

    Library models, networks, jam maps and the thrust map; errors by the number of exact searches; other failures. All
    of it takes about a quarter of an hour of processor time the first time. What is finished is kept: the same command
    goes on where it was stopped.
    """
    from rich.console import Console

    from study import surrogate_figures
    from study.files import save_figure, write_text
    from study.progress import stages
    from study.surrogate_report import markdown
    from study.surrogate_study import run

    results = run(output, only)
    with stages(Console(stderr=True)) as stage:
        with stage("Surface of least thrust") as advance:
            save_figure(surrogate_figures.plot_surface(advance), output / "surrogate_surface.png")
        with stage("Speed across a fold") as advance:
            cut = surrogate_figures.fold_cut(advance)
            save_figure(surrogate_figures.plot_fold(cut), output / "surrogate_fold.png")
    save_figure(surrogate_figures.plot_errors(results), output / "surrogate_errors.png")
    text = markdown(results)
    write_text(text, output / "surrogates.md")
    print(json.dumps(results, allow_nan=False) if as_json else f"{text}\nAll files are in {output}.")


def thrust_map(
    output: Annotated[Path, typer.Option(help="File of the map.")] = Path("build/rudder_thrust_map.npz"),
    workers: Annotated[int | None, typer.Option(min=1, help="Threads; default one a core.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")] = False,
) -> None:
    """Solve the rudder's thrust map anew, as it comes with the package, and measure it off the lattice.

    It takes a minute of processor time. A run that was stopped goes on where it was.
    """
    from dataclasses import replace

    from rich.console import Console

    from gtm_fmu.files import check_writable
    from gtm_fmu.thrust_survey import Nodes, survey
    from study import off_lattice
    from study.cli import show
    from study.progress import stages
    from study.surrogate_study import measured_map

    check_writable(output)
    kept = check_writable(output.with_name(f"{output.name}.unfinished.npz"))
    with stages(Console(stderr=True)) as stage, stage("Thrust map") as advance:
        solved = survey(Nodes(), progress=advance, workers=workers, kept=kept)
    scores = measured_map(solved, off_lattice.load())
    parts = {part: scores[part] for part in off_lattice.PARTS}
    replace(solved, provenance=solved.provenance | {"off_lattice": parts}).save(output)
    show({"output": str(output), **scores}, as_json, "Thrust map")
