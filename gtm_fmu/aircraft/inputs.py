"""Inputs of a case: flight condition and failure as numbers, each a column, and the failure that they mean.

An input is a quantity (one number), the limits of a control (two) or a choice (the number of a name). A further one is
an entry here and its part of `failure`.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, fields
from enum import StrEnum
from typing import Any, NamedTuple

import numpy as np

from gtm_fmu.aircraft.failures import Failure
from gtm_fmu.aircraft.limits import ControlLimits, RateLimits
from gtm_fmu.aircraft.ranges import ALTITUDE_FT, FASTEST_DEG_S, GAMMA_DEG, WIDEST, Range
from gtm_fmu.airframe.configuration import RANGES
from gtm_fmu.airframe.damage import DAMAGE_CASES
from gtm_fmu.airframe.names import CONTROLS
from gtm_fmu.airframe.surfaces import COMMANDED, FLAPS, SPOILERS
from gtm_fmu.core.configuration import Configuration

_SUFFIX = {"": "", "1": "", "deg": "_deg", "deg/s": "_deg_s", "%": "_pct", "ft": "_ft", "kt": "_kt", "lb": "_lb"}


@dataclass(frozen=True)
class Column:
    """A quantity of every case: its name and its unit."""

    name: str
    units: str

    @property
    def label(self) -> str:
        """Name with the unit, as ``altitude_ft``, for where nothing else tells the unit."""
        return self.name + _SUFFIX[self.units]


class EngineOut(StrEnum):
    """Engines that do not run."""

    NONE = "none"
    LEFT = "left"
    RIGHT = "right"
    BOTH = "both"

    @property
    def running(self) -> tuple[bool, bool]:
        """Whether the left and the right one run."""
        return self not in (EngineOut.LEFT, EngineOut.BOTH), self not in (EngineOut.RIGHT, EngineOut.BOTH)


class _Setting(NamedTuple):
    """A field of `Configuration`, or the panels of it, that one number sets."""

    field: str
    panels: slice | None = None


def _each(field: str, name: str, units: str, surfaces: tuple[str, ...]) -> dict[Column, _Setting]:
    """An input for each panel."""
    return {Column(name.format(surface), units): _Setting(field, slice(k, k + 1)) for k, surface in enumerate(surfaces)}


_SETTINGS = {
    Column("stabilizer", "deg"): _Setting("stabilizer_deg"),
    Column("flaps", "deg"): _Setting("flap_deg", slice(len(FLAPS))),
    Column("spoilers", "deg"): _Setting("spoiler_deg", slice(len(SPOILERS))),
    Column("gear", "1"): _Setting("gear"),
    Column("fuel_used", "lb"): _Setting("fuel_used_lb"),
    **_each("flap_deg", "{}", "deg", FLAPS),
    **_each("spoiler_deg", "{}", "deg", SPOILERS),
    **_each("surface_gain", "{}_gain", "1", COMMANDED),
    **_each("surface_offset_deg", "{}_offset", "deg", COMMANDED),
}
"""Single panels by their signals (`surfaces.SIGNALS`): one that is jammed has gain 0, and its position as offset."""

_RATES = {Column(f.name.replace("_deg_s", "_rate"), "deg/s"): f.name for f in fields(RateLimits)}

CONDITION: dict[Column, Range] = {Column("altitude", "ft"): ALTITUDE_FT, Column("gamma", "deg"): GAMMA_DEG}
QUANTITIES: dict[str, tuple[Column, Range]] = {
    column.name: (column, allowed)
    for column, allowed in {
        **CONDITION,
        **{column: RANGES[setting.field] for column, setting in _SETTINGS.items()},
        **dict.fromkeys(_RATES, (0.0, FASTEST_DEG_S)),
    }.items()
}
"""Inputs of one number, and what is allowed."""

CHOICES: dict[str, tuple[str, ...]] = {
    "damage_case": tuple(case.name.replace("%", "percent").replace(" ", "_") for case in DAMAGE_CASES),
    "engine_out": tuple(EngineOut),
}
"""Inputs that are the number of a name."""

LIMITED: dict[str, tuple[Column, Range]] = {
    column.name: (column, WIDEST.get(column.label, WIDEST["throttle_pct"]))
    for column in (
        *(Column(name, "deg") for name in ("elevator", "aileron", "rudder")),
        *(Column(name, "%") for name in ("throttle", "throttle_left", "throttle_right")),
    )
}
"""Controls, and the limits of the undamaged aircraft. With limits of one engine's throttle, each engine is
controlled by a throttle of its own."""

_APART = tuple(control for control in LIMITED if control not in CONTROLS)


def limit_columns(control: str) -> tuple[Column, Column]:
    """Lower and upper limit of a control."""
    units = LIMITED[control][0].units
    return Column(f"{control}_lower", units), Column(f"{control}_upper", units)


NAMES: tuple[str, ...] = (
    *(column.name for column in CONDITION),
    *CHOICES,
    *(column.name for column in _SETTINGS),
    *LIMITED,
    *(column.name for column in _RATES),
)
"""Every input, in the order of columns: cases of one flight condition and airframe lie together on a lattice."""

INPUTS: tuple[Column, ...] = (*CONDITION, *(column for control in CONTROLS for column in limit_columns(control)))
"""The columns that every table of cases has; the others belong to the undamaged aircraft where they are missing."""

EVERYWHERE = tuple(column.name for column in INPUTS)


def attributes(column: Column) -> tuple[np.dtype, dict[str, Any]]:
    """Type and attributes of an input: its unit, or the legend of a choice in the CF conventions' words."""
    if (names := CHOICES.get(column.name)) is None:
        return np.dtype(float), {"units": column.units}
    return np.dtype(np.uint8), {"flag_values": list(range(len(names))), "flag_meanings": " ".join(names)}


def has_throttles_apart(inputs: Collection[str]) -> bool:
    """Whether the columns hold limits of one engine's throttle."""
    return any(limit_columns(control)[0].name in inputs for control in _APART)


def failure(values: Mapping[str, float]) -> Failure:
    """The failure that inputs mean, by the names of their columns; what is missing is as on the undamaged aircraft.

    Raises:
        InputError: a value outside what is allowed.
    """

    def limits(controls: Sequence[str]) -> dict[str, Range]:
        pairs = {LIMITED[control][0].label: [column.name for column in limit_columns(control)] for control in controls}
        return {label: (values[low], values[high]) for label, (low, high) in pairs.items() if low in values}

    engine_out = tuple(EngineOut)[int(values.get("engine_out", 0))]
    settings: dict[str, Any] = {}
    for column, (field, panels) in _SETTINGS.items():
        if column.name not in values:
            continue
        if panels is None:
            settings[field] = values[column.name]
        else:
            all_panels = settings.setdefault(field, list(getattr(Configuration, field)))
            all_panels[panels] = [values[column.name]] * len(all_panels[panels])
    rates = {field: values[column.name] for column, field in _RATES.items() if column.name in values}
    return Failure(
        ControlLimits(**limits(CONTROLS)),
        Configuration(damage_case=int(values.get("damage_case", 0)), engine_running=engine_out.running, **settings),
        **limits(_APART),
        rate_limits=RateLimits(**rates),
    )
