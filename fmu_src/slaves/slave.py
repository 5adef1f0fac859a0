"""What the slaves of this project share. It runs in the Python of the host: standard library and pythonfmu only.

A slave is one flat list of numbers in SI, in the order of the variable table that travels in the FMU's resources. What
it refuses it says in one sentence of the log, whose status the wrapper gives to the caller. It never raises after
instantiation: pythonfmu's own binary, which runs it on Windows, would then free it twice. Log texts are format strings
of C and hold no percent sign.
"""

import hashlib
import json
import platform
import sys
from math import inf, isfinite
from pathlib import Path
from typing import Any

from pythonfmu import Fmi2Slave
from pythonfmu.enums import Fmi2Status

TABLE_FILE = "variables.json"
PLATFORMS = {
    ("Linux", "x86_64"): "linux64",
    ("Windows", "AMD64"): "win64",
    ("Darwin", "x86_64"): "darwin64",
}
ROUNDING = 1e-9
"""What a bound given in another unit may be off by, relative to one."""
REMEDIES = "give other inputs or parameters, go back to a saved state, or end the simulation."


def platform_folder() -> str:
    """Name of this platform as in the binaries folder of an FMI 2.0 FMU."""
    system, machine = platform.system(), platform.machine()
    return PLATFORMS.get((system, machine), f"{machine}-{system}".lower())


def shortest(number: float) -> str:
    """The shortest text that reads back as the number."""
    return repr(float(number)).removesuffix(".0")


