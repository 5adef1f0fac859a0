"""The GtmManoeuvre slave: manoeuvres after a failure behind co-simulation. It runs in the Python of the host."""

import ctypes
from math import isfinite
from operator import mul, truediv
from typing import Any

from .core_library import load_core
from .failure_faults import FAILURE_FAULTS
from .slave import TableSlave


class GtmManoeuvre(TableSlave):
    """Whether a manoeuvre can be flown, its margins and its trim; how it may turn when that is asked for."""

    def __init__(self, **kwargs: Any) -> None:
        """Load the core and make its buffers."""
        super().__init__(**kwargs)
        core = load_core(self.resources, "GtmManoeuvre")
        self.solve, self.solve_turn_rates = core.gtm_failure_query, core.gtm_failure_turn_rates
        first, last = self.group("case").start, self.group("failure").stop
        self.inputs, self.turn_rates = slice(first, last), self.group("turn_rates")
        self.answer = slice(self.group("verdicts").start, self.turn_rates.start)
        self.scales: list[float] = self.table["scales"]
        real = ctypes.c_double
        self.given, self.found = (real * last)(), (real * (self.turn_rates.stop - last))()
        bounds = [(real * len(ends))(*ends) for ends in map(self.table["constants"].get, ("lower", "upper"))]
        self.arguments = (
            self.given,
            ctypes.byref(self.given, ctypes.sizeof(real) * self.group("failure").start),
            *bounds,
        )
        self.are_rates_known = False

    def _ask(self, solve: Any, places: slice) -> str | None:
        """Outputs of the inputs by a function of the core."""
        self.given[:] = [*map(truediv, self.values[self.inputs], self.scales[self.inputs])]
        if fault := solve(*self.arguments, self.found):
            return FAILURE_FAULTS[fault]
        results = list(map(mul, self.found, self.scales[places]))
        if not isfinite(sum(results)):
            return FAILURE_FAULTS[1]
        self.values[places] = results
        return None

    def compute(self) -> str | None:
        """All but the turn rates."""
        self.are_rates_known = False
        return self._ask(self.solve, self.answer)

    def _get(self, places: list[int]) -> list[float]:
        """The turn rates are found when one of them is asked for."""
        got = super()._get(places)
        asked = range(self.turn_rates.start, self.turn_rates.stop)
        if self.fault or self.are_rates_known or not any(place in asked for place in places):
            return got
        self.fault = self._ask(self.solve_turn_rates, self.turn_rates)
        self.are_rates_known = True
        return super()._get(places)

    def advance(self, step_size: float) -> str | None:
        """Nothing moves: the outputs are those of the inputs."""
        return self.compute()
