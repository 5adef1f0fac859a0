"""Who is asked about the aircraft: FMUs, through FMPy. One interface, so that one can take another's place."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from fmpy.model_description import ModelDescription

from gtm_fmu import FmuClient, FmuError
from gtm_fmu.airframe.names import LIMITED
from gtm_fmu.errors import InputError
from gtm_fmu.units import M_PER_FT, M_S_PER_KT, RAD_PER_DEG

Failure = Mapping[str, float | bool]
Speeds = tuple[float, float]
_GRAVITY_M_S2 = 9.81
_RUDDER = ("limits.rudder.lower", "limits.rudder.upper")
_SAFE = ("v_min_safe", "v_max_safe", "feasible_safe")
_ASKED = ("altitude", "gamma", "tas", "turn_rate")
_SUFFIX = {"deg": "deg", "%": "pct", "lbf": "lbf"}


@dataclass(frozen=True)
class Answer:
    """About one manoeuvre; trim and margins by name with the unit at the end, empty where there are none.

    Attributes:
        is_found: whether there are trim and margins, of the manoeuvre or of one that exceeds the limits least.
    """

    feasible: bool
    is_found: bool
    binding: str
    trim: Mapping[str, float]
    margins: Mapping[str, tuple[float, float]]


class EnvelopeSource(Protocol):
    """What a planner asks."""

    name: str
    queries: int

    def speeds(self, altitude_ft: float, gamma_deg: float, failure: Failure) -> Speeds | None:
        """V_min and V_max in kn after a failure; None where no steady flight is left, or where it does not know."""

    def turn_rates(self, altitude_ft: float, gamma_deg: float, tas_kt: float) -> tuple[float, float] | None:
        """Ends of the turns in deg/s, from left to right; None without any."""

    def are_feasible(self, manoeuvres: np.ndarray) -> np.ndarray:
        """Whether manoeuvres can be flown (n): rows of altitude in ft, path in deg, speed in kn, deg/s (n, 4)."""

    def answer(self, altitude_ft: float, gamma_deg: float, tas_kt: float, turn_rate_deg_s: float) -> Answer:
        """All about one manoeuvre."""

    def knows(self, failure: Failure) -> bool:
        """Whether it can be asked about this failure."""

    def close(self) -> None:
        """Free the FMUs."""


def display_factors(description: ModelDescription) -> dict[str, float]:
    """By variable: its display unit in its SI unit, 1 without one."""
    units = {unit.name: {each.name: each.factor for each in unit.displayUnits} for unit in description.unitDefinitions}
    found = {}
    for variable in description.modelVariables:
        display = variable.displayUnit or (variable.declaredType and variable.declaredType.displayUnit)
        found[variable.name] = float(units.get(variable.unit, {}).get(display, 1.0))
    return found


def set_failure(fmu: FmuClient, failure: Failure) -> None:
    """Set inputs or parameters given in display units.

    Raises:
        InputError: a name that the FMU does not have as an input or parameter, or a value that it refuses.
    """
    factors = display_factors(fmu.description)
    allowed = {v.name for v in fmu.description.modelVariables if v.causality in ("input", "parameter")}
    reals: dict[str, float] = {}
    for name, value in failure.items():
        if name not in allowed:
            raise InputError(f"The failure's '{name}' is no input of {fmu.description.modelName}; see docs/fmus.md.")
        if fmu.is_boolean(name) != isinstance(value, bool):
            wanted = "true or false" if fmu.is_boolean(name) else "a number"
            raise InputError(f"The failure's '{name}' is {value!r}; give {wanted}.")
        if isinstance(value, bool):
            fmu.set_boolean(name, value)
        else:
            reals[name] = value / factors[name]
    try:
        fmu.set(tuple(reals), list(reals.values()))
    except FmuError as error:
        raise InputError(f"The failure is refused: {error}") from error


class _Envelope:
    """V_min and V_max of an FMU with the envelope's interface, each asked once."""

    def __init__(self, path: Path, ends: tuple[str, str, str] = ("v_min", "v_max", "feasible")) -> None:
        self.fmu, self.ends = FmuClient(path), ends
        inputs = [v for v in self.fmu.description.modelVariables if v.causality == "input"]
        self.names = {v.name for v in inputs}
        self.starts: dict[str, Any] = {v.name: v.start for v in inputs}
        self.known: dict[tuple, Speeds | None] = {}
        self.set: Failure = {}
        self.queries = 0

    def input_name(self, name: str) -> str:
        """The rudder's limits have shorter names where nothing else can fail."""
        return name if name in self.names else name.removeprefix("limits.")

    def speeds(self, altitude_ft: float, gamma_deg: float, failure: Failure) -> Speeds | None:
        key = altitude_ft, gamma_deg, tuple(sorted(failure.items()))
        if key not in self.known:
            self.known[key] = self._ask(altitude_ft, gamma_deg, failure)
        return self.known[key]

    def _ask(self, altitude_ft: float, gamma_deg: float, failure: Failure) -> Speeds | None:
        self.queries += 1
        wanted = {self.input_name(name): value for name, value in failure.items()}
        if wanted != self.set:
            self._restore()
            set_failure(self.fmu, wanted)
            self.set = wanted
        self.fmu.set(_ASKED[:2], (altitude_ft * M_PER_FT, gamma_deg * RAD_PER_DEG))
        v_min, v_max = self.fmu.get(self.ends[:2]) / M_S_PER_KT
        is_left = self.fmu.get_boolean(self.ends[2]) and v_min <= v_max
        return (float(v_min), float(v_max)) if is_left else None

    def _restore(self) -> None:
        """What was set before goes back to its start value."""
        reals = [name for name in self.set if not self.fmu.is_boolean(name)]
        self.fmu.set(tuple(reals), [float(self.starts[name]) for name in reals])
        for name in self.set:
            if self.fmu.is_boolean(name):
                self.fmu.set_boolean(name, self.starts[name] == "true")


