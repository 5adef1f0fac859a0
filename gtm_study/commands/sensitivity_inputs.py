"""What the inputs of `gtm-fmu sensitivity` vary over, from its options or from a file."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gtm_fmu.errors import InputError
from gtm_study.commands.options import Pair

if TYPE_CHECKING:
    from sensitivity import Distribution


def words(spelling: str) -> tuple[str, ...]:
    """Words with commas between."""
    return tuple(word.strip() for word in spelling.split(",") if word.strip())


Laws = tuple["Distribution", tuple[tuple[str, ...], ...]]


def described_inputs(
    model: str, path: Path | None, inputs: Sequence[str], ranges: dict[str, Pair | None], jam_share: float | None
) -> Laws | None:
    """The distribution that is asked for, with its groups; None for the ranges of a model of one's own."""
    from gtm_study.commands.sensitivity_models import AIRCRAFT
    from sensitivity import described_distribution, read_distribution

    condition = jam_share is not None or any(ends is not None for ends in ranges.values())
    if sum((path is not None, bool(inputs), condition)) > 1:
        raise InputError(
            "Inputs are described twice: give --distribution, or --input for each, or the rudder's ranges."
        )
    if path is not None:
        return read_distribution(path)
    if inputs:
        return described_distribution({"inputs": [_law(spelling) for spelling in inputs]})
    if model not in AIRCRAFT:
        if condition:
            raise InputError(f"Ranges of the rudder are not for '{model}': give --distribution or --input.")
        return None
    from gtm_fmu.aircraft.ranges import WIDEST
    from gtm_fmu.datasets.paper import ALTITUDE_FT, GAMMA_DEG

    defaults = ALTITUDE_FT, GAMMA_DEG, WIDEST["rudder_deg"]
    altitude, gamma, rudder = (list(given or default) for given, default in zip(ranges.values(), defaults, strict=True))
    return described_distribution(
        {
            "inputs": [
                {"name": "altitude_ft", "unit": "ft", "uniform": altitude},
                {"name": "gamma_deg", "unit": "deg", "uniform": gamma},
                {
                    "names": ["rudder_lower_deg", "rudder_upper_deg"],
                    "unit": "deg",
                    "ordered": rudder,
                    "jam_share": jam_share or 0.0,
                },
            ]
        }
    )


def _law(spelling: str) -> dict[str, Any]:
    """An input as --input spells it."""
    found = re.fullmatch(r"(.+?)=(\w+):(.*)", spelling)
    try:
        if not found:
            raise ValueError
        numbers = [float(number) for number in found[3].split(",")]
    except ValueError:
        raise InputError(f"--input was given as '{spelling}': give NAME=LAW:NUMBERS, as x=norm:5,2.") from None
    if found[2] == "uniform":
        return {"name": found[1], "uniform": numbers}
    return {"name": found[1], "law": found[2], "parameters": numbers}
