"""The command `gtm-fmu study`: the study from end to end."""

import json
from pathlib import Path
from typing import Annotated

import typer

from gtm_study.commands.options import Json


def study(
    output: Annotated[Path, typer.Option(help="Folder of the results; what is finished there is kept.")] = Path(
        "build/study"
    ),
    level: Annotated[
        str, typer.Option(help="How far: quick (90 s on two cores), paper (10 minutes), full (about an hour).")
    ] = "paper",
    only: Annotated[
        list[str] | None, typer.Option(metavar="STAGE", help="Only this stage and what it needs. Once for each.")
    ] = None,
    listed: Annotated[bool, typer.Option("--list", help="Name the stages, and do nothing.")] = False,
    pdf: Annotated[bool, typer.Option("--pdf", help="Print the page to study.pdf too, by Chromium.")] = False,
    seed: Annotated[int, typer.Option(min=0, max=2**63 - 1, help="Start of all random numbers.")] = 0,
    as_json: Json = False,
) -> None:
    """The whole study, with figures, tables and a page, beside the published values.

    The page is there at once and grows with each stage: FMUs, trims, envelopes, networks, local model networks, data
    sets and sensitivity. A stage that is finished is not run again, and a run that was stopped goes on.
    """
    if listed:
        from gtm_study.paper.stages import STAGES

        for stage in STAGES:
            print(f"{stage.name:20} {stage.level:6} {stage.title}")
        return
    from gtm_study.kept import check_run_folder
    from gtm_study.paper.pipeline import run
    from gtm_study.paper.report import study_report
    from gtm_study.report.browser import PDF, check_browser, write_pdf
    from gtm_study.report.page import PAGE, write_page

    check_run_folder(output)
    if pdf:
        check_browser()
    results = run(output, seed, level, only or (), after_stage=write_page)
    if pdf:
        write_pdf(output / PAGE, output / PDF)
    print(
        json.dumps(results, allow_nan=False)
        if as_json
        else f"{study_report(results)}\nThe page is {output / PAGE}; all files are in {output}."
    )
