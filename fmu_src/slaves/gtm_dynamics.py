"""The GtmDynamics slave: the compiled core behind co-simulation. It runs in the Python of the host."""

import ctypes
from math import isfinite
from typing import Any

from pythonfmu.enums import Fmi2Status

from .core_library import Buffer, load_core
from .slave import ROUNDING, TableSlave, shortest

FAULTS = {
    1: "The state is not finite.",
    2: "The airspeed is below 1 ft/s (0.3048 m/s), where the angles of the flow are undefined.",
    3: "The sideslip is 90 deg, where the angle of attack is undefined.",
    4: "The pitch angle is 90 or -90 deg, where bank and heading are undefined.",
    5: "The latitude is 90 or -90 deg, where the longitude is undefined.",
    6: "The step takes more than 1000000 parts of solver.substep: take shorter steps, or a longer solver.substep.",
}
"""``enum gtm_fault`` of gtm_core.h."""


class GtmDynamics(TableSlave):
    """Flight dynamics of the GTM-T2: states by fixed-step Runge-Kutta, commands held inside their limits."""

    def __init__(self, **kwargs: Any) -> None:
        """Load the core and make its buffers, which are in its units."""
        super().__init__(**kwargs)
        self.core = load_core(self.resources, "GtmDynamics")
        self.core.gtm_advance.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_double, ctypes.c_double]
        self.held: set[str] = set()
        groups = ("states", "derivatives", "controls", "outputs")
        self.x, self.dx, self.u, self.y = (Buffer(self, group) for group in groups)
        self.limits, solver = self.group("limits"), self.group("solver")
        self.substep = solver.start

    def _load(self) -> str | None:
        """States and held commands into the core's buffers."""
        limits = self.values[self.limits]
        commands, lower, upper = self.values[self.u.places], limits[::2], limits[1::2]
        for name, low, high in zip(self.u.names, lower, upper, strict=True):
            if low > high:
                lowest, highest = shortest(low), shortest(high)
                return f"{name.replace('control', 'limits')} is reversed: lower {lowest} is above upper {highest} (SI)."
        held = list(map(min, map(max, commands, lower), upper))
        if self.held or held != commands:
            self._note_excursions(commands, held)
        self.x.load(self.values[self.x.places])
        self.u.load(held)
        return None

    def _note_excursions(self, commands: list[float], held: list[float]) -> None:
        """Log each command outside its limits once, until it is inside again."""
        for name, command, kept in zip(self.u.names, commands, held, strict=True):
            if abs(command - kept) <= ROUNDING:
                self.held.discard(name)
            elif name not in self.held:
                self.held.add(name)
                given, used = shortest(command), shortest(kept)
                self.log(f"{name} {given} is outside its limits and is held at {used} (SI).", Fmi2Status.warning)

    def _store(self) -> str | None:
        """Derivatives and outputs at the core's state into the values."""
        x, u, dx, y = self.x.address, self.u.address, self.dx.address, self.y.address
        fault = self.core.gtm_state_fault(x)
        if fault:
            return FAULTS[fault]
        self.core.gtm_derivatives(x, u, dx)
        self.core.gtm_outputs(x, u, y)
        rates, outputs = self.dx.read(), self.y.read()
        if not isfinite(sum(rates) + sum(outputs)):
            return "The derivatives at this state are not finite."
        self.values[self.dx.places] = rates
        self.values[self.y.places] = outputs
        return None

    def compute(self) -> str | None:
        """Derivatives and outputs of the values."""
        return self._load() or self._store()

    def advance(self, step_size: float) -> str | None:
        """Integrate with constant commands."""
        fault = self._load()
        if fault:
            return fault
        code = self.core.gtm_advance(self.x.address, self.u.address, step_size, self.values[self.substep])
        fault = FAULTS[code] if code else self._store()
        if fault:
            return fault
        self.values[self.x.places] = self.x.read()
        return None

    def _get_fmu_state(self) -> dict:
        return {**super()._get_fmu_state(), "held": sorted(self.held)}

    def restore(self, state: dict) -> None:
        """Go back to what `_get_fmu_state` gave."""
        super().restore(state)
        self.held = set(state["held"])
