"""The command line `gtm-fmu`: thin commands over the packages, one sentence for every mistake."""

import errno
import io
import os
import sys
from contextlib import suppress
from typing import TYPE_CHECKING, Annotated

import typer
from typer.exceptions import TyperException

from gtm_fmu import __version__
from gtm_fmu.errors import InputError
from gtm_study.commands.advise import advise
from gtm_study.commands.build import build
from gtm_study.commands.command import NO_SOLUTION, Commands
from gtm_study.commands.dataset import dataset
from gtm_study.commands.doctor import doctor
from gtm_study.commands.envelope import envelope
from gtm_study.commands.explorer import explorer
from gtm_study.commands.machine import shortage
from gtm_study.commands.manoeuvre import manoeuvre, performance
from gtm_study.commands.maps import maps
from gtm_study.commands.models import export, predict, train
from gtm_study.commands.protocol import protocol
from gtm_study.commands.sensitivity import sensitivity
from gtm_study.commands.study import study
from gtm_study.commands.surrogates import networks, surrogates, thrust_map
from gtm_study.commands.trims import linearize, trim

if TYPE_CHECKING:
    pass

BAD_INPUT, INTERRUPTED = 2, 130

app = Commands(
    name="gtm-fmu",
    help="Flight envelopes of the impaired NASA Generic Transport Model: FMUs, trims, envelopes, surrogates.",
    pretty_exceptions_enable=False,
)


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


app.command(epilog=example("trim --altitude-ft 10000 --tas-kt 118.5 --rudder-deg 10 10 --json"))(trim)
app.command(epilog=example("linearize --altitude-ft 10000 --tas-kt 118.5 --rudder-deg 10 10 --json"))(linearize)
app.command(epilog=example("envelope --altitude-ft 10000 --gamma-deg 0 --rudder-deg -10 20 --json"))(envelope)
app.command(epilog=example("build dynamics-native surrogate-native --output build/fmu"))(build)
app.command(epilog=example("study --output build/study"))(study)
app.command(epilog=example("manoeuvre --altitude-ft 10000 --tas-kt 100 --turn-rate-deg-s 3 --rudder-deg 10 10"))(
    manoeuvre
)
app.command(epilog=example("performance --altitude-ft 10000 --rudder-deg 10 10"))(performance)
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
