"""The command `gtm-fmu envelope`: V_min and V_max of one flight condition, or of many along an axis."""

from pathlib import Path
from typing import Annotated, Any

import typer

from gtm_fmu.aircraft.ranges import ALPHA_DEG, PHI_DEG
from gtm_fmu.errors import InputError
from gtm_study.commands.options import FAILURE, TOLERANCES, Alpha, Json, Phi, given_failure, given_tolerances, takes
from gtm_study.commands.printing import show
from gtm_study.commands.trims import described
from gtm_study.files import check_picture


@takes(FAILURE | TOLERANCES)
def envelope(
    altitude_ft: Annotated[float | None, typer.Option(help="Geometric altitude, 0 to 36089 ft; required.")] = None,
    gamma_deg: Annotated[float | None, typer.Option(help="Flight-path angle in deg, in a climb positive.")] = None,
    alpha_deg: Alpha = ALPHA_DEG,
    phi_deg: Phi = PHI_DEG,
    over: Annotated[
        tuple[str, float, float, float] | None,
        typer.Option(metavar="AXIS LOWER UPPER STEP", help="Vary gamma, altitude, or the position a control jams at."),
    ] = None,
    plot: Annotated[Path | None, typer.Option(help="Write turn rate over speed to this .png or .html too.")] = None,
    as_json: Json = False,
    **given: Any,
) -> None:
    """Lowest and highest speed that a failure leaves, exact.

    The trims at both ends come with them, and the slopes: what each limit, the altitude, the flight path and the
    airframe move the speeds by. Without any envelope "feasible" is false, the manoeuvre that exceeds the limits least
    comes as the nearest, and the exit code is still 0.
    With --over, envelopes along an axis with their polygons, as --over gamma -5 5 1 or --over rudder -30 30 10.
    With tolerances the speeds come twice more: guaranteed, inside the envelopes of all aircraft within them and with
    room for the gust, and possible, inside that of some aircraft. --over then tells and draws these.
    """
    from gtm_fmu.envelopes.envelope import FlightCondition

    limits, tolerances = given_failure(given), given_tolerances(given)
    if tolerances and plot and not over:
        raise InputError("With tolerances --plot draws speeds along an axis; give --over too, or leave one out.")
    if over:
        from gtm_study.commands.family import check_over, show_family

        check_over(over, altitude_ft, gamma_deg, given)
        altitude_ft = over[1] if over[0] == "altitude" else altitude_ft
    if altitude_ft is None:
        raise InputError("Missing option '--altitude-ft'; see `gtm-fmu envelope --help`.")
    if plot:
        check_picture(plot)
    condition = FlightCondition(altitude_ft, gamma_deg or 0.0, limits, alpha_deg, phi_deg)
    if over and tolerances:
        from gtm_study.commands.family import show_tolerant_family

        return show_tolerant_family(condition, tolerances, over, plot, as_json)
    if over:
        return show_family(condition, over, plot, as_json)
    found = condition.envelope()
    values = found.to_dict() | {"intervals_kt": condition.intervals()}
    for end in ("at_v_min", "at_v_max", "nearest"):
        values[end] = (trim := getattr(found, end)) and described(trim)
    if tolerances:
        from gtm_fmu.envelopes.tolerant_envelope import tolerant_envelope_of

        values |= tolerant_envelope_of(condition, tolerances).to_dict()
    values["slopes"] = {slope.name: slope.to_dict() for slope in found.slopes}
    if plot:
        from gtm_study.figures.envelopes import save_envelope

        save_envelope(condition, plot)
        values["plot"] = str(plot)
    from gtm_study.commands.words import envelope_rows

    show(values if as_json else envelope_rows(found, values), as_json, "Envelope")
