"""The command `gtm-fmu build`: FMUs by their names."""

import sys
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from gtm_fmu.errors import InputError
from gtm_study.commands.options import Json
from gtm_study.commands.printing import show
from surrogate.rudder.names import MODEL_HELP


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
    from fmu_src.fmus import CARRIERS, MODELS, build_fmu
    from gtm_study.progress import stages

    names = names or [f"{name}-native" for name in MODELS]
    if model is not None and not any(name.startswith(CARRIERS) for name in names):
        raise InputError(
            f"--model {model} is for the FMUs of surrogates and thrust maps, and none is built; leave it out."
        )
    paths = []
    is_shown = all_platforms or sys.stderr.isatty()
    with stages(Console(stderr=True, quiet=not is_shown)) as stage:
        for name in names:
            with stage(f"Build {name}") as advance:
                paths.append(str(build_fmu(name, output, model, all_platforms, advance)))
    show({"fmus": paths}, as_json, "Built")
