"""The command `gtm-fmu study`: the study from end to end."""

import json
from pathlib import Path
from typing import Annotated

import typer

from study.commands.options import Json


def study(
    output: Annotated[Path, typer.Option(help="Folder of the results.")] = Path("build/study"),
    seed: Annotated[int, typer.Option(min=0, max=2**63 - 1, help="Start of all random numbers.")] = 0,
    as_json: Json = False,
) -> None:
    """The whole study, with figures and a results table.

    FMUs, trims, linear models, envelopes, networks and sensitivity, beside the published values.
    """
    from study.paper.pipeline import run
    from study.paper.report import study_report

    results = run(output, seed)
    print(json.dumps(results, allow_nan=False) if as_json else f"{study_report(results)}\nAll files are in {output}.")
