"""The thrust map: envelopes of a jammed or restricted control by interpolation, in microseconds.

At a given equivalent airspeed and flight-path angle a steady manoeuvre needs nearly the same gross thrust at every
altitude, and the engines give theirs in proportion to the pressure (SPEC 6). So the envelopes of all altitudes follow
from one surface, the least gross thrust over equivalent airspeed and jammed deflection: V_min and V_max are where it
meets the thrust available, or where another limit ends it. The surface has no jumps; V_max has, where the surface folds
under the available thrust, and they come out right. A restricted control may be held anywhere in its range, so its
envelope is the union over the range, which the core finds exactly: wider limits never shrink an envelope.

`thrust_survey` fills a map with exact solutions. A map is a small file; evaluating it needs NumPy and the core.
"""

import ctypes
import hashlib
import json
import lzma
import struct
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from gtm_fmu import conformal
from gtm_fmu.aircraft import ranges
from gtm_fmu.aircraft.limits import ControlLimits
from gtm_fmu.aircraft.ranges import WIDEST, Range
from gtm_fmu.core.library import address, library, rows
from gtm_fmu.core.map_layout import GROUPS, RESULTS, SAFE_ENDS, CoreMap
from gtm_fmu.envelopes.safe_margins import SafeMargins
from gtm_fmu.errors import InputError
from gtm_fmu.files import write_whole

_DATA = Path(__file__).parent / "data"
THRUST_MAPS = {control: _DATA / f"{control}_thrust_map.npz" for control in ("rudder", "aileron", "elevator")}
"""The maps that come with the package, by their controls."""
RUDDER_MAP = THRUST_MAPS["rudder"]
FORMAT = "gtm_fmu.ThrustMap 2"
MOST_DEFLECTIONS = MOST_SPEEDS = 128
MOST_BYTES = 64_000_000
"""Of all arrays of a file."""
ARRAYS = (
    *("altitude_ft", "density_ratio", "gamma_deg", "deflection_deg", "table"),
    *("full_thrust_lbf", "tolerances"),
)
"""What a file holds beside its description, and reach_deg where not every deflection has manoeuvres."""
REACH = "reach_deg"
SAFE = {"margins": "safe_margins", "cases": "safe_cases"}
"""What a file of a calibrated map holds too: arrays of its `SafeMargins`."""
_ARCHIVE = zipfile.BadZipFile, zlib.error, lzma.LZMAError, NotImplementedError, IndexError, AttributeError, struct.error
"""What reading a damaged archive may end in."""
NO_MARGINS = np.full((len(GROUPS), len(SAFE_ENDS)), np.inf)
"""Of a map that was not calibrated."""


class Tolerances(NamedTuple):
    """What the standard deviations of a map are made of; chosen so that they hold on cases of their own.

    Attributes:
        thrust_lbf: how far the thrusts may be wrong; an end that jumps inside it is flagged as a fold.
        thrust_deviations: how many standard deviations of the thrusts that is.
        bend_share: standard deviation of an interpolated value, of the bend of its curve there.
        least_kt: least standard deviation of V_min and V_max, equivalent airspeed.
        reach_deg: a limit so near to the last deflection with any manoeuvre is flagged as a fold.
    """

    thrust_lbf: float = 0.03
    thrust_deviations: float = 8.0
    bend_share: float = 0.2
    least_kt: float = 0.0075
    reach_deg: float = 0.05


