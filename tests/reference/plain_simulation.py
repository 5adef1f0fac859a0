"""A flight as time goes on, SPEC 10.1-10.6, in plain NumPy and SciPy on top of the plain model.

Servos and throttle lag are integrated as differential equations, between the times at which commands arrive; the
motion by the classical Runge-Kutta method. Written from the specification alone.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import solve_ivp

from tests.reference import plain_actuators, plain_configuration, plain_model
from tests.reference.plain_configuration import SIGNALS

Array = np.ndarray
SERVOS = tuple(name for name in SIGNALS if name in plain_actuators.POSITION_LIMITS and name != "STEER")
UNDELAYED = ("THROTL", "THROTR", "GEAR")
COMMAND_DELAY, POSITION_DELAY = 0.005, 0.010  # s

# SPEC 10.1; half widths in deg
DEAD_BAND = {
    "ELLOB": 0.3, "ELROB": 0.3, "ELLIB": 0.6, "ELRIB": 0.6, "AILL": 0.25, "AILR": 0.25, "RUDU": 0.4, "RUDL": 0.3,
    "FLAPLIB": 0.4, "FLAPLOB": 0.4, "FLAPRIB": 0.4, "FLAPROB": 0.4,
}  # fmt: skip


@dataclass
class Flight:
    """Commands and what happens.

    Attributes:
        times: s, from 0 on: when commands change.
        buses: what is commanded of each signal from each of these times on, SPEC 4.
        settings: of `plain_configuration.Configuration` by time: fuel, bus and damage aside.
        onset: s, when the damage happens.
    """

    times: Sequence[float]
    buses: Sequence[Mapping[str, float]]
    settings: Callable[[float], dict] = field(default=lambda time: {})
    onset: float = np.inf
    damage_case: int = 0
    has_dead_band: bool = False

    def command(self, signal: str, time: float) -> float:
        """The command given at a time; before the first, the first one."""
        return self.buses[max(0, int(np.searchsorted(self.times, time, side="right")) - 1)].get(signal, 0.0)

    def _pieces(self, delay: float, end: float):
        """Intervals without a change of what arrives after a delay."""
        edges = [0.0, *sorted({t + delay for t in self.times if 0 < t + delay < end}), end]
        return pairwise(edges)

    def servo(self, signal: str, end: float) -> Callable[[float], float]:
        """Position of a servo over time, which starts at its command (SPEC 10.1)."""
        low, high = plain_actuators.POSITION_LIMITS[signal]
        position = float(np.clip(self.command(signal, 0), low, high))
        solutions = []
        for begin, stop in self._pieces(COMMAND_DELAY, end):
            arrived = self.command(signal, (begin + stop) / 2 - COMMAND_DELAY)
            run = solve_ivp(
                lambda _, y, c=arrived: [plain_actuators.servo_rate(signal, y[0], c)],
                (begin, stop), [position], method="DOP853", rtol=1e-13, atol=1e-13, dense_output=True, max_step=0.002,
            )  # fmt: skip
            position = float(np.clip(run.y[0, -1], low, high))
            solutions.append((stop, run.sol))
        return lambda time: float(np.clip(next(s for stop, s in solutions if time <= stop)(time)[0], low, high))

    def lag(self, signal: str, end: float) -> Callable[[float], float]:
        """Throttle position over time (SPEC 10.2)."""
        z, solutions = plain_actuators.throttle_lag_start(self.command(signal, 0)), []
        for begin, stop in self._pieces(COMMAND_DELAY, end):
            u = self.command(signal, (begin + stop) / 2 - COMMAND_DELAY)
            run = solve_ivp(
                lambda _, z, u=u: plain_actuators.throttle_lag_rate(z, u),
                (begin, stop), z, method="DOP853", rtol=1e-13, atol=1e-13, dense_output=True,
            )  # fmt: skip
            z = run.y[:, -1]
            solutions.append((stop, run.sol))
        return lambda time: plain_actuators.throttle_lag_output(next(s for stop, s in solutions if time <= stop)(time))

    def run(self, x: ArrayLike, fuel_burn: bool, end: float, step: float) -> tuple[Array, dict[str, float]]:
        """State and fuel used (13) at the end, and the bus then; the damage begins at a multiple of the step."""
        servos = {name: self.servo(name, end) for name in SERVOS}
        lags = {name: self.lag(name, end) for name in ("THROTL", "THROTR")}

        def bus_at(time: float, middle: float) -> dict[str, float]:
            seen = time - POSITION_DELAY if middle > POSITION_DELAY else time
            bus = {name: position(max(seen, 0.0)) for name, position in servos.items()}
            for name, half in DEAD_BAND.items() if self.has_dead_band else ():
                bus[name] = np.sign(bus[name]) * max(abs(bus[name]) - half, 0.0)
            bus |= {name: position(time) for name, position in lags.items()}
            return bus | {"STAB": self.command("STAB", 0), "GEAR": self.command("GEAR", middle - COMMAND_DELAY)}

        def rates(y: Array, time: float, middle: float) -> Array:
            bus = bus_at(time, middle)
            case = self.damage_case if middle >= self.onset else 0
            full = plain_configuration.Configuration(bus, y[12], case, **self.settings(middle))
            N = [plain_model.rotor_speed(bus[name]) for name in ("THROTL", "THROTR")]
            fuel = plain_actuators.fuel_used_rate(N, full.engines_on) if fuel_burn else 0.0
            return np.append(plain_configuration.derivatives(y[:12], full), fuel)

        y = np.append(np.asarray(x, float), 0.0)
        for i in range(round(end / step)):
            t, h, middle = i * step, step, (i + 0.5) * step
            k1 = rates(y, t, middle)
            k2 = rates(y + h / 2 * k1, t + h / 2, middle)
            k3 = rates(y + h / 2 * k2, t + h / 2, middle)
            y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + rates(y + h * k3, t + h, middle))
        return y, bus_at(end, end)
