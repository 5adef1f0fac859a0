"""A failure by the names of the FMUs' inputs, in their display units, as the package knows it."""

from collections.abc import Mapping

from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.aircraft.ranges import ALPHA_DEG, PHI_DEG, WIDEST, Range
from gtm_fmu.airframe.names import CONTROLS
from gtm_fmu.core.configuration import Configuration
from gtm_fmu.errors import InputError

_SIDES = ("left", "right")
_ENDS = ("lower", "upper")
_LABELS = dict(zip(CONTROLS, WIDEST, strict=True))
BOUNDS = tuple(f"limits.{angle}.{end}" for angle in ("alpha", "bank") for end in _ENDS)
"""Of the manoeuvres, not of the aircraft."""


def failure_of(values: Mapping[str, float | bool]) -> Failure:
    """The failure.

    Raises:
        InputError: a name that the aircraft does not have as a failure, or a value outside what is allowed.
    """
    left = {name: value for name, value in values.items() if name not in BOUNDS}
    limits = {
        label: tuple(
            left.pop(f"limits.{control}.{end}", usual) for end, usual in zip(_ENDS, WIDEST[label], strict=True)
        )
        for control, label in _LABELS.items()
    }
    running = tuple(bool(left.pop(f"engine.{side}.running", True)) for side in _SIDES)
    damage, stabilizer = int(left.pop("damage.case", 0)), float(left.pop("stabilizer.setting", 0.0))
    if left:
        raise InputError(
            f"GtmAircraft has no failure '{min(left)}', so the path cannot be flown; it knows limits of the controls, "
            "damage.case, engine.left.running, engine.right.running and stabilizer.setting."
        )
    configuration = Configuration(damage_case=damage, engine_running=running, stabilizer_deg=stabilizer)
    return Failure(ControlLimits(**limits), configuration)


def bounds_of(values: Mapping[str, float | bool]) -> tuple[Range, Range]:
    """Bounds of alpha and bank in deg that its manoeuvres keep."""
    alpha, bank = (
        tuple(float(values.get(f"limits.{angle}.{end}", usual)) for end, usual in zip(_ENDS, widest, strict=True))
        for angle, widest in (("alpha", ALPHA_DEG), ("bank", PHI_DEG))
    )
    return alpha, bank  # type: ignore[return-value]
