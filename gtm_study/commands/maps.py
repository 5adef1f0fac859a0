"""The commands `gtm-fmu map`: pictures of many envelopes, V_max over limits and where an envelope exists."""

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer
from rich.console import Console

from gtm_fmu.progress import Advance
from gtm_study.commands.command import Commands
from gtm_study.commands.options import FAILURE, TOLERANCES, check_varied, given_failure, given_tolerances, takes
from gtm_study.files import check_picture, save_picture
from gtm_study.progress import stages

if TYPE_CHECKING:
    from gtm_fmu.envelopes.tolerances import Tolerances

Range3 = tuple[float, float, float]
Plot = Annotated[Path, typer.Option(help="The picture (.png) or interactive page (.html) to write.")]
Control = Annotated[str, typer.Option(help="elevator, aileron, rudder or throttle.")]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")]

Envelopes = Annotated[
    Literal["guaranteed", "possible"], typer.Option(help="With tolerances or a gust: which envelopes to survey.")
]

maps = Commands(help="Pictures of many envelopes, for any failure.")


@contextmanager
def _picture(plot: Path, name: str) -> Iterator[tuple[Advance, Callable]]:
    """A progress bar, and how to write the picture, whose name is checked before anything is computed."""
    check_picture(plot)
    with stages(Console(stderr=True)) as stage, stage(name) as advance:
        yield advance, partial(save_picture, plot)


def _show(values: dict[str, Any], plot: Path, as_json: bool) -> None:
    print(json.dumps(values | {"plot": str(plot)}, allow_nan=False) if as_json else f"The picture is {plot}.")


def _of(tolerances: "Tolerances | None", envelopes: str) -> dict[str, Any]:
    """Which envelopes were surveyed, for JSON."""
    return {} if tolerances is None else {"envelopes": envelopes, "tolerances": asdict(tolerances)}


def _lattice(text: str) -> Any:
    return typer.Option(metavar="LOWER UPPER STEP", help=text)


@maps.command(epilog="\b\nExample:\n  gtm-fmu map limits --altitude-ft 10000 --gamma-deg 0 --plot limits.png")
@takes(FAILURE | TOLERANCES)
def limits(
    altitude_ft: Annotated[float, typer.Option(help="Geometric altitude, 0 to 36089 ft.")],
    plot: Plot,
    gamma_deg: Annotated[float, typer.Option(help="Flight-path angle in deg.")] = 0.0,
    control: Control = "rudder",
    step: Annotated[float, typer.Option(help="Between the limits, in deg or %.")] = 1.0,
    envelopes: Envelopes = "guaranteed",
    as_json: Json = False,
    **given: Any,
) -> None:
    """V_max over the lower and upper limit of a control, and its jams.

    With tolerances it is the guaranteed or the possible one.
    """
    from gtm_fmu.envelopes import maps as surveys
    from gtm_fmu.envelopes.envelope import FlightCondition
    from gtm_study.figures import maps as survey_figures

    check_varied(control, given)
    condition, tolerances = FlightCondition(altitude_ft, gamma_deg, given_failure(given)), given_tolerances(given)
    with _picture(plot, "Highest speeds") as (advance, save):
        found = surveys.limit_surface(condition, control, step, advance, tolerances, envelopes)
        save(lambda: survey_figures.plot_limit_surface(found), lambda: survey_figures.surface_page(found))
    v_max = [[None if speed != speed else speed for speed in row] for row in found.v_max_kt.tolist()]
    values = {"control": found.control.label, "limits": found.limits.tolist(), "v_max_kt": v_max}
    _show(values | _of(tolerances, envelopes), plot, as_json)


@maps.command(epilog="\b\nExample:\n  gtm-fmu map feasibility --control rudder --plot feasibility.png")
@takes(FAILURE | TOLERANCES)
def feasibility(
    plot: Plot,
    control: Control = "rudder",
    step: Annotated[float | None, typer.Option(help="Between the jams, in deg or %; default 2.")] = None,
    altitudes_ft: Annotated[Range3, _lattice("Altitudes in ft.")] = (0.0, 36000.0, 3000.0),
    gammas_deg: Annotated[Range3, _lattice("Flight-path angles in deg.")] = (-5.0, 5.0, 1.0),
    envelopes: Envelopes = "guaranteed",
    as_json: Json = False,
    **given: Any,
) -> None:
    """Where a jam of a control leaves an envelope: the largest over altitude and flight path.

    With tolerances: where it leaves a guaranteed, or a possible one.
    """
    from gtm_fmu.envelopes import maps as surveys
    from gtm_study.commands.family import positions
    from gtm_study.figures import maps as survey_figures

    check_varied(control, given)
    lattice = positions("altitudes in ft", *altitudes_ft), positions("gammas in deg", *gammas_deg)
    failure, tolerances = given_failure(given), given_tolerances(given)
    with _picture(plot, "Where an envelope exists") as (advance, save):
        found = surveys.feasibility_map(failure, control, step, *lattice, advance, tolerances, envelopes)
        save(lambda: survey_figures.plot_feasibility(found), lambda: survey_figures.feasibility_page(found))
    values = {"control": found.control.label, "jams": list(found.jams), "altitudes_ft": lattice[0]}
    values |= {"gammas_deg": lattice[1], "feasible": found.feasible.tolist()}
    _show(values | _of(tolerances, envelopes), plot, as_json)
