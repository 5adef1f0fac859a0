"""Flight with a thrust that cannot be chosen: engines out or a stuck throttle. Speed and turn settle the flight path.

The flight path is where the thrust that a trim needs is the thrust that there is. The manoeuvre FMU tells the thrust
that trims need, also of those that need more; it grows with the flight path by about the weight, nearly in a line.
"""

import math
from collections.abc import Mapping
from functools import cache

import numpy as np

from examples.path_planner.planner.sources import Answer, ExactFmus, Failure, Speeds
from gtm_fmu.units import RAD_PER_DEG

LAYER_FT = 500.0
_FIRST_DEG, _STEP_DEG, _STEPS, _TOLERANCE_DEG = 2.0, 2.0, 14, 1e-5
_STEEPEST_DEG, _RATE_STEP_DEG_S = 40.0, 0.5
_ABOVE_SLOWEST = 1.15
"""Of the speed of a glide, to the slowest straight one."""
_IDLE = ("engine.left.running", "engine.right.running")
ENGINES_OUT = dict.fromkeys(_IDLE, False)
_THROTTLE = ("limits.throttle.lower", "limits.throttle.upper")


def is_thrust_fixed(failure: Failure) -> bool:
    """Whether both engines are out or the throttle is stuck."""
    return is_powerless(failure) or failure.get(_THROTTLE[0], 0.0) == failure.get(_THROTTLE[1], 100.0)


def is_powerless(failure: Failure) -> bool:
    """Whether both engines are out."""
    return not any(failure.get(name, True) for name in _IDLE)


