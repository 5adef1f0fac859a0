"""What the slaves of this project share. It runs in the Python of the host: standard library and pythonfmu only.

A slave is one flat list of numbers in SI, in the order of the variable table that travels in the FMU's resources.
pythonfmu 0.7.0 answers an exception after instantiation by freeing the slave twice, so a slave never raises then: it
logs one sentence and refuses the step. Log texts are format strings of C and hold no percent sign.
"""

import json
import platform
import sys
from math import inf, isfinite
from pathlib import Path

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


def platform_folder() -> str:
    """Name of this platform as in the binaries folder of an FMI 2.0 FMU."""
    system, machine = platform.system(), platform.machine()
    return PLATFORMS.get((system, machine), f"{machine}-{system}".lower())


def read_resource(resources: str, name: str) -> dict:
    """The content of a JSON file of the resources."""
    try:
        return json.loads(Path(resources, name).read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise RuntimeError(f"The FMU's {name} is missing or damaged ({error}): build the FMU anew.") from None


class TableSlave(Fmi2Slave):
    """A slave whose `compute` and `advance` return what is wrong, in one sentence, or None."""

    def __init__(self, **kwargs):
        """Read the variable table."""
        super().__init__(**kwargs)
        self.table = read_resource(self.resources, TABLE_FILE)
        self.log_categories = self.table["log_categories"]
        self.names: list[str] = self.table["names"]
        self.values: list[float] = self.table["starts"]
        self.bounds = {int(place): bounds for place, bounds in self.table["bounds"].items()}
        self.booleans = set(self.table["booleans"])
        self.refused: dict[str, str] = {}
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

    def enter_initialization_mode(self):
        """Take pythonfmu's entries of the resources out of the host's module search path: all code is loaded."""
        sys.path[:] = [path for path in sys.path if path != self.resources]

    def set_real(self, vrs, values):
        """Take finite values, and parameters inside their bounds; any other is refused and the old one kept."""
        is_plain = isfinite(sum(values)) and not self.refused and self.bounds.keys().isdisjoint(vrs)
        for place, value in zip(self._known(vrs), values, strict=False):
            if is_plain:
                self.values[place] = value
            else:
                self._set_checked(place, value)
        self.is_stale = True

    def _known(self, places: list[int]) -> list[int]:
        """The value references, or none of them when one does not exist."""
        if max(places, default=0) < len(self.values):
            return places
        self.log(f"There is no value reference {max(places)}: the last is {len(self.values) - 1}.", Fmi2Status.error)
        return []

    def _set_checked(self, place: int, value: float) -> None:
        least, greatest = self.bounds.get(place, (-inf, inf))
        slack = ROUNDING * max(1.0, abs(value))
        name = self.names[place]
        if isfinite(value) and least - slack <= value <= greatest + slack:
            self.values[place] = value
            self.refused.pop(name, None)
            return
        unit = self.table["units"][place]
        allowed = f"{least:g} .. {greatest:g} {unit}" if place in self.bounds else "a finite number"
        self.refused[name] = f"{name} was given as {value:g}, allowed is {allowed}: {self.values[place]:g} is kept."
        self.log(self.refused[name], Fmi2Status.error)

    def _update(self) -> None:
        if self.is_stale:
            self.is_stale = False
            fault = self.compute()
            if fault:
                self.log(f"{fault} The outputs are those of the last good values.", Fmi2Status.error)

    def get_real(self, vrs):
        """Values in SI; the outputs are computed when they are asked for."""
        self._update()
        values = self.values
        return [values[place] for place in self._known(vrs)] or [0.0] * len(vrs)

    def get_boolean(self, vrs):
        """Values as truth."""
        return [value != 0 for value in self.get_real(vrs)]

    def set_boolean(self, vrs, values):
        """Take truth as 0 or 1."""
        for place in vrs:
            if place not in self.booleans:
                self.log(f"There is no Boolean variable with value reference {place}.", Fmi2Status.error)
                return
        self.set_real(vrs, [float(value) for value in values])

    def do_step(self, current_time, step_size):
        """One communication step; refused (Discard) with one sentence in the log, the values being as before."""
        fault = self.refusal()
        if fault is None and not 0 <= step_size < inf:
            fault = f"A step of {step_size:g} s was asked for, allowed is a finite one that is not negative."
        if fault is None:
            fault = self.advance(step_size)
        if fault:
            self.log(f"{fault} The step at {current_time:g} s is refused.", Fmi2Status.discard)
        return fault is None

    def _get_fmu_state(self):
        return {"values": list(self.values), "refused": dict(self.refused)}

    def _set_fmu_state(self, state):
        self.values, self.refused = list(state["values"]), dict(state["refused"])
        self.is_stale = True