def checked_cases(cases: ArrayLike, control: str) -> np.ndarray:
    """Cases (n, 4) of altitude in ft, gamma in deg, lower and upper limit of a control in deg, one behind the other.

    Raises:
        InputError: another shape, no numbers, or outside what is allowed.
    """
    try:
        cases = np.atleast_2d(np.asarray(cases, dtype=float))
    except (TypeError, ValueError):
        raise InputError(f"Cases {cases!r} are no numbers; give altitude, gamma, lower, upper limit.") from None
    if cases.shape[-1] != 4:
        raise InputError(f"Cases of the shape {cases.shape} were given; give altitude, gamma, lower, upper limit.")
    cases = rows(cases, 4, "cases")
    altitude, gamma, lower, upper = cases.T
    ranges.check_values("altitude in ft", altitude, ranges.ALTITUDE_FT)
    ranges.check_values("gamma in deg", gamma, ranges.GAMMA_DEG)
    for limits in (lower, upper):
        ranges.check_values(f"{control} in deg", limits, WIDEST[f"{control}_deg"])
    if (lower > upper).any():
        raise InputError(f"{control} in deg: limits are reversed; give the lower one first.")
    return cases


def checked_case(altitude_ft: float, gamma_deg: float, limits_deg: Range, control: str) -> list[float]:
    """One case as a row of `checked_cases`.

    Raises:
        InputError: as there.
    """
    ranges.check_range("altitude in ft", altitude_ft, ranges.ALTITUDE_FT)
    ranges.check_range("gamma in deg", gamma_deg, ranges.GAMMA_DEG)
    name = f"{control}_deg"
    return [altitude_ft, gamma_deg, *getattr(ControlLimits(**{name: limits_deg}), name)]


def first_of(envelopes: NamedTuple) -> dict[str, Any]:
    """The first of several envelopes by its names, ready for JSON: None where there is no number."""
    values = {name: column[0].item() for name, column in envelopes._asdict().items()}
    return {name: None if value != value else value for name, value in values.items()}


class MapEnvelopes(NamedTuple):
    """Envelopes (n) by a map; without one the speeds and their standard deviations are NaN.

    The safe speeds are promised for one new case of the distribution that the map was calibrated on (its
    ``provenance["safe"]`` tells which), by `safe_margins`, each with a probability of at least 1 - epsilon. What lies
    between them may still have gaps, as near the ceiling.

    Attributes:
        feasible: there is an envelope.
        in_domain: altitude and flight path lie inside the map. Outside, the map goes on by its polynomials, and nobody
            knows how far it is off: the standard deviations are NaN.
        fold: a small change of thrust makes an end jump, or the envelope begin or cease to exist: solve exactly here.
        spare_thrust_lbf: thrust left where the least is needed, at the tabulated deflections and both limits; below
            zero there is no envelope; NaN where no thrust is enough.
        v_min_safe_kt: not below the exact V_min. NaN where nothing is promised: without an envelope or with one in
            doubt, outside the map, where the calibration is too small, and everywhere if there was none.
        v_max_safe_kt: not above the exact V_max.
        feasible_safe: there are safe speeds, and so an envelope.
    """

    v_min_kt: np.ndarray
    v_max_kt: np.ndarray
    v_min_std_kt: np.ndarray
    v_max_std_kt: np.ndarray
    feasible: np.ndarray
    in_domain: np.ndarray
    fold: np.ndarray
    spare_thrust_lbf: np.ndarray
    v_min_safe_kt: np.ndarray
    v_max_safe_kt: np.ndarray
    feasible_safe: np.ndarray


