"""The command line `gtm-fmu`: thin commands over the packages, one sentence for every mistake."""

import errno
import io
import os
import sys
from contextlib import suppress
from typing import Annotated

import typer
from typer.exceptions import TyperException

from gtm_fmu.errors import InputError
from gtm_study.commands.command import NO_SOLUTION, Commands, Listed, listing
from gtm_study.commands.machine import shortage

BAD_INPUT, INTERRUPTED = 2, 130

COMMANDS = {
    "trim": Listed(
        "trims.trim",
        "Controls of one steady manoeuvre.",
        ("trim --altitude-ft 10000 --tas-kt 118.5 --rudder-deg 10 10 --json",),
    ),
    "linearize": Listed(
        "trims.linearize",
        "Linear model at a steady manoeuvre.",
        ("linearize --altitude-ft 10000 --tas-kt 118.5 --rudder-deg 10 10 --json",),
    ),
    "envelope": Listed(
        "envelope.envelope",
        "Lowest and highest speed that a failure leaves, exact.",
        ("envelope --altitude-ft 10000 --gamma-deg 0 --rudder-deg -10 20 --json",),
    ),
    "manoeuvre": Listed(
        "manoeuvre.manoeuvre",
        "Can this be flown, and what is in its way.",
        ("manoeuvre --altitude-ft 10000 --tas-kt 100 --turn-rate-deg-s 3 --rudder-deg 10 10",),
    ),
    "performance": Listed(
        "manoeuvre.performance",
        "What can still be flown at best.",
        ("performance --altitude-ft 10000 --rudder-deg 10 10",),
    ),
    "map": Listed("maps.maps", "Pictures of many envelopes."),
    "dataset": Listed(
        "dataset.dataset",
        "Envelopes of many cases: a lattice, or random.",
        ("dataset build/rudder.zarr --cases 1000 --rudder-deg -30 30 --jam-share 0.2",),
    ),
    "train": Listed(
        "models.train",
        "Train a model on a table.",
        ("train wing.csv --inputs span_mm,alpha_deg --outputs lift:N --output wing.json",),
    ),
    "predict": Listed(
        "models.predict",
        "Lowest and highest speed by a surrogate.",
        ("predict --altitude-ft 10000 --gamma-deg 0 --rudder-deg -10 20 --json",),
    ),
    "export": Listed(
        "models.export", "A trained model in another form.", ("export wing.json --fmu --output wing.fmu",)
    ),
    "build": Listed("build.build", "Build FMUs.", ("build dynamics-native surrogate-native --output build/fmu",)),
    "sensitivity": Listed(
        "sensitivity.sensitivity",
        "Which inputs matter, dependent ones too.",
        (
            "sensitivity --method shapley --plot shapley.png",
            "sensitivity --model wing.json --input span_mm=norm:800,20 --input alpha_deg=uniform:0,8 "
            "--input speed_m_s=weibull_min:2,0,30",
            "sensitivity --model exact --distribution failures.toml --samples 1024 --output indices.json",
            "sensitivity --data runs.csv --columns a,b --outputs y --method given-data",
        ),
    ),
    "advise": Listed(
        "advise.advise",
        "What not to touch after a failure.",
        ("advise --altitude-ft 10000 --gamma-deg -5 --rudder-deg 5 25",),
    ),
    "study": Listed("study.study", "The paper reproduced, with figures and tables.", ("study --output build/study",)),
    "explorer": Listed(
        "explorer.explorer", "A page that solves envelopes live.", ("explorer --output build/explorer.html",)
    ),
    "surrogates": Listed(
        "surrogates.surrogates", "Surrogates beyond the paper's, measured.", ("surrogates --only 'thrust map'",)
    ),
    "protocol": Listed(
        "protocol.protocol", "Networks by the paper's protocol.", ("protocol --output build/protocol --splits 5",)
    ),
    "networks": Listed(
        "surrogates.networks",
        "The package's networks, trained anew.",
        ("networks --output build/networks --device cuda",),
    ),
    "thrust-map": Listed(
        "surrogates.thrust_map",
        "The package's thrust maps, solved anew.",
        ("thrust-map --output build/rudder_thrust_map.npz",),
    ),
    "calibrate": Listed(
        "calibrate.calibrate",
        "Margins that make a thrust map's speeds safe.",
        ("calibrate aileron --cases 20000 --draws 300000 --output build/aileron_thrust_map.npz",),
    ),
    "doctor": Listed("doctor.doctor", "What is here, and what a missing part needs.", ("doctor --json",)),
}

app = Commands(
    name="gtm-fmu",
    cls=listing(COMMANDS),
    add_completion=True,
    help="Flight envelopes of the impaired NASA Generic Transport Model: FMUs, trims, envelopes, surrogates.",
    pretty_exceptions_enable=False,
)


def _show_version(is_asked: bool) -> None:
    if is_asked:
        from gtm_fmu import __version__

        print(f"gtm-fmu {__version__}")
        raise typer.Exit


@app.callback()
def _gtm_fmu(
    version: Annotated[
        bool, typer.Option("--version", is_eager=True, callback=_show_version, help="Print the version and end.")
    ] = False,
) -> None:
    pass


_TYPES = {"a valid int range": "an integer", "a valid int": "an integer", "a valid float": "a number"}
"""What the command line calls types, in words."""


def _plain(sentence: str) -> str:
    """Names of types in words."""
    for name, word in _TYPES.items():
        sentence = sentence.replace(name, word)
    return sentence


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
        code = _refuse(f"{_plain(error.format_message()).rstrip('.')}; see `{command} --help`.")
    except ModuleNotFoundError as error:
        from gtm_fmu.extras import advice

        if (way := advice(str(error.name))) is None:
            raise
        code = _refuse(f"This needs {error.name}, which is not here: {way}.")
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
