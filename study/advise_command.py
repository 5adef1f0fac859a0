"""`gtm-fmu advise`: what narrows an envelope most, what is free, and what the next degree lost would cost."""

import json
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.box import SIMPLE
from rich.console import Console
from rich.table import Column, Table

from gtm_fmu.errors import InputError
from gtm_fmu.files import check_writable
from study.advice import FREE_KT, Advice, Move, advice, at, sentences
from study.files import save_figure
from study.options import FAILURE, Alpha, Altitude, Gamma, Json, Phi, given_failure, takes

NAMES = {"v_min_kt": "V_min", "v_max_kt": "V_max"}


@takes(FAILURE)
def advise(
    altitude_ft: Altitude,
    gamma_deg: Gamma = 0.0,
    alpha_deg: Alpha = (-5.0, 10.5),
    phi_deg: Phi = (-30.0, 30.0),
    plot: Annotated[Path | None, typer.Option(help="Write the costs to this picture too.")] = None,
    as_json: Json = False,
    **given: Any,
) -> None:
    """What narrows the envelope of a failure most, what is free, and what the next degree lost would cost.

    The exact slopes of V_min and V_max by altitude, flight path and every limit, to both sides, the exact envelopes
    after the next degree, per cent or 1000 ft, and the global indices beside them. Without an envelope: what would have
    to move to have one; the exit code is still 0.
    """
    from gtm_fmu.envelope_slopes import envelope_slopes

    failure = given_failure(given)
    if plot and plot.suffix != ".png":
        raise InputError(f"{plot} does not end in .png; name the picture so.")
    if plot:
        check_writable(plot)
    found = advice(envelope_slopes(altitude_ft, gamma_deg, failure, alpha_deg, phi_deg))
    values = found.to_dict()
    if plot and found.moves:
        from study.advice_figure import plot_advice

        save_figure(plot_advice(found), plot)
        values["plot"] = str(plot)
    if as_json:
        print(json.dumps(values, allow_nan=False))
        return
    console = Console()
    for sentence in sentences(found):
        console.print(sentence, highlight=False)
    if found.moves:
        console.print(_table(found))
    if plot:
        console.print(
            f"{plot} is drawn." if found.moves else "Nothing is drawn: there is no envelope.", highlight=False
        )


def _table(found: Advice) -> Table:
    """The moves that cost or gain something."""
    caption = (
        "Slopes in kn per deg, % or 1000 ft, towards where it is moved; * a kink: the other side's differs. S^T: total "
        f"index of {found.shares.of}."
    )
    shares = found.shares.outputs
    heads = ["kn\nlost", "\nV_min", "\nV_max", "slope\nV_min", "slope\nV_max"]
    heads += [f"S^T\n{NAMES.get(name, name.removesuffix('_kt'))}" for name in shares]
    columns = (Column(head, justify="right", no_wrap=True) for head in heads)
    table = Table(
        Column("\nmoved", no_wrap=True),
        *columns,
        box=SIMPLE,
        pad_edge=False,
        show_edge=False,
        collapse_padding=True,
        caption=caption,
    )
    for move in found.moves:
        if abs(move.cost) <= FREE_KT:
            continue
        total = found.shares.total.get(move.quantity.name, {})
        table.add_row(
            f"{move.quantity.name} to {at(move.change.to, move.quantity.units)}",
            "all" if move.lost_kt is None else _number(move.lost_kt),
            _number(move.change.v_min_kt),
            _number(move.change.v_max_kt),
            *(_slope(move, end) for end in ("v_min", "v_max")),
            *(_number(total.get(name)) for name in shares),
        )
    return table


def _slope(move: Move, end: str) -> str:
    slope, per = move.slope(end), 1000.0 if move.quantity.units == "ft" else 1.0
    return _number(None if slope is None else per * slope) + ("*" if end in move.slopes.kinks else "")


def _number(value: float | None) -> str:
    return "-" if value is None else f"{round(value, 2) + 0.0:.2f}"
