"""The command `gtm-fmu protocol`: the paper's comparison of neural networks and local model networks."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from gtm_fmu.extras import check_installed
from gtm_fmu.progress import Advance
from gtm_study.files import write_text
from gtm_study.kept import check_run_folder, run_folder
from gtm_study.progress import stages
from gtm_study.style import figure_style

if TYPE_CHECKING:
    from gtm_study.paper.protocol import Lattice


def protocol(
    output: Annotated[Path, typer.Option(help="Folder of the results; parts that are there are kept.")] = Path(
        "build/protocol"
    ),
    splits: Annotated[int, typer.Option(min=1, max=1000, help="Divisions of the data, by seeds from 0 on.")] = 5,
    data_set_splits: Annotated[int, typer.Option(min=1, max=1000, help="Of them for the diminished data sets.")] = 3,
    rounds: Annotated[int, typer.Option(min=2, max=1000, help="Trainings of each selection.")] = 20,
    jobs: Annotated[int, typer.Option(min=1, max=256, help="Processes for the local model networks.")] = 2,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")] = False,
) -> None:
    """Neural networks and local model networks by the paper's Algorithms 1 and 2, on its lattice and off it.

    Bayesian regularisation and Levenberg-Marquardt, LOLIMOT and HILOMOT, the diminished data sets and the number of
    hidden neurons, beside the published values. A stopped run goes on where it was.
    """
    check_run_folder(output)
    check_installed("torch", "Networks are trained with")
    from gtm_study.paper.protocol import Protocol, run
    from gtm_study.paper.protocol_report import protocol_report, summary

    folder = run_folder(output)
    with figure_style(), stages(Console(stderr=True)) as stage:
        with stage("Envelopes of the lattice") as advance:
            lattice = _lattice(folder / "envelopes.zarr", advance)
        comparison = Protocol(lattice, folder, rounds, jobs)
        results = summary(run(comparison, splits, min(splits, data_set_splits), stage))
    write_text(json.dumps(results, indent=1, allow_nan=False), folder / "results.json")
    write_text(protocol_report(results), folder / "results.md")
    print(
        json.dumps(results, allow_nan=False) if as_json else f"{protocol_report(results)}\nAll files are in {folder}."
    )


def _lattice(store: Path, advance: Advance) -> "Lattice":
    """The feasible cases of the lattice, solved once."""
    import numpy as np

    from gtm_fmu.datasets import lattice as dataset
    from gtm_study.paper.protocol import Lattice

    X, V, _ = dataset.samples(dataset.solved(store, dataset.lattice(), advance))
    feasible = np.isfinite(V).all(axis=1)
    return Lattice(X[feasible], V[feasible])
