"""The surrogates of a failed rudder by their names: those that come with the package, or of a file or folder."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from gtm_fmu.conformal import EPSILON
from gtm_fmu.envelopes.thrust_map import RUDDER_MAP, THRUST_MAPS, ThrustMap
from gtm_fmu.errors import InputError
from surrogate.rudder.names import DEFAULT, NETWORK, PAPER, SPEEDS_FILE, THROTTLE_FILE

if TYPE_CHECKING:
    from surrogate.rudder.emulator import RudderEmulator

SURROGATES: Mapping[str, Path] = {DEFAULT: RUDDER_MAP, "network": NETWORK, "paper": PAPER}
"""Where the surrogates of the package are, by their names."""
OTHER_CONTROLS: Mapping[str, Path] = {control: path for control, path in THRUST_MAPS.items() if control != "rudder"}
"""Thrust maps of other failed controls."""


def surrogate_path(model: str) -> Path:
    """The file of a thrust map or the folder of networks that a name or a path means.

    Raises:
        InputError: there is none.
    """
    named = {**SURROGATES, **OTHER_CONTROLS}
    path = named.get(model, Path(model))
    if not path.exists():
        names = ", ".join(named)
        raise InputError(f"--model was given as '{model}': give {names}, a thrust map's file or a folder of networks.")
    return path


def load_surrogate(model: str = DEFAULT, control: str | None = "rudder") -> "ThrustMap | RudderEmulator":
    """A surrogate by its name, its file or its folder, of one control or (None) of any.

    Raises:
        InputError: missing, damaged or foreign.
    """
    path = surrogate_path(model)
    if path.is_dir():
        from surrogate.rudder.emulator import RudderEmulator  # a thrust map needs no networks

        return RudderEmulator.load(path)
    thrust_map = ThrustMap.load(path)
    if control is not None and thrust_map.control != control:
        raise InputError(f"'{model}' is a thrust map of the {thrust_map.control}: give one of the {control}.")
    return thrust_map


def surrogate_files(model: str = DEFAULT, control: str | None = "rudder") -> list[Path]:
    """The files that an FMU is built of, after a look into them.

    Raises:
        InputError: as `load_surrogate`.
    """
    path = surrogate_path(model)
    load_surrogate(model, control)
    return [path / SPEEDS_FILE, path / THROTTLE_FILE] if path.is_dir() else [path]


def measured_errors(surrogate: "ThrustMap | RudderEmulator") -> str | None:
    """One sentence on the errors that were measured on exact cases off the lattice, where they are known."""
    provenance = surrogate.provenance if isinstance(surrogate, ThrustMap) else surrogate.speeds.provenance
    scores = provenance.get("off_lattice")
    if not scores:
        return None
    whole = scores["all"]
    inside = f"; its 95 % intervals hold {scores['inside_95']:.0%} of them" if "inside_95" in scores else ""
    return (
        f"In {whole['cases']} random cases off the lattice 95 % of its errors were below "
        f"{whole['percentile_95_kt']:.2f} kn, the largest {whole['largest_kt']:.1f} kn{inside}; whether there is an "
        f"envelope was right in {whole['same_verdict']:.2%}."
    )


def promise(thrust_map: ThrustMap, epsilon: float = EPSILON) -> str:
    """What the safe speeds of a map promise, in a few sentences.

    Raises:
        InputError: an epsilon that its calibration cannot carry.
    """
    thrust_map.margins(epsilon)
    if thrust_map.safe is None:
        return "This map was not calibrated and promises nothing; `gtm-fmu calibrate` does that."
    cases = thrust_map.safe.cases.sum()
    return (
        f"v_min_safe_kt is not below the exact V_min, and v_max_safe_kt not above the exact V_max, each with a "
        f"probability of at least {1 - epsilon:.5g} over the {cases} exact cases that set the margins and one more of "
        f"the same distribution: random ones of the whole map, by jams and ranges, at folds and elsewhere."
    )
