"""What is planned for: an aircraft with a failure, where it is, what is ahead and where it has to go, from TOML."""

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from examples.path_planner.planner import terrain
from examples.path_planner.planner.elevation_files import read_geotiff, read_hgt
from examples.path_planner.planner.terrain import Terrain
from examples.path_planner.planner.tracks import CALM, Wind
from gtm_fmu.aircraft import ranges
from gtm_fmu.errors import InputError
from gtm_fmu.units import M_S_PER_KT, RAD_PER_DEG

COSTS = ("time", "distance", "margin", "second failure")

GAMMAS_DEG = (-9.0, -6.0, -3.0, 0.0, 3.0, 6.0, 9.0)
NUMBER = (-1e7, 1e7)
_BELOW_FT = 30.0
_HEADING = (-360.0, 360.0)


class Pose(NamedTuple):
    """A place, an altitude and a heading through the air."""

    north_m: float
    east_m: float
    altitude_ft: float
    heading_deg: float


@dataclass(frozen=True)
class Goal:
    """Where the path ends.

    Attributes:
        radius_m: how far from the place it may end.
        altitude_ft: from and to.
        heading_deg: None for any.
        heading_tolerance_deg: to both sides.
    """

    north_m: float
    east_m: float
    radius_m: float
    altitude_ft: tuple[float, float]
    heading_deg: float | None = None
    heading_tolerance_deg: float = 15.0


@dataclass(frozen=True)
class Runway:
    """A threshold and the direction of landing."""

    name: str
    north_m: float
    east_m: float
    altitude_ft: float
    heading_deg: float


@dataclass(frozen=True)
class Cost:
    """What is made least.

    Attributes:
        of: one of `COSTS`.
        weight: a second without any margin costs as much as this many with the margin that is wanted.
        wanted_kt: the margin that costs nothing.
        rudder_lost_deg: the second failure of the rudder: so much less to the worse side.
        engine_out: whether an engine out is a second failure too.
    """

    of: str = "time"
    weight: float = 10.0
    wanted_kt: float = 20.0
    rudder_lost_deg: float = 5.0
    engine_out: bool = True


@dataclass(frozen=True)
class Scenario:
    """Everything that a plan depends on.

    Attributes:
        failure: what has failed, by the names of the FMU's inputs, in their display units (deg, %).
        tas_kt: the speed to fly; None for the one with the most margin.
        clearance_ft: least height above the ground.
        gammas_deg: flight paths to choose from; an end that needs one between them has it.
        reserve: which part of the turns that are left is used; the rest is for guidance.
    """

    title: str
    failure: Mapping[str, float | bool]
    start: Pose
    goal: Goal | None
    terrain: Terrain
    tas_kt: float | None = None
    wind: Wind = CALM
    clearance_ft: float = 200.0
    gammas_deg: tuple[float, ...] = GAMMAS_DEG
    reserve: float = 0.8
    runways: tuple[Runway, ...] = ()
    cost: Cost = field(default_factory=Cost)


class _Table:
    """A table of the file, whose keys are taken one by one; what is left over was misspelt."""

    def __init__(self, name: str, values: Any) -> None:
        if not isinstance(values, dict):
            raise InputError(f"[{name}] is {values!r}; give a table.")
        self.name, self.values = name, dict(values)

    def number(self, key: str, default: float | None = None, allowed: tuple[float, float] = NUMBER) -> float:
        value = self.values.pop(key, default)
        if value is None:
            raise InputError(f"[{self.name}] has no {key}; give a number.")
        if isinstance(value, bool):
            raise InputError(f"{key} of [{self.name}] is {value}; give a number.")
        return ranges.check_range(f"{key} of [{self.name}]", value, allowed)

    def optional(self, key: str, allowed: tuple[float, float]) -> float | None:
        return self.number(key, allowed=allowed) if key in self.values else None

    def pair(self, key: str, allowed: tuple[float, float]) -> tuple[float, float]:
        if key not in self.values:
            raise InputError(f"[{self.name}] has no {key}; give two numbers, lower and upper.")
        return ranges.check_pair(f"{key} of [{self.name}]", self.values.pop(key), allowed)

    def truth(self, key: str, default: bool) -> bool:
        value = self.values.pop(key, default)
        if not isinstance(value, bool):
            raise InputError(f"{key} of [{self.name}] is {value!r}; give true or false.")
        return value

    def text(self, key: str, default: str | None) -> str:
        value = self.values.pop(key, default)
        if not isinstance(value, str):
            raise InputError(f"{key} of [{self.name}] is {value!r}; give a text.")
        return value

    def end(self) -> None:
        if self.values:
            raise InputError(f"[{self.name}] has an unknown key '{next(iter(self.values))}'; correct its spelling.")


def read_scenario(path: str | Path) -> Scenario:
    """A scenario from a TOML file; files that it names lie beside it.

    Raises:
        InputError: no such file, no TOML, a key that is missing, misspelt or out of its range.
    """
    path = Path(path)
    try:
        values = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise InputError(f"'{path}' cannot be read as a scenario: {error}.") from error
    return scenario(values, path.parent, path.stem)


