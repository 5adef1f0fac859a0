"""The GtmSurrogate slave: the thrust map behind co-simulation. It runs in the Python of the host."""

import ctypes
from math import inf, isfinite
from pathlib import Path
from typing import Any

from .core_library import load_core
from .envelope_slave import EnvelopeSlave, Found, is_inside
from .map_layout import RESULTS, SAFE_ENDS, CoreMap
from .slave import read_resource

RUDDER = slice(2, 4)  # of a case


class GtmSurrogate(EnvelopeSlave):
    """V_min and V_max of a failed rudder by a map of exact solutions; an envelope exists where thrust is to spare."""

    def __init__(self, **kwargs: Any) -> None:
        """Load the core and the map."""
        super().__init__(**kwargs)
        real = ctypes.c_double
        core = load_core(self.resources, "GtmSurrogate")
        self.solve, self.move = core.gtm_map_envelopes, core.gtm_map_safe_ends
        numbers = read_resource(self.resources, "map.json")
        table = Path(self.resources, "map.f4").read_bytes()
        self.nodes = [(real * len(array))(*array) for array in numbers["arrays"]]
        self.thrusts = (ctypes.c_float * (len(table) // 4)).from_buffer_copy(table)
        places = [ctypes.addressof(array) for array in self.nodes] + [ctypes.addressof(self.thrusts)]
        self.map = CoreMap(*numbers["sizes"], *places, *numbers["constants"])
        margins = [inf if margin is None else margin for margin in numbers["margins"]]
        self.margins = (real * len(margins))(*margins)
        constants = self.table["constants"]
        self.ranges = list(zip(constants["lower"], constants["upper"], strict=True))
        self.unknown = constants["unknown_std_kt"]
        self.asked, self.answer = (real * len(self.ranges))(), (real * len(RESULTS))()
        self.safe = (real * len(SAFE_ENDS))()

    def find(self, case: list[float]) -> Found:
        """The interpolated envelope; a limit of the rudder may be a rounding beyond the map's deflections."""
        in_domain = is_inside(case, self.ranges)
        rudder = [min(max(v, least), most) for v, (least, most) in zip(case[RUDDER], self.ranges[RUDDER], strict=True)]
        self.asked[:] = [*case[: RUDDER.start], *rudder]
        core, one = ctypes.byref(self.map), ctypes.c_long(1)
        self.solve(core, one, self.asked, self.answer)
        self.move(core, self.margins, one, self.asked, self.answer, self.safe)
        *speeds, spare, fold = self.answer
        feasible = spare >= 0
        if feasible and not in_domain:
            speeds[2:] = [self.unknown] * 2
        safe = list(self.safe) if in_domain and isfinite(self.safe[0]) else None
        return Found(speeds, feasible, in_domain, fold > 0, safe or [self.unknown, 0.0], safe is not None)
