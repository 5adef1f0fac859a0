"""What a second of flight costs: time, distance, or more the less margin there is, now or after a second failure.

A margin is how far the speed is from the nearer end of the speeds that are left on this flight path, in kn. A second
with the margin that is wanted costs 1; the cost grows in proportion to what is short of it, by ``weight`` where the
margin is zero, and no further than twice that, which is the cost of a second in which nothing is left.
"""

from examples.path_planner.planner.scenario import Cost
from examples.path_planner.planner.sources import EnvelopeSource, Failure, second_failures

_WORST_SHORTFALL = 2.0


class Margins:
    """Margins of the speed by altitude and flight path, now and after a second failure."""

    def __init__(self, source: EnvelopeSource, failure: Failure, cost: Cost) -> None:
        self.source, self.failure, self.cost = source, failure, cost
        further = second_failures(failure, cost.rudder_lost_deg, cost.engine_out)
        self.further = {
            name: variants for name, variants in further.items() if all(source.knows(each) for each in variants)
        }

    def now_kt(self, altitude_ft: float, gamma_deg: float, tas_kt: float) -> float | None:
        """The margin in kn; None where no steady flight is left."""
        return self._margin(altitude_ft, gamma_deg, tas_kt, self.failure)

    def after(self, altitude_ft: float, gamma_deg: float, tas_kt: float) -> dict[str, float | None]:
        """The margin that each second failure would leave, of its variants the worst."""
        found: dict[str, float | None] = {}
        for name, variants in self.further.items():
            margins = [self._margin(altitude_ft, gamma_deg, tas_kt, each) for each in variants]
            found[name] = None if None in margins else min(m for m in margins if m is not None)
        return found

    def worst_after(self, altitude_ft: float, gamma_deg: float, tas_kt: float) -> float | None:
        """The least margin that a second failure would leave; None where one would leave nothing."""
        margins = self.after(altitude_ft, gamma_deg, tas_kt).values()
        return None if None in margins else min((m for m in margins if m is not None), default=None)

    def _margin(self, altitude_ft: float, gamma_deg: float, tas_kt: float, failure: Failure) -> float | None:
        speeds = self.source.speeds(altitude_ft, gamma_deg, failure)
        return None if speeds is None else min(tas_kt - speeds[0], speeds[1] - tas_kt)

    def rate(self, altitude_ft: float, gamma_deg: float, tas_kt: float, ground_m_s: float) -> float:
        """Cost of a second of this flight."""
        if self.cost.of == "time":
            return 1.0
        if self.cost.of == "distance":
            return ground_m_s
        margin = (self.now_kt if self.cost.of == "margin" else self.worst_after)(altitude_ft, gamma_deg, tas_kt)
        short = _WORST_SHORTFALL if margin is None else 1.0 - margin / self.cost.wanted_kt
        return 1.0 + self.cost.weight * min(max(short, 0.0), _WORST_SHORTFALL)

    def least_rate(self, ground_m_s: float) -> float:
        """No second costs less."""
        return ground_m_s if self.cost.of == "distance" else 1.0
