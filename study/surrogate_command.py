"""The command `gtm-fmu surrogates`: every surrogate of the envelope, fitted and measured off the lattice."""

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
    of it takes about ten minutes of processor time the first time. What is finished is kept: the same command goes on
    where it was stopped.
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
