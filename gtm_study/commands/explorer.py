"""`gtm-fmu explorer`: the page that computes envelopes while its sliders move."""

import json
import sys
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from gtm_fmu.errors import InputError
from gtm_fmu.files import check_writable
from gtm_study.files import write_text
from gtm_study.progress import stages


def explorer(
    output: Annotated[Path, typer.Option(help="The page (.html) to write.")] = Path("build/explorer.html"),
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")] = False,
) -> None:
    """A page to explore failures in: exact envelopes, solved in the browser as sliders move.

    One file that needs no network, with the compiled core inside. Making it takes the extra 'cross'.
    """
    if output.suffix != ".html":
        raise InputError(f"{output} does not end in .html; name the page so.")
    check_writable(output)
    from gtm_study.explorer.page import explorer_page
    from gtm_study.paper.advice import shares_by_kind

    with stages(Console(stderr=True, quiet=not sys.stderr.isatty())) as stage, stage("Compile the core for browsers"):
        write_text(explorer_page(shares_by_kind()), output)
    print(json.dumps({"page": str(output)}) if as_json else f"The page is {output}.")
