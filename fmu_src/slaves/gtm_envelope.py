"""The GtmEnvelope slave: the core's exact V_min and V_max behind co-simulation. It runs in the Python of the host."""

import ctypes
from typing import Any

from .core_library import load_core
from .envelope_slave import EnvelopeSlave, Found
from .names import RUDDER, TRIM_UNKNOWNS, V

ONE_THROTTLE, TRIMMED = 1, 0


class GtmEnvelope(EnvelopeSlave):
    """The slowest and the fastest trim that a failed rudder leaves."""

    def __init__(self, **kwargs: Any) -> None:
        """Load the core and make its buffers."""
        super().__init__(**kwargs)
        trim, real = ctypes.c_double * len(TRIM_UNKNOWNS), ctypes.c_double
        self.solve = load_core(self.resources, "GtmEnvelope").gtm_envelope_end
        self.solve.argtypes = [ctypes.c_void_p, ctypes.c_int, real, real, trim, trim, trim, trim, ctypes.POINTER(real)]
        self.lower, self.upper = (trim(*self.table["constants"][end]) for end in ("lower", "upper"))
        self.best, self.violation = trim(), real()

    def find(self, case: list[float]) -> Found:
        """Both ends; none without a trim inside the limits."""
        altitude, gamma, self.lower[RUDDER], self.upper[RUDDER] = case
        speeds: list[float] = []
        for sign in (1.0, -1.0):
            objective = type(self.best)(sign)
            at = None, ONE_THROTTLE, altitude, gamma, self.lower, self.upper, objective
            if self.solve(*at, self.best, self.violation) != TRIMMED:
                return Found([0.0] * 4, False, True)
            speeds.append(self.best[V])
        return Found([*speeds, 0.0, 0.0], True, True)
