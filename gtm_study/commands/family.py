"""`gtm-fmu envelope --over`: envelopes along an axis, printed and drawn."""

from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from gtm_fmu.envelopes.envelope import FlightCondition
from gtm_fmu.envelopes.family import EnvelopeFamily, envelope_family
from gtm_fmu.envelopes.tolerances import Tolerances
from gtm_fmu.envelopes.tolerant_family import tolerant_family
from gtm_fmu.errors import InputError
from gtm_study.commands.options import check_varied
from gtm_study.files import save_picture
from gtm_study.progress import stages

MOST_VALUES = 1000
Over = tuple[str, float, float, float]


def positions(name: str, lower: float, upper: float, step: float) -> list[float]:
    """From the lower to the upper value in steps, both included where they fit.

    Raises:
        InputError: not finite, reversed, or a step that is not positive or too small.
    """
    if not np.isfinite([lower, upper, step]).all() or lower > upper:
        raise InputError(f"{name} {lower:g} {upper:g} {step:g} are no range; give lower, upper and step.")
    if not step > 0 or (upper - lower) / step >= MOST_VALUES:
        raise InputError(f"{name}: a step of {step:g} gives none or over {MOST_VALUES} values; give another.")
    return (lower + step * np.arange(np.floor((upper - lower) / step + 1e-9) + 1)).tolist()


def check_over(over: Over, altitude_ft: float | None, gamma_deg: float | None, given: dict[str, Any]) -> None:
    """Refuse what is both held and varied.

    Raises:
        InputError: it is.
    """
    check_varied(over[0], given)
    if {"altitude": altitude_ft, "gamma": gamma_deg}.get(over[0]) is not None:
        raise InputError(f"The {over[0]} is either held or varied; leave out --over or its own option.")


def show_family(condition: FlightCondition, over: Over, plot: Path | None, as_json: bool) -> None:
    """Compute, draw and print the envelopes along an axis."""
    from gtm_study.commands.printing import show
    from gtm_study.figures.families import family_page, plot_family

    name, *lattice = over
    values = positions(name, *lattice)
    with stages(Console(stderr=True, quiet=as_json)) as stage, stage(f"Envelopes over {name}") as advance:
        family = envelope_family(condition, name, values, progress=advance)
    if plot:
        save_picture(plot, lambda: plot_family(family), lambda: family_page(family))
    if as_json:
        show(family.to_dict() | ({"plot": str(plot)} if plot else {}), True, "")
    else:
        Console().print(_table(family))


def show_tolerant_family(
    condition: FlightCondition, tolerances: Tolerances, over: Over, plot: Path | None, as_json: bool
) -> None:
    """Compute, draw and print guaranteed and possible speeds along an axis."""
    from gtm_study.commands.printing import show
    from gtm_study.figures.tolerances import plot_tolerances, tolerances_page

    name, *lattice = over
    values = positions(name, *lattice)
    with stages(Console(stderr=True, quiet=as_json)) as stage, stage(f"Envelopes over {name}") as advance:
        family = tolerant_family(condition, name, values, tolerances, progress=advance)
    if plot:
        save_picture(plot, lambda: plot_tolerances(family), lambda: tolerances_page(family))
    if as_json:
        show(family.to_dict() | ({"plot": str(plot)} if plot else {}), True, "")
        return
    table = Table(family.axis.label, "guaranteed, kn", "nominal, kn", "possible, kn", title_justify="left")
    table.title = f"Speeds over {family.axis.name}"
    for value, speeds in zip(family.values, family.speeds_kt.tolist(), strict=True):
        table.add_row(f"{value:g}", *("none" if low != low else f"{low:.2f} .. {high:.2f}" for low, high in speeds))
    Console().print(table)


def _table(family: EnvelopeFamily) -> Table:
    columns = family.axis.label, "v_min_kt", "v_max_kt", "t_min_pct", "manoeuvres", "stable"
    table = Table(*columns, title=f"Envelopes over {family.axis.name}", title_justify="left")
    for member in family.members:
        ends = (member.envelope.v_min_kt, member.envelope.v_max_kt, member.envelope.t_min_pct)
        counts = member.to_dict()["manoeuvres"]
        numbers = ["-" if end is None else f"{end:.2f}" for end in ends]
        table.add_row(f"{member.value:g}", *numbers, str(counts["accepted"]), str(counts["stable"]))
    return table
