"""The command line `gtm-fmu`: thin commands over the packages, one sentence for every mistake."""

import errno
import io
import json
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from typer.exceptions import TyperException

from gtm_fmu import __version__
from gtm_fmu.errors import InputError
from study.commands.advise import advise
from study.commands.command import Commands
from study.commands.dataset import dataset
from study.commands.doctor import doctor
from study.commands.explorer import explorer
from study.commands.machine import shortage
from study.commands.maps import maps
from study.commands.models import export, predict, train
from study.commands.options import ASKED, FAILURE, Alpha, Altitude, Gamma, Json, Phi, given_failure, takes
from study.commands.printing import show
from study.commands.protocol import protocol
from study.commands.sensitivity import sensitivity
from study.commands.surrogates import networks, surrogates, thrust_map
from study.files import check_picture
from surrogate.rudder.names import MODEL_HELP

if TYPE_CHECKING:
    from gtm_fmu.trims.manoeuvre import Trim

BAD_INPUT, NO_SOLUTION, INTERRUPTED = 2, 3, 130

app = Commands(
    name="gtm-fmu",
    help="Flight envelopes of the impaired NASA Generic Transport Model: FMUs, trims, envelopes, surrogates.",
    pretty_exceptions_enable=False,
)

Fmu = Annotated[Path | None, typer.Option(help="Evaluate this GtmDynamics.fmu, or a native one, not the core.")]


def _show_version(is_asked: bool) -> None:
    if is_asked:
        print(f"gtm-fmu {__version__}")
        raise typer.Exit


@app.callback()
def _gtm_fmu(
    version: Annotated[
        bool, typer.Option("--version", is_eager=True, callback=_show_version, help="Print the version and end.")
    ] = False,
) -> None:
    pass


def example(command: str) -> str:
    """Closing lines of a help text, never wrapped so that they can be copied."""
    return f"\b\nExample:\n  gtm-fmu {command}"


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


def _described(found: "Trim") -> dict[str, Any]:
    """A trim with its stability and controllability, which the nearest to one does not have."""
    from gtm_fmu.trims.linearization import linearize as linear_model

    verdicts = linear_model(found).verdicts if found.feasible else {"stable": None, "controllable": None}
    return found.to_dict() | verdicts


def _show_trim(found: "Trim", as_json: bool, title: str) -> None:
    from study.commands.words import trim_rows

    values = _described(found)
    show(values if as_json else trim_rows(found, values), as_json, title)


