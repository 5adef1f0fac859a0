"""The GtmSurrogate slave: the trained networks behind co-simulation. It runs in the Python of the host."""

import json
from math import isfinite
from operator import mul, truediv
from pathlib import Path

from .closed_form import ClosedForm
from .slave import ROUNDING, TableSlave


def load_network(resources: str, name: str) -> ClosedForm:
    """A network of the FMU's resources."""
    return ClosedForm(json.loads(Path(resources, f"{name}.json").read_text(encoding="utf-8"))["model"])


class GtmSurrogate(TableSlave):
    """V_min and V_max of a failed rudder; an envelope exists where the least throttle of a trim is at most full."""

    def __init__(self, **kwargs):
        """Load the networks."""
        super().__init__(**kwargs)
        self.speeds, self.throttle = (load_network(self.resources, name) for name in ("speeds", "throttle"))
        self.full_throttle = self.table["constants"]["full_throttle_pct"]
        self.case, self.results = self.group("case"), self.group("envelope")
        self.place = {name: place for place, name in enumerate(self.names)}

    def compute(self) -> str | None:
        """The emulated envelope of the case."""
        values, place, scales = self.values, self.place, self.table["scales"]
        lower, upper = values[place["rudder.lower"]], values[place["rudder.upper"]]
        if lower > upper:
            return f"The rudder limits are reversed: lower {lower:g} is above upper {upper:g} rad."
        case = list(map(truediv, values[self.case], scales[self.case]))
        v_min, v_max = speeds = self.speeds.predict(case)
        results = [*speeds, *self.speeds.predict_std(case)]
        (t_min,) = self.throttle.predict(case)
        if not isfinite(sum(results) + t_min):
            return "The networks have no finite value at this case."
        values[self.results] = list(map(mul, results, scales[self.results]))
        values[place["feasible"]] = float(t_min <= self.full_throttle and v_min <= v_max)
        values[place["in_domain"]] = float(self.speeds.in_range(case, ROUNDING))
        values[place["margin.slow"]] = values[place["tas"]] - values[place["v_min"]]
        values[place["margin.fast"]] = values[place["v_max"]] - values[place["tas"]]
        return None

    def advance(self, step_size: float) -> str | None:
        """Nothing moves: the outputs are those of the inputs."""
        self.is_stale = False
        return self.compute()
