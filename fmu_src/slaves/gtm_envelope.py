"""The GtmEnvelope slave: the core's exact V_min and V_max behind co-simulation. It runs in the Python of the host."""

import ctypes
from typing import Any

from .core_library import load_core
from .envelope_slave import EnvelopeSlave, Found
from .failure_faults import FAILURE_FAULTS
from .names import TWO_THROTTLE_UNKNOWNS, V


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
        self.ends = (ctypes.c_double * (2 * len(TWO_THROTTLE_UNKNOWNS)))()
        self.arguments = (self.inputs, failure, *bounds, None, self.ends)

    def find(self, case: list[float]) -> Found | str:
        """Both ends; none without a trim inside the limits."""
        self.inputs[:] = [*case]
        if fault := self.solve(*self.arguments):
            return FAILURE_FAULTS[fault]
        speeds = self.ends[V :: len(TWO_THROTTLE_UNKNOWNS)]
        return Found([*speeds, 0.0, 0.0], speeds[0] > 0, True)