@dataclass(frozen=True, eq=False)
class ThrustMap:
    """Least gross thrust over jammed deflection and equivalent airspeed, at some density ratios and flight paths.

    Attributes:
        control: ``rudder``, ``aileron`` or ``elevator``.
        altitude_ft: lowest and highest altitude of the map.
        density_ratio: (k) of its altitudes, to sea level's.
        gamma_deg: (l) flight-path angles; between them, and between the densities, by Lagrange's polynomials.
        deflection_deg: (m) rising, where every deflection has manoeuvres.
        table: (k, l, m, 2 + n) slowest and fastest equivalent airspeed in kn that all limits but the throttle's leave,
            and n least thrusts of both engines in lbf, at speeds v with evenly spaced sqrt(v - slowest).
        full_thrust_lbf: gross thrust of both engines at sea level.
        provenance: how the map came about and its measured errors: anything that JSON can hold.
        reach_deg: (k, l, 2) least and greatest deflection with any manoeuvre at any thrust, as of an elevator, which
            sets alpha; the m deflections lie between them in the same proportions. None: the first and the last.
        safe: margins of a calibration, which belong to this map and no other. None: the map promises nothing.

    Raises:
        InputError: arrays that do not fit together, or numbers that no map can hold.
    """

    control: str
    altitude_ft: tuple[float, float]
    density_ratio: np.ndarray
    gamma_deg: np.ndarray
    deflection_deg: np.ndarray
    table: np.ndarray
    full_thrust_lbf: float
    tolerances: Tolerances = field(default_factory=Tolerances)
    provenance: dict[str, Any] = field(default_factory=dict)
    reach_deg: np.ndarray | None = None
    safe: SafeMargins | None = None

    def __post_init__(self) -> None:
        """Hold the arrays unchangeable, in the types of the core."""
        for name, dtype in (
            *(("density_ratio", "f8"), ("gamma_deg", "f8"), ("deflection_deg", "f8")),
            *(("table", "f4"), ("reach_deg", "f8")),
        ):
            if getattr(self, name) is not None:
                array = np.array(getattr(self, name), dtype=dtype, order="C")
                array.setflags(write=False)
                object.__setattr__(self, name, array)
        object.__setattr__(self, "tolerances", Tolerances(*map(float, self.tolerances)))
        _check(self)

    @cached_property
    def reach(self) -> np.ndarray:
        """Least and greatest deflection (k, l, 2) in deg with any manoeuvre at any thrust."""
        if self.reach_deg is not None:
            return self.reach_deg
        ends = self.deflection_deg[[0, -1]]
        return np.tile(ends, (*self.table.shape[:2], 1))

    def predict(self, cases: ArrayLike, epsilon: float = conformal.EPSILON) -> MapEnvelopes:
        """Envelopes of cases (n, 4): altitude in ft, gamma in deg, lower and upper limit of the control in deg.

        Args:
            cases: as `checked_cases`.
            epsilon: probability with which a safe speed may be wrong; between the levels of `safe_margins.EPSILONS`
                the next stricter one is taken.

        Raises:
            InputError: altitude, flight path or limits outside what is allowed, or an epsilon that the calibration of
                the map cannot carry.
        """
        margins = self.margins(epsilon)
        cases = checked_cases(cases, self.control)
        altitude, gamma = cases[:, 0], cases[:, 1]
        found, safe = self._found(cases), np.empty((len(cases), len(SAFE_ENDS)))
        core, count = ctypes.byref(self._core()), ctypes.c_long(len(cases))
        library().gtm_map_safe_ends(core, address(margins), count, address(cases), address(found), address(safe))
        feasible = found[:, 4] >= 0
        v_min, v_max, v_min_std, v_max_std = np.where(feasible[:, None], found[:, :4], np.nan).T
        inside = (self.altitude_ft[0] <= altitude) & (altitude <= self.altitude_ft[1])
        inside &= (self.gamma_deg.min() <= gamma) & (gamma <= self.gamma_deg.max())
        v_min_std, v_max_std = (np.where(inside, std, np.nan) for std in (v_min_std, v_max_std))
        spare = np.where(np.isfinite(found[:, 4]), found[:, 4], np.nan)
        is_safe = inside & np.isfinite(safe).all(axis=1)
        v_min_safe, v_max_safe = np.where(is_safe, safe.T, np.nan)
        return MapEnvelopes(
            *(v_min, v_max, v_min_std, v_max_std, feasible, inside),
            fold=found[:, 5] > 0,
            spare_thrust_lbf=spare,
            v_min_safe_kt=v_min_safe,
            v_max_safe_kt=v_max_safe,
            feasible_safe=is_safe,
        )

    def predict_one(
        self, altitude_ft: float, gamma_deg: float, limits_deg: Range, epsilon: float = conformal.EPSILON
    ) -> dict[str, Any]:
        """The same for one case, by the names of `MapEnvelopes` and ready for JSON: None where there is no speed.

        Args:
            altitude_ft: geometric altitude in ft.
            gamma_deg: flight-path angle in deg, positive in a climb.
            limits_deg: lower and upper limit of the map's control in deg.
            epsilon: probability with which a safe speed may be wrong, as of `predict`.

        Raises:
            InputError: as `predict`.
        """
        return first_of(self.predict([checked_case(altitude_ft, gamma_deg, limits_deg, self.control)], epsilon))

    def margins(self, epsilon: float = conformal.EPSILON) -> np.ndarray:
        """Margins (groups, 2) of the safe V_min and V_max in standard deviations; infinite without a calibration.

        Args:
            epsilon: probability with which a safe speed may be wrong.

        Raises:
            InputError: an epsilon that the calibration cannot carry.
        """
        conformal.least_cases(epsilon)
        return NO_MARGINS if self.safe is None else self.safe.at(epsilon)

    def groups(self, cases: ArrayLike) -> np.ndarray:
        """Number (n) in `map_layout.GROUPS` of each of the cases (n, 4); -1 where nothing is promised.

        Raises:
            InputError: as `predict`.
        """
        cases = checked_cases(cases, self.control)
        found, group = self._found(cases), np.empty(len(cases), dtype=ctypes.c_long)
        core, count = ctypes.byref(self._core()), ctypes.c_long(len(cases))
        library().gtm_map_groups(core, count, address(cases), address(found), address(group))
        return group

    def _found(self, cases: np.ndarray) -> np.ndarray:
        """The core's results (n, `RESULTS`) of checked cases."""
        found = np.empty((len(cases), len(RESULTS)))
        core, count = ctypes.byref(self._core()), ctypes.c_long(len(cases))
        library().gtm_map_envelopes(core, count, address(cases), address(found))
        return found

    def _core(self) -> CoreMap:
        arrays = (self.density_ratio, self.gamma_deg, self.deflection_deg, self.reach, self.table)
        sizes = (*self.table.shape[:3], self.table.shape[3] - 2)
        return CoreMap(*sizes, *(address(array) for array in arrays), self.full_thrust_lbf, *self.tolerances)

    def save(self, path: str | Path) -> Path:
        """Write the map to the file ``path``, in one piece or not at all.

        Raises:
            InputError: it cannot be written.
        """
        path = Path(path)
        described = {"format": FORMAT, "control": self.control, "provenance": self.provenance}
        arrays = {name: np.asarray(getattr(self, name)) for name in ARRAYS}
        arrays |= {} if self.reach_deg is None else {REACH: self.reach_deg}
        arrays |= {} if self.safe is None else {name: getattr(self.safe, part) for part, name in SAFE.items()}
        text = json.dumps(described | {"checksum": _checksum(described, arrays)}, sort_keys=True, allow_nan=False)

        def write(draft: Path) -> None:
            with draft.open("wb") as file:  # NumPy would add an ending to a name
                np.savez_compressed(file, allow_pickle=False, described=np.asarray(text), **arrays)

        write_whole(path, write)
        return path

    @classmethod
    def load(cls, path: str | Path = RUDDER_MAP) -> "ThrustMap":
        """Read a map that `save` wrote to ``path``; by default the rudder's of the package (see `THRUST_MAPS`).

        Raises:
            InputError: there is none, or it is damaged or foreign.
        """
        try:
            with zipfile.ZipFile(path) as archive:
                declared = sum(member.file_size for member in archive.infolist())
            if declared > MOST_BYTES:
                raise ValueError(f"it says that it holds {declared:.3g} bytes, {MOST_BYTES:.3g} at most are read")
            with np.load(path, allow_pickle=False) as content:
                described = json.loads(str(content["described"]))
                further = {REACH, *SAFE.values()} & set(content)
                arrays = {name: content[name] for name in (*ARRAYS, *further)}
            if described["format"] != FORMAT:
                raise ValueError(f"its format is {described['format']!r}, {FORMAT!r} is read")
            if described.pop("checksum") != _checksum(described, arrays):
                raise ValueError("its checksum does not match its content")
            held = {part: arrays.pop(name) for part, name in SAFE.items() if name in arrays}
            lowest, highest = arrays.pop("altitude_ft").tolist()
            full_thrust, tolerances = float(arrays.pop("full_thrust_lbf")), Tolerances(*arrays.pop("tolerances"))
            return cls(
                described["control"],
                (lowest, highest),
                **arrays,
                full_thrust_lbf=full_thrust,
                tolerances=tolerances,
                provenance=described["provenance"],
                safe=SafeMargins(**held) if held else None,
            )
        except (OSError, ValueError, KeyError, TypeError, EOFError, MemoryError, RecursionError, *_ARCHIVE) as error:
            reason = error.strerror if isinstance(error, OSError) and error.strerror else error
            text = " ".join(str(reason).split()).rstrip(".") or type(error).__name__
            raise InputError(f"'{path}' is no readable thrust map ({text}); make one with ThrustMap.save.") from None


