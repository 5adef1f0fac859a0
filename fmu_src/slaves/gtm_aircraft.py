"""The GtmAircraft slave: the compiled simulation behind co-simulation. It runs in the Python of the host."""

import ctypes
from math import isfinite
from typing import Any

from .core_library import Buffer, load_core
from .gtm_dynamics import FAULTS
from .slave import TableSlave

SIMULATION_FAULTS = {
    7: "The limits of a control are reversed: lower above upper.",
    8: "A command, wind, setting or the fuel used is outside its range, or damage.case is no whole number.",
    9: "The commands changed more than 2048 times within the transport delays: take longer steps or shorter delays.",
    10: "The memory of the actuators is damaged.",
}
"""``enum gtm_simulation_fault`` of gtm_simulation.h."""

ALL_FAULTS = {**FAULTS, **SIMULATION_FAULTS}


class GtmAircraft(TableSlave):
    """The GTM-T2 as it flies, from pilot commands to motion."""

    def __init__(self, **kwargs: Any) -> None:
        """Load the core and make its buffers, which are in its units."""
        super().__init__(**kwargs)
        self.core = load_core(self.resources, "GtmAircraft")
        self.core.gtm_simulation_advance.argtypes = [ctypes.c_void_p] * 4 + [ctypes.c_double] * 2
        self.core.gtm_simulation_memory_size.restype = ctypes.c_long
        self.memory = (ctypes.c_double * self.core.gtm_simulation_memory_size())()
        groups = ("states", "controls", "settings", "derivatives", "outputs")
        self.x, self.u, self.p, self.dx, self.y = (Buffer(self, group) for group in groups)
        self.substep = self.group("solver").start

    def _load(self) -> list[ctypes.c_void_p]:
        """States, inputs and settings into the core's buffers; where they and the memory are."""
        for buffer in (self.x, self.u, self.p):
            buffer.load(self.values[buffer.places])
        memory = ctypes.c_void_p(ctypes.addressof(self.memory))
        return [self.x.address, self.u.address, self.p.address, memory]

    def compute(self) -> str | None:
        """Derivatives and outputs of the values."""
        code = self.core.gtm_simulation_evaluate(*self._load(), self.dx.address, self.y.address)
        if code:
            return ALL_FAULTS[code]
        rates, outputs = self.dx.read(), self.y.read()
        if not isfinite(sum(rates) + sum(outputs)):
            return "The derivatives at this state are not finite."
        self.values[self.dx.places] = rates
        self.values[self.y.places] = outputs
        return None

    def advance(self, step_size: float) -> str | None:
        """Integrate with constant inputs."""
        before = bytes(self.memory)
        code = self.core.gtm_simulation_advance(*self._load(), step_size, self.values[self.substep])
        if code:
            return ALL_FAULTS[code]
        states = self.values[self.x.places]
        self.values[self.x.places] = self.x.read()
        fault = self.compute()
        if fault:
            self.values[self.x.places] = states
            ctypes.memmove(self.memory, before, len(before))
            return fault
        return None

    def _get_fmu_state(self) -> dict:
        return {**super()._get_fmu_state(), "memory": bytes(self.memory).hex()}

    def restore(self, state: dict) -> None:
        """Go back to what `_get_fmu_state` gave."""
        super().restore(state)
        memory = bytes.fromhex(state["memory"])
        ctypes.memmove(self.memory, memory, len(memory))