class ExactFmus:
    """The exact solver: GtmManoeuvre about manoeuvres, GtmEnvelope about speeds."""

    def __init__(self, manoeuvre: Path, envelope: Path, failure: Failure) -> None:
        """Instantiate both.

        Raises:
            InputError: an FMU that does not load, or a failure that it does not know.
        """
        self.name, self._paths = "exact", (manoeuvre, envelope)
        self._fmu, self._envelope = FmuClient(manoeuvre), _Envelope(envelope)
        set_failure(self._fmu, failure)
        self._factors = display_factors(self._fmu.description)
        outputs = [v for v in self._fmu.description.modelVariables if v.causality == "output" and v.type == "Real"]
        self._told = tuple(v.name for v in outputs if v.name.startswith(("trim.", "margin.")))
        self._units = {v.name: _SUFFIX[v.displayUnit] for v in outputs if v.name in self._told}
        self._asked = 0

    @property
    def queries(self) -> int:
        """How many answers were asked for."""
        return self._asked + self._envelope.queries

    def of(self, failure: Failure) -> "ExactFmus":
        """The same FMUs after another failure."""
        return ExactFmus(*self._paths, failure)

    def knows(self, failure: Failure) -> bool:
        """Every failure."""
        return True

    def speeds(self, altitude_ft: float, gamma_deg: float, failure: Failure) -> Speeds | None:
        """See `EnvelopeSource`."""
        return self._envelope.speeds(altitude_ft, gamma_deg, failure)

    def turn_rates(self, altitude_ft: float, gamma_deg: float, tas_kt: float) -> tuple[float, float] | None:
        """See `EnvelopeSource`."""
        self._ask(altitude_ft, gamma_deg, tas_kt, 0.0)
        least, greatest = self._fmu.get(("turn_rate.least", "turn_rate.greatest")) / RAD_PER_DEG
        return (float(least), float(greatest)) if least <= greatest else None

    def are_feasible(self, manoeuvres: np.ndarray) -> np.ndarray:
        """See `EnvelopeSource`."""
        feasible = np.zeros(len(manoeuvres), bool)
        for k, row in enumerate(manoeuvres.tolist()):
            self._ask(*row)
            feasible[k] = self._fmu.get_boolean("feasible")
        return feasible

    def answer(self, altitude_ft: float, gamma_deg: float, tas_kt: float, turn_rate_deg_s: float) -> Answer:
        """See `EnvelopeSource`."""
        self._ask(altitude_ft, gamma_deg, tas_kt, turn_rate_deg_s)
        told = {
            name: float(value) * self._factors[name]
            for name, value in zip(self._told, self._fmu.get(self._told), strict=True)
        }
        trim = {_label(name, self._units): value for name, value in told.items() if name.startswith("trim.")}
        limited = [*LIMITED, "thrust"]
        margins = {
            _label(f"margin.{name}.lower", self._units): (told[f"margin.{name}.lower"], told[f"margin.{name}.upper"])
            for name in limited
        }
        return Answer(
            self._fmu.get_boolean("feasible"),
            self._fmu.get_boolean("found"),
            self._fmu.get_item("binding"),
            trim,
            margins,
        )

    def close(self) -> None:
        """Free both."""
        self._fmu.close()
        self._envelope.fmu.close()

    def _ask(self, altitude_ft: float, gamma_deg: float, tas_kt: float, turn_rate_deg_s: float) -> None:
        self._asked += 1
        self._fmu.set(
            _ASKED,
            (altitude_ft * M_PER_FT, gamma_deg * RAD_PER_DEG, tas_kt * M_S_PER_KT, turn_rate_deg_s * RAD_PER_DEG),
        )


