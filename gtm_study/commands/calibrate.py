"""The command `gtm-fmu calibrate`: margins that make the speeds of a thrust map safe to use, and their check."""

from pathlib import Path
from typing import Annotated, Any

import typer

CASES, DRAWS, TEST_CASES, TEST_DRAWS = 47_000, 1_300_000, 5_000, 300_000


def calibrate(
    model: Annotated[
        str, typer.Argument(metavar="NAME|FILE", help="thrust-map (the rudder's), aileron, elevator, or a map's file.")
    ] = "thrust-map",
    output: Annotated[Path | None, typer.Option(help="File of the calibrated map.")] = None,
    cases: Annotated[
        int, typer.Option(min=1000, max=1_000_000, help="Exact random cases of each group at most, to set the margins.")
    ] = CASES,
    draws: Annotated[int, typer.Option(min=1000, max=10_000_000, help="Draws from which these are taken.")] = DRAWS,
    test_cases: Annotated[
        int, typer.Option(min=100, max=1_000_000, help="Further exact cases of each group at most, to check them.")
    ] = TEST_CASES,
    test_draws: Annotated[int, typer.Option(min=100, max=10_000_000, help="Draws of these.")] = TEST_DRAWS,
    workers: Annotated[int | None, typer.Option(min=1, max=1024, help="Processes; default one a core.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")] = False,
) -> None:
    """Calibrate a thrust map, so that it tells safe speeds, and measure what they promise on other cases.

    The safe V_min is not below the exact one, and the safe V_max not above it, each with a probability of at least
    1 - epsilon, by group: jams and ranges, at folds and elsewhere. Exact cases are kept beside the map; a run that was
    stopped goes on where it was. With the default numbers the rudder's takes half an hour of processor time, another
    control's two hours.
    """
    from dataclasses import replace

    from rich.console import Console

    from gtm_fmu.datasets import calibration
    from gtm_fmu.envelopes.thrust_map import ThrustMap
    from gtm_fmu.errors import InputError
    from gtm_fmu.files import check_writable
    from gtm_study.commands.printing import show
    from gtm_study.progress import stages
    from surrogate.rudder.surrogates import load_surrogate

    thrust_map = load_surrogate(model, control=None)
    if not isinstance(thrust_map, ThrustMap):
        raise InputError(
            f"'{model}' is no thrust map: give one, or calibrate networks with `gtm-fmu train --calibrate`."
        )
    control = thrust_map.control
    output = check_writable(output or Path(f"build/{control}_thrust_map.npz"))
    sets = {"calibration": (cases, draws, calibration.SEED), "test": (test_cases, test_draws, calibration.TEST_SEED)}
    found = []
    with stages(Console(stderr=True)) as stage:
        for name, asked in sets.items():
            X = calibration.draw(thrust_map, *asked)
            store = output.with_name(f"{output.stem}_{name}.zarr")
            with stage(f"Exact cases of the {name}") as advance:
                found.append((X, calibration.solve(store, control, X, advance, workers)))
    facts: dict[str, Any] = {"of_each_group": cases, "draws": draws, "seed": calibration.SEED}
    (X, exact), test = found
    safe = calibration.calibrated(thrust_map, X, exact, **facts)
    checked = calibration.check(safe, *test)
    measured = {"test_seed": calibration.TEST_SEED, "measured": checked}
    provenance = safe.provenance | {calibration.SAFE: safe.provenance[calibration.SAFE] | measured}
    replace(safe, provenance=provenance).save(output)
    show(
        {"output": str(output), "calibration cases": provenance[calibration.SAFE]["cases"], **checked}, as_json, "Safe"
    )