def _check(thrust_map: ThrustMap) -> None:
    """Refuse numbers that a map cannot hold.

    Raises:
        InputError: with what is wrong.
    """
    control, table = thrust_map.control, thrust_map.table
    nodes = {name: getattr(thrust_map, name) for name in ("density_ratio", "gamma_deg", "deflection_deg")}
    if f"{control}_deg" not in WIDEST:
        raise InputError(f"A thrust map of the control {control!r} is not known.")
    if (
        any(axis.ndim != 1 for axis in nodes.values())
        or table.ndim != 4
        or table.shape[:3] != tuple(map(len, nodes.values()))
    ):
        shapes = ", ".join(str(axis.shape) for axis in nodes.values())
        raise InputError(f"A thrust map of nodes {shapes} cannot have a table of the shape {table.shape}.")
    _, _, deflections, numbers = table.shape
    if not (2 <= deflections <= MOST_DEFLECTIONS and 8 <= numbers - 2 <= MOST_SPEEDS):
        raise InputError(f"A thrust map cannot have {deflections} deflections and {numbers - 2} speeds.")
    constants = [*thrust_map.altitude_ft, thrust_map.full_thrust_lbf, *thrust_map.tolerances]
    reach = thrust_map.reach
    if reach.shape != (*table.shape[:2], 2):
        raise InputError(
            f"A thrust map of {table.shape[:2]} conditions cannot have a reach of the shape {reach.shape}."
        )
    finite = ("table", table), ("constants", np.array(constants, dtype=float)), (REACH, reach)
    for name, array in (*nodes.items(), *finite):
        if not np.isfinite(array).all():
            raise InputError(f"A thrust map must hold finite numbers, but its {name} does not.")
    for name, way in (("density_ratio", -1.0), ("gamma_deg", 1.0), ("deflection_deg", 1.0)):
        if (way * np.diff(nodes[name]) <= 0).any():
            raise InputError(f"The {name} of a thrust map must {'rise' if way > 0 else 'fall'} from node to node.")
    ends = np.array(thrust_map.altitude_ft), table[..., :2], reach
    if any((pairs[..., 0] > pairs[..., 1]).any() for pairs in ends):
        raise InputError("Altitudes, speeds or reach of a thrust map are reversed: the lower one comes first.")
    if thrust_map.full_thrust_lbf <= 0 or min(thrust_map.tolerances) < 0 or thrust_map.tolerances.thrust_deviations < 1:
        raise InputError("The thrust and the tolerances of a thrust map must be positive, its deviations at least 1.")


def _checksum(described: dict[str, Any], arrays: Mapping[str, Any]) -> str:
    """Hash of what a file holds."""
    digest = hashlib.sha256(json.dumps(described, sort_keys=True).encode())
    for name in sorted(arrays):
        array = np.asarray(arrays[name])
        digest.update(f"{name} {array.dtype.str} {array.shape}".encode() + array.tobytes())
    return digest.hexdigest()
