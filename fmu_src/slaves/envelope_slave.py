"""What the slaves of an envelope share, exact or learnt. It runs in the Python of the host."""

from math import isfinite
from operator import mul
from typing import Any, NamedTuple

from .slave import ROUNDING, TableSlave, shortest


class Found(NamedTuple):
    """v_min, v_max, v_min_std and v_max_std in the units of their variables, and the flags."""

    speeds: list[float]
    feasible: bool
    in_domain: bool
    fold: bool | None = None
    """Where a model tells folds."""
    safe: list[float] | None = None
    """v_min_safe and v_max_safe, where a model promises speeds."""
    feasible_safe: bool | None = None


def is_inside(values: list[float], ranges: list[tuple[float, float]]) -> bool:
    """Whether each value lies inside its range, but for a rounding relative to that."""
    return all(
        least - ROUNDING * (greatest - least) <= value <= greatest + ROUNDING * (greatest - least)
        for value, (least, greatest) in zip(values, ranges, strict=True)
    )


class EnvelopeSlave(TableSlave):
    """V_min, V_max and margins after a failure; `find` is asked only when the case has changed."""

    case_groups: tuple[str, ...] = ("case",)
    """Groups of the inputs that make a case."""

    def __init__(self, **kwargs: Any) -> None:
        """Find the places of the variables."""
        super().__init__(**kwargs)
        self.case = [place for name in self.case_groups for place in range(len(self.names))[self.group(name)]]
        self.case_scales = [self.table["scales"][place] for place in self.case]
        self.results = self.group("envelope")
        self.place = {name: place for place, name in enumerate(self.names)}
        self.found: tuple[list[float], Found] | None = None

    def find(self, case: list[float]) -> Found | str:
        """The envelope of a case (altitude, gamma, rudder.lower and rudder.upper, then others) in the units of its
        variables, or what is wrong with it.
        """
        raise NotImplementedError

    def compute(self) -> str | None:
        """Envelope and margins of the inputs."""
        values, place, scales = self.values, self.place, self.table["scales"]
        lower, upper = values[place["rudder.lower"]], values[place["rudder.upper"]]
        if lower > upper:
            low, high = shortest(lower), shortest(upper)
            return f"The rudder limits are reversed: lower {low} is above upper {high} rad."
        case = [values[place] / scale for place, scale in zip(self.case, self.case_scales, strict=True)]
        if self.found is None or self.found[0] != case:
            answer = self.find(case)
            if isinstance(answer, str):
                return answer
            self.found = case, answer
        found = self.found[1]
        results = list(map(mul, found.speeds, scales[self.results]))
        tas = values[place["tas"]]
        margins = [tas - results[0], results[1] - tas]
        if not isfinite(sum(results) + sum(margins)):
            return "The outputs are not finite at these inputs."
        values[self.results] = results
        values[place["feasible"]], values[place["in_domain"]] = float(found.feasible), float(found.in_domain)
        if found.fold is not None:
            values[place["fold"]] = float(found.fold)
        if found.safe is not None:
            values[self.group("safe")] = [
                *map(mul, found.safe, scales[self.group("safe")]),
                float(found.feasible_safe or 0),
            ]
        values[place["margin.slow"]], values[place["margin.fast"]] = margins
        return None

    def advance(self, step_size: float) -> str | None:
        """Nothing moves: the outputs are those of the inputs."""
        return self.compute()
