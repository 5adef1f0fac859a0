"""The GtmEnvelope slave: the core's exact V_min and V_max behind co-simulation. It runs in the Python of the host."""

import ctypes
from typing import Any

from .core_library import load_core
from .envelope_slave import EnvelopeSlave, Found
from .failure_faults import FAILURE_FAULTS


class GtmEnvelope(EnvelopeSlave):
    """The slowest and the fastest trim that a failure leaves."""

    case_groups = ("case", "failure")

    def __init__(self, **kwargs: Any) -> None:
        """Load the core and make its buffers."""
        super().__init__(**kwargs)
        self.solve = load_core(self.resources, "GtmEnvelope").gtm_failure_envelope
        self.inputs = (ctypes.c_double * len(self.case))()
        failure = ctypes.byref(self.inputs, ctypes.sizeof(ctypes.c_double) * self.group("speed").start)
        constants = self.table["constants"]
        bounds = [(ctypes.c_double * len(constants[end]))(*constants[end]) for end in ("lower", "upper")]
        self.speeds, self.exists = (ctypes.c_double * 2)(), ctypes.c_int()
        results = self.speeds, ctypes.byref(self.exists)
        self.arguments = (self.inputs, failure, *bounds, *results)

    def find(self, case: list[float]) -> Found | str:
        """Both ends; none without a trim inside the limits."""
        self.inputs[:] = [*case]
        fault = self.solve(*self.arguments)
        return FAILURE_FAULTS[fault] if fault else Found([*self.speeds, 0.0, 0.0], self.exists.value != 0, True)
