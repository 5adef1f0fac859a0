"""The commands `gtm-fmu trim` and `gtm-fmu linearize`: one steady manoeuvre, and the linear model at it."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gtm_fmu.errors import InputError
from gtm_study.commands.command import NO_SOLUTION
from gtm_study.commands.options import ASKED, CONDITION, FAILURE, Json, given_failure, takes
from gtm_study.commands.printing import show

if TYPE_CHECKING:
    from gtm_fmu.trims.manoeuvre import Trim

Fmu = Annotated[Path | None, typer.Option(help="Evaluate this GtmDynamics.fmu, or a native one, not the core.")]


@takes(CONDITION | ASKED | FAILURE)
def trim(
    fmu: Fmu = None,
    as_json: Json = False,
    **given: Any,
) -> None:
    """Trim: the controls of one steady manoeuvre.

    Besides altitude and flight path it takes a speed and two conditions, with a jammed rudder a speed and one. Straight
    flight where none is given, and of several trims the one with the least sideslip; of turns to either side the right
    one. Exit code 3 if the limits leave none; the nearest is printed all the same.
    """
    with _aircraft(fmu, given) as (solve, _):
        found = solve(**{name: given[name] for name in CONDITION})
    _show_trim(found, as_json, "Steady manoeuvre")
    if not found.feasible:
        raise typer.Exit(NO_SOLUTION)


@takes(CONDITION | ASKED | FAILURE)
def linearize(
    fmu: Fmu = None,
    as_json: Json = False,
    **given: Any,
) -> None:
    """Linear model at a steady manoeuvre.

    A, B, eigenvalues, stability and controllability.
    States u v w p q r phi theta in ft/s, rad/s, rad; inputs elevator, aileron, rudder in deg and throttle in %, without
    the jammed ones. Exit code 3 if the limits leave no such manoeuvre.
    """
    with _aircraft(fmu, given) as (solve, linear_model):
        found = solve(**{name: given[name] for name in CONDITION})
        model = linear_model(found) if found.feasible else None
    from gtm_study.commands.words import model_rows

    if model is None:
        _show_trim(found, as_json, "No such steady manoeuvre; the nearest")
        raise typer.Exit(NO_SOLUTION)
    show(model.to_dict() if as_json else model_rows(model), as_json, "Linear model")


def described(found: "Trim") -> dict[str, Any]:
    """A trim with its stability and controllability, which the nearest to one does not have."""
    from gtm_fmu.trims.linearization import linearize as linear_model

    verdicts = linear_model(found).verdicts if found.feasible else {"stable": None, "controllable": None}
    return found.to_dict() | verdicts


def _show_trim(found: "Trim", as_json: bool, title: str) -> None:
    from gtm_study.commands.words import trim_rows

    values = described(found)
    show(values if as_json else trim_rows(found, values), as_json, title)


@contextmanager
def _aircraft(fmu: Path | None, given: dict[str, Any]) -> Iterator[tuple[Callable, Callable]]:
    """How to trim as `given` asks, and how to linearise: by the core, or over evaluations of an FMU."""
    from gtm_fmu.core import solver
    from gtm_fmu.trims import linearization, steady

    failure = given_failure(given)
    asked = {"limits": failure} | {name: given[name] for name in ASKED}
    if fmu is None:
        yield partial(steady.trim, **asked), linearization.linearize
        return
    if failure.airframe != solver.STUDY:
        raise InputError(
            f"'{fmu}' is the study's airframe with one throttle; leave out --fmu, or the options of another."
        )
    from fmu_src.description.dynamics_variables import dynamics_description
    from gtm_fmu.aircraft.client import FmuClient, FmuError
    from gtm_fmu.aircraft.evaluation import FmuAirframe
    from gtm_fmu.trims.fmu_trimmer import FmuTrimmer

    groups = dynamics_description().groups
    states, rates, controls = ([v.name for v in groups[name]] for name in ("states", "derivatives", "controls"))
    try:
        with FmuClient(fmu, states=states, derivatives=rates, controls=controls) as client:
            yield partial(FmuTrimmer(client).trim, **asked), partial(linearization.linearize_fmu, FmuAirframe(client))
    except FmuError as error:
        raise InputError(f"'{fmu}' cannot be evaluated ({error}); give a GtmDynamics.fmu built here.") from error