class Glides:
    """Flight paths of steady flight after a failure that fixes the thrust."""

    def __init__(self, source: ExactFmus, failure: Failure) -> None:
        """Engines out are asked about with engines that run: trims of hardly any thrust lead to those of none."""
        self.source, self.failure = source, failure
        running: Mapping[str, float | bool] = {k: v for k, v in failure.items() if k not in (*_IDLE, *_THROTTLE)}
        self._is_powerless = is_powerless(failure)
        self._asked = source.of(running) if self._is_powerless else source
        self._at_layer = cache(self._solve)
        self._others: dict[tuple, Glides] = {}

    @property
    def queries(self) -> int:
        """How many answers were asked for."""
        return self.source.queries + (self._asked.queries if self._is_powerless else 0)

    def close(self) -> None:
        """Free what is not the source's."""
        for other in self._others.values():
            other.close()
            other.source.close()
        if self._is_powerless:
            self._asked.close()

    def gamma_deg(self, altitude_ft: float, tas_kt: float, turn_rate_deg_s: float) -> float | None:
        """Between layers in a line, below sea level as there; None where this cannot be flown."""
        altitude_ft = max(altitude_ft, 0.0)
        layer = math.floor(altitude_ft / LAYER_FT)
        low, high = (self._at_layer((layer + k) * LAYER_FT, tas_kt, turn_rate_deg_s) for k in (0, 1))
        if low is None or high is None:
            return None
        return low + (high - low) * (altitude_ft / LAYER_FT - layer)

    def answer(self, altitude_ft: float, gamma_deg: float, tas_kt: float, turn_rate_deg_s: float) -> Answer:
        """All about a manoeuvre on its flight path; a glide's next to it, where there is hardly any thrust."""
        for above in (0.0, 0.02, 0.1, 0.5, 1.0, 2.0):
            found = self._asked.answer(altitude_ft, gamma_deg + above, tas_kt, turn_rate_deg_s)
            if found.is_found:
                break
        return found

    def _solve(self, altitude_ft: float, tas_kt: float, turn_rate_deg_s: float) -> float | None:
        """The flight path in deg by secants from above, where all limits but the thrust's are kept.

        Engines that run give some thrust at idle, and nothing is known below; there the last secant leads on.
        """
        points: list[tuple[float, float]] = []
        gamma, feasible = _FIRST_DEG, False
        for _ in range(_STEPS):
            found = self._asked.answer(altitude_ft, gamma, tas_kt, turn_rate_deg_s)
            if not found.is_found:
                gamma = 0.5 * (gamma + points[-1][0]) if points else gamma - _STEP_DEG
                continue
            excess = found.trim["thrust_lbf"] if self._is_powerless else found.margins["thrust_lbf"][0]
            points.append((gamma, excess))
            feasible = all(
                min(pair) >= -1e-6 for name, pair in found.margins.items() if not name.startswith(("thr", "beta"))
            )
            below = self._below(points)
            if below is None or abs(below - gamma) < _TOLERANCE_DEG:
                break
            gamma = below
        below = self._below(points) if len(points) >= 2 else None
        return below if feasible else None

    @staticmethod
    def _below(points: list[tuple[float, float]]) -> float | None:
        """Where the line through the last two points has no excess of thrust; a step below a single one."""
        if len(points) == 1:
            return points[0][0] - _STEP_DEG
        (g0, t0), (g1, t1) = points[-2:]
        gamma = g1 - t1 * (g1 - g0) / (t1 - t0) if t1 != t0 else math.inf
        return gamma if abs(gamma) < _STEEPEST_DEG else None

    def speed_kt(self, altitude_ft: float) -> tuple[float, float] | None:
        """Speed in kn of the flattest straight flight with reserve above the slowest; its flight path in deg.

        None where nothing is straight.
        """
        paths = self._straight(altitude_ft)
        kept = [(gamma, v) for v, gamma in paths.items() if v >= _ABOVE_SLOWEST * min(paths)]
        return max(kept)[::-1] if kept else None

    def _straight(self, altitude_ft: float) -> dict[float, float]:
        """Flight paths in deg of straight flight at a layer, by the speed in kn."""
        speeds = np.arange(50.0, 181.0, 2.5).tolist()
        return {v: gamma for v in speeds if (gamma := self._at_layer(altitude_ft, v, 0.0)) is not None}

    def turns_deg_s(self, altitude_ft: float, tas_kt: float, reserve: float) -> tuple[float, float] | None:
        """Turns to the left and to the right that lose least height for their angle; None without either."""
        found = []
        for rates in self._turning(altitude_ft, tas_kt):
            kept = [rate for rate in rates if abs(rate) <= reserve * max(map(abs, rates))]
            if not kept:
                return None
            losses = {
                rate: math.sin(-self._at_layer(altitude_ft, tas_kt, rate) * RAD_PER_DEG) / abs(rate) for rate in kept
            }
            found.append(min(losses, key=lambda rate: losses[rate]))
        return found[0], found[1]

    def turn_rates(self, altitude_ft: float, gamma_deg: float, tas_kt: float) -> tuple[float, float] | None:
        """Ends of the turns in deg/s at this speed, each on its own flight path; to half a deg/s."""
        left, right = self._turning(round(altitude_ft / LAYER_FT) * LAYER_FT, tas_kt)
        return (min(left, default=0.0), max(right, default=0.0)) if left or right else None

    def _turning(self, altitude_ft: float, tas_kt: float) -> tuple[list[float], list[float]]:
        """Turns to the left and to the right that can be flown at a layer."""
        rates = np.arange(_RATE_STEP_DEG_S, 20.0, _RATE_STEP_DEG_S).tolist()
        sides = [[-rate for rate in rates], rates]
        left, right = ([r for r in side if self._at_layer(altitude_ft, tas_kt, r) is not None] for side in sides)
        return left, right

    # The rest of what a planner asks of a source.

    @property
    def name(self) -> str:
        """The source's."""
        return self.source.name

    def speeds(self, altitude_ft: float, gamma_deg: float, failure: Failure) -> Speeds | None:
        """Slowest and fastest straight flight, each on its own flight path, to 2.5 kn; see `sources.EnvelopeSource`."""
        if dict(failure) != dict(self.failure):
            key = tuple(sorted(failure.items()))
            if key not in self._others:
                self._others[key] = Glides(self.source.of(failure), failure)
            return self._others[key].speeds(altitude_ft, gamma_deg, failure)
        paths = self._straight(round(altitude_ft / LAYER_FT) * LAYER_FT)
        return (min(paths), max(paths)) if paths else None

    def knows(self, failure: Failure) -> bool:
        """See `sources.EnvelopeSource`."""
        return self.source.knows(failure)

    def are_feasible(self, manoeuvres: np.ndarray) -> np.ndarray:
        """See `sources.EnvelopeSource`; of manoeuvres within 0.05 deg of their flight path."""
        paths = [self.gamma_deg(altitude, tas, rate) for altitude, _, tas, rate in manoeuvres.tolist()]
        asked = manoeuvres[:, 1].tolist()
        return np.array([p is not None and abs(p - g) < 0.05 for p, g in zip(paths, asked, strict=True)], bool)