@app.command(epilog=example("trim --altitude-ft 10000 --tas-kt 118.5 --rudder-deg 10 10 --json"))
@takes(ASKED | FAILURE)
def trim(
    altitude_ft: Altitude,
    gamma_deg: Gamma = 0.0,
    alpha_deg: Alpha = (-5.0, 10.5),
    phi_deg: Phi = (-30.0, 30.0),
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
        found = solve(altitude_ft, gamma_deg=gamma_deg, alpha_deg=alpha_deg, phi_deg=phi_deg)
    _show_trim(found, as_json, "Steady manoeuvre")
    if not found.feasible:
        raise typer.Exit(NO_SOLUTION)


@app.command(epilog=example("linearize --altitude-ft 10000 --tas-kt 118.5 --rudder-deg 10 10 --json"))
@takes(ASKED | FAILURE)
def linearize(
    altitude_ft: Altitude,
    gamma_deg: Gamma = 0.0,
    alpha_deg: Alpha = (-5.0, 10.5),
    phi_deg: Phi = (-30.0, 30.0),
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
        found = solve(altitude_ft, gamma_deg=gamma_deg, alpha_deg=alpha_deg, phi_deg=phi_deg)
        model = linear_model(found) if found.feasible else None
    from study.commands.words import model_rows

    if model is None:
        _show_trim(found, as_json, "No such steady manoeuvre; the nearest")
        raise typer.Exit(NO_SOLUTION)
    show(model.to_dict() if as_json else model_rows(model), as_json, "Linear model")


@app.command(epilog=example("envelope --altitude-ft 10000 --gamma-deg 0 --rudder-deg -10 20 --json"))
@takes(FAILURE)
def envelope(
    altitude_ft: Annotated[float | None, typer.Option(help="Geometric altitude, 0 to 36089 ft; required.")] = None,
    gamma_deg: Annotated[float | None, typer.Option(help="Flight-path angle in deg, in a climb positive.")] = None,
    alpha_deg: Alpha = (-5.0, 10.5),
    phi_deg: Phi = (-30.0, 30.0),
    over: Annotated[
        tuple[str, float, float, float] | None,
        typer.Option(metavar="AXIS LOWER UPPER STEP", help="Vary gamma, altitude, or the position a control jams at."),
    ] = None,
    plot: Annotated[Path | None, typer.Option(help="Write turn rate over speed to this .png or .html too.")] = None,
    as_json: Json = False,
    **given: Any,
) -> None:
    """Lowest and highest speed that a failure leaves, exact.

    The trims at both ends come with them. Without any envelope "feasible" is false, the manoeuvre that exceeds the
    limits least comes as the nearest, and the exit code is still 0.
    With --over, envelopes along an axis with their polygons, as --over gamma -5 5 1 or --over rudder -30 30 10.
    """
    from gtm_fmu.envelopes.envelope import FlightCondition

    limits = given_failure(given)
    if over:
        from study.commands.family import check_over, show_family

        check_over(over, altitude_ft, gamma_deg, given)
        altitude_ft = over[1] if over[0] == "altitude" else altitude_ft
    if altitude_ft is None:
        raise InputError("Missing option '--altitude-ft'; see `gtm-fmu envelope --help`.")
    if plot:
        check_picture(plot)
    condition = FlightCondition(altitude_ft, gamma_deg or 0.0, limits, alpha_deg, phi_deg)
    if over:
        return show_family(condition, over, plot, as_json)
    found = condition.envelope()
    values = found.to_dict() | {"intervals_kt": condition.intervals()}
    for end in ("at_v_min", "at_v_max", "nearest"):
        values[end] = (trim := getattr(found, end)) and _described(trim)
    if plot:
        from study.figures.envelopes import save_envelope

        save_envelope(condition, plot)
        values["plot"] = str(plot)
    from study.commands.words import envelope_rows

    show(values if as_json else envelope_rows(found, values), as_json, "Envelope")


@app.command(epilog=example("build dynamics-native surrogate-native --output build/fmu"))
def build(
    names: Annotated[
        list[str] | None,
        typer.Argument(
            help="dynamics, aircraft, envelope, surrogate with -native (FMI 2.0 in C) or -native3 (FMI 3.0 in C), or "
            "alone (Python inside); thrust-map-native."
        ),
    ] = None,
    output: Annotated[Path, typer.Option(help="Folder of the FMUs.")] = Path("build/fmu"),
    model: Annotated[str | None, typer.Option(metavar="NAME|FILE|FOLDER", help=f"The surrogate: {MODEL_HELP}")] = None,
    all_platforms: Annotated[
        bool, typer.Option("--all-platforms", help="Native FMUs for every platform; needs the extra 'cross'.")
    ] = False,
    as_json: Json = False,
) -> None:
    """Build FMUs; without names dynamics-native, aircraft-native, envelope-native and surrogate-native.

    Those run anywhere, and all but the aircraft do model exchange too. With a 3 at the end they are FMI 3.0. Without
    -native they are FMI 2.0 co-simulation and need a Python in the importing tool.
    """
    from fmu_src.fmus import MODELS, build_fmu
    from study.progress import stages

    names = names or [f"{name}-native" for name in MODELS]
    if model is not None and not any(name.startswith("surrogate") for name in names):
        raise InputError(f"--model {model} is for the surrogate FMU, which is not built; leave it out.")
    paths = []
    is_shown = all_platforms or sys.stderr.isatty()
    with stages(Console(stderr=True, quiet=not is_shown)) as stage:
        for name in names:
            with stage(f"Build {name}") as advance:
                paths.append(str(build_fmu(name, output, model, all_platforms, advance)))
    show({"fmus": paths}, as_json, "Built")


@app.command(epilog=example("study --output build/study"))
def study(
    output: Annotated[Path, typer.Option(help="Folder of the results.")] = Path("build/study"),
    seed: Annotated[int, typer.Option(min=0, max=2**63 - 1, help="Start of all random numbers.")] = 0,
    as_json: Json = False,
) -> None:
    """The whole study, with figures and a results table.

    FMUs, trims, linear models, envelopes, networks and sensitivity, beside the published values.
    """
    from study.paper.pipeline import run
    from study.paper.report import markdown

    results = run(output, seed)
    print(json.dumps(results, allow_nan=False) if as_json else f"{markdown(results)}\nAll files are in {output}.")


app.command(epilog=example("advise --altitude-ft 10000 --gamma-deg -5 --rudder-deg 5 25"))(advise)
app.command(epilog=example("train wing.csv --inputs span_mm,alpha_deg --outputs lift:N --output wing.json"))(train)
app.command(epilog=example("predict --altitude-ft 10000 --gamma-deg 0 --rudder-deg -10 20 --json"))(predict)
app.command(epilog=example("export wing.json --fmu --output wing.fmu"))(export)
app.command(epilog=example("surrogates --only 'thrust map'"))(surrogates)
app.command(
    epilog=example("sensitivity --method shapley --plot shapley.png")
    + "\n  gtm-fmu sensitivity --model wing.json --input span_mm=norm:800,20 --input alpha_deg=uniform:0,8 "
    "--input speed_m_s=weibull_min:2,0,30"
    + "\n  gtm-fmu sensitivity --model exact --distribution failures.toml --samples 1024 --output indices.json"
    + "\n  gtm-fmu sensitivity --data runs.csv --columns a,b --outputs y --method given-data"
)(sensitivity)
app.command(epilog=example("protocol --output build/protocol --splits 5"))(protocol)
app.command(epilog=example("networks --output build/networks --device cuda"))(networks)
app.command("thrust-map", epilog=example("thrust-map --output build/rudder_thrust_map.npz"))(thrust_map)
app.command(epilog=example("dataset build/rudder.zarr --cases 1000 --rudder-deg -30 30 --jam-share 0.2"))(dataset)


app.command(epilog=example("doctor --json"))(doctor)
app.command(epilog=example("explorer --output build/explorer.html"))(explorer)
app.add_typer(maps, name="map")


def _refuse(sentence: str) -> int:
    with suppress(OSError):  # standard error may be full too
        print(f"gtm-fmu: {' '.join(sentence.split())}", file=sys.stderr, flush=True)
    return BAD_INPUT


def main() -> None:
    """Run a command; a user's mistake is one sentence on standard error and exit code 2.

    So is a machine that is short of something: memory, room on a disk, open files.
    """
    if sys.stderr is None:  # closed, as by 2>&-
        sys.stderr = open(os.devnull, "w")  # noqa: SIM115
    if sys.stdout is None:
        sys.exit(_refuse("Standard output is closed; leave it open, or send it to a file or to /dev/null."))
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # the name of a file need not be text
    code = _run()
    if error := _output_error():
        is_told = code not in (0, NO_SOLUTION) or error.errno == errno.EPIPE  # who reads a pipe may have seen enough
        code = BAD_INPUT
        if not is_told:
            _refuse(f"Cannot write to standard output ({error.strerror}); finished files are kept.")
        with suppress(OSError):  # the rest of the output is not tried again at the end of the process
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    sys.exit(code)


def _output_error() -> OSError | None:
    """Why standard output cannot be written."""
    try:
        if sys.stdout is not None:
            sys.stdout.flush()
    except OSError as error:
        return error
    return None


def _run() -> int:
    """The exit code of the command that is asked for."""
    try:
        code = app(sys.argv[1:] or ["--help"], standalone_mode=False, prog_name=app.info.name) or 0
    except InputError as error:
        code = _refuse(str(error))
    except TyperException as error:
        context = getattr(error, "ctx", None)
        command = context.command_path if context else app.info.name
        code = _refuse(f"{error.format_message().rstrip('.')}; see `{command} --help`.")
    except Exception as error:
        if sentence := shortage(error):
            return _refuse(sentence)
        if not isinstance(error, OSError):
            raise
        reason = f"{error.strerror or error}: {error.filename}" if error.filename else error.strerror or error
        code = 0 if _output_error() else _refuse(f"The system refused something ({reason}); finished files are kept.")
    if code == INTERRUPTED:
        print("gtm-fmu: stopped; finished files are kept.", file=sys.stderr)
    return code