def _label(name: str, units: Mapping[str, str]) -> str:
    """As ``throttle_left_pct`` of ``trim.throttle.left``."""
    parts = [part for part in name.split(".")[1:] if part not in ("lower", "upper")]
    return "_".join([*parts, units[name]])


class MapFmu:
    """A map of V_min and V_max (GtmSurrogate, GtmThrustMap), which knows the rudder's limits and no turns.

    Turns are then those of coordinated flight up to a bank: psi_dot = g tan(phi) / V, the same to both sides.
    """

    BANK_DEG = 30.0

    def __init__(self, path: Path, failure: Failure, is_safe: bool = False, label: str | None = None) -> None:
        """Instantiate it.

        Args:
            is_safe: whether to take the safe speeds, which are inside the exact ones with a probability that the map's
                documentation says.
            label: of what the FMU carries, for its name.

        Raises:
            InputError: an FMU that does not load or has no safe speeds, or a failure of more than the rudder.
        """
        self._envelope = _Envelope(path, _SAFE) if is_safe else _Envelope(path)
        parts = self._envelope.fmu.description.modelName, label, "safe speeds" if is_safe else None
        self.name = ", ".join(part for part in parts if part)
        self._failure = failure
        if not self.knows(failure):
            other = next(name for name in failure if name not in _RUDDER)
            raise InputError(f"{self.name} knows limits of the rudder only, not '{other}'; ask the exact FMUs.")

    @property
    def queries(self) -> int:
        """How many answers were asked for."""
        return self._envelope.queries

    def knows(self, failure: Failure) -> bool:
        """Whether nothing but the rudder has failed."""
        return set(failure) <= set(_RUDDER)

    def speeds(self, altitude_ft: float, gamma_deg: float, failure: Failure) -> Speeds | None:
        """See `EnvelopeSource`."""
        return self._envelope.speeds(altitude_ft, gamma_deg, failure)

    def turn_rates(self, altitude_ft: float, gamma_deg: float, tas_kt: float) -> tuple[float, float] | None:
        """See `EnvelopeSource`."""
        speeds = self.speeds(altitude_ft, gamma_deg, self._failure)
        if speeds is None or not speeds[0] <= tas_kt <= speeds[1]:
            return None
        rate = _GRAVITY_M_S2 * math.tan(self.BANK_DEG * RAD_PER_DEG) / (tas_kt * M_S_PER_KT) / RAD_PER_DEG
        return -rate, rate

    def are_feasible(self, manoeuvres: np.ndarray) -> np.ndarray:
        """See `EnvelopeSource`."""
        return np.array([self._is_feasible(*row) for row in manoeuvres.tolist()], bool)

    def answer(self, altitude_ft: float, gamma_deg: float, tas_kt: float, turn_rate_deg_s: float) -> Answer:
        """See `EnvelopeSource`."""
        return Answer(self._is_feasible(altitude_ft, gamma_deg, tas_kt, turn_rate_deg_s), False, "none", {}, {})

    def close(self) -> None:
        """Free it."""
        self._envelope.fmu.close()

    def _is_feasible(self, altitude_ft: float, gamma_deg: float, tas_kt: float, turn_rate_deg_s: float) -> bool:
        turns = self.turn_rates(altitude_ft, gamma_deg, tas_kt)
        return turns is not None and turns[0] <= turn_rate_deg_s <= turns[1]


def second_failures(failure: Failure, rudder_lost_deg: float, engine_out: bool) -> dict[str, Sequence[dict]]:
    """By name: what the aircraft's failure becomes; of several variants the worst counts.

    The rudder's limits come so much closer from either side; a jam moves so much further to either side.
    """
    found: dict[str, Sequence[dict]] = {}
    if rudder_lost_deg:
        lower, upper = (float(failure.get(name, end)) for name, end in zip(_RUDDER, (-30.0, 30.0), strict=True))
        pairs = [(min(lower + rudder_lost_deg, upper), upper), (lower, max(upper - rudder_lost_deg, lower))]
        if lower == upper:
            pairs = [(end, end) for end in (max(lower - rudder_lost_deg, -30.0), min(lower + rudder_lost_deg, 30.0))]
        variants = [dict(failure) | dict(zip(_RUDDER, pair, strict=True)) for pair in pairs]
        found[f"rudder {rudder_lost_deg:g} deg further"] = variants
    if engine_out:
        sides = [side for side in ("left", "right") if failure.get(f"engine.{side}.running", True)]
        found["an engine out"] = [dict(failure) | {f"engine.{side}.running": False} for side in sides]
    return {name: variants for name, variants in found.items() if variants}