def read_resource(resources: str, name: str) -> dict:
    """The content of a JSON file of the resources."""
    try:
        return json.loads(Path(resources, name).read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise RuntimeError(f"The FMU's {name} is missing or damaged ({error}): build the FMU anew.") from None


class TableSlave(Fmi2Slave):
    """A slave whose `compute` and `advance` return what is wrong, in one sentence, or None."""

    def __init__(self, **kwargs: Any) -> None:
        """Read the variable table."""
        super().__init__(**kwargs)
        self.table = read_resource(self.resources, TABLE_FILE)
        self.log_categories = self.table["log_categories"]
        self.names: list[str] = self.table["names"]
        self.values: list[float] = self.table["starts"]
        self.bounds = {int(place): bounds for place, bounds in self.table["bounds"].items()}
        self.computed = set(self.table["computed"])
        booleans, enumerations = set(self.table["booleans"]), set(self.table["enumerations"])
        numbers = set(range(len(self.names))) - booleans - enumerations
        self.kinds = {"real": numbers, "Boolean": booleans, "enumeration": enumerations}
        self.refused: dict[str, str] = {}
        self.fault: str | None = None
        self.is_stale = True

    def group(self, name: str) -> slice:
        """Places of a group of variables."""
        return slice(*self.table["groups"][name])

    def compute(self) -> str | None:
        """Compute the outputs from the other values; on a fault leave them as they were."""
        raise NotImplementedError

    def advance(self, step_size: float) -> str | None:
        """Move the values on by a step; on a fault leave them as they were."""
        raise NotImplementedError

    def refusal(self) -> str | None:
        """Why the values given by the importer cannot be used."""
        return next(iter(self.refused.values()), None)

    def enter_initialization_mode(self) -> None:
        """Take pythonfmu's entries of the resources out of the host's module search path: all code is loaded."""
        sys.path[:] = [path for path in sys.path if path != self.resources]

    def set_real(self, vrs: list[int], values: list[float]) -> None:
        """Take finite values, and parameters inside their bounds; any other is refused and the old one kept."""
        if self._are_known(vrs, "real"):
            self._set(vrs, values)

    def _set(self, places: list[int], values: list[float]) -> None:
        if not self.computed.isdisjoint(places):
            name = self.names[next(place for place in places if place in self.computed)]
            self.log(f"{name} is computed by the FMU and cannot be set.", Fmi2Status.error)
            return
        is_plain = isfinite(sum(values)) and not self.refused and self.bounds.keys().isdisjoint(places)
        for place, value in zip(places, values, strict=True):
            if is_plain:
                self.values[place] = value
            else:
                self._set_checked(place, value)
        self.is_stale = True

    def _are_known(self, places: list[int], kind: str) -> bool:
        """Whether the value references are those of real or of Boolean variables."""
        known = self.kinds[kind]
        if known.issuperset(places):
            return True
        self._has_none(kind, [place for place in places if place not in known])
        return False

    def _has_none(self, kind: str, places: list[int]) -> None:
        self.log(f"There is no {kind} variable with value reference {places[0]}.", Fmi2Status.error)

    def _set_checked(self, place: int, value: float) -> None:
        least, greatest = self.bounds.get(place, (-inf, inf))
        slack = ROUNDING * max(1.0, abs(value))
        name = self.names[place]
        if isfinite(value) and least - slack <= value <= greatest + slack:
            self.values[place] = value
            self.refused.pop(name, None)
            return
        unit = self.table["units"][place]
        allowed = f"{shortest(least)} .. {shortest(greatest)} {unit}" if place in self.bounds else "a finite number"
        kept = shortest(self.values[place])
        self.refused[name] = f"{name} was given as {shortest(value)}, allowed is {allowed}: {kept} is kept."
        self.log(self.refused[name], Fmi2Status.discard)

    def _update(self) -> None:
        """Compute the outputs if the values have changed; say what is wrong each time they are asked for."""
        if self.is_stale:
            self.is_stale = False
            self.fault = self.refusal() or self.compute()
        if self.fault:
            self.log(f"{self.fault} The outputs are those of the last good values.", Fmi2Status.discard)

    def _get(self, places: list[int]) -> list[float]:
        if not self.computed.isdisjoint(places):
            self._update()
        values = self.values
        return [values[place] for place in places]

    def get_real(self, vrs: list[int]) -> list[float]:
        """Values in SI; the outputs are computed when they are asked for."""
        return self._get(vrs) if self._are_known(vrs, "real") else [0.0] * len(vrs)

    def get_boolean(self, vrs: list[int]) -> list[bool]:
        """Values as truth."""
        return [value != 0 for value in self._get(vrs)] if self._are_known(vrs, "Boolean") else [False] * len(vrs)

    def set_boolean(self, vrs: list[int], values: list[bool]) -> None:
        """Take truth as 0 or 1."""
        if self._are_known(vrs, "Boolean"):
            self._set(vrs, [float(value) for value in values])

    def get_integer(self, vrs: list[int]) -> list[int]:
        """Values of enumerations."""
        return [int(value) for value in self._get(vrs)] if self._are_known(vrs, "enumeration") else [0] * len(vrs)

    def set_integer(self, vrs: list[int], values: list[int]) -> None:
        """Refused: all enumerations are computed."""
        if self._are_known(vrs, "enumeration"):
            self._set(vrs, [float(value) for value in values])

    def get_string(self, vrs: list[int]) -> list[str]:
        """Refused: there are none."""
        self._has_none("String", vrs)
        return [""] * len(vrs)

    def set_string(self, vrs: list[int], values: list[str]) -> None:
        """Refused: there are none."""
        self._has_none("String", vrs)

    def do_step(self, current_time: float, step_size: float) -> bool:
        """One communication step; refused (Discard) with one sentence in the log, the values being as before."""
        fault = self.refusal()
        if fault is None and not 0 <= step_size < inf:
            fault = f"A step of {shortest(step_size)} s was asked for, allowed is a finite one that is not negative."
        if fault is None:
            fault = self.advance(step_size)
        self.is_stale, self.fault = fault is not None, None
        if fault:
            stays = f"The step at {shortest(current_time)} s is refused and the FMU stays there"
            self.log(f"{fault} {stays}: {REMEDIES}", Fmi2Status.discard)
        return fault is None

    def _get_fmu_state(self) -> dict:
        return {"values": list(self.values), "refused": dict(self.refused)}

    def _set_fmu_state(self, state: dict) -> None:
        if state:
            self.restore(state)
        else:
            self.log("The bytes were no state of this FMU.", Fmi2Status.error)

    def restore(self, state: dict) -> None:
        """Go back to what `_get_fmu_state` gave."""
        self.values, self.refused = list(state["values"]), dict(state["refused"])
        self.is_stale = True

    @staticmethod
    def _fmu_state_to_bytes(state: dict) -> bytes:
        content = json.dumps(state).encode()
        return _seal(content) + content

    @staticmethod
    def _fmu_state_from_bytes(state: bytes) -> dict:
        """The state, or an empty one when the bytes are not those of a state of this FMU."""
        length = len(_seal(b""))
        content = state[length:]
        return json.loads(content) if state[:length] == _seal(content) else {}


def _seal(content: bytes) -> bytes:
    """What only this FMU puts before a state: its package is named by a hash of all that it consists of."""
    return hashlib.sha256(f"{__package__}\n".encode() + content).digest()
