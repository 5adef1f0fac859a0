"""The GtmSurrogate slave: the trained networks behind co-simulation. It runs in the Python of the host."""

from typing import Any

from .closed_form import ClosedForm
from .envelope_slave import EnvelopeSlave, Found, is_inside
from .slave import read_resource


def load_model(resources: str, name: str) -> ClosedForm:
    """A model of the FMU's resources."""
    return ClosedForm(read_resource(resources, f"{name}.json"))


class GtmSurrogate(EnvelopeSlave):
    """V_min and V_max of a failed rudder; an envelope exists where the least throttle of a trim is at most full."""

    def __init__(self, **kwargs: Any) -> None:
        """Load the models."""
        super().__init__(**kwargs)
        self.speeds, self.throttle = (load_model(self.resources, name) for name in ("speeds", "throttle"))
        self.full_throttle = self.table["constants"]["full_throttle_pct"]

    def find(self, case: list[float]) -> Found:
        """The emulated envelope."""
        v_min, v_max = speeds = self.speeds.predict(case)
        (t_min,) = self.throttle.predict(case)
        feasible = t_min <= self.full_throttle and v_min <= v_max
        return Found(speeds + self.speeds.predict_std(case), feasible, is_inside(case, self.speeds.ranges))
