"""`gtm-fmu advise`: what narrows an envelope most, what is free, and what the next degree lost would cost."""

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from gtm_fmu.errors import InputError
from gtm_fmu.files import check_writable
from gtm_study.commands.options import CONDITION, FAILURE, Json, given_failure, takes
from gtm_study.files import save_figure
from gtm_study.style import figure_style


@takes(CONDITION | FAILURE)
def advise(
    plot: Annotated[Path | None, typer.Option(help="Write the costs to this picture too.")] = None,
    as_json: Json = False,
    **given: Any,
) -> None:
    """What narrows the envelope of a failure most, what is free, and what the next degree lost would cost.

    The exact slopes of V_min and V_max by altitude, flight path and every limit, to both sides, the exact envelopes
    after the next degree, per cent or 1000 ft, and the global indices beside them. Without an envelope: what would have
    to move to have one; the exit code is still 0.
    """
    from gtm_fmu.envelopes.slopes import envelope_slopes
    from gtm_study.paper.advice import advice, sentences, table

    failure = given_failure(given)
    if plot and plot.suffix != ".png":
        raise InputError(f"{plot} does not end in .png; name the picture so.")
    if plot:
        check_writable(plot)
    found = advice(envelope_slopes(limits=failure, **{name: given[name] for name in CONDITION}))
    values = found.to_dict()
    if plot and found.moves:
        from gtm_study.paper.advice_figure import plot_advice

        with figure_style():
            save_figure(plot_advice(found), plot)
        values["plot"] = str(plot)
    if as_json:
        print(json.dumps(values, allow_nan=False))
        return
    from rich.console import Console

    console = Console()
    for sentence in sentences(found):
        console.print(sentence, highlight=False)
    if found.moves:
        console.print(table(found))
    if plot:
        console.print(
            f"{plot} is drawn." if found.moves else "Nothing is drawn: there is no envelope.", highlight=False
        )
