"""`gtm-fmu manoeuvre` and `gtm-fmu performance`: can this be flown, and what can still be flown at best."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gtm_fmu.aircraft.ranges import ALTITUDE_FT, GAMMA_DEG, TAS_KT, TURN_RATE_DEG_S, check_range
from gtm_fmu.errors import InputError
from gtm_study.commands.command import NO_SOLUTION
from gtm_study.commands.options import (
    ASKED,
    FAILURE,
    TOLERANCES,
    Alpha,
    Altitude,
    Gamma,
    Json,
    Option,
    Phi,
    given_failure,
    given_tolerances,
    takes,
)
from gtm_study.commands.printing import show
from gtm_study.files import check_picture, save_picture

if TYPE_CHECKING:
    from rich.table import Table

    from gtm_fmu.aircraft.failures import Failure
    from gtm_fmu.envelopes.manoeuvres import Manoeuvres
    from gtm_fmu.envelopes.performance import Performance
    from gtm_fmu.envelopes.tolerances import Tolerances

_SPEEDS = ("tas_kt", "eas_kt", "cas_kt")
_TRIM = ("alpha_deg", "beta_deg", "phi_deg", "elevator_deg", "aileron_deg", "rudder_deg", "throttle_pct")
TURN_RATE = Option(Annotated[float, typer.Option(help="Turn rate in deg/s, positive to the right.")], 0.0)
MANOEUVRE: dict[str, Option] = {name: ASKED[name] for name in _SPEEDS} | {"turn_rate_deg_s": TURN_RATE}


@takes(MANOEUVRE | FAILURE | TOLERANCES)
def manoeuvre(
    altitude_ft: Annotated[float | None, typer.Option(help="Geometric altitude, 0 to 36089 ft.")] = None,
    gamma_deg: Gamma = 0.0,
    alpha_deg: Alpha = (-5.0, 10.5),
    phi_deg: Phi = (-30.0, 30.0),
    intervals: Annotated[
        bool, typer.Option("--intervals", help="The turn rates, speeds and flight paths about it, too.")
    ] = False,
    data: Annotated[Path | None, typer.Option(help="Table of manoeuvres, in the place of one.")] = None,
    output: Annotated[Path | None, typer.Option(help="Table for the answers: .csv or .parquet.")] = None,
    as_json: Json = False,
    **given: Any,
) -> None:
    """Can this be flown: feasible or not, the margin to every limit, the limit that binds, stable, controllable.

    Where it cannot, the limits that would make it possible if they alone were moved, and how far. Exit code 3 then.
    Margins are those of the trim with the least sideslip. A table has the columns altitude_ft and tas_kt, and may have
    gamma_deg, turn_rate_deg_s and limits as rudder_lower_deg and rudder_upper_deg, which take the options' place.
    With tolerances: whether it is guaranteed, flown by all aircraft within them and in the gust, and whether it is
    possible, flown by some aircraft. Exit code 3 is about the aircraft as it should be.
    """
    failure, tolerances = given_failure(given), given_tolerances(given)
    if (data is None) != (output is None):
        raise InputError("A table is answered by another: give --data and --output, or neither.")
    if data is not None and output is not None:
        if intervals or altitude_ft is not None or any(given[name] is not None for name in _SPEEDS):
            raise InputError("Manoeuvres are in the table: leave out --altitude-ft, the speed and --intervals.")
        rows = _answer_table(data, output, gamma_deg, given["turn_rate_deg_s"], failure, alpha_deg, phi_deg, tolerances)
        return show({"output": str(output), **rows}, as_json, "Manoeuvres")
    if altitude_ft is None:
        raise InputError("Missing option '--altitude-ft'; see `gtm-fmu manoeuvre --help`.")
    from gtm_fmu.envelopes.manoeuvres import manoeuvres

    tas_kt = _speed(altitude_ft, given)
    rate = check_range("turn rate in deg/s", given["turn_rate_deg_s"], TURN_RATE_DEG_S)
    check_range("gamma in deg", gamma_deg, GAMMA_DEG)
    found = manoeuvres(altitude_ft, tas_kt, gamma_deg, rate, failure, alpha_deg, phi_deg)
    values: dict[str, Any] = found.to_dict(0)
    if not found.feasible[0]:
        from gtm_fmu.envelopes.remedies import remedies

        values["remedies"] = [remedy.to_dict() for remedy in remedies(found, 0)]
    if tolerances:
        from gtm_fmu.envelopes.tolerant_manoeuvres import tolerant_manoeuvres

        values |= tolerant_manoeuvres(found, tolerances).to_dict(0)
    if intervals:
        from gtm_fmu.envelopes.sections import climb_interval, speed_interval, turn_rate_interval

        bounds = failure, alpha_deg, phi_deg
        sections = (
            turn_rate_interval(altitude_ft, tas_kt, gamma_deg, *bounds),
            speed_interval(altitude_ft, gamma_deg, rate, *bounds),
            climb_interval(altitude_ft, tas_kt, rate, *bounds),
        )
        values["intervals"] = {section.name: [list(ends) for ends in section.intervals] for section in sections}
    show(values if as_json else _rows(values), as_json, "Can this be flown?")
    if not found.feasible[0]:
        raise typer.Exit(NO_SOLUTION)


def _speed(altitude_ft: float, given: dict[str, Any]) -> float:
    """True airspeed in kn of the one speed that is given."""
    from gtm_fmu.aircraft import airspeed

    told = {name: given[name] for name in _SPEEDS if given[name] is not None}
    if len(told) != 1:
        raise InputError("A manoeuvre has one speed: give one of --tas-kt, --eas-kt and --cas-kt.")
    ((name, speed),) = told.items()
    at = check_range("altitude in ft", altitude_ft, ALTITUDE_FT)
    speed = check_range(f"{name.removesuffix('_kt')} in kn", speed, TAS_KT)
    convert = {"tas_kt": lambda kt, _: kt, "eas_kt": airspeed.tas_of_eas, "cas_kt": airspeed.tas_of_cas}
    return float(convert[name](speed, at))


def _rows(values: dict[str, Any]) -> dict[str, Any]:
    """An answer as a person reads it."""
    rows = {name: values[name] for name in ("feasible", "binding", "stable", "controllable")}
    rows |= {name: values[name] for name in ("guaranteed", "possible") if name in values}
    if unfit := values.get("not_flown_by"):
        aircraft = ", ".join(f"{name} {value:+.3g}" for name, value in unfit["aircraft"].items() if value)
        rows["not guaranteed, as not flown by"] = f"{aircraft or 'the aircraft as it is'} at {unfit['tas_kt']:.2f} kn"
    if values["trim"] is None:
        rows["why not"] = "no trim at any limit"
    for remedy in values.get("remedies", ()):
        title = f"possible with {remedy['limit']} at, {remedy['units']}"
        rows[title] = f"{remedy['needed']:.4g} (it is {remedy['value']:.4g}, a move of {remedy['move']:+.4g})"
    if values["trim"] is not None and values.get("remedies") == []:
        rows["why not"] = "no limit by itself would make it possible"
    for name, (lower, upper) in values["margins"].items():
        rows[f"margin of {name}"] = f"{lower:.4g} to the lower limit, {upper:.4g} to the upper"
    if values["thrust_margin_n"]:
        lower, upper = values["thrust_margin_n"]
        rows["margin of thrust_n"] = f"{lower:.4g} to the least, {upper:.4g} to the most"
    for name, (lower, upper) in (values.get("least_margins") or {}).items():
        rows[f"guaranteed margin of {name}"] = f"{lower:.4g} to the lower limit, {upper:.4g} to the upper"
    for name, ends in values.get("intervals", {}).items():
        rows[f"interval of {name}"] = [f"{low:.4f} .. {high:.4f}" for low, high in ends]
    return rows | {f"trim: {name}": values["trim"][name] for name in _TRIM if name in (values["trim"] or {})}


def _answer_table(
    data: Path,
    output: Path,
    gamma_deg: float,
    turn_rate_deg_s: float,
    failure: "Failure",
    alpha_deg: tuple[float, float],
    phi_deg: tuple[float, float],
    tolerances: "Tolerances | None",
) -> dict[str, int]:
    """Write the answers about all rows of a table beside them; how many rows, and how many of them are feasible."""
    from gtm_fmu.aircraft.inputs import LIMITED, limit_columns
    from gtm_fmu.envelopes.manoeuvres import manoeuvres
    from gtm_fmu.files import check_kept
    from surrogate import Variable
    from surrogate.training.samples import inputs_of_table
    from surrogate.training.tables import check_table, read_table, with_results, write_table

    check_kept(output, data)
    check_table(output)
    table = read_table(data)
    asked = {"altitude_ft": "ft", "tas_kt": "kt", "gamma_deg": "deg", "turn_rate_deg_s": "deg/s"}
    ends = {
        column[0].label: tuple(end.label for end in limit_columns(control))
        for control, column in LIMITED.items()
        if any(end.label in table.names for end in limit_columns(control))
    }
    defaults = {"gamma_deg": gamma_deg, "turn_rate_deg_s": turn_rate_deg_s}
    names = [name for name in asked if name in table.names or name not in defaults]
    names += [end for pair in ends.values() for end in pair]
    X, rows = inputs_of_table([Variable(name, asked.get(name, "")) for name in names], table)
    columns = dict(zip(names, X.T, strict=True))
    failures: Any = failure
    if ends:
        known: dict[tuple[float, ...], Failure] = {}
        limits = [tuple(float(columns[end][k]) for pair in ends.values() for end in pair) for k in range(len(X))]
        for row in set(limits):
            known[row] = failure
            for label, low, high in zip(ends, row[::2], row[1::2], strict=True):
                known[row] = known[row].with_limits(label, (low, high))
        failures = [known[row] for row in limits]
    path, rate = (columns.get(name, defaults[name]) for name in ("gamma_deg", "turn_rate_deg_s"))
    found = manoeuvres(columns["altitude_ft"], columns["tas_kt"], path, rate, failures, alpha_deg, phi_deg)
    answers, counts = _columns(found), {"rows": len(found), "feasible": int(found.feasible.sum())}
    if tolerances:
        from gtm_fmu.envelopes.tolerant_manoeuvres import tolerant_manoeuvres

        told = tolerant_manoeuvres(found, tolerances)
        for name in ("guaranteed", "possible"):
            answers[name] = getattr(told, name)
            counts[name] = int(answers[name].sum())
    write_table(with_results(rows, answers, data), output)
    return counts


def _columns(found: "Manoeuvres") -> dict[str, Any]:
    """The answers as columns of a table, without a value where there is none."""
    import numpy as np

    margins = [found.margins(k) for k in range(len(found))]
    names = dict.fromkeys(name for row in margins for name in row)
    missing = (np.nan, np.nan)
    columns: dict[str, Any] = {
        "feasible": found.feasible,
        "stable": found.stable,
        "controllable": found.controllable,
        "binding": np.array([name or "" for name in found.binding], dtype=object),
    }
    for name in names:
        quantity, unit = name.rsplit("_", 1)
        for side, word in enumerate(("lower", "upper")):
            columns[f"{quantity}_margin_{word}_{unit}"] = np.array([row.get(name, missing)[side] for row in margins])
    thrust = np.where(found.is_trimmed[:, None], found.thrust_margin_n, np.nan)
    columns |= {f"thrust_margin_{word}_n": thrust[:, side] for side, word in enumerate(("lower", "upper"))}
    trims = [found.trim(k) for k in range(len(found))]
    return columns | {
        f"trim_{name}": np.array([getattr(trim, name, None) for trim in trims], dtype=float) for name in _TRIM
    }


@takes(FAILURE)
def performance(
    altitude_ft: Altitude,
    gamma_deg: Gamma = 0.0,
    alpha_deg: Alpha = (-5.0, 10.5),
    phi_deg: Phi = (-30.0, 30.0),
    plot: Annotated[
        Path | None, typer.Option(help="Write turn rates and flight paths over speed to this .png or .html.")
    ] = None,
    as_json: Json = False,
    **given: Any,
) -> None:
    """What can still be flown at best, beside the healthy aircraft.

    Speeds, turn rates and radii to either side at --gamma-deg; the steepest and the fastest climb; the flattest glide
    and the least sink, with the throttles at their lowest and with both engines out; speeds of straight flight.
    """
    from rich.console import Console

    from gtm_fmu.aircraft.failures import Failure
    from gtm_fmu.envelopes.performance import performance as extremes
    from gtm_study.progress import stages

    failure, healthy = given_failure(given), Failure()
    if plot:
        check_picture(plot)
    cases = {"healthy": healthy} | ({"failure": failure} if failure != healthy else {})
    found: dict[str, Performance] = {}
    with stages(Console(stderr=True, quiet=as_json)) as stage:
        for name, each in cases.items():
            with stage(f"Performance: {name}") as advance:
                found[name] = extremes(altitude_ft, each, gamma_deg, alpha_deg, phi_deg, advance)
    if plot:
        from gtm_study.figures.performance import performance_page, plot_performance

        bounds = alpha_deg, phi_deg
        save_picture(plot, lambda: plot_performance(found, *bounds), lambda: performance_page(found, *bounds))
    if as_json:
        values: dict[str, Any] = {name: each.to_dict() for name, each in found.items()}
        show(values | ({"plot": str(plot)} if plot else {}), True, "")
    else:
        Console().print(_extremes(found))


def _extremes(found: "dict[str, Performance]") -> "Table":
    from rich.table import Table

    from gtm_study.figures.captions import condition

    healthy = found["healthy"]
    title = f"Performance at {condition(healthy.altitude_ft, healthy.gamma_deg)}"
    told = list(found.values())[-1]
    columns = [*found, "reached at kn, deg/s, deg"]
    table = Table(title=title, title_justify="left")
    table.add_column("quantity", no_wrap=True)
    for name in columns:
        table.add_column(name)
    straight = ([f"{low:.2f} .. {high:.2f}" for low, high in each.straight_tas_kt] for each in found.values())
    table.add_row("straight flight, kn", *(", ".join(text) or "no" for text in straight), "")
    for k, extreme in enumerate(healthy.extremes):
        values = [each.extremes[k].value for each in found.values()]
        trim = told.extremes[k].trim
        at = (trim.tas_kt, trim.turn_rate_deg_s, trim.gamma_deg) if trim else ()
        place = ", ".join(f"{round(value, 1) + 0.0:g}" for value in at)
        table.add_row(extreme.name, *("-" if value is None else f"{value:.2f}" for value in values), place)
    return table