def scenario(values: Mapping[str, Any], folder: Path, title: str) -> Scenario:
    """A scenario from tables as in its file.

    Raises:
        InputError: as `read_scenario`.
    """
    file = _Table("scenario", values)
    title = file.text("title", title)
    failure = flat_names(_Table("failure", file.values.pop("failure", {})).values)
    start = _Table("start", file.values.pop("start", None))
    pose = Pose(
        start.number("north_m", 0.0),
        start.number("east_m", 0.0),
        start.number("altitude_ft", allowed=ranges.ALTITUDE_FT),
        start.number("heading_deg", allowed=_HEADING),
    )
    tas_kt = start.optional("tas_kt", ranges.TAS_KT)
    start.end()
    ground = _Table("terrain", file.values.pop("terrain", {}))
    clearance_ft, heights = ground.number("clearance_ft", 200.0, (0.0, 10_000.0)), _terrain(ground, folder)
    found = Scenario(
        title=title,
        failure=failure,
        start=pose,
        goal=_goal(file.values.pop("goal", None)),
        terrain=heights,
        tas_kt=tas_kt,
        wind=_wind(_Table("wind", file.values.pop("wind", {}))),
        clearance_ft=clearance_ft,
        gammas_deg=_gammas(file.values.pop("gammas_deg", GAMMAS_DEG)),
        reserve=file.number("reserve", 0.8, (0.1, 1.0)),
        runways=tuple(_runway(_Table("runway", each), heights) for each in file.values.pop("runway", [])),
        cost=_cost(_Table("cost", file.values.pop("cost", {}))),
    )
    file.end()
    if found.goal is None and not found.runways:
        raise InputError("The scenario has neither a [goal] nor a [[runway]]; give one.")
    return found


def flat_names(values: Mapping[str, Any], prefix: str = "") -> dict[str, float | bool]:
    """Nested tables of TOML's dotted keys as names with dots, as ``limits.rudder.lower``."""
    flat: dict[str, float | bool] = {}
    for key, value in values.items():
        name = prefix + key
        if isinstance(value, dict):
            flat |= flat_names(value, name + ".")
        elif isinstance(value, bool | int | float):
            flat[name] = value
        else:
            raise InputError(f"{name} of [failure] is {value!r}; give a number, true or false.")
    return flat


def _terrain(table: _Table, folder: Path) -> Terrain:
    name = table.text("file", "")
    if not name:
        found = terrain.flat(table.number("ground_ft", 0.0))
    else:
        origin = table.values.pop("origin", None)
        if origin is not None:
            origin = _origin(origin)
        path = folder / name
        if not path.is_file():
            raise InputError(f"There is no terrain '{path}'; its name is relative to the scenario's file.")
        readers = {".hgt": read_hgt, ".tif": read_geotiff, ".tiff": read_geotiff}
        reader = readers.get(path.suffix.lower())
        found = reader(path, origin) if reader else terrain.read(path)
    table.end()
    return found


def _origin(values: Any) -> tuple[float, float]:
    """Latitude and longitude in deg, or northing and easting in m."""
    if not isinstance(values, list) or len(values) != 2:
        raise InputError(f"origin of [terrain] is {values!r}; give [latitude, longitude] or [northing, easting].")
    north, east = (ranges.check_range("a number of the origin of [terrain]", each, NUMBER) for each in values)
    return north, east


def _goal(values: Any) -> Goal | None:
    if values is None:
        return None
    table = _Table("goal", values)
    goal = Goal(
        table.number("north_m"),
        table.number("east_m"),
        table.number("radius_m", 300.0, (1.0, 1e5)),
        table.pair("altitude_ft", ranges.ALTITUDE_FT),
        table.optional("heading_deg", _HEADING),
        table.number("heading_tolerance_deg", 15.0, (1.0, 180.0)),
    )
    table.end()
    return goal


def _gammas(values: Any) -> tuple[float, ...]:
    if not isinstance(values, list | tuple) or not values:
        raise InputError(f"gammas_deg is {values!r}; give a list of flight-path angles in deg.")
    return tuple(sorted(ranges.check_range("a flight path of gammas_deg", each, ranges.GAMMA_DEG) for each in values))


def _wind(table: _Table) -> Wind:
    """Of a wind from a direction; the air moves the other way."""
    angle = table.number("from_deg", 0.0, _HEADING) * RAD_PER_DEG
    speed = table.number("speed_kt", 0.0, (0.0, 100.0)) * M_S_PER_KT
    table.end()
    return Wind(-speed * math.cos(angle), -speed * math.sin(angle))


def _runway(table: _Table, ground: Terrain) -> Runway:
    """At the height of the ground unless an altitude is given, which is not below that."""
    name, north_m, east_m = table.text("name", None), table.number("north_m"), table.number("east_m")
    height_ft = float(ground.height(np.float64(north_m), np.float64(east_m)))
    if math.isinf(height_ft):
        raise InputError(f"Runway '{name}' lies outside the terrain; move it, or give a larger terrain.")
    altitude_ft = table.number("altitude_ft", height_ft, ranges.ALTITUDE_FT)
    if altitude_ft < height_ft - _BELOW_FT:
        raise InputError(
            f"Runway '{name}' at {altitude_ft:g} ft lies below the ground, which is at {height_ft:.0f} ft there; "
            "leave altitude_ft out to take that."
        )
    runway = Runway(name, north_m, east_m, max(altitude_ft, height_ft), table.number("heading_deg", allowed=_HEADING))
    table.end()
    return runway


def _cost(table: _Table) -> Cost:
    usual = Cost()
    of = table.text("of", usual.of)
    if of not in COSTS:
        raise InputError(f"of of [cost] is '{of}'; give one of {', '.join(COSTS)}.")
    cost = Cost(
        of,
        table.number("weight", usual.weight, (0.0, 1000.0)),
        table.number("wanted_kt", usual.wanted_kt, (0.1, 200.0)),
        table.number("rudder_lost_deg", usual.rudder_lost_deg, (0.0, 60.0)),
        table.truth("engine_out", usual.engine_out),
    )
    table.end()
    if cost.of == "second failure" and not cost.rudder_lost_deg and not cost.engine_out:
        raise InputError("of of [cost] is second failure, but there is none; give rudder_lost_deg or engine_out.")
    return cost
